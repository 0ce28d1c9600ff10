// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSMChainMailDeformationProxy.h"

#include "vtkClientServerStream.h"
#include "vtkObjectFactory.h"
#include "vtkPVDataInformation.h"
#include "vtkPVXMLElement.h"
#include "vtkSMPropertyHelper.h"

#include <cstring>

vtkStandardNewMacro(vtkSMChainMailDeformationProxy);

//------------------------------------------------------------------------------
vtkPVXMLElement* vtkSMChainMailDeformationProxy::GetHints()
{
  vtkPVXMLElement* hints = this->Superclass::GetHints();
  vtkSMPropertyHelper input(this, "Input", true);
  auto* source = vtkSMSourceProxy::SafeDownCast(input.GetNumberOfElements() > 0 ? input.GetAsProxy(0) : nullptr);
  if (hints == nullptr || source == nullptr || !source->GetOutputPortsCreated())
  {
    return hints;
  }
  int extent[6];
  source->GetDataInformation(input.GetOutputPort(0))->GetExtent(extent);
  if (extent[0] != extent[1] && extent[2] != extent[3] && extent[4] != extent[5])
  {
    return hints;
  }
  if (this->SliceHints == nullptr)
  {
    this->SliceHints = vtkSmartPointer<vtkPVXMLElement>::New();
    this->SliceHints->SetName("Hints");
    for (unsigned int i = 0; i < hints->GetNumberOfNestedElements(); ++i)
    {
      vtkPVXMLElement* hint = hints->GetNestedElement(i);
      if (std::strcmp(hint->GetName(), "RepresentationType") != 0)
      {
        this->SliceHints->AddNestedElement(hint, /*setParent=*/0);
      }
    }
  }
  return this->SliceHints;
}

//------------------------------------------------------------------------------
void vtkSMChainMailDeformationProxy::MarkModified(vtkSMProxy* modifiedProxy)
{
  if (modifiedProxy == this && this->ObjectsCreated)
  {
    vtkClientServerStream stream;
    stream << vtkClientServerStream::Invoke << VTKOBJECT(this) << "Modified" << vtkClientServerStream::End;
    this->ExecuteStream(stream);
  }
  this->Superclass::MarkModified(modifiedProxy);
}
