// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailLandmarks.h"

#include "Error.h"
#include "Private/ProbeSet.h"
#include "Private/Text.h"
#include "Private/TextFile.h"

#include "vtkFieldData.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMath.h"
#include "vtkObjectFactory.h"
#include "vtkPointSet.h"
#include "vtkStringArray.h"
#include "vtkTable.h"
#include "vtkVariant.h"

#include <algorithm>
#include <map>
#include <set>
#include <vector>

vtkStandardNewMacro(vtkChainMailLandmarks);

namespace
{

using chainmail::InputError;
using Place = std::array<double, 3>;

/// The landmarks of one input.
struct Landmarks
{
  std::string Name; ///< of the input, for messages
  std::vector<Place> Places;
  std::vector<Place> Targets;
  std::vector<std::string> Labels; ///< empty where the input has no such array

  std::string ToString(std::size_t n) const
  {
    const std::string label = n < this->Labels.size() && !this->Labels[n].empty() ? " (" + this->Labels[n] + ")" : "";
    return "landmark " + std::to_string(n + 1) + label + " of " + this->Name;
  }
};

std::vector<std::string> TextsOf(vtkAbstractArray* array)
{
  std::vector<std::string> texts;
  for (vtkIdType n = 0; array && n < array->GetNumberOfTuples(); ++n)
  {
    texts.push_back(array->GetVariantValue(n * array->GetNumberOfComponents()).ToString());
  }
  return texts;
}

std::vector<Place> PlacesOf(vtkDataArray* array)
{
  std::vector<Place> places(static_cast<std::size_t>(array->GetNumberOfTuples()));
  for (std::size_t n = 0; n < places.size(); ++n)
  {
    array->GetTuple(static_cast<vtkIdType>(n), places[n].data());
  }
  return places;
}

Landmarks FromPoints(vtkPointSet* points, const std::string& name, const std::string& targetArray)
{
  Landmarks landmarks;
  landmarks.Name = name;
  if (points->GetNumberOfPoints() > 0)
  {
    landmarks.Places = PlacesOf(points->GetPoints()->GetData());
    landmarks.Labels = TextsOf(points->GetPointData()->GetAbstractArray("Label"));
    if (vtkDataArray* targets = points->GetPointData()->GetArray(targetArray.empty() ? "Target" : targetArray.c_str()))
    {
      if (targets->GetNumberOfComponents() != 3)
      {
        throw InputError("TargetArray is \"" + std::string(targets->GetName()) + "\", which has " +
                         std::to_string(targets->GetNumberOfComponents()) + " components; it needs 3.");
      }
      landmarks.Targets = PlacesOf(targets);
    }
    else if (!targetArray.empty())
    {
      throw InputError("TargetArray is \"" + targetArray + "\", but " + name + " has no such point array. " +
                       vtkChainMail::ListArrays(points->GetPointData()));
    }
  }
  return landmarks;
}

Landmarks FromTable(vtkTable* table, const std::string& name)
{
  Landmarks landmarks;
  landmarks.Name = name;
  std::vector<std::pair<vtkDataArray*, int>> numbers; // a column and its component
  for (vtkIdType c = 0; c < table->GetNumberOfColumns(); ++c)
  {
    vtkAbstractArray* column = table->GetColumn(c);
    const std::string title = vtkChainMail::LowerCase(column->GetName() ? column->GetName() : "");
    if (title == "label" || title == "name" || title == "landmark" || title == "id")
    {
      landmarks.Labels = TextsOf(column);
    }
    else if (auto* array = vtkDataArray::SafeDownCast(column))
    {
      for (int k = 0; k < array->GetNumberOfComponents(); ++k)
      {
        numbers.emplace_back(array, k);
      }
    }
  }
  if (table->GetNumberOfRows() > 0 && numbers.size() != 3 && numbers.size() != 6)
  {
    throw InputError(
      "The table " + name + " has " + std::to_string(numbers.size()) +
      " numbers in each row beside the label, but needs 3 (a position) or 6 (a position and its target). " +
      vtkChainMail::ListArrays(table->GetRowData()));
  }
  for (vtkIdType row = 0; row < table->GetNumberOfRows(); ++row)
  {
    const auto at = [&](std::size_t first)
    {
      Place place;
      for (std::size_t a = 0; a < 3; ++a)
      {
        place[a] = numbers[first + a].first->GetComponent(row, numbers[first + a].second);
      }
      return place;
    };
    landmarks.Places.push_back(at(0));
    if (numbers.size() == 6)
    {
      landmarks.Targets.push_back(at(3));
    }
  }
  return landmarks;
}

Landmarks LandmarksOf(vtkDataObject* data, const std::string& name, const std::string& targetArray, vtkImageData* image)
{
  auto* table = vtkTable::SafeDownCast(data);
  Landmarks landmarks = table ? FromTable(table, name) : FromPoints(vtkPointSet::SafeDownCast(data), name, targetArray);
  if (data->GetFieldData()->GetArray("Voxels")) // voxel indices, marked by vtkChainMailLandmarkReader
  {
    if (!image)
    {
      throw InputError(
        "The landmarks of " + name + " are voxel indices. Connect the image that these count in as Image.");
    }
    int extent[6];
    image->GetExtent(extent);
    for (Place& place : landmarks.Places)
    {
      const double index[3] = { place[0] + extent[0], place[1] + extent[2], place[2] + extent[4] };
      image->TransformContinuousIndexToPhysicalPoint(index, place.data());
    }
  }
  for (const std::vector<Place>* places : { &landmarks.Places, &landmarks.Targets })
  {
    for (std::size_t n = 0; n < places->size(); ++n)
    {
      if (!vtkChainMail::IsFinite((*places)[n].data()))
      {
        throw InputError("The " + std::string(places == &landmarks.Places ? "position" : "target") + " of " +
                         landmarks.ToString(n) + " is " + vtkChainMail::ToString((*places)[n].data()) +
                         "; it must be finite. Correct or remove the landmark.");
      }
    }
  }
  return landmarks;
}

/// The number of the landmark with each label. Throws InputError for a label that occurs twice.
std::map<std::string, std::size_t> NumbersOf(const Landmarks& landmarks)
{
  std::map<std::string, std::size_t> numbers;
  for (std::size_t n = 0; n < landmarks.Labels.size(); ++n)
  {
    if (!numbers.emplace(landmarks.Labels[n], n).second)
    {
      throw InputError("Two landmarks of " + landmarks.Name + " have the label \"" + landmarks.Labels[n] +
                       "\", but MatchLabels needs labels that differ. Change one, or switch MatchLabels off.");
    }
  }
  return numbers;
}

/// Writes the first of some names: "a, b and 3 more".
std::string ListOf(const std::vector<std::string>& names)
{
  std::string list;
  for (std::size_t n = 0; n < std::min<std::size_t>(names.size(), 5); ++n)
  {
    list += (n ? ", " : "") + names[n];
  }
  return list + (names.size() > 5 ? " and " + std::to_string(names.size() - 5) + " more" : "");
}

/// Gives `from` the places with the same labels in `to` as targets, and removes all other landmarks. Returns a text
/// about those that were left out.
std::string Match(Landmarks& from, const Landmarks& to)
{
  for (const Landmarks* const one : { static_cast<const Landmarks*>(&from), &to })
  {
    if (one->Labels.empty())
    {
      throw InputError(one->Name + " has no array Label, which MatchLabels needs. Add the array, or switch MatchLabels "
                                   "off to pair landmarks by their order.");
    }
  }
  const auto mine = NumbersOf(from);
  const auto theirs = NumbersOf(to);
  Landmarks both;
  both.Name = from.Name;
  std::vector<std::string> alone;
  for (std::size_t n = 0; n < from.Places.size(); ++n)
  {
    const auto match = theirs.find(from.Labels[n]);
    if (match == theirs.end())
    {
      alone.push_back("\"" + from.Labels[n] + "\"");
      continue;
    }
    both.Places.push_back(from.Places[n]);
    both.Targets.push_back(to.Places[match->second]);
    both.Labels.push_back(from.Labels[n]);
  }
  for (const std::string& label : to.Labels)
  {
    if (mine.find(label) == mine.end())
    {
      alone.push_back("\"" + label + "\"");
    }
  }
  if (both.Places.empty())
  {
    throw InputError("From and To have no label in common. From has " + ListOf(from.Labels) + "; To has " +
                     ListOf(to.Labels) + ". Correct the labels, or switch MatchLabels off.");
  }
  from = both;
  return alone.empty() ? "" : "Left out because only one of From and To has them: " + ListOf(alone) + ".";
}

/// Whether both have the same labels, each once, in another order.
bool AreShuffled(const Landmarks& from, const Landmarks& to)
{
  const std::set<std::string> mine(from.Labels.begin(), from.Labels.end());
  const std::set<std::string> theirs(to.Labels.begin(), to.Labels.end());
  return from.Labels != to.Labels && mine.size() == from.Labels.size() && mine == theirs;
}

/// Whether at least 4 pairs would fit much better with x and y of the targets negated: below a quarter of the sum of
/// squared distances, after subtracting the centroid of each list.
bool AreMirrored(const Landmarks& pairs)
{
  const std::size_t count = pairs.Places.size();
  Place p = { { 0.0, 0.0, 0.0 } };
  Place q = p;
  for (std::size_t n = 0; n < count; ++n)
  {
    for (int a = 0; a < 3; ++a)
    {
      p[a] += pairs.Places[n][a] / static_cast<double>(count);
      q[a] += pairs.Targets[n][a] / static_cast<double>(count);
    }
  }
  double asIs = 0.0;
  double mirrored = 0.0;
  for (std::size_t n = 0; n < count; ++n)
  {
    for (int a = 0; a < 3; ++a)
    {
      const double rest = pairs.Places[n][a] - p[a];
      const double there = pairs.Targets[n][a] - q[a];
      asIs += (there - rest) * (there - rest);
      mirrored += ((a < 2 ? -there : there) - rest) * ((a < 2 ? -there : there) - rest);
    }
  }
  return count >= 4 && mirrored < 0.25 * asIs;
}

}

//------------------------------------------------------------------------------
vtkChainMailLandmarks::vtkChainMailLandmarks()
{
  this->SetNumberOfInputPorts(3);
}

//------------------------------------------------------------------------------
int vtkChainMailLandmarks::FillInputPortInformation(int port, vtkInformation* info)
{
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  for (const char* const type : { "vtkPointSet", "vtkTable" })
  {
    info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), port == 2 ? "vtkImageData" : type);
  }
  if (port > 0)
  {
    info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailLandmarks::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkPolyData* output = vtkPolyData::GetData(outputVector, 0);
  this->Report.clear();
  try
  {
    vtkDataObject* toData = vtkDataObject::GetData(inputVector[1], 0);
    vtkImageData* image = vtkImageData::GetData(inputVector[2], 0);
    Landmarks pairs =
      LandmarksOf(vtkDataObject::GetData(inputVector[0], 0), "From", toData ? "" : this->TargetArray, image);
    if (pairs.Places.empty())
    {
      throw InputError("From has no landmarks. Connect points or a table with at least one landmark.");
    }
    std::string warning;
    if (toData)
    {
      const Landmarks to = LandmarksOf(toData, "To", "", image);
      if (this->MatchLabels)
      {
        warning = Match(pairs, to);
      }
      else if (to.Places.size() != pairs.Places.size())
      {
        throw InputError("From has " + std::to_string(pairs.Places.size()) + " landmarks and To has " +
                         std::to_string(to.Places.size()) +
                         ", but their order pairs the first with the first. Add what is missing, or switch MatchLabels "
                         "on to pair them by their labels.");
      }
      else
      {
        pairs.Targets = to.Places;
        if (AreShuffled(pairs, to))
        {
          warning = "From and To have the same labels in another order. The landmarks were paired by order; switch "
                    "MatchLabels on to pair them by labels.";
        }
      }
    }
    else if (pairs.Targets.empty())
    {
      throw InputError("The landmarks have no targets. Connect a second list as To, or set TargetArray to an array of "
                       "From whose 3 components are the target.");
    }
    if (AreMirrored(pairs))
    {
      warning += std::string(warning.empty() ? "" : " ") +
                 "The pairs would fit much better with other signs of x and y in one list. One list may have LPS axes "
                 "(left, back, head), the other RAS axes (right, front, head): check FileWorld of their readers.";
    }
    if (!warning.empty())
    {
      vtkWarningMacro(<< warning);
    }

    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    points->SetNumberOfPoints(static_cast<vtkIdType>(pairs.Places.size()));
    for (std::size_t n = 0; n < pairs.Places.size(); ++n)
    {
      points->SetPoint(static_cast<vtkIdType>(n), pairs.Places[n].data());
    }
    vtkChainMail::SetProbePoints(output, points);
    const auto displacement = vtkChainMail::AddProbeArray(output, "Displacement", 3);
    double sum = 0.0;
    double most = 0.0;
    std::size_t farthest = 0;
    for (std::size_t n = 0; n < pairs.Places.size(); ++n)
    {
      double way[3];
      vtkMath::Subtract(pairs.Targets[n].data(), pairs.Places[n].data(), way);
      displacement->SetTuple(static_cast<vtkIdType>(n), way);
      const double length = vtkMath::Norm(way);
      sum += length;
      farthest = length > most ? n : farthest;
      most = std::max(most, length);
    }
    output->GetPointData()->SetActiveVectors("Displacement");
    vtkChainMail::SetGrip(output, this->Radius, this->Tolerance);
    vtkNew<vtkStringArray> labels;
    labels->SetName("Label");
    for (const std::string& label : pairs.Labels)
    {
      labels->InsertNextValue(label);
    }
    if (!pairs.Labels.empty())
    {
      output->GetPointData()->AddArray(labels);
    }
    this->Report = std::to_string(pairs.Places.size()) +
                   " pairs. Displacements: " + chainmail::toString(sum / static_cast<double>(pairs.Places.size()), 3) +
                   " mm on average, at most " + chainmail::toString(most, 3) + " mm (" + pairs.ToString(farthest) +
                   ").\n" + warning + (warning.empty() ? "" : "\n");
  }
  catch (const std::exception& error)
  {
    vtkErrorMacro(<< error.what());
    return 0;
  }
  return 1;
}

//------------------------------------------------------------------------------
void vtkChainMailLandmarks::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "TargetArray: " << this->TargetArray << "\n";
  os << indent << "MatchLabels: " << (this->MatchLabels ? "On" : "Off") << "\n";
  os << indent << "Radius: " << this->Radius << "\n";
  os << indent << "Tolerance: " << this->Tolerance << "\n";
  os << indent << "Report: " << this->Report << "\n";
}
