// SPDX-License-Identifier: BSD-3-Clause
// The values of enumerated properties and their names.

#ifndef Choices_h
#define Choices_h

#include "Error.h"
#include "Types.h"

#include <iterator>
#include <string>

namespace vtkChainMail
{

// The enumerations of vtkChainMailDeformation that the engine does not have. They have the same names and numbers
// there.

enum class MaterialPresets
{
  Function,
  CT,
  MR
};

enum class Modes
{
  FromRest,
  Interactive
};

enum class RelaxationPresets
{
  Custom,
  Fast,
  Balanced,
  Accurate
};

enum class InterpolationTypes
{
  Linear,
  Nearest
};

template <typename E> struct Choice
{
  E Value;
  const char* Name; // as in the panel
};

/// All values of an enumerated property. Their numbers are those of the constants of vtkChainMailDeformation.
template <typename E> inline constexpr bool Choices = false; // of anything else there are none

template <>
inline constexpr Choice<MaterialPresets> Choices<MaterialPresets>[] = {
  { MaterialPresets::Function, "Function" },
  { MaterialPresets::CT, "CT" },
  { MaterialPresets::MR, "MR" },
};

template <>
inline constexpr Choice<Modes> Choices<Modes>[] = {
  { Modes::FromRest, "FromRest" },
  { Modes::Interactive, "Interactive" },
};

template <>
inline constexpr Choice<chainmail::PropagationMethod> Choices<chainmail::PropagationMethod>[] = {
  { chainmail::PropagationMethod::Envelope, "Envelope" },
  { chainmail::PropagationMethod::Timestamp, "Timestamp" },
};

template <>
inline constexpr Choice<chainmail::ConflictPolicy> Choices<chainmail::ConflictPolicy>[] = {
  { chainmail::ConflictPolicy::Limit, "Limit" },
  { chainmail::ConflictPolicy::Latest, "Latest" },
  { chainmail::ConflictPolicy::Share, "Share" },
};

template <>
inline constexpr Choice<chainmail::RelaxationMethod> Choices<chainmail::RelaxationMethod>[] = {
  { chainmail::RelaxationMethod::Projected, "Projected" },
  { chainmail::RelaxationMethod::Paper, "Paper" },
};

template <>
inline constexpr Choice<RelaxationPresets> Choices<RelaxationPresets>[] = {
  { RelaxationPresets::Custom, "Custom" },
  { RelaxationPresets::Fast, "Fast" },
  { RelaxationPresets::Balanced, "Balanced" },
  { RelaxationPresets::Accurate, "Accurate" },
};

template <>
inline constexpr Choice<InterpolationTypes> Choices<InterpolationTypes>[] = {
  { InterpolationTypes::Linear, "Linear" },
  { InterpolationTypes::Nearest, "Nearest" },
};

/// The name of a value; null where it is none of its enumeration.
template <typename E> const char* NameOf(E value)
{
  for (const Choice<E>& choice : Choices<E>)
  {
    if (choice.Value == value)
    {
      return choice.Name;
    }
  }
  return nullptr;
}

/// The value of a property. Throws InputError where it is none of its enumeration.
template <typename E> E Checked(const char* property, E value)
{
  if (NameOf(value))
  {
    return value;
  }
  const auto& all = Choices<E>;
  std::string list;
  for (std::size_t n = 0; n < std::size(all); ++n)
  {
    list += n == 0 ? "" : n + 1 == std::size(all) ? " or " : ", ";
    list += std::to_string(static_cast<int>(all[n].Value)) + " (" + all[n].Name + ")";
  }
  throw chainmail::InputError(std::string(property) + " is " + std::to_string(static_cast<int>(value)) +
                              ", which is not one of its values. Choose " + list + ".");
}

}

#endif
