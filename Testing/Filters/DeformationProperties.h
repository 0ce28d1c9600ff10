// SPDX-License-Identifier: BSD-3-Clause
// All properties of vtkChainMailDeformation, a row for each. What holds for every property is tested by loops over
// these rows. So a new property needs a row here and no edit of those tests, and a new value of an enumerated property
// does not even need that. TestChainMailDefaults fails while a property has no row.

#ifndef DeformationProperties_h
#define DeformationProperties_h

#include "FilterTest.h"

#include "vtkDataArraySelection.h"

#include <limits>
#include <sstream>

namespace FilterTest
{

using Deformation = vtkChainMailDeformation;

struct DeformationProperty
{
  /// A call that sets the property, and what is seen of it afterwards.
  struct Setting
  {
    std::function<void(Deformation*)> Set;
    std::string Value;   ///< what DeformationProperty::Value gives
    std::string Printed; ///< the line of PrintSelf
  };

  std::string Name;
  std::string Getter; ///< as the class's header declares it, below the comment that documents the default
  std::function<std::string(Deformation*)> Value; ///< as the documentation writes it, numbers as Text() does
  std::function<void(Deformation* from, Deformation* to)> Copy;
  std::vector<Setting> Changes; ///< one after the other, each sets another value than the property has by then
  std::vector<Setting> Limits;  ///< values beyond both ends of a range, which are clamped; empty: there is no range
};

/// A number as text: with 17 digits any two numbers differ; 6 are what PrintSelf writes.
template <typename T> std::string Text(T number, int digits = 17)
{
  std::ostringstream text;
  text.precision(digits);
  text << number;
  return text.str();
}

template <typename T> std::string Texts(const T* numbers, int size, int digits = 17)
{
  std::string text;
  for (int n = 0; n < size; ++n)
  {
    text += (n > 0 ? " " : "") + Text(numbers[n], digits);
  }
  return text;
}

/// Names as the documentation lists them.
inline std::string Listed(const std::vector<std::string>& names)
{
  std::string text;
  for (const std::string& name : names)
  {
    text += (text.empty() ? "" : " and ") + name;
  }
  return text.empty() ? "none" : text;
}

/// What makes a row from the functions of a property. Macros pass these to it, see below.
namespace Rows
{

/// What most rows have in common. `value` is the text of what `get` returns.
template <typename Get, typename Set, typename Value>
DeformationProperty MakeRow(const std::string& name, const std::string& getter, Get get, Set set, Value value)
{
  DeformationProperty row;
  row.Name = name;
  row.Getter = getter;
  row.Value = [get, value](Deformation* filter) { return value(get(filter)); };
  row.Copy = [get, set](Deformation* from, Deformation* to) { set(to, get(from)); };
  return row;
}

template <typename Get, typename Set>
DeformationProperty Number(const std::string& name, Get get, Set set, const std::vector<double>& others)
{
  using T = decltype(get(nullptr));
  auto row = MakeRow(name, "vtkGetMacro(" + name + ",", get, set, [](T value) { return Text(value); });
  for (double other : others)
  {
    row.Changes.push_back(
      { [=](Deformation* filter) { set(filter, static_cast<T>(other)); }, Text(other), name + ": " + Text(other, 6) });
  }
  return row;
}

template <typename Get, typename Set>
DeformationProperty Clamped(const std::string& name, Get get, Set set, double other, double lowest, double highest)
{
  using T = decltype(get(nullptr));
  auto row = Number(name, get, set, { other });
  const auto limit = [&](double value, double kept)
  {
    row.Limits.push_back(
      { [=](Deformation* filter) { set(filter, static_cast<T>(value)); }, Text(kept), name + ": " + Text(kept, 6) });
  };
  limit(lowest - 1.0, lowest);
  if (highest < std::numeric_limits<T>::max()) // nothing is above that
  {
    limit(highest + std::max(1.0, highest), highest); // 1 would be lost in VTK_DOUBLE_MAX
  }
  return row;
}

template <typename Get, typename Set, typename Switch>
DeformationProperty Boolean(const std::string& name, Get get, Set set, Switch change, const std::string& to)
{
  auto row = MakeRow(name, "vtkGetMacro(" + name + ",", get, set, [](bool on) { return on ? "on" : "off"; });
  row.Changes = { { change, to == "On" ? "on" : "off", name + ": " + to } };
  return row;
}

/// A number of an enumeration and the name that the header gives it.
struct Constant
{
  int Number;
  std::string Name;
};

template <typename Get, typename Set, typename Choose>
DeformationProperty Enumerated(const std::string& name, Get get, Set set, const Constant& initial,
  const Constant& other, Choose choose, const std::string& word)
{
  auto row = MakeRow(name, "vtkGetMacro(" + name + ",", get, set,
    [initial, other](int number) {
      return number == initial.Number ? initial.Name : number == other.Number ? other.Name : Text(number);
    });
  row.Changes.push_back({ choose, other.Name, name + ": " + word });
  // A number that stands for nothing is kept; the update reports it (TestChainMailErrors).
  for (int strange : { 99, -9 })
  {
    row.Changes.push_back({ [=](Deformation* filter) { set(filter, strange); }, Text(strange), name + ": (unknown)" });
  }
  return row;
}

template <typename Get, typename Set>
DeformationProperty String(const std::string& name, Get get, Set set, const std::string& other)
{
  auto row = MakeRow(name, "vtkGetCharFromStdStringMacro(" + name + ")", get, set,
    [](const std::string& value) { return '"' + value + '"'; });
  row.Changes = { { [=](Deformation* filter) { set(filter, other.c_str()); }, '"' + other + '"',
    name + ": " + other } };
  return row;
}

template <typename Get, typename Set, typename Change>
DeformationProperty Numbers(
  const std::string& name, Get get, Set set, int size, Change change, const std::vector<double>& others)
{
  auto row = MakeRow(name, "vtkGetVector" + Text(size) + "Macro(" + name + ",", get, set,
    [size](const auto* values) { return Texts(values, size); });
  row.Changes = { { change, Texts(others.data(), size), name + ": " + Texts(others.data(), size, 6) } };
  return row;
}

inline DeformationProperty MaterialFunction()
{
  const auto other = vtkSmartPointer<vtkPiecewiseFunction>::New();
  const auto value = [](vtkPiecewiseFunction* function)
  { return function ? Text(static_cast<void*>(function)) : std::string("null"); };
  auto row = MakeRow(
    "MaterialFunction", "GetMaterialFunction()", [](Deformation* filter) { return filter->GetMaterialFunction(); },
    [](Deformation* filter, vtkPiecewiseFunction* function) { filter->SetMaterialFunction(function); }, value);
  // What PrintSelf writes of the function itself begins in the next line.
  row.Changes = { { [other](Deformation* filter) { filter->SetMaterialFunction(other); }, value(other),
    "MaterialFunction: " } };
  return row;
}

inline DeformationProperty ModelArrays()
{
  DeformationProperty row;
  row.Name = "ModelArrays";
  row.Getter = "GetModelArraySelection()";
  row.Value = [](Deformation* filter)
  {
    vtkDataArraySelection* const arrays = filter->GetModelArraySelection();
    std::vector<std::string> chosen;
    for (int n = 0; n < arrays->GetNumberOfArrays(); ++n)
    {
      if (arrays->GetArraySetting(n))
      {
        chosen.emplace_back(arrays->GetArrayName(n));
      }
    }
    return Listed(chosen);
  };
  row.Copy = [](Deformation* from, Deformation* to)
  { to->GetModelArraySelection()->CopySelections(from->GetModelArraySelection()); };
  row.Changes = { { [](Deformation* filter) { filter->GetModelArraySelection()->EnableArray("Cluster"); },
    "Displacement and Element and Cluster", "ModelArrays: Displacement Element no Constraint Cluster" } };
  return row;
}

inline DeformationProperty LabelArrays()
{
  DeformationProperty row;
  row.Name = "LabelArrays";
  row.Getter = "int GetNumberOfLabelArrays()";
  row.Value = [](Deformation* filter)
  {
    std::vector<std::string> names;
    for (int n = 0; n < filter->GetNumberOfLabelArrays(); ++n)
    {
      names.emplace_back(filter->GetLabelArray(n));
    }
    return Listed(names);
  };
  row.Copy = [](Deformation* from, Deformation* to)
  {
    to->ClearLabelArrays();
    for (int n = 0; n < from->GetNumberOfLabelArrays(); ++n)
    {
      to->AddLabelArray(from->GetLabelArray(n));
    }
  };
  row.Changes = {
    { [](Deformation* filter) { filter->AddLabelArray("labels"); }, "labels", "LabelArrays: labels" },
    { [](Deformation* filter) { filter->RemoveLabelArray("labels"); }, "none", "LabelArrays:" },
  };
  return row;
}

}

// The kinds of rows. Defaults are not repeated here: the class's header documents them. Where a value is given, it is
// another one than the default.

#define GET(name) [](Deformation* filter) { return filter->Get##name(); }
#define SET(name) [](Deformation* filter, auto value) { filter->Set##name(value); }
#define CALL(...) [](Deformation* filter) { filter->__VA_ARGS__; }

/// Other values, one after the other.
#define NUMBER(name, ...) Number(#name, GET(name), SET(name), { __VA_ARGS__ })
/// Another value, and the ends of the range.
#define CLAMPED(name, other, lowest, highest) Clamped(#name, GET(name), SET(name), other, lowest, highest)
/// On or Off.
#define BOOLEAN(name, other) Boolean(#name, GET(name), SET(name), CALL(name##other()), #other)
/// The constants of the default and of another value, and the other's name in setters and in PrintSelf.
#define ENUMERATED(name, initial, other, word)                                                                         \
  Enumerated(#name, GET(name), SET(name), { Deformation::initial, #initial }, { Deformation::other, #other },          \
    CALL(Set##name##To##word()), #word)
#define STRING(name, other) String(#name, GET(name), SET(name), other)
/// Their number, and other values.
#define NUMBERS(name, size, ...)                                                                                       \
  Numbers(#name, GET(name), SET(name), size, CALL(Set##name(__VA_ARGS__)), { __VA_ARGS__ })

/// The rows, in the order of the header.
inline std::vector<DeformationProperty> DeformationProperties()
{
  using namespace Rows;
  const double notANumber = std::nan("");
  return {
    ENUMERATED(MaterialPreset, MATERIAL_FUNCTION, MATERIAL_CT, CT),
    MaterialFunction(),
    STRING(ConstraintArray, "fractions"),
    STRING(BodyArray, "bones"),
    CLAMPED(JointSize, 4, 0, 256),
    CLAMPED(JointConstraint, 0.25, 0.0, 1.0),
    CLAMPED(JointMargin, 7, 1, 100),
    NUMBER(TissueThreshold, 5.0, notANumber),
    BOOLEAN(AnchorRigid, On),
    NUMBERS(AnchoredFaces, 6, 0, 1, 0, 1, 1, 0),
    ENUMERATED(Mode, MODE_FROM_REST, MODE_INTERACTIVE, Interactive),
    ENUMERATED(PropagationMethod, PROPAGATION_ENVELOPE, PROPAGATION_TIMESTAMP, Timestamp),
    CLAMPED(PropagationIterations, 10, 0, VTK_INT_MAX),
    ENUMERATED(ConflictPolicy, CONFLICT_LIMIT, CONFLICT_LATEST, Latest),
    BOOLEAN(PropagationTimes, On),
    ModelArrays(),
    ENUMERATED(RelaxationMethod, RELAXATION_PROJECTED, RELAXATION_PAPER, Paper),
    ENUMERATED(RelaxationPreset, RELAXATION_CUSTOM, RELAXATION_FAST, Fast),
    BOOLEAN(CoarseToFine, On),
    CLAMPED(ElasticRecovery, 0.8, 0.0, 1.0),
    BOOLEAN(Rotations, On),
    CLAMPED(PoissonRatio, 0.3, 0.0, 0.49),
    CLAMPED(RelaxationIterations, 7, 0, VTK_INT_MAX),
    CLAMPED(RelaxationTolerance, 0.5, 0.0, VTK_DOUBLE_MAX),
    CLAMPED(RelaxationError, 0.25, 0.0, VTK_DOUBLE_MAX),
    NUMBER(ModelReduction, 4),
    ENUMERATED(Interpolation, INTERPOLATION_LINEAR, INTERPOLATION_NEAREST, Nearest),
    LabelArrays(),
    NUMBER(BackgroundValue, -1000.0, notANumber),
    CLAMPED(OutputPadding, 3, 0, 4096),
    CLAMPED(OutputMagnification, 2, 1, 4),
    BOOLEAN(UseOutputBounds, On),
    NUMBERS(OutputBounds, 6, 0.0, 2.0, 0.0, 3.0, 0.0, 4.5),
    BOOLEAN(SmoothCuts, Off),
    BOOLEAN(PullBack, On),
    CLAMPED(ScalarSmoothing, 0.75, 0.0, 2.0),
    STRING(Device, "some"),
    NUMBERS(BrickSize, 3, 8, 4, 2),
  };
}

#undef GET
#undef SET
#undef CALL
#undef NUMBER
#undef CLAMPED
#undef BOOLEAN
#undef ENUMERATED
#undef STRING
#undef NUMBERS

}

#endif
