// SPDX-License-Identifier: BSD-3-Clause
#include "PartTissue.h"

#include "Convert.h"

#include "vtkDataArray.h"
#include "vtkMultiProcessStream.h"
#include "vtkPointData.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>

namespace vtkChainMail
{

namespace
{

std::vector<char> BytesOf(const vtkMultiProcessStream& stream)
{
  std::vector<unsigned char> raw;
  stream.GetRawData(raw);
  return { raw.begin(), raw.end() };
}

vtkMultiProcessStream StreamOf(const std::vector<char>& bytes)
{
  vtkMultiProcessStream stream;
  stream.SetRawData(std::vector<unsigned char>(bytes.begin(), bytes.end()));
  return stream;
}

void Write(vtkMultiProcessStream& stream, const std::vector<double>& values)
{
  stream << static_cast<int>(values.size());
  std::for_each(values.begin(), values.end(), [&](double value) { stream << value; });
}

void Read(vtkMultiProcessStream& stream, std::vector<double>& values)
{
  int count;
  stream >> count;
  values.resize(static_cast<std::size_t>(count));
  std::for_each(values.begin(), values.end(), [&](double& value) { stream >> value; });
}

}

chainmail::Material ToMaterial(
  double threshold, double highPadding, const std::vector<double>& function, const std::vector<double>& regions)
{
  chainmail::Material material;
  material.tissueThreshold = threshold;
  material.tissueCeiling = highPadding;
  material.constraint = ToEngineFunction(function);
  for (std::size_t n = 0; n < regions.size(); n += 5)
  {
    const double* r = regions.data() + n;
    material.regions.push_back({ { { r[0], r[1], r[2] } }, r[3], r[4] });
  }
  return material;
}

chainmail::Grid PartTissue::GetGrid() const
{
  chainmail::Grid grid;
  for (int a = 0; a < 3; ++a)
  {
    grid.size[a] = this->Whole[2 * a + 1] - this->Whole[2 * a] + 1;
    grid.spacing[a] = this->Spacing[a];
  }
  return grid;
}

chainmail::VoxelBox PartTissue::BoxOf(const Extent& part) const
{
  chainmail::VoxelBox box;
  for (int a = 0; a < 3; ++a)
  {
    box.first[a] = part[2 * a] - this->Whole[2 * a];
    box.size[a] = part[2 * a + 1] - part[2 * a] + 1;
  }
  return box;
}

/// An array of a part, by the numbers of voxels of the whole image.
chainmail::ArrayView PartTissue::ViewOf(vtkImageData* own, int number) const
{
  auto* const array = vtkDataArray::SafeDownCast(own->GetPointData()->GetAbstractArray(number));
  chainmail::ArrayView view = View(array);
  const auto* const values = static_cast<const char*>(view.data);
  view.data = nullptr;
  view.read = [values, bytes = BytesOfVoxel(array), grid = this->GetGrid(), box = this->BoxOf(ExtentOf(own))](
                std::size_t first, int) -> const void*
  {
    const chainmail::Index3 at = grid.indexOf(first);
    return values + bytes * box.at(at[0], at[1], at[2]);
  };
  return view;
}

chainmail::Constraints PartTissue::ConstraintsOf(vtkImageData* own) const
{
  chainmail::Material material = ToMaterial(this->Threshold, this->HighPadding, this->Function, this->Regions);
  material.constraintArray = this->Constraints < 0 ? chainmail::ArrayView() : this->ViewOf(own, this->Constraints);
  return chainmail::Constraints(this->GetGrid(), this->ViewOf(own, this->Scalars), material);
}

chainmail::TissueCounts PartTissue::Count(vtkImageData* own, const Extent& part) const
{
  return this->ConstraintsOf(own).count(this->BoxOf(part));
}

chainmail::ReducedBox PartTissue::Reduce(vtkImageData* own, const Extent& part) const
{
  return this->ConstraintsOf(own).reduce(this->Factor, this->IsRigidAnchored, this->BoxOf(part));
}

chainmail::VoxelBox PartTissue::ElementsIn(const Extent& part) const
{
  return chainmail::elementsWithin(this->GetGrid(), this->Factor, this->BoxOf(part));
}

std::vector<char> PartTissue::Pack() const
{
  vtkMultiProcessStream stream;
  std::for_each(this->Whole.begin(), this->Whole.end(), [&](int e) { stream << e; });
  std::for_each(this->Spacing.begin(), this->Spacing.end(), [&](double s) { stream << s; });
  stream << this->Scalars << this->Constraints << this->Threshold << this->HighPadding;
  Write(stream, this->Function);
  Write(stream, this->Regions);
  stream << static_cast<int>(this->IsRigidAnchored);
  std::for_each(this->Factor.begin(), this->Factor.end(), [&](int f) { stream << f; });
  return BytesOf(stream);
}

PartTissue PartTissue::Unpack(const std::vector<char>& bytes)
{
  vtkMultiProcessStream stream = StreamOf(bytes);
  PartTissue tissue;
  std::for_each(tissue.Whole.begin(), tissue.Whole.end(), [&](int& e) { stream >> e; });
  std::for_each(tissue.Spacing.begin(), tissue.Spacing.end(), [&](double& s) { stream >> s; });
  stream >> tissue.Scalars >> tissue.Constraints >> tissue.Threshold >> tissue.HighPadding;
  Read(stream, tissue.Function);
  Read(stream, tissue.Regions);
  int isAnchored;
  stream >> isAnchored;
  tissue.IsRigidAnchored = isAnchored != 0;
  std::for_each(tissue.Factor.begin(), tissue.Factor.end(), [&](int& f) { stream >> f; });
  return tissue;
}

std::vector<char> PartTissue::Pack(const chainmail::TissueCounts& counts)
{
  vtkMultiProcessStream stream;
  stream << static_cast<vtkTypeInt64>(counts.elements) << static_cast<vtkTypeInt64>(counts.nonFinite)
         << static_cast<vtkTypeInt64>(counts.badVoxel) << counts.problem;
  return BytesOf(stream);
}

chainmail::TissueCounts PartTissue::UnpackCounts(const std::vector<char>& bytes)
{
  vtkMultiProcessStream stream = StreamOf(bytes);
  vtkTypeInt64 elements;
  vtkTypeInt64 nonFinite;
  vtkTypeInt64 badVoxel;
  chainmail::TissueCounts counts;
  stream >> elements >> nonFinite >> badVoxel >> counts.problem;
  counts.elements = static_cast<std::size_t>(elements);
  counts.nonFinite = static_cast<std::size_t>(nonFinite);
  counts.badVoxel = static_cast<std::size_t>(badVoxel); // -1 becomes TissueCounts::none
  return counts;
}

std::vector<char> PartTissue::Pack(const chainmail::ReducedBox& box)
{
  const auto* const constraints = reinterpret_cast<const char*>(box.constraints.data());
  std::vector<char> bytes(constraints, constraints + sizeof(float) * box.constraints.size());
  bytes.insert(bytes.end(), box.linked.begin(), box.linked.end());
  return bytes;
}

chainmail::ReducedBox PartTissue::UnpackBox(const std::vector<char>& bytes, const Extent& part) const
{
  chainmail::ReducedBox box;
  box.elements = this->ElementsIn(part);
  box.linked.resize(box.elements.voxels());
  box.constraints.resize((bytes.size() - box.linked.size()) / sizeof(float));
  const std::size_t constraints = sizeof(float) * box.constraints.size();
  std::memcpy(box.constraints.data(), bytes.data(), constraints);
  std::memcpy(box.linked.data(), bytes.data() + constraints, box.linked.size());
  return box;
}

}
