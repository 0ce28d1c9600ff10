// SPDX-License-Identifier: BSD-3-Clause
// Composite probes, cuts and carves are what their datasets are together: the same outputs, bit for bit, as from one
// input for each, and one state in Interactive mode. A composite image is refused, once.

#include "FilterTest.h"

#include "vtkCellArray.h"
#include "vtkInformation.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkSphereSource.h"

using namespace FilterTest;

namespace
{

vtkSmartPointer<vtkPolyData> Ball(double x)
{
  vtkNew<vtkSphereSource> source;
  source->SetOutputPointsPrecision(vtkAlgorithm::DOUBLE_PRECISION);
  source->SetCenter(x, 8.0, 5.0);
  source->SetRadius(2.6);
  source->Update();
  return source->GetOutput();
}

/// Every second triangle of a surface, or the others.
vtkSmartPointer<vtkPolyData> Half(vtkPolyData* surface, vtkIdType which)
{
  auto half = vtkSmartPointer<vtkPolyData>::New();
  half->SetPoints(surface->GetPoints());
  vtkNew<vtkCellArray> cells;
  vtkNew<vtkIdList> cell;
  for (vtkIdType n = which; n < surface->GetPolys()->GetNumberOfCells(); n += 2)
  {
    surface->GetPolys()->GetCellAtId(n, cell);
    cells->InsertNextCell(cell);
  }
  half->SetPolys(cells);
  return half;
}

using Parts = std::vector<vtkSmartPointer<vtkPolyData>>;
using Composite = std::function<vtkSmartPointer<vtkDataObject>(const Parts&)>;

void SetUp(vtkChainMailDeformation* filter, vtkImageData* image)
{
  filter->SetInputData(image);
  filter->SetTissueThreshold(1.0);
  filter->SetMaterialFunction(ConstantMaterial(0.3));
  filter->SetRelaxationIterations(5);
}

}

int TestChainMailComposite(int, char*[])
{
  Checks check;
  Noise noise(5);
  auto image = MakeImage({ { 0, 23, 0, 15, 0, 11 } });
  Fill(image->GetPointData()->GetScalars(), image, [&](int, int, int) { return 10 + noise.Next() % 50; });

  const Parts probes = { MakeProbes({ { { { 7.0, 7.0, 5.0 } }, { { 1.0, 0.4, 0.0 } }, 1.2 } }),
    MakeProbes(
      { { { { 18.0, 8.0, 6.0 } }, { { -0.4, 0.9, 0.3 } }, 1.0 }, { { { 12.0, 3.0, 3.0 } }, { { 0, 0, 0.7 } } } }) };
  const Parts blades = {
    MakeBlade({ { { { 9.4, -1.0, -1.0 } }, { { 9.4, 9.3, -1.0 } }, { { 9.4, 9.3, 13.0 } }, { { 9.4, -1.0, 13.0 } } } }),
    MakeBlade(
      { { { { 15.3, 5.0, -1.0 } }, { { 15.3, 17.0, -1.0 } }, { { 15.3, 17.0, 7.2 } }, { { 15.3, 5.0, 7.2 } } } })
  };
  // Two that overlap, so that neither is in the other's inside by mistake, and one in parts that are closed together.
  const Parts balls = { Ball(12.0), Ball(14.0) };
  const Parts halves = { Half(Ball(4.0), 0), Half(Ball(4.0), 1) };

  vtkNew<vtkChainMailDeformation> reference;
  EventLog referenceLog(reference);
  SetUp(reference, image);
  for (int n = 0; n < 2; ++n)
  {
    reference->AddInputDataObject(1, probes[n]);
    reference->AddInputDataObject(2, blades[n]);
    reference->AddInputDataObject(3, balls[n]);
  }
  reference->AddInputDataObject(3, Ball(4.0));
  reference->Update();
  check.Equal(referenceLog.TakeErrors(), std::string(), "an input for each");
  check.Equal(reference->GetOutput()->GetFieldData()->GetArray("ProbeReached")->GetNumberOfTuples(), 3, "three probes");
  check.That(Field(reference->GetOutput(), "DisplacedElements") > 100.0, "tissue moves");

  const std::vector<std::pair<std::string, Composite>> kinds = {
    { "multi-block",
      [](const Parts& parts)
      {
        auto all = vtkSmartPointer<vtkMultiBlockDataSet>::New();
        vtkNew<vtkMultiBlockDataSet> inner; // blocks within blocks, and one that is not there
        inner->SetBlock(1, parts[1]);
        all->SetBlock(0, parts[0]);
        all->SetBlock(1, inner);
        inner->GetMetaData(1u)->Set(vtkCompositeDataSet::NAME(), "liver");
        return vtkSmartPointer<vtkDataObject>(all);
      } },
    { "partitioned",
      [](const Parts& parts)
      {
        auto all = vtkSmartPointer<vtkPartitionedDataSet>::New();
        all->SetPartition(0, parts[0]);
        all->SetPartition(1, vtkNew<vtkPolyData>());
        all->SetPartition(2, parts[1]);
        all->GetMetaData(2u)->Set(vtkCompositeDataSet::NAME(), "liver");
        return vtkSmartPointer<vtkDataObject>(all);
      } },
    { "collection",
      [](const Parts& parts)
      {
        auto all = vtkSmartPointer<vtkPartitionedDataSetCollection>::New();
        all->SetPartition(0, 0, parts[0]);
        all->SetPartition(2, 1, parts[1]);
        all->GetMetaData(2u)->Set(vtkCompositeDataSet::NAME(), "liver");
        return vtkSmartPointer<vtkDataObject>(all);
      } },
  };
  for (const auto& [name, make] : kinds)
  {
    vtkNew<vtkChainMailDeformation> filter;
    EventLog log(filter);
    SetUp(filter, image);
    filter->SetInputDataObject(1, make(probes));
    filter->SetInputDataObject(2, make(blades));
    filter->SetInputDataObject(3, make(balls));
    filter->AddInputDataObject(3, make(halves));
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), name + ": no error");
    check.That(vtkImageData::SafeDownCast(filter->GetOutputDataObject(0)) != nullptr, name + ": one image");
    check.That(SameImage(filter->GetOutput(), reference->GetOutput()), name + ": the volume");
    check.That(SameImage(filter->GetModelOutput(), reference->GetModelOutput()), name + ": the model");
    check.That(SameBits(filter->GetOutput()->GetFieldData()->GetArray("ProbeReached"),
                 reference->GetOutput()->GetFieldData()->GetArray("ProbeReached")),
      name + ": the probes, in order");

    // One state: it settles, as with an input for each.
    filter->SetModeToInteractive();
    int updates = 0;
    do
    {
      filter->Update();
    } while (filter->GetNeedsUpdate() && ++updates < 1000);
    check.That(updates > 0 && updates < 1000, name + ": settles after " + std::to_string(updates) + " updates");
    check.Equal(log.TakeErrors(), std::string(), name + ": no error while it settles");

    // What is wrong with one dataset names it.
    auto bad = MakeProbes({ { { { 7.0, 7.0, 5.0 } }, { { 1.0, std::nan(""), 0.0 } } } });
    filter->SetInputDataObject(1, make({ probes[0], bad }));
    filter->Update();
    const std::string error = log.TakeErrors();
    check.Contains(error, "Probes input 0, block ", name + ": a bad probe's block");
    check.Contains(error, "(liver)", name + ": by its name, too");
  }

  // Half a ball is open.
  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);
  SetUp(filter, image);
  vtkNew<vtkMultiBlockDataSet> half;
  half->SetBlock(0, halves[0]);
  half->SetBlock(1, balls[0]);
  filter->SetInputDataObject(3, half);
  filter->Update();
  check.Contains(log.TakeErrors(), "not closed", "half a ball beside a whole one");
  filter->RemoveAllCarves();

  // Blocks of another kind.
  vtkNew<vtkMultiBlockDataSet> images;
  images->SetBlock(0, image);
  images->SetBlock(1, image);
  for (int port : { 1, 2 })
  {
    filter->SetInputDataObject(port, images);
    filter->Update();
    check.Contains(log.TakeErrors(), "block 1 is a vtkImageData", "images as port " + std::to_string(port));
    filter->SetInputDataObject(port, nullptr);
  }
  filter->Update();
  check.Equal(log.TakeErrors(), std::string(), "all is well without them");

  // Several images: refused, once, in both modes, and nothing goes on by itself.
  for (const bool interactive : { false, true })
  {
    filter->SetMode(interactive ? vtkChainMailDeformation::MODE_INTERACTIVE : vtkChainMailDeformation::MODE_FROM_REST);
    filter->SetInputDataObject(0, images);
    filter->Update();
    const std::string errors = log.TakeErrors();
    check.Contains(errors, "vtkMultiBlockDataSet", "several images");
    check.Contains(errors, "one image", "what to do with them");
    check.Equal(errors.find("ERROR:"), errors.rfind("ERROR:"), "one message");
    check.That(!filter->GetNeedsUpdate(), "no update loop");
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), "it is not repeated");
    check.That(vtkImageData::SafeDownCast(filter->GetOutputDataObject(0)) != nullptr, "the output is an image");
    check.Equal(filter->GetOutput()->GetNumberOfPoints(), 0, "an empty one");
    filter->SetInputData(image);
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), "one image again");
    check.That(SameImage(filter->GetOutput(), image), "it is shown");
  }
  return check.Finish();
}
