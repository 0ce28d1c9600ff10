// SPDX-License-Identifier: BSD-3-Clause
#include "Bones.h"

#include "vtkNew.h"
#include "vtkPVChainMailBoneInformation.h"
#include "vtkSMSourceProxy.h"

namespace vtkChainMail
{

namespace
{
bool Ask(vtkSMProxy* deformation, vtkPVChainMailBoneInformation* asked, Bone& bone)
{
  auto* source = vtkSMSourceProxy::SafeDownCast(deformation);
  if (source == nullptr)
  {
    return false;
  }
  source->InvokeCommand("CollectBodies"); // on all processes of the server; information is asked of the first one alone
  source->GatherInformation(asked);
  bone = { asked->Body, asked->Bounds, asked->Middle };
  return asked->IsFound;
}
}

bool FindBone(vtkSMProxy* deformation, const std::vector<double>& rays, Bone& bone)
{
  vtkNew<vtkPVChainMailBoneInformation> asked;
  asked->Rays = rays;
  return !rays.empty() && Ask(deformation, asked, bone);
}

bool FindBone(vtkSMProxy* deformation, vtkIdType body, const Place& place, Bone& bone)
{
  vtkNew<vtkPVChainMailBoneInformation> asked;
  asked->Body = body;
  asked->Place = place;
  return Ask(deformation, asked, bone);
}

}
