// SPDX-License-Identifier: BSD-3-Clause
// The defaults that the header documents are the real ones, ranges are kept, and setters report changes and only those.

#include "FilterTest.h"

#include "vtkDataArraySelection.h"

#include "vtkPiecewiseFunction.h"

#include <fstream>
#include <sstream>

using namespace FilterTest;

namespace
{

/// What stands after "Default: " in the comment before `code` in the header.
std::string DocumentedDefault(const std::string& header, const std::string& code)
{
  const std::size_t at = header.find(code);
  const std::size_t comment = at == std::string::npos ? at : header.rfind("/**", at);
  if (comment == std::string::npos)
  {
    return "no comment for " + code;
  }
  std::string text = header.substr(comment, header.find("*/", comment) - comment);
  for (std::size_t newline = text.find("\n   *"); newline != std::string::npos; newline = text.find("\n   *"))
  {
    text.erase(newline, 5);
  }
  const std::size_t start = text.find("Default: ");
  if (start == std::string::npos)
  {
    return "no default documented for " + code;
  }
  text = text.substr(start + 9);
  // Up to the end of the sentence, or to an explanation after a comma.
  for (std::size_t end = 0; end < text.size(); ++end)
  {
    if (text[end] == ',' || (text[end] == '.' && (end + 1 == text.size() || std::isspace(text[end + 1]))))
    {
      return text.substr(0, end);
    }
  }
  return text;
}

}

int TestChainMailDefaults(int, char*[])
{
  Checks check;
  const std::string here = __FILE__;
  std::ifstream file(here.substr(0, here.find_last_of('/')) + "/../../Filters/vtkChainMailDeformation.h");
  std::stringstream content;
  content << file.rdbuf();
  const std::string header = content.str();
  check.That(!header.empty(), "the header is found beside the test");

  vtkNew<vtkChainMailDeformation> filter;
  const auto number = [&](const std::string& name, double actual)
  {
    const std::string documented = DocumentedDefault(header, "vtkGetMacro(" + name + ",");
    char* end = nullptr;
    const double value = std::strtod(documented.c_str(), &end);
    check.That(end && end != documented.c_str() && *end == '\0', name + " has a number as default: " + documented);
    check.That(
      value == actual || (std::isnan(value) && std::isnan(actual)), "default of " + name + " is " + documented);
  };
  const auto word = [&](const std::string& code, const std::string& actual)
  { check.Equal(actual, DocumentedDefault(header, code), "default before " + code); };
  const auto vector = [&](const auto* values, int size)
  {
    std::ostringstream text;
    for (int n = 0; n < size; ++n)
    {
      text << (n ? " " : "") << values[n];
    }
    return text.str();
  };
  const char* presets[] = { "MATERIAL_FUNCTION", "MATERIAL_CT", "MATERIAL_MR" };
  const char* interpolations[] = { "INTERPOLATION_LINEAR", "INTERPOLATION_NEAREST" };
  const char* modes[] = { "MODE_FROM_REST", "MODE_INTERACTIVE" };
  const char* propagations[] = { "PROPAGATION_ENVELOPE", "PROPAGATION_TIMESTAMP" };
  const char* conflicts[] = { "CONFLICT_LIMIT", "CONFLICT_LATEST", "CONFLICT_SHARE" };
  const char* relaxations[] = { "RELAXATION_PROJECTED", "RELAXATION_PAPER" };
  word("vtkGetMacro(MaterialPreset,", presets[filter->GetMaterialPreset()]);
  word("GetMaterialFunction()", filter->GetMaterialFunction() ? "a function" : "null");
  word("vtkGetCharFromStdStringMacro(ConstraintArray)", "\"" + std::string(filter->GetConstraintArray()) + "\"");
  word("vtkGetCharFromStdStringMacro(BodyArray)", "\"" + std::string(filter->GetBodyArray()) + "\"");
  number("JointSize", filter->GetJointSize());
  number("JointConstraint", filter->GetJointConstraint());
  number("JointMargin", filter->GetJointMargin());
  number("TissueThreshold", filter->GetTissueThreshold());
  word("vtkGetMacro(AnchorRigid,", filter->GetAnchorRigid() ? "on" : "off");
  word("vtkGetVector6Macro(AnchoredFaces,", vector(filter->GetAnchoredFaces(), 6));
  word("vtkGetMacro(Mode,", modes[filter->GetMode()]);
  word("vtkGetMacro(PropagationMethod,", propagations[filter->GetPropagationMethod()]);
  number("PropagationIterations", filter->GetPropagationIterations());
  word("vtkGetMacro(ConflictPolicy,", conflicts[filter->GetConflictPolicy()]);
  word("vtkGetMacro(PropagationTimes,", filter->GetPropagationTimes() ? "on" : "off");
  word("vtkGetMacro(SmoothCuts,", filter->GetSmoothCuts() ? "on" : "off");
  word("vtkGetMacro(PullBack,", filter->GetPullBack() ? "on" : "off");
  number("ScalarSmoothing", filter->GetScalarSmoothing());
  std::string modelArrays;
  vtkDataArraySelection* const selection = filter->GetModelArraySelection();
  for (int n = 0; n < selection->GetNumberOfArrays(); ++n)
  {
    modelArrays += selection->GetArraySetting(n)
                     ? (modelArrays.empty() ? "" : " and ") + std::string(selection->GetArrayName(n))
                     : "";
  }
  word("GetModelArraySelection()", modelArrays);
  word("vtkGetMacro(RelaxationMethod,", relaxations[filter->GetRelaxationMethod()]);
  const char* relaxationPresets[] = { "RELAXATION_CUSTOM", "RELAXATION_FAST", "RELAXATION_BALANCED",
    "RELAXATION_ACCURATE" };
  word("vtkGetMacro(RelaxationPreset,", relaxationPresets[filter->GetRelaxationPreset()]);
  word("vtkGetMacro(CoarseToFine,", filter->GetCoarseToFine() ? "on" : "off");
  number("ElasticRecovery", filter->GetElasticRecovery());
  word("vtkGetMacro(Rotations,", filter->GetRotations() ? "on" : "off");
  number("PoissonRatio", filter->GetPoissonRatio());
  number("RelaxationIterations", filter->GetRelaxationIterations());
  number("RelaxationTolerance", filter->GetRelaxationTolerance());
  word("vtkGetMacro(Interpolation,", interpolations[filter->GetInterpolation()]);
  word("int GetNumberOfLabelArrays()", filter->GetNumberOfLabelArrays() == 0 ? "none" : "some");
  number("BackgroundValue", filter->GetBackgroundValue());
  number("OutputPadding", filter->GetOutputPadding());
  number("OutputMagnification", filter->GetOutputMagnification());
  word("vtkGetMacro(UseOutputBounds,", filter->GetUseOutputBounds() ? "on" : "off");
  word("vtkGetVector6Macro(OutputBounds,", vector(filter->GetOutputBounds(), 6));
  word("vtkGetCharFromStdStringMacro(Device)", "\"" + std::string(filter->GetDevice()) + "\"");
  number("ModelReduction", filter->GetModelReduction());
  word("vtkGetVector3Macro(BrickSize,", vector(filter->GetBrickSize(), 3));

  // Ranges.
  filter->SetPropagationIterations(-1);
  check.Equal(filter->GetPropagationIterations(), 0, "PropagationIterations from 0");
  filter->SetElasticRecovery(-0.1);
  check.Equal(filter->GetElasticRecovery(), 0.0, "ElasticRecovery from 0");
  filter->SetElasticRecovery(1.1);
  check.Equal(filter->GetElasticRecovery(), 1.0, "ElasticRecovery to 1");
  filter->SetPoissonRatio(-0.1);
  check.Equal(filter->GetPoissonRatio(), 0.0, "PoissonRatio from 0");
  filter->SetPoissonRatio(0.5);
  check.Equal(filter->GetPoissonRatio(), 0.49, "PoissonRatio to 0.49");
  filter->SetRelaxationIterations(-1);
  check.Equal(filter->GetRelaxationIterations(), 0, "RelaxationIterations from 0");
  filter->SetRelaxationTolerance(-1.0);
  check.Equal(filter->GetRelaxationTolerance(), 0.0, "RelaxationTolerance from 0");
  filter->SetJointSize(-1);
  check.Equal(filter->GetJointSize(), 0, "JointSize from 0");
  filter->SetJointSize(1000);
  check.Equal(filter->GetJointSize(), 256, "JointSize to 256");
  filter->SetJointConstraint(-0.5);
  check.Equal(filter->GetJointConstraint(), 0.0, "JointConstraint from 0");
  filter->SetJointConstraint(1.5);
  check.Equal(filter->GetJointConstraint(), 1.0, "JointConstraint to 1");
  filter->SetJointMargin(0);
  check.Equal(filter->GetJointMargin(), 1, "JointMargin from 1");
  filter->SetOutputPadding(-1);
  check.Equal(filter->GetOutputPadding(), 0, "OutputPadding from 0");
  filter->SetOutputPadding(1000000);
  check.Equal(filter->GetOutputPadding(), 4096, "OutputPadding to 4096");
  filter->SetOutputMagnification(0);
  check.Equal(filter->GetOutputMagnification(), 1, "OutputMagnification from 1");
  filter->SetOutputMagnification(5);
  check.Equal(filter->GetOutputMagnification(), 4, "OutputMagnification to 4");
  // A choice that stands for nothing is told by the update (TestChainMailErrors), and printed.
  vtkNew<vtkChainMailDeformation> strange;
  strange->SetMode(7);
  strange->SetInterpolation(-9);
  std::ostringstream strangeText;
  strange->PrintSelf(strangeText, vtkIndent());
  check.Contains(strangeText.str(), "Mode: (unknown)", "PrintSelf");
  check.Contains(strangeText.str(), "Interpolation: (unknown)", "PrintSelf");

  // A setter that changes something modifies the filter, once; repeated it does not, not even with NaN.
  vtkNew<vtkPiecewiseFunction> function;
  const std::pair<const char*, std::function<void()>> setters[] = {
    { "MaterialPreset", [&] { filter->SetMaterialPresetToCT(); } },
    { "MaterialFunction", [&] { filter->SetMaterialFunction(function); } },
    { "ConstraintArray", [&] { filter->SetConstraintArray("fractions"); } },
    { "BodyArray", [&] { filter->SetBodyArray("bones"); } },
    { "JointSize", [&] { filter->SetJointSize(4); } },
    { "JointConstraint", [&] { filter->SetJointConstraint(0.25); } },
    { "JointMargin", [&] { filter->SetJointMargin(7); } },
    { "TissueThreshold", [&] { filter->SetTissueThreshold(5.0); } },
    { "TissueThreshold NaN", [&] { filter->SetTissueThreshold(std::nan("")); } },
    { "AnchorRigid", [&] { filter->AnchorRigidOn(); } },
    { "AnchoredFaces", [&] { filter->SetAnchoredFaces(0, 1, 0, 1, 1, 0); } },
    { "Mode", [&] { filter->SetModeToInteractive(); } },
    { "PropagationMethod", [&] { filter->SetPropagationMethodToTimestamp(); } },
    { "PropagationIterations", [&] { filter->SetPropagationIterations(10); } },
    { "ConflictPolicy", [&] { filter->SetConflictPolicyToLatest(); } },
    { "PropagationTimes", [&] { filter->PropagationTimesOn(); } },
    { "ModelArrays", [&] { filter->GetModelArraySelection()->EnableArray("Cluster"); } },
    { "RelaxationMethod", [&] { filter->SetRelaxationMethodToPaper(); } },
    { "ElasticRecovery", [&] { filter->SetElasticRecovery(0.8); } },
    { "Rotations", [&] { filter->SetRotations(true); } },
    { "PoissonRatio", [&] { filter->SetPoissonRatio(0.3); } },
    { "RelaxationIterations", [&] { filter->SetRelaxationIterations(7); } },
    { "RelaxationTolerance", [&] { filter->SetRelaxationTolerance(0.5); } },
    { "Interpolation", [&] { filter->SetInterpolationToNearest(); } },
    { "AddLabelArray", [&] { filter->AddLabelArray("labels"); } },
    { "RemoveLabelArray", [&] { filter->RemoveLabelArray("labels"); } },
    { "BackgroundValue", [&] { filter->SetBackgroundValue(-1000.0); } },
    { "BackgroundValue NaN", [&] { filter->SetBackgroundValue(std::nan("")); } },
    { "OutputPadding", [&] { filter->SetOutputPadding(3); } },
    { "OutputMagnification", [&] { filter->SetOutputMagnification(2); } },
    { "UseOutputBounds", [&] { filter->UseOutputBoundsOn(); } },
    { "OutputBounds", [&] { filter->SetOutputBounds(0, 2, 0, 3, 0, 4.5); } },
    { "SmoothCuts", [&] { filter->SmoothCutsOff(); } },
    { "PullBack", [&] { filter->PullBackOn(); } },
    { "ScalarSmoothing", [&] { filter->SetScalarSmoothing(0.75); } },
    { "Device", [&] { filter->SetDevice("some"); } },
    { "BrickSize", [&] { filter->SetBrickSize(8, 4, 2); } },
    { "ModelReduction", [&] { filter->SetModelReduction(4); } },
  };
  for (const auto& setter : setters)
  {
    const vtkMTimeType before = filter->GetMTime();
    setter.second();
    const vtkMTimeType after = filter->GetMTime();
    setter.second();
    check.That(after > before, std::string(setter.first) + " modifies");
    check.That(filter->GetMTime() == after, std::string(setter.first) + " again does not");
  }
  // Reset() always has something to do in Interactive mode and never in the other; before the first update nothing is
  // left to do.
  vtkMTimeType now = filter->GetMTime();
  filter->Reset();
  check.That(filter->GetMTime() > now, "Reset modifies");
  check.That(!filter->GetNeedsUpdate(), "a filter that was never updated needs no other update");
  vtkNew<vtkChainMailDeformation> fromRest;
  now = fromRest->GetMTime();
  fromRest->Reset();
  check.That(fromRest->GetMTime() == now, "Reset from rest does nothing");

  const vtkMTimeType before = filter->GetMTime();
  function->AddPoint(1.0, 0.5);
  check.That(filter->GetMTime() > before, "editing the material function modifies the filter");

  // Label arrays by name.
  filter->AddLabelArray("a");
  filter->AddLabelArray("b");
  filter->AddLabelArray("a");
  filter->AddLabelArray("");
  check.Equal(filter->GetNumberOfLabelArrays(), 2, "label arrays are a set");
  check.Equal(std::string(filter->GetLabelArray(1)), std::string("b"), "label arrays keep their order");
  check.That(filter->GetLabelArray(2) == nullptr && filter->GetLabelArray(-1) == nullptr, "no such label array");
  filter->RemoveLabelArray("a");
  check.That(!filter->HasLabelArray("a") && filter->HasLabelArray("b"), "label array removed by name");
  filter->ClearLabelArrays();
  check.Equal(filter->GetNumberOfLabelArrays(), 0, "no label arrays");

  std::ostringstream text;
  filter->PrintSelf(text, vtkIndent());
  for (const char* line :
    { "MaterialPreset: CT", "MaterialFunction: \n", "ConstraintArray: fractions", "BodyArray: bones", "JointSize: 4",
      "JointConstraint: 0.25", "JointMargin: 7", "TissueThreshold: nan", "AnchorRigid: On",
      "AnchoredFaces: 0 1 0 1 1 0", "Mode: Interactive", "PropagationMethod: Timestamp", "PropagationIterations: 10",
      "ConflictPolicy: Latest", "PropagationTimes: On", "ModelArrays: Displacement Element no Constraint Cluster",
      "RelaxationMethod: Paper", "ElasticRecovery: 0.8", "PoissonRatio: 0.3", "RelaxationIterations: 7",
      "RelaxationTolerance: 0.5", "Interpolation: Nearest", "LabelArrays:", "BackgroundValue: nan", "OutputPadding: 3",
      "OutputMagnification: 2", "UseOutputBounds: On", "OutputBounds: 0 2 0 3 0 4.5", "SmoothCuts: Off", "PullBack: On",
      "ScalarSmoothing: 0.75", "Device: some", "BrickSize: 8 4 2", "ModelReduction: 4" })
  {
    check.Contains(text.str(), line, "PrintSelf");
  }

  // Fitted materials. CT: signed range. Rigid bone, soft fat, air below -300.
  double threshold = 0.0;
  const double ct[2] = { -1024.0, 3071.0 };
  vtkChainMailDeformation::FitMaterial(ct, threshold, function);
  check.Equal(threshold, -300.0, "CT: threshold");
  check.Equal(function->GetValue(600.0), 0.0, "CT: bone is rigid");
  check.That(function->GetValue(500.0) > 0.0, "CT: contrast agent is not");
  check.Equal(function->GetValue(2000.0), 0.0, "CT: beyond the last node too");
  check.Near(function->GetValue(50.0), 0.2, 1e-6, "CT: muscle");
  check.That(function->GetValue(-100.0) > function->GetValue(50.0), "CT: fat is softer than muscle");
  double presetThreshold = 0.0;
  vtkNew<vtkPiecewiseFunction> preset;
  vtkChainMailDeformation::GetPresetMaterial(vtkChainMailDeformation::MATERIAL_CT, ct, presetThreshold, preset);
  check.Equal(presetThreshold, threshold, "CT: the preset is what is fitted to a signed range");
  for (int n = 0; n < preset->GetSize(); ++n)
  {
    double a[4];
    double b[4];
    preset->GetNodeValue(n, a);
    function->GetNodeValue(n, b);
    check.That(a[0] == b[0] && a[1] == b[1], "CT: the same nodes");
  }
  // Other ranges: relative to the range; never rigid; all constraints in [0, 1).
  const double ranges[][2] = { { 0.0, 255.0 }, { 0.0, 4095.0 }, { -200.0, 50.0 }, { 0.001, 0.002 }, { 7.0, 7.0 },
    { 1.0, -1.0 }, { -1e300, 1e300 }, { 0.0, std::numeric_limits<double>::infinity() } };
  for (const auto& range : ranges)
  {
    for (int which : { vtkChainMailDeformation::MATERIAL_FUNCTION, vtkChainMailDeformation::MATERIAL_MR })
    {
      vtkChainMailDeformation::GetPresetMaterial(which, range, threshold, function);
      const std::string where = "range from " + std::to_string(range[0]) + ": ";
      check.That(std::isfinite(threshold), where + "finite threshold");
      if (range[0] < range[1] && range[1] <= 1e299 && range[0] >= -1e299)
      {
        check.Near((threshold - range[0]) / (range[1] - range[0]), 0.1, 1e-9, where + "threshold at a tenth");
        check.That(function->GetValue(threshold) > 0.0, where + "soft at the threshold");
        check.That(function->GetValue(range[1]) > 0.0, where + "nothing rigid");
      }
      check.That(function->GetSize() > 0, where + "nodes");
      for (int n = 0; n < function->GetSize(); ++n)
      {
        double node[4];
        function->GetNodeValue(n, node);
        check.That(node[1] >= 0.0 && node[1] < 1.0 && std::isfinite(node[0]), where + "valid node");
      }
    }
  }
  const double mr[2] = { 0.0, 1000.0 };
  vtkChainMailDeformation::GetPresetMaterial(vtkChainMailDeformation::MATERIAL_MR, mr, threshold, function);
  check.That(function->GetValue(900.0) > function->GetValue(300.0), "MR: bright fat is softer than muscle");
  vtkChainMailDeformation::FitMaterial(mr, threshold, function);
  check.That(function->GetValue(900.0) < function->GetValue(300.0), "unknown: brighter is stiffer");
  vtkChainMailDeformation::FitMaterial(mr, threshold, nullptr);
  check.Equal(threshold, 100.0, "the function may be null");
  return check.Finish();
}
