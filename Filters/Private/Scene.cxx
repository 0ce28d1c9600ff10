// SPDX-License-Identifier: BSD-3-Clause
#include "Scene.h"

#include "../vtkChainMailScanStatistics.h"
#include "Choices.h"
#include "SpreadImage.h"
#include "Text.h"

#include "vtkAbstractArray.h"
#include "vtkCellData.h"
#include "vtkInformation.h"
#include "vtkMath.h"
#include "vtkNew.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPointData.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>

namespace vtkChainMail
{

namespace
{

constexpr double anyBody = -1.0; // the value of Body for the tissue at the probe's point

chainmail::Method ReadMethod(const Properties& properties)
{
  chainmail::Method method;
  method.propagation = Checked("PropagationMethod", properties.PropagationMethod);
  method.conflict = Checked("ConflictPolicy", properties.ConflictPolicy);
  if (method.conflict == chainmail::ConflictPolicy::Share &&
      method.propagation != chainmail::PropagationMethod::Envelope)
  {
    throw chainmail::InputError("The ConflictPolicy Share needs the PropagationMethod Envelope. Choose that, or the "
                                "ConflictPolicy Limit or Latest.");
  }
  method.propagationIterations = properties.PropagationIterations;
  method.relaxation = Checked("RelaxationMethod", properties.RelaxationMethod);
  Checked("RelaxationPreset", properties.RelaxationPreset);
  ApplyRelaxationPreset(properties, method);
  method.elasticRecovery = properties.ElasticRecovery;
  if (properties.Rotations &&
      (method.propagation != chainmail::PropagationMethod::Envelope ||
        method.relaxation != chainmail::RelaxationMethod::Projected || method.elasticRecovery != 1.0))
  {
    throw chainmail::InputError("Rotations need the PropagationMethod Envelope, the RelaxationMethod Projected and an "
                                "ElasticRecovery of 1. Choose these, or switch Rotations off.");
  }
  if (properties.PoissonRatio != 0.0 && !properties.Rotations)
  {
    throw chainmail::InputError(
      "A PoissonRatio other than 0 needs Rotations. Switch Rotations on, or set PoissonRatio to 0.");
  }
  return method;
}

/// The array that a property names, as numbers. Throws InputError where it does not hold numbers.
vtkDataArray* NumbersOf(const std::string& property, vtkAbstractArray* array)
{
  vtkDataArray* numbers = vtkDataArray::SafeDownCast(array);
  if (!numbers)
  {
    throw chainmail::InputError(property + " is the array \"" + (array->GetName() ? array->GetName() : "") +
                                "\", which does not hold numbers. Choose another one.");
  }
  return numbers;
}

vtkDataArray* ReadScalars(vtkImageData* image, const ChosenArray& chosen)
{
  vtkPointData* arrays = image->GetPointData();
  vtkNew<vtkFieldData> ofCells;
  ofCells->PassData(image->GetCellData());
  ofCells->RemoveArray(vtkDataSetAttributes::GhostArrayName());
  if (arrays->GetNumberOfArrays() == 0 && ofCells->GetNumberOfArrays() > 0)
  {
    // Some readers give each pixel as a cell, such as GDAL's, which ParaView offers first for TIFF.
    throw chainmail::InputError("The input image has cell data alone, but tissue is made from point data. " +
                                ListArrays(ofCells) +
                                " Put the filter Cell Data to Point Data before this one, or open the file with a "
                                "reader that gives points (for TIFF the TIFF Series Reader).");
  }
  // A ParaView proxy without information about the image's arrays passes an empty name.
  const bool unnamed = chosen.Name && !*chosen.Name;
  vtkAbstractArray* scalars = chosen.Array || !unnamed ? chosen.Array : arrays->GetScalars();
  if (scalars && chosen.Association != vtkDataObject::FIELD_ASSOCIATION_POINTS)
  {
    throw chainmail::InputError("Scalars is a cell array, but tissue is made from point data. Choose a point array, or "
                                "put Cell Data to Point Data before this filter.");
  }
  if (!scalars && chosen.Name)
  {
    throw chainmail::InputError("The input image has no point array called \"" + std::string(chosen.Name) +
                                "\" to take as scalars. " + ListArrays(arrays) + " Choose one of these.");
  }
  if (!scalars)
  {
    throw chainmail::InputError(
      "The input image has no active point scalars to tell tissue from air. " + ListArrays(arrays) +
      (arrays->GetNumberOfArrays() > 0 ? " Choose one of these." : " Give an image with point scalars."));
  }
  return NumbersOf("Scalars", scalars);
}

/// The point array that a property names; null where the name is empty.
vtkDataArray* ReadNamed(vtkPointData* arrays, const std::string& property, const std::string& name)
{
  if (name.empty())
  {
    return nullptr;
  }
  vtkAbstractArray* array = arrays->GetAbstractArray(name.c_str());
  if (!array)
  {
    throw chainmail::InputError("The input image has no point array called \"" + name + "\" to take as " + property +
                                ". " + ListArrays(arrays) + " Choose one of these, or none.");
  }
  return NumbersOf(property, array);
}

/// A point array of a leaf; null where there is none of that name. Throws InputError where its number of components or
/// tuples is wrong.
vtkDataArray* FindNumbers(const InputDataset& leaf, const char* name, int components)
{
  vtkAbstractArray* array = leaf.Data->GetPointData()->GetAbstractArray(name);
  if (!array)
  {
    return nullptr;
  }
  vtkDataArray* numbers = vtkDataArray::SafeDownCast(array);
  if (!numbers || numbers->GetNumberOfComponents() != components ||
      numbers->GetNumberOfTuples() != leaf.Data->GetNumberOfPoints())
  {
    throw chainmail::InputError(leaf.ToString() + ": the point array \"" + name + "\" has to hold " +
                                std::to_string(components) + (components == 1 ? " number" : " numbers") +
                                " for every point; it holds " +
                                (numbers ? std::to_string(numbers->GetNumberOfComponents()) + " for each of " +
                                             std::to_string(numbers->GetNumberOfTuples()) + " points."
                                         : std::string("no numbers.")));
  }
  return numbers;
}

}

Scene::Scene(const vtkChainMail::Properties& properties, const Inputs& inputs, const ChosenArray& scalars,
  const TissueSource& tissueBefore, LabelVoxels& labels)
  : Properties(properties)
  , Given(inputs)
  , Image(inputs.Image)
  , Whole(inputs.GetWhole())
  , Space(this->Whole)
  , Output(properties, this->Whole)
  , BackgroundValue(properties.BackgroundValue)
  , LabelArrays(properties.LabelArrays)
{
  this->Interactive = Checked("Mode", properties.Mode) == Modes::Interactive;
  this->How = ReadMethod(properties);
  Checked("Interpolation", properties.Interpolation);
  Checked("MaterialPreset", properties.MaterialPreset);
  this->CheckPointArrays();
  this->ReadTissue(scalars, tissueBefore);
  this->ReadRegions();
  this->ReadProbes();
  this->ReadPoses(labels);
  this->Cuts = ReadCuts(inputs, this->Space);
  this->Carves = ReadCarves(inputs, this->Space);
  this->ReadMaterial(); // last, because it may read all scalars for their statistics
}

std::string Scene::NameOf(std::size_t probe) const
{
  const ProbeOrigin& origin = this->ProbeOrigins[probe];
  return this->Given.Leaves[origin.InputDataset].ToString() + ", point " + std::to_string(origin.Point) + " at " +
         ToString(origin.Position.data());
}

void Scene::CheckPointArrays() const
{
  const auto check = [](vtkAbstractArray* array, const char* kind, vtkIdType places, const char* ofImage)
  {
    if (array->GetNumberOfTuples() != places)
    {
      throw chainmail::InputError("The " + std::string(kind) + " array \"" +
                                  (array->GetName() ? array->GetName() : "") + "\" has " +
                                  std::to_string(array->GetNumberOfTuples()) + " tuples, but the input image has " +
                                  std::to_string(places) + " " + ofImage + ". Remove it, or give it a value for each.");
    }
  };
  vtkPointData* arrays = this->Image->GetPointData();
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    check(arrays->GetAbstractArray(a), "point", this->Image->GetNumberOfPoints(), "voxels");
  }
  // The only cell array that is read.
  if (vtkAbstractArray* ghosts = this->Image->GetCellData()->GetAbstractArray(vtkDataSetAttributes::GhostArrayName()))
  {
    check(ghosts, "cell", this->Image->GetNumberOfCells(), "cells");
  }
  for (const std::string& name : this->LabelArrays)
  {
    if (!arrays->HasArray(name.c_str()))
    {
      throw chainmail::InputError("LabelArrays names \"" + name + "\", which is no point array of the input image. " +
                                  ListArrays(arrays) + " Remove that name or choose one of these.");
    }
  }
}

/// An array of the image, also of one that is spread.
ArrayContents Scene::ContentsOf(vtkDataArray* array, const ArrayContents& before) const
{
  ArrayContents contents;
  if (this->Given.Spread)
  {
    contents.Array = array;
    contents.Values = this->Given.Spread->FingerprintFor(array);
  }
  else
  {
    contents.Take(array, this->Image->GetMTime(), before);
  }
  return contents;
}

void Scene::ReadTissue(const ChosenArray& chosen, const TissueSource& before)
{
  vtkPointData* arrays = this->Image->GetPointData();
  this->Scalars = ReadScalars(this->Image, chosen);
  vtkDataArray* constraints = ReadNamed(arrays, "ConstraintArray", this->Properties.ConstraintArray);

  TissueSource& tissue = this->Tissue;
  tissue.Scalars = this->ContentsOf(this->Scalars, before.Scalars);
  if (constraints)
  {
    tissue.Constraints = this->ContentsOf(constraints, before.Constraints);
  }

  this->ReadBodies(before);

  this->Whole->GetDimensions(tissue.Size.data());
  tissue.Spacing = this->Space.GetSpacing();
  tissue.GetGrid().check(); // the model checks it again, but only after the statistics have read all scalars
  tissue.Anchors.rigid = this->Properties.AnchorRigid;
  for (int f = 0; f < 6; ++f)
  {
    // In a single slice all voxels lie on both faces of its axis, so these do not anchor it.
    tissue.Anchors.faces[f] = this->Properties.AnchoredFaces[f] != 0 && tissue.Size[f / 2] > 1;
  }
  tissue.Settings.device = this->Properties.Device;
  tissue.Settings.brickSize = this->Properties.BrickSize;
  tissue.Settings.modelReduction = this->Properties.ModelReduction;
  tissue.Settings.rotations = this->Properties.Rotations;
  tissue.Settings.poissonRatio = this->Properties.PoissonRatio;
}

void Scene::ReadBodies(const TissueSource& before)
{
  vtkDataArray* labels = ReadNamed(this->Image->GetPointData(), "BodyArray", this->Properties.BodyArray);
  const bool divides = (labels || this->Properties.JointSize > 0) && this->Properties.JointConstraint > 0.0;
  TissueSource& tissue = this->Tissue;
  if (labels)
  {
    this->LabelArrays.emplace_back(this->Properties.BodyArray);
  }
  if (divides && labels)
  {
    tissue.Bodies = this->ContentsOf(labels, before.Bodies);
  }
  if (divides)
  {
    tissue.JointSize = this->Properties.JointSize;
    tissue.JointConstraint = this->Properties.JointConstraint;
    tissue.JointMargin = this->Properties.JointMargin;
  }
}

void Scene::ReadMaterial()
{
  TissueSource& tissue = this->Tissue;
  const MaterialPresets preset = this->Properties.MaterialPreset;
  const bool isFunction = preset == MaterialPresets::Function;
  vtkPiecewiseFunction* given = isFunction ? this->Properties.MaterialFunction : nullptr;
  tissue.Threshold = isFunction ? this->Properties.TissueThreshold : vtkMath::Nan();

  const auto statistics = this->Given.Spread ? this->Given.Spread->GetStatistics(this->Scalars)
                                             : vtkChainMailScanStatistics::Of(this->Image, this->Scalars);
  vtkNew<vtkPiecewiseFunction> function;
  double fitted;
  statistics->GetMaterial(static_cast<int>(preset), fitted, function);
  tissue.Threshold = std::isnan(tissue.Threshold) ? fitted : tissue.Threshold;
  tissue.HighPadding = statistics->GetHighPadding();
  // With a threshold below the padding, the padding is tissue.
  this->LowPadding = statistics->GetLowPadding() < tissue.Threshold ? statistics->GetLowPadding() : -vtkMath::Inf();
  if (std::isnan(this->BackgroundValue) && this->Scalars->GetNumberOfComponents() == 1)
  {
    this->BackgroundValue = statistics->GetBackgroundValue();
  }
  this->AreLabels = statistics->GetKind() == vtkChainMailScanStatistics::KIND_LABELS;
  this->Guess = statistics->GetDescription();
  if (tissue.Threshold == fitted)
  {
    this->Doubt = statistics->GetDoubt(static_cast<int>(preset));
  }
  else
  {
    this->Guess = "Air below " + ToString(tissue.Threshold) + ", as set. " + this->Guess;
  }
  if (tissue.Constraints.Array)
  {
    return; // the function is not used
  }
  if (given)
  {
    function->DeepCopy(given);
    if (given->GetSize() == 0)
    {
      throw chainmail::InputError(
        "MaterialFunction has no nodes. Add some, or unset it: the filter then fits a function to the scalars.");
    }
  }
  for (int n = 0; n < function->GetSize(); ++n)
  {
    double node[4]; // scalar, constraint, midpoint, sharpness
    function->GetNodeValue(n, node);
    if (!(node[1] >= 0.0 && static_cast<float>(node[1]) < 1.0f))
    {
      throw chainmail::InputError(
        "MaterialFunction is " + ToString(node[1]) + " for a scalar of " + ToString(node[0]) +
        ". A constraint is a fraction of the spacing from 0 (rigid) to less than 1: move that node.");
    }
    tissue.Function.insert(tissue.Function.end(), node, node + 4);
  }
  tissue.Function.push_back(function->GetClamping());
  tissue.Function.push_back(function->GetUseLogScale());
}

void Scene::ReadRegions()
{
  for (const InputDataset& leaf : this->Given.Leaves)
  {
    if (leaf.Port != REGIONS)
    {
      continue;
    }
    vtkDataArray* radii = FindNumbers(leaf, "Radius", 1);
    vtkDataArray* constraints = FindNumbers(leaf, "Constraint", 1);
    if (!radii || !constraints)
    {
      throw chainmail::InputError(leaf.ToString() +
                                  ": a region needs the point arrays \"Radius\" and \"Constraint\". " +
                                  ListArrays(leaf.Data->GetPointData()) + " Add what is missing.");
    }
    for (vtkIdType p = 0; p < leaf.Data->GetNumberOfPoints(); ++p)
    {
      double place[3];
      leaf.Data->GetPoint(p, place);
      const double radius = radii->GetTuple1(p);
      const double constraint = constraints->GetTuple1(p);
      if (!IsFinite(place) || !(radius >= 0.0) || !std::isfinite(radius) || !(constraint >= 0.0) ||
          !(static_cast<float>(constraint) < 1.0f))
      {
        throw chainmail::InputError(leaf.ToString() + ", point " + std::to_string(p) +
                                    ": a region needs a finite place, a radius of 0 or more (it is " +
                                    ToString(radius) + ") and a constraint from 0 (rigid) to less than 1 (it is " +
                                    ToString(constraint) + ").");
      }
      const Vector3 centre = this->Space.PointToEngine(place);
      this->Tissue.Regions.insert(this->Tissue.Regions.end(), centre.begin(), centre.end());
      this->Tissue.Regions.push_back(radius);
      this->Tissue.Regions.push_back(constraint + 0.0); // -0 is 0
      this->RegionNames.push_back(leaf.ToString() + ", point " + std::to_string(p));
    }
  }
}

void Scene::ReadProbes()
{
  for (std::size_t l = 0; l < this->Given.Leaves.size(); ++l)
  {
    const InputDataset& leaf = this->Given.Leaves[l];
    if (leaf.Port != PROBES)
    {
      continue;
    }
    vtkPolyData* points = leaf.Data;
    const vtkIdType numberOfPoints = points->GetNumberOfPoints();
    vtkDataArray* displacements = FindNumbers(leaf, "Displacement", 3);
    vtkDataArray* radii = FindNumbers(leaf, "Radius", 1);
    vtkDataArray* anchors = FindNumbers(leaf, "Anchor", 1);
    vtkDataArray* tolerances = FindNumbers(leaf, "Tolerance", 1);

    for (vtkIdType p = 0; p < numberOfPoints; ++p)
    {
      ProbeOrigin origin{ l, p, {} };
      double* position = origin.Position.data();
      points->GetPoint(p, position);
      this->ProbeOrigins.push_back(origin);
      const std::string name = this->NameOf(this->Probes.size());
      if (!IsFinite(position))
      {
        throw chainmail::InputError(name + ": the position has to be finite. Set one on the tissue.");
      }
      chainmail::Probe probe;
      probe.position = this->Space.PointToEngine(position);
      probe.anchor = anchors && anchors->GetTuple1(p) != 0.0;
      probe.radius = radii ? radii->GetTuple1(p) : 0.0;
      if (!(probe.radius >= 0.0) || !std::isfinite(probe.radius))
      {
        throw chainmail::InputError(name + ": the radius is " + ToString(probe.radius) +
                                    "; it has to be 0 (the nearest element) or a positive length.");
      }
      probe.tolerance = tolerances ? tolerances->GetTuple1(p) : 0.0;
      if (!(probe.tolerance >= 0.0) || !std::isfinite(probe.tolerance))
      {
        throw chainmail::InputError(name + ": the tolerance is " + ToString(probe.tolerance) +
                                    "; it has to be 0 (the tissue goes exactly there) or a positive length.");
      }
      if (!probe.anchor && !displacements)
      {
        throw chainmail::InputError(
          name + ": the input has no point array \"Displacement\", which sets how far to pull. " +
          ListArrays(points->GetPointData()) +
          " Add one with 3 components, or an array \"Anchor\" that is not 0 where tissue is to be held in place.");
      }
      if (!probe.anchor)
      {
        double displacement[3];
        displacements->GetTuple(p, displacement);
        if (!IsFinite(displacement))
        {
          throw chainmail::InputError(name + ": the displacement " + ToString(displacement) +
                                      " has to be finite. Give the probe another target.");
        }
        probe.displacement = this->Space.VectorToEngine(displacement);
      }
      this->Probes.push_back(probe);
    }
  }
}

/// Reads the arrays `Rotation`, `Centre` and `Body` of the probes.
void Scene::ReadPoses(LabelVoxels& labels)
{
  constexpr double radians = 3.14159265358979323846 / 180.0;
  std::vector<std::pair<std::size_t, vtkTypeInt64>> bodies; // probe, label
  for (std::size_t n = 0; n < this->Probes.size(); ++n)
  {
    chainmail::Probe& probe = this->Probes[n];
    const ProbeOrigin& origin = this->ProbeOrigins[n];
    const InputDataset& leaf = this->Given.Leaves[origin.InputDataset];
    const auto read = [&](const char* name, int components, double* values)
    {
      vtkDataArray* numbers = FindNumbers(leaf, name, components);
      if (!numbers)
      {
        return false;
      }
      numbers->GetTuple(origin.Point, values);
      for (int a = 0; a < components; ++a)
      {
        if (!std::isfinite(values[a]))
        {
          throw chainmail::InputError(this->NameOf(n) + ": the point array \"" + name + "\" has to be finite.");
        }
      }
      return true;
    };
    double rotation[3] = { 0.0, 0.0, 0.0 };
    double centre[3] = { origin.Position[0], origin.Position[1], origin.Position[2] };
    double body = anyBody;
    const bool hasRotation = read("Rotation", 3, rotation);
    read("Centre", 3, centre);
    const bool hasBody = read("Body", 1, &body);
    if (probe.anchor || !(hasRotation || hasBody))
    {
      continue;
    }
    const bool rotates = rotation[0] != 0.0 || rotation[1] != 0.0 || rotation[2] != 0.0;
    if (rotates && !this->Properties.Rotations)
    {
      throw chainmail::InputError(this->NameOf(n) + ": the probe prescribes a rotation, which needs Rotations. Switch "
                                                    "Rotations on, or remove the point array \"Rotation\".");
    }
    if (rotates && this->How.propagationIterations != 0)
    {
      throw chainmail::InputError(
        this->NameOf(n) +
        ": the probe prescribes a rotation, which needs a propagation without limit. Set PropagationIterations to 0.");
    }
    probe.rotates = this->Properties.Rotations;
    probe.rotation = this->Space.AxialToEngine(rotation);
    for (double& part : probe.rotation)
    {
      part *= radians;
    }
    probe.centre = this->Space.PointToEngine(centre);
    if (body != anyBody)
    {
      if (!(body >= 1.0 && body <= 9e18) || std::nearbyint(body) != body)
      {
        throw chainmail::InputError(
          this->NameOf(n) + ": \"Body\" is " + ToString(body) +
          "; it has to be a label of BodyArray, a whole number from 1 on, or -1 for the tissue at the point.");
      }
      bodies.emplace_back(n, static_cast<vtkTypeInt64>(body));
    }
  }
  if (bodies.empty())
  {
    return;
  }
  vtkDataArray* array = ReadNamed(this->Image->GetPointData(), "BodyArray", this->Properties.BodyArray);
  if (!array)
  {
    throw chainmail::InputError(
      this->NameOf(bodies.front().first) +
      ": the probe has the label of a body (\"Body\"), but BodyArray is empty in the filter for this image. " +
      ListArrays(this->Image->GetPointData()) + " Choose one of these.");
  }
  std::vector<vtkTypeInt64> wanted;
  std::transform(
    bodies.begin(), bodies.end(), std::back_inserter(wanted), [](const auto& body) { return body.second; });
  labels.Read(this->ContentsOf(array, labels.GetContents()), this->Given.Spread.get(), this->Tissue.GetGrid(), wanted);
  for (const auto& [n, label] : bodies)
  {
    const LabelVoxels::Body& body = labels.Get(label);
    if (body.Voxels->empty())
    {
      throw chainmail::InputError(this->NameOf(n) + ": no voxel of BodyArray \"" + this->Properties.BodyArray +
                                  "\" has the label " + std::to_string(label) +
                                  " (\"Body\"). Set a label that the array has, or -1 for the tissue at the point.");
    }
    this->Probes[n].voxels = body.Voxels;
    this->Probes[n].body = body.Number;
  }
}

}
