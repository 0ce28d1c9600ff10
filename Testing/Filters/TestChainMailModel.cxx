// SPDX-License-Identifier: BSD-3-Clause
// The second output and the field data: constraints, elements, clusters, displacements and figures are those of the
// tissue; materials, anchors, cuts and probes do what their documentation says.

#include "FilterTest.h"

#include "vtkDataArraySelection.h"

#include "vtkDoubleArray.h"
#include "vtkFloatArray.h"
#include "vtkIntArray.h"
#include "vtkTriangle.h"

#include <algorithm>
#include <set>

using namespace FilterTest;

namespace
{

vtkDataArray* Array(vtkDataSet* data, const char* name)
{
  return data->GetPointData()->GetArray(name);
}

/// Sum over the links of |du|^2 / D, recomputed from the arrays of the model output in plain doubles.
double EnergyOf(vtkImageData* model, const std::function<bool(const double*, const double*)>& isCut)
{
  vtkDataArray* displacement = Array(model, "Displacement");
  vtkDataArray* constraint = Array(model, "Constraint");
  vtkDataArray* element = Array(model, "Element");
  int size[3];
  model->GetDimensions(size);
  const vtkIdType step[3] = { 1, size[0], static_cast<vtkIdType>(size[0]) * size[1] };
  double energy = 0.0;
  for (int k = 0; k < size[2]; ++k)
  {
    for (int j = 0; j < size[1]; ++j)
    {
      for (int i = 0; i < size[0]; ++i)
      {
        const int at[3] = { i, j, k };
        const vtkIdType p = i * step[0] + j * step[1] + k * step[2];
        for (int d = 0; d < 3; ++d)
        {
          if (at[d] + 1 == size[d])
          {
            continue;
          }
          const vtkIdType q = p + step[d];
          double x[3];
          double y[3];
          model->GetPoint(p, x);
          model->GetPoint(q, y);
          if (element->GetTuple1(p) == 0.0 || element->GetTuple1(q) == 0.0 || isCut(x, y))
          {
            continue;
          }
          for (int a = 0; a < 3; ++a)
          {
            const int component = std::min(a, constraint->GetNumberOfComponents() - 1);
            const double limit = 0.5 * model->GetSpacing()[a] *
                                 (constraint->GetComponent(p, component) + constraint->GetComponent(q, component));
            const double u = displacement->GetComponent(p, a) - displacement->GetComponent(q, a);
            energy += limit > 0.0 ? u * u / limit : 0.0;
          }
        }
      }
    }
  }
  return energy;
}

}

int TestChainMailModel(int, char*[])
{
  Checks check;
  Noise noise(11);

  // Constraints from the function; air; two rigid rods.
  {
    auto image = MakeImage({ { 2, 21, -4, 7, 0, 9 } }, VTK_INT, 2);
    const auto inRod = [](int i, int j, int k) { return k == 5 && (j == 3 || j == 8) && i > 4 && i < 15; };
    Fill(image->GetPointData()->GetScalars(), image,
      [&](int i, int j, int k) {
        return i == 0 ? -500 : inRod(i, j, k) ? 1000 : static_cast<int>(noise.Next() % 200);
      });
    image->SetSpacing(1.0, 0.5, 2.0);
    vtkNew<vtkPiecewiseFunction> material;
    material->AddPoint(0.0, 0.4);
    material->AddPoint(200.0, 0.2);
    material->AddPoint(900.0, 0.0);
    vtkNew<vtkChainMailDeformation> filter;
    filter->GetModelArraySelection()->EnableAllArrays();
    filter->SetInputData(image);
    filter->SetMaterialFunction(material);
    filter->SetTissueThreshold(-100.0);
    filter->SetRelaxationIterations(200);
    double grabbed[3];
    int middle[3] = { 11, -1, 5 }; // on the first rod
    image->TransformIndexToPhysicalPoint(middle, grabbed);
    filter->SetInputDataObject(
      1, MakeProbes({ { { { grabbed[0], grabbed[1], grabbed[2] } }, { { 0.6, 0.3, -0.5 } } } }));
    filter->Update();
    vtkImageData* model = filter->GetModelOutput();
    check.Equal(model->GetNumberOfPoints(), image->GetNumberOfPoints(), "the model is on the input's grid");
    for (int e = 0; e < 6; ++e)
    {
      check.Equal(model->GetExtent()[e], image->GetExtent()[e], "the model has the input's extent");
    }
    vtkDataArray* constraint = Array(model, "Constraint");
    vtkDataArray* element = Array(model, "Element");
    vtkDataArray* cluster = Array(model, "Cluster");
    vtkDataArray* displacement = Array(model, "Displacement");
    check.That(
      constraint->GetDataType() == VTK_FLOAT && constraint->GetNumberOfComponents() == 1, "type of Constraint");
    check.That(element->GetDataType() == VTK_UNSIGNED_CHAR && element->GetNumberOfComponents() == 1, "type of Element");
    check.That(cluster->GetDataType() == VTK_INT && cluster->GetNumberOfComponents() == 1, "type of Cluster");
    check.That(
      displacement->GetDataType() == VTK_FLOAT && displacement->GetNumberOfComponents() == 3, "type of Displacement");
    check.That(model->GetPointData()->GetVectors() == displacement, "Displacement is the active vector");
    std::set<double> clusters;
    vtkIdType moved = 0;
    vtkIdType p = 0;
    for (int k = 0; k < 10; ++k)
    {
      for (int j = 0; j < 12; ++j)
      {
        for (int i = 0; i < 20; ++i, ++p)
        {
          const double scalar = image->GetPointData()->GetScalars()->GetComponent(p, 0);
          const bool air = scalar < -100.0;
          check.Equal(element->GetTuple1(p), air ? 0.0 : 1.0, "Element");
          check.Near(constraint->GetTuple1(p), air ? 0.0 : material->GetValue(scalar), 1e-6, "Constraint");
          check.That((cluster->GetTuple1(p) >= 0.0) == inRod(i, j, k), "Cluster is where tissue is rigid");
          if (inRod(i, j, k))
          {
            clusters.insert(cluster->GetTuple1(p));
            // Held by the probe: the first rod has, as a whole, what the probe reached.
            for (int a = 0; a < 3 && j == 3; ++a)
            {
              check.Equal(displacement->GetComponent(p, a),
                static_cast<double>(static_cast<float>(Field(model, "ProbeReached", a))), "the rod moves as one");
            }
          }
          const double u[3] = { displacement->GetComponent(p, 0), displacement->GetComponent(p, 1),
            displacement->GetComponent(p, 2) };
          moved += u[0] != 0.0 || u[1] != 0.0 || u[2] != 0.0;
          const bool face = i == 0 || i == 19 || j == 0 || j == 11 || k == 0 || k == 9;
          check.That(!(air || face) || (u[0] == 0.0 && u[1] == 0.0 && u[2] == 0.0), "air and anchored faces stay");
        }
      }
    }
    check.Equal(clusters.size(), std::size_t(2), "two rods");
    check.That(clusters.count(0) == 1 && clusters.count(1) == 1, "numbered from 0");
    check.Equal(
      Field(model, "DisplacedElements"), static_cast<double>(moved), "DisplacedElements are those that moved");
    check.That(moved > 200, "the scene is deformed");
    check.That(Field(model, "MaxLinkExcess") >= 0.0 && Field(model, "MaxLinkExcess") <= 1e-5, "MaxLinkExcess");
    const double energy = EnergyOf(model, [](const double*, const double*) { return false; });
    // Float displacements, and 1e-6 added to every limit.
    check.Near(Field(model, "Energy"), energy, 1e-4 * energy, "Energy");
    check.That(Field(model, "RelaxationIterationsUsed") > 0.0 && Field(model, "RelaxationIterationsUsed") <= 200.0,
      "RelaxationIterationsUsed");
    check.That(Field(filter->GetOutput(), "Energy") == Field(model, "Energy"), "both outputs have the field data");
    auto* device = vtkStringArray::SafeDownCast(model->GetFieldData()->GetAbstractArray("DeviceName"));
    check.That(device && device->GetNumberOfValues() == 1 && !device->GetValue(0).empty(), "DeviceName");
    vtkStringArray* devices = filter->GetAvailableDevices();
    check.That(devices->GetNumberOfValues() > 0, "there are devices");
    check.Equal(std::string(device ? device->GetValue(0) : ""), std::string(devices->GetValue(0)),
      "the best device is the first of those available");
    check.Equal(Array(filter->GetOutput(), "Scan")->GetNumberOfComponents(), 2, "all components are resampled");

    // The force is what the energy grows with: a finite difference over the displacement of a probe between the rods.
    int between[3] = { 11, 2, 5 };
    image->TransformIndexToPhysicalPoint(between, grabbed);
    filter->SetRelaxationIterations(3000);
    filter->SetRelaxationTolerance(0.0);
    double force[3];
    double slope[3];
    const Vector pull{ { 0.2, 0.1, -0.2 } };
    const auto energyAt = [&](const Vector& u)
    {
      filter->SetInputDataObject(1, MakeProbes({ { { { grabbed[0], grabbed[1], grabbed[2] } }, u } }));
      filter->Update();
      return Field(filter->GetOutput(), "Energy");
    };
    energyAt(pull);
    filter->GetOutput()->GetFieldData()->GetArray("ProbeForce")->GetTuple(0, force);
    for (int a = 0; a < 3; ++a)
    {
      const double step = 0.01;
      Vector more = pull;
      Vector less = pull;
      more[a] += step;
      less[a] -= step;
      slope[a] = (energyAt(more) - energyAt(less)) / (2.0 * step);
      // A quadratic has no error in a central difference; what is left are floats and the last bit of relaxation.
      check.Near(force[a], slope[a], 0.02 * std::fabs(slope[a]), "ProbeForce along axis " + std::to_string(a));
    }
  }

  // Constraints from an array: three axes; it wins over the function, not over the threshold; its rows are the image's.
  for (int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    auto image = MakeImage({ { 0, 12, 0, 8, 0, 8 } }, VTK_UNSIGNED_CHAR);
    Fill(image->GetPointData()->GetScalars(), image, [](int i, int, int) { return i == 12 ? 0 : 200; });
    auto fractions = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
    fractions->SetName("Fractions");
    fractions->SetNumberOfComponents(3);
    fractions->SetNumberOfTuples(image->GetNumberOfPoints());
    for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
    {
      fractions->SetTuple3(p, 0.5, 0.25, 0.125);
    }
    image->GetPointData()->AddArray(fractions);
    vtkNew<vtkChainMailDeformation> filter;
    filter->GetModelArraySelection()->EnableAllArrays();
    filter->SetInputData(image);
    filter->SetConstraintArray("Fractions");
    filter->SetTissueThreshold(100.0);
    filter->SetRelaxationIterations(0);
    filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    filter->SetInputDataObject(1, MakeProbes({ { { { 4.0, 4.0, 4.0 } }, { { 1.0, 1.0, 1.0 } } } }));
    filter->Update();
    vtkImageData* model = filter->GetModelOutput();
    check.Equal(Array(model, "Constraint")->GetNumberOfComponents(), 3, "three constraints");
    check.Equal(Array(model, "Cluster")->GetNumberOfComponents(), 3, "three clusters");
    const double D[3] = { 0.5, 0.25, 0.125 };
    for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
    {
      double x[3];
      image->GetPoint(p, x);
      const double links = std::fabs(x[0] - 4.0) + std::fabs(x[1] - 4.0) + std::fabs(x[2] - 4.0);
      for (int a = 0; a < 3; ++a)
      {
        const bool air = x[0] == 12.0;
        check.Equal(Array(model, "Constraint")->GetComponent(p, a), air ? 0.0 : D[a], "constraint along an axis");
        // Formula (P): every link costs D_a of axis a, whatever its direction.
        check.Near(Array(model, "Displacement")->GetComponent(p, a), air ? 0.0 : std::max(0.0, 1.0 - links * D[a]),
          1e-5, "propagation along an axis");
      }
    }
  }

  // Anchors: faces, rigid tissue, probes that hold; two probes that the tissue between cannot follow.
  {
    auto image = MakeImage({ { 0, 10, 0, 4, 0, 4 } }, VTK_SHORT);
    Fill(image->GetPointData()->GetScalars(), image, [](int i, int, int) { return i == 5 ? 1000 : 100; });
    vtkNew<vtkPiecewiseFunction> material;
    material->AddPoint(100.0, 0.3);
    material->AddPoint(1000.0, 0.0);
    vtkNew<vtkChainMailDeformation> filter;
    filter->GetModelArraySelection()->EnableAllArrays();
    filter->SetInputData(image);
    filter->SetMaterialFunction(material);
    filter->SetTissueThreshold(0.0);
    filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    filter->SetRelaxationIterations(0);
    const auto pull = [&](const std::vector<Probe>& probes)
    {
      filter->SetInputDataObject(1, MakeProbes(probes));
      filter->Update();
    };
    const auto reached = [&](int component, vtkIdType probe)
    { return Field(filter->GetOutput(), "ProbeReached", component, probe); };
    const Probe left{ { { 1.0, 2.0, 2.0 } }, { { -2.5, 0.0, 0.0 } } };
    pull({ left });
    check.Equal(reached(0, 0), -2.5, "free tissue follows all the way");
    filter->SetAnchoredFaces(0, 1, 0, 0, 0, 0);
    pull({ left });
    // 9 links to the held face: the two that touch the rigid plane are 0.15.
    check.Near(reached(0, 0), -(7 * 0.3 + 2 * 0.15), 1e-5, "as far as it stretches from the held face");
    filter->AnchorRigidOn();
    pull({ left });
    check.Near(reached(0, 0), -(3 * 0.3 + 0.15), 1e-5, "as far as it stretches from the held bone");
    filter->AnchorRigidOff();
    filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    pull({ { { { 3.0, 2.0, 2.0 } }, { { 9.0, 9.0, 9.0 } }, 1.0, true }, left });
    check.Near(reached(0, 1), -0.3, 1e-5, "a held place limits what is pulled beside it");
    check.Equal(reached(0, 0), 0.0, "an anchor does not use its displacement");
    // The ball of radius 1 around (3, 2, 2).
    const vtkIdType within = image->vtkDataSet::FindPoint(3.0, 1.0, 2.0); // vtkImageData of VTK 9.3 hides it
    check.Equal(Array(filter->GetModelOutput(), "Displacement")->GetComponent(within, 0), 0.0,
      "an anchor holds all within its radius");
    pull({ { { { 3.0, 2.0, 2.0 } }, { { 1.0, 0.0, 0.0 } } }, left });
    check.Equal(reached(0, 0), 1.0, "the first of two incompatible probes gets all");
    check.Near(reached(0, 1), 1.0 - 0.6, 1e-5, "the second gives way");

    // Two inputs are probes one after the other.
    filter->SetInputDataObject(1, MakeProbes({ { { { 3.0, 2.0, 2.0 } }, { { 0.5, 0.0, 0.0 } } } }));
    filter->AddInputDataObject(1, MakeProbes({ { { { 8.0, 2.0, 2.0 } }, { { 0.0, 0.25, 0.0 } } } }));
    filter->Update();
    check.Equal(filter->GetOutput()->GetFieldData()->GetArray("ProbeReached")->GetNumberOfTuples(), 2, "two probes");
    check.Equal(reached(0, 0), 0.5, "the first input's probe");
    check.Equal(reached(1, 1), 0.25, "the second input's probe");

    // A single slice is not held by the faces that it lies on.
    auto slice = MakeImage({ { 0, 10, 0, 10, 7, 7 } }, VTK_SHORT);
    slice->GetPointData()->GetScalars()->Fill(100);
    vtkNew<vtkChainMailDeformation> flat;
    flat->SetInputData(slice);
    flat->SetMaterialFunction(ConstantMaterial(0.3));
    flat->SetTissueThreshold(0.0);
    flat->SetRelaxationIterations(0);
    flat->SetInputDataObject(1, MakeProbes({ { { { 5.0, 5.0, 7.0 } }, { { 1.2, 0.0, 0.0 } } } }));
    flat->Update();
    check.Near(Field(flat->GetOutput(), "ProbeReached"), 1.2, 1e-6, "a slice moves within its plane");
  }

  // Cuts: polygons of any number of corners, also concave, strips, and several inputs; what is behind stays.
  {
    auto image = MakeImage({ { 0, 11, 0, 5, 0, 5 } }, VTK_SHORT);
    image->GetPointData()->GetScalars()->Fill(100);
    vtkNew<vtkChainMailDeformation> filter;
    filter->GetModelArraySelection()->EnableAllArrays();
    filter->SetInputData(image);
    filter->SetMaterialFunction(ConstantMaterial(0.2));
    filter->SetTissueThreshold(0.0);
    filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    filter->SetInputDataObject(1, MakeProbes({ { { { 2.0, 2.0, 2.0 } }, { { 0.0, 1.5, 0.0 } } } }));
    const auto behind = [&]()
    {
      filter->Update();
      double largest = 0.0;
      for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
      {
        if (image->GetPoint(p)[0] > 5.5)
        {
          largest = std::max(largest, std::fabs(Array(filter->GetModelOutput(), "Displacement")->GetComponent(p, 1)));
        }
      }
      return largest;
    };
    check.That(behind() > 0.5, "without a cut the far side follows");

    const Vector corners[] = { { { 5.4, -1.0, -1.0 } }, { { 5.4, 7.0, -1.0 } }, { { 5.4, 7.0, 7.0 } },
      { { 5.4, -1.0, 7.0 } } };
    vtkNew<vtkPoints> points;
    for (const Vector& corner : corners)
    {
      points->InsertNextPoint(corner.data());
    }
    const auto surface = [&](vtkCellArray* polygons, vtkCellArray* strips)
    {
      vtkNew<vtkPolyData> cut;
      cut->SetPoints(points);
      cut->SetPolys(polygons);
      cut->SetStrips(strips);
      filter->SetInputDataObject(2, cut);
      return behind();
    };
    vtkNew<vtkCellArray> quad;
    quad->InsertNextCell({ 0, 1, 2, 3 });
    check.Equal(surface(quad, nullptr), 0.0, "a quadrilateral");
    vtkNew<vtkCellArray> triangles;
    triangles->InsertNextCell({ 0, 1, 2 });
    check.That(surface(triangles, nullptr) > 0.1, "half of it leaves a bridge");
    triangles->InsertNextCell({ 0, 2, 3 });
    check.Equal(surface(triangles, nullptr), 0.0, "two triangles");
    vtkNew<vtkCellArray> strip;
    strip->InsertNextCell({ 0, 1, 3, 2 });
    check.Equal(surface(nullptr, strip), 0.0, "a strip");
    vtkNew<vtkCellArray> lines;
    lines->InsertNextCell({ 0, 2 });
    vtkNew<vtkPolyData> wire;
    wire->SetPoints(points);
    wire->SetLines(lines);
    filter->SetInputDataObject(2, wire);
    check.That(behind() > 0.5, "lines do not cut");

    // An arrow head: concave at its last corner, which leaves a notch of uncut links.
    vtkNew<vtkPoints> arrow;
    arrow->InsertNextPoint(5.4, -1.0, -1.0);
    arrow->InsertNextPoint(5.4, 7.0, -1.0);
    arrow->InsertNextPoint(5.4, 7.0, 7.0);
    arrow->InsertNextPoint(5.4, -1.0, 7.0);
    arrow->InsertNextPoint(5.4, 2.6, 2.6);
    vtkNew<vtkCellArray> concave;
    concave->InsertNextCell({ 0, 1, 2, 3, 4 });
    vtkNew<vtkPolyData> head;
    head->SetPoints(arrow);
    head->SetPolys(concave);
    filter->SetInputDataObject(2, head);
    check.That(behind() > 0.1, "the notch of a concave polygon is not cut");
    vtkNew<vtkCellArray> notch;
    notch->InsertNextCell({ 3, 0, 4 });
    vtkNew<vtkPolyData> rest;
    rest->SetPoints(arrow);
    rest->SetPolys(notch);
    filter->AddInputDataObject(2, rest);
    check.Equal(behind(), 0.0, "a second input closes it");
  }

  // Presets decide what is tissue and what is rigid.
  {
    auto image = MakeImage({ { 0, 5, 0, 1, 0, 1 } }, VTK_SHORT);
    const double scalars[6] = { -1000.0, -400.0, -100.0, 50.0, 600.0, 1200.0 };
    Fill(image->GetPointData()->GetScalars(), image, [&](int i, int, int) { return scalars[i]; });
    vtkNew<vtkChainMailDeformation> filter;
    filter->GetModelArraySelection()->EnableAllArrays();
    filter->SetInputData(image);
    const auto row = [&](const char* name)
    {
      filter->Update();
      std::string text;
      for (int i = 0; i < 6; ++i)
      {
        const double value = Array(filter->GetModelOutput(), name)->GetTuple1(i);
        text += std::string(name) == "Constraint" ? (value > 0.0 ? "s" : "-") : value != 0.0 ? "x" : "-";
      }
      return text;
    };
    check.Equal(row("Element"), std::string("--xxxx"), "fitted to a signed range: tissue from -300");
    check.Equal(row("Constraint"), std::string("--ss--"), "and rigid from 600");
    filter->SetMaterialPresetToCT();
    check.Equal(row("Element"), std::string("--xxxx"), "CT: tissue from -300");
    check.Equal(row("Constraint"), std::string("--ss--"), "CT: rigid from 600");
    filter->SetMaterialPresetToMR();
    check.Equal(row("Element"), std::string("-xxxxx"), "MR: tissue from a tenth of the range");
    check.Equal(row("Constraint"), std::string("-sssss"), "MR: nothing is rigid");
    filter->SetTissueThreshold(1000.0);
    check.Equal(row("Element"), std::string("-xxxxx"), "a preset has its own threshold");
    filter->SetMaterialPresetToFunction();
    check.Equal(row("Element"), std::string("-----x"), "the threshold of one's own");
    filter->SetMaterialFunction(ConstantMaterial(0.3));
    check.Equal(row("Constraint"), std::string("-----s"), "the function of one's own");
  }
  return check.Finish();
}
