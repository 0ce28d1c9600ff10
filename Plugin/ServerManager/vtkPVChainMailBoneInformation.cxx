// SPDX-License-Identifier: BSD-3-Clause
#include "vtkPVChainMailBoneInformation.h"

#include "vtkBoundingBox.h"
#include "vtkChainMailDeformation.h"
#include "vtkChainMailTissuePicker.h"
#include "vtkClientServerStream.h"
#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkIntArray.h"
#include "vtkMath.h"
#include "vtkMatrix3x3.h"
#include "vtkMultiProcessStream.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

vtkStandardNewMacro(vtkPVChainMailBoneInformation);

namespace
{
// A crumb of bone is no bone that somebody means, nor is a vessel with a spot of calcium: as many voxels as a bone has
// at least and, with a label, which share of them is rigid. Where voxels are large, that share is small: spongy bone is
// not.
constexpr vtkIdType FewestVoxels = 50;
constexpr double RigidShare = 0.005;

/// The bones of a deformation by voxel. A bone has a number from 1 on: with labels its label, else its cluster's + 1.
class Bones
{
public:
  explicit Bones(vtkChainMailDeformation* filter)
  {
    if (filter->GetBodies(this->Image) && this->Image->GetNumberOfPoints() > 0)
    {
      const char* name = filter->GetBodyArray();
      this->Labels = name && *name ? this->Image->GetPointData()->GetArray(name) : nullptr;
      this->Clusters = vtkIntArray::SafeDownCast(this->Image->GetPointData()->GetArray("Cluster"));
    }
  }

  bool AreKnown() const { return this->Clusters != nullptr; }
  bool HaveLabels() const { return this->Labels != nullptr; }
  vtkImageData* GetImage() const { return this->Image; }
  bool IsRigid(vtkIdType voxel) const { return this->Clusters->GetTypedComponent(voxel, 0) >= 0; }

  /// The bone that a voxel belongs to; 0 where it belongs to none.
  vtkIdType At(vtkIdType voxel) const
  {
    if (!this->Labels)
    {
      return this->Clusters->GetTypedComponent(voxel, 0) + vtkIdType(1);
    }
    const double label = this->Labels->GetComponent(voxel, 0);
    return label >= 1.0 && label < 9e15 ? static_cast<vtkIdType>(label) : 0;
  }

  /// The voxel at a place; -1 outside.
  vtkIdType VoxelAt(const double place[3]) const
  {
    double index[3];
    this->Image->TransformPhysicalPointToContinuousIndex(place, index);
    const int* extent = this->Image->GetExtent();
    int nearest[3];
    for (int a = 0; a < 3; ++a)
    {
      nearest[a] = static_cast<int>(std::floor(index[a] + 0.5));
      if (!(nearest[a] >= extent[2 * a] && nearest[a] <= extent[2 * a + 1]))
      {
        return -1;
      }
    }
    return this->Image->ComputePointId(nearest);
  }

private:
  vtkNew<vtkImageData> Image;
  vtkDataArray* Labels = nullptr;
  vtkIntArray* Clusters = nullptr;
};

/// The numbers of those that are bones and no crumbs.
std::set<vtkIdType> FindWholeBones(const Bones& bones)
{
  std::map<vtkIdType, std::array<vtkIdType, 2>> counts; // of all voxels, and of rigid ones
  const vtkIdType voxels = bones.GetImage()->GetNumberOfPoints();
  vtkIdType last = 0;
  std::array<vtkIdType, 2>* ofLast = nullptr;
  for (vtkIdType v = 0; v < voxels; ++v)
  {
    const vtkIdType bone = bones.At(v);
    if (bone == 0)
    {
      continue;
    }
    if (bone != last)
    {
      ofLast = &counts[bone];
      last = bone;
    }
    ++(*ofLast)[0];
    (*ofLast)[1] += bones.IsRigid(v);
  }
  std::set<vtkIdType> whole;
  for (const auto& [bone, count] : counts)
  {
    if (count[0] >= FewestVoxels && count[1] > 0 && count[1] >= RigidShare * count[0])
    {
      whole.insert(bone);
    }
  }
  return whole;
}

/// The first bone that one of the rays meets, 0 for none: whole ones first.
vtkIdType OnRays(const Bones& bones, const std::vector<double>& rays)
{
  const std::set<vtkIdType> whole = FindWholeBones(bones);
  vtkNew<vtkImageData> image;
  image->CopyStructure(bones.GetImage());
  vtkNew<vtkUnsignedCharArray> mask;
  mask->SetNumberOfTuples(image->GetNumberOfPoints());
  vtkNew<vtkChainMailTissuePicker> picker;
  picker->SetTissueThreshold(0.5);
  for (const bool ofWhole : { true, false })
  {
    vtkIdType last = 0;
    bool isLastWhole = false;
    for (vtkIdType v = 0; v < image->GetNumberOfPoints(); ++v)
    {
      const vtkIdType bone = bones.At(v);
      isLastWhole = bone == last ? isLastWhole : whole.count(bone) != 0;
      last = bone;
      mask->SetValue(v, ofWhole ? isLastWhole : bone != 0 && bones.IsRigid(v));
    }
    mask->Modified();
    image->GetPointData()->SetScalars(mask);
    for (std::size_t n = 0; n + 6 <= rays.size(); n += 6)
    {
      const double* from = rays.data() + n;
      const double* to = from + 3;
      const double share = picker->Pick(image, from, to);
      double place[3];
      for (int a = 0; a < 3; ++a)
      {
        place[a] = from[a] + share * (to[a] - from[a]);
      }
      const vtkIdType voxel = share < 0.0 ? -1 : bones.VoxelAt(place);
      if (voxel >= 0 && bones.At(voxel) != 0)
      {
        return bones.At(voxel);
      }
    }
  }
  return 0;
}
}

//------------------------------------------------------------------------------
void vtkPVChainMailBoneInformation::CopyParametersToStream(vtkMultiProcessStream& stream)
{
  stream << static_cast<int>(this->Rays.size());
  for (const double number : this->Rays)
  {
    stream << number;
  }
  stream << this->Place[0] << this->Place[1] << this->Place[2] << static_cast<vtkTypeInt64>(this->Body);
}

void vtkPVChainMailBoneInformation::CopyParametersFromStream(vtkMultiProcessStream& stream)
{
  int size = 0;
  stream >> size;
  this->Rays.resize(static_cast<std::size_t>(size));
  for (double& number : this->Rays)
  {
    stream >> number;
  }
  vtkTypeInt64 body = -1;
  stream >> this->Place[0] >> this->Place[1] >> this->Place[2] >> body;
  this->Body = static_cast<vtkIdType>(body);
}

//------------------------------------------------------------------------------
void vtkPVChainMailBoneInformation::CopyFromObject(vtkObject* object)
{
  this->IsFound = false;
  auto* filter = vtkChainMailDeformation::SafeDownCast(object);
  if (filter == nullptr)
  {
    return;
  }
  const Bones bones(filter);
  if (!bones.AreKnown())
  {
    return;
  }
  vtkIdType bone = bones.HaveLabels() ? this->Body : -1;
  if (!this->Rays.empty())
  {
    bone = OnRays(bones, this->Rays);
  }
  else if (bone < 0)
  {
    const vtkIdType voxel = bones.VoxelAt(this->Place.data());
    bone = voxel >= 0 && bones.IsRigid(voxel) ? bones.At(voxel) : 0;
  }
  vtkImageData* image = bones.GetImage();
  vtkBoundingBox box;
  int index[3];
  double place[3];
  const auto forEachVoxel = [&](auto&& call)
  {
    const int* extent = image->GetExtent();
    vtkIdType voxel = 0;
    for (index[2] = extent[4]; index[2] <= extent[5]; ++index[2])
    {
      for (index[1] = extent[2]; index[1] <= extent[3]; ++index[1])
      {
        for (index[0] = extent[0]; index[0] <= extent[1]; ++index[0], ++voxel)
        {
          if (bones.At(voxel) == bone)
          {
            image->TransformIndexToPhysicalPoint(index, place);
            call();
          }
        }
      }
    }
  };
  if (bone > 0)
  {
    forEachVoxel([&] { box.AddPoint(place); });
  }
  if (!box.IsValid())
  {
    return;
  }
  box.GetCenter(this->Middle.data());
  if (!bones.HaveLabels())
  {
    // The probe grips what is at its place, and the middle of a bent or hollow bone may be none of it.
    const std::array<double, 3> middle = this->Middle;
    double nearest = std::numeric_limits<double>::infinity();
    forEachVoxel(
      [&]
      {
        const double distance = vtkMath::Distance2BetweenPoints(place, middle.data());
        if (distance < nearest)
        {
          nearest = distance;
          std::copy_n(place, 3, this->Middle.begin());
        }
      });
  }
  box.GetBounds(this->Bounds.data());
  const double* spacing = image->GetSpacing();
  for (int a = 0; a < 3; ++a)
  {
    double half = 0.0; // of a voxel, along this axis of the world
    for (int b = 0; b < 3; ++b)
    {
      half += 0.5 * std::fabs(image->GetDirectionMatrix()->GetElement(a, b)) * spacing[b];
    }
    this->Bounds[2 * a] -= half;
    this->Bounds[2 * a + 1] += half;
  }
  this->Body = bones.HaveLabels() ? bone : -1;
  this->IsFound = true;
}

//------------------------------------------------------------------------------
void vtkPVChainMailBoneInformation::AddInformation(vtkPVInformation* information)
{
  auto* other = vtkPVChainMailBoneInformation::SafeDownCast(information);
  if (other && other->IsFound && !this->IsFound)
  {
    this->IsFound = true;
    this->Body = other->Body;
    this->Bounds = other->Bounds;
    this->Middle = other->Middle;
  }
}

//------------------------------------------------------------------------------
void vtkPVChainMailBoneInformation::CopyToStream(vtkClientServerStream* stream)
{
  stream->Reset();
  *stream << vtkClientServerStream::Reply << static_cast<int>(this->IsFound) << static_cast<vtkTypeInt64>(this->Body)
          << vtkClientServerStream::InsertArray(this->Bounds.data(), static_cast<int>(this->Bounds.size()))
          << vtkClientServerStream::InsertArray(this->Middle.data(), static_cast<int>(this->Middle.size()))
          << vtkClientServerStream::End;
}

void vtkPVChainMailBoneInformation::CopyFromStream(const vtkClientServerStream* stream)
{
  int found = 0;
  vtkTypeInt64 body = -1;
  this->IsFound = stream->GetArgument(0, 0, &found) && stream->GetArgument(0, 1, &body) &&
                  stream->GetArgument(0, 2, this->Bounds.data(), static_cast<vtkTypeUInt32>(this->Bounds.size())) &&
                  stream->GetArgument(0, 3, this->Middle.data(), static_cast<vtkTypeUInt32>(this->Middle.size())) &&
                  found != 0;
  this->Body = static_cast<vtkIdType>(body);
}

//------------------------------------------------------------------------------
void vtkPVChainMailBoneInformation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Rays: " << this->Rays.size() / 6 << "\n";
  os << indent << "Body: " << this->Body << "\n";
  os << indent << "IsFound: " << this->IsFound << "\n";
}
