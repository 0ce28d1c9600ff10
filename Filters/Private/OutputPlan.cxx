// SPDX-License-Identifier: BSD-3-Clause
#include "OutputPlan.h"

#include "vtkAbstractArray.h"
#include "vtkMatrix3x3.h"
#include "vtkPointData.h"

#include <algorithm>

namespace vtkChainMail
{

namespace
{

vtkSmartPointer<vtkImageData> GeometryOf(vtkImageData* image)
{
  auto geometry = vtkSmartPointer<vtkImageData>::New();
  geometry->CopyStructure(image);
  return geometry;
}

/// Rounds down, also below zero.
int Floor(int n, int divisor)
{
  return n >= 0 ? n / divisor : -((divisor - 1 - n) / divisor);
}

}

OutputPlan::OutputPlan(const Scene& scene, const Session& session)
  : Whole(GeometryOf(scene.Whole))
  , Padding(scene.Output.Padding)
  , Detail(scene.Output.Detail)
  , Background(scene.BackgroundValue)
  , NotMeasured{ scene.LowPadding, scene.Tissue.HighPadding }
  , Threshold(scene.Tissue.Threshold)
  , Ceiling(scene.Tissue.HighPadding)
  , AreLabels(scene.AreLabels)
  , LabelArrays(scene.LabelArrays)
  , Arrays(ListTypes(scene.Image))
  , Builds(session.GetBuilds())
  , TissueChanges(session.GetTissueChanges())
  , LinkChanges(session.GetLinkChanges())
  , IsCut(session.IsCut())
  , Axes(session.GetModel().axes())
{
  while (scene.Image->GetPointData()->GetAbstractArray(this->Scalars) != scene.Scalars)
  {
    ++this->Scalars;
  }
}

void OutputPlan::Write(vtkMultiProcessStream& stream) const
{
  WriteGeometry(stream, this->Whole);
  stream << this->Scalars << this->Background << this->NotMeasured.Low << this->NotMeasured.High << this->Threshold
         << this->Ceiling << this->AreLabels << this->Arrays << this->Builds << this->TissueChanges << this->LinkChanges
         << this->IsCut << this->Axes << static_cast<int>(this->LabelArrays.size());
  for (const std::string& name : this->LabelArrays)
  {
    stream << name;
  }
  stream << this->Detail.finer;
  for (int a = 0; a < 3; ++a)
  {
    stream << this->Padding[a] << this->Detail.first[a] << this->Detail.last[a];
  }
}

OutputPlan OutputPlan::Read(vtkMultiProcessStream& stream)
{
  OutputPlan plan;
  int labels = 0;
  plan.Whole = vtkSmartPointer<vtkImageData>::New();
  ReadGeometry(stream, plan.Whole);
  stream >> plan.Scalars >> plan.Background >> plan.NotMeasured.Low >> plan.NotMeasured.High >> plan.Threshold >>
    plan.Ceiling >> plan.AreLabels >> plan.Arrays >> plan.Builds >> plan.TissueChanges >> plan.LinkChanges >>
    plan.IsCut >> plan.Axes >> labels;
  plan.LabelArrays.resize(labels);
  for (std::string& name : plan.LabelArrays)
  {
    stream >> name;
  }
  stream >> plan.Detail.finer;
  for (int a = 0; a < 3; ++a)
  {
    stream >> plan.Padding[a] >> plan.Detail.first[a] >> plan.Detail.last[a];
  }
  return plan;
}

chainmail::Index3 OutputPlan::GetSize() const
{
  chainmail::Index3 size;
  this->Whole->GetDimensions(size.data());
  return size;
}

chainmail::OutputDetail OutputPlan::GetRange() const
{
  chainmail::OutputDetail range = this->Detail;
  const chainmail::Index3 size = this->GetSize();
  for (int a = 0; a < 3; ++a)
  {
    range.first[a] = std::max(-this->Padding[a], range.first[a]);
    range.last[a] = std::min(size[a] - 1 + this->Padding[a], range.last[a]);
  }
  return range;
}

chainmail::OutputDetail OutputPlan::GetPart(const Extent& extent, int halo) const
{
  chainmail::OutputDetail part = this->GetRange();
  const Extent whole = vtkChainMail::ExtentOf(this->Whole);
  for (int a = 0; a < 3; ++a)
  {
    const int first = Floor(extent[2 * a], part.finer) - whole[2 * a];
    const int last = -Floor(-extent[2 * a + 1], part.finer) - whole[2 * a];
    part.first[a] = std::max(part.first[a], first - halo);
    part.last[a] = std::min(part.last[a], last + halo);
  }
  return part;
}

Extent OutputPlan::ExtentOf(const chainmail::OutputDetail& part) const
{
  const Extent whole = vtkChainMail::ExtentOf(this->Whole);
  Extent extent;
  for (int a = 0; a < 3; ++a)
  {
    extent[2 * a] = part.finer * (whole[2 * a] + part.first[a]);
    extent[2 * a + 1] = part.finer * (whole[2 * a] + part.last[a]);
  }
  return extent;
}

chainmail::VoxelBox OutputPlan::BoxOf(const Extent& extent) const
{
  const Extent whole = vtkChainMail::ExtentOf(this->Whole);
  chainmail::VoxelBox box;
  for (int a = 0; a < 3; ++a)
  {
    box.first[a] = extent[2 * a] - whole[2 * a];
    box.size[a] = extent[2 * a + 1] - extent[2 * a] + 1;
  }
  return box;
}

}
