// SPDX-License-Identifier: BSD-3-Clause
#include "LandmarkFile.h"

#include "Error.h"
#include "TextFile.h"

#include <vtk_jsoncpp.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace vtkChainMail
{

namespace
{

using chainmail::InputError;
using Place = std::array<double, 3>;

/// Slicer numbers its coordinate systems, and in later versions names them.
PatientAxes AxesNamed(const std::string& name)
{
  if (name == "LPS" || name == "1")
  {
    return LPS;
  }
  if (name == "RAS" || name == "0")
  {
    return RAS;
  }
  throw InputError("the coordinate system \"" + name +
                   "\" is neither LPS nor RAS. Save the landmarks in LPS or RAS; 3D Slicer does so by default.");
}

//------------------------------------------------------------------------------
/// Slicer's .mrk.json. A file may have several lists.
std::vector<LandmarkList> ReadMarkups(const std::string& content)
{
  Json::Value root;
  std::string errors;
  const std::unique_ptr<Json::CharReader> reader(Json::CharReaderBuilder().newCharReader());
  bool isParsed = false;
  try
  {
    isParsed = reader->parse(content.data(), content.data() + content.size(), &root, &errors);
  }
  catch (const std::exception& error) // for example too deeply nested
  {
    errors = error.what();
  }
  if (!isParsed)
  {
    throw InputError("the file is not valid JSON: " + Trimmed(errors));
  }
  if (!root.isObject() || !root["markups"].isArray())
  {
    throw InputError("the file has no list \"markups\", so it is not a .mrk.json of 3D Slicer.");
  }
  std::vector<LandmarkList> lists;
  for (const Json::Value& markup : root["markups"])
  {
    const std::string what = "list " + std::to_string(lists.size() + 1);
    if (!markup.isObject() || !markup["controlPoints"].isArray())
    {
      throw InputError(what + " has no \"controlPoints\".");
    }
    LandmarkList list;
    list.SaysAxes = true;
    const Json::Value& axes = markup["coordinateSystem"];
    if (!axes.isNull() && !axes.isString())
    {
      throw InputError(what + ": \"coordinateSystem\" is not a text.");
    }
    list.Who = axes.isNull() ? "the format (the file names none)" : "the file";
    list.Axes = axes.isNull() ? LPS : AxesNamed(axes.asString());
    for (const Json::Value& unit :
      markup["coordinateUnits"].isArray() ? markup["coordinateUnits"] : Json::Value(Json::arrayValue))
    {
      if (unit != "mm")
      {
        throw InputError(what + " is in " + Trimmed(unit.toStyledString()) + ". Save it in mm.");
      }
    }
    if (markup["coordinateUnits"].isString() && markup["coordinateUnits"].asString() != "mm")
    {
      throw InputError(what + " is in " + markup["coordinateUnits"].asString() + ". Save it in mm.");
    }
    for (const Json::Value& point : markup["controlPoints"])
    {
      const int number = static_cast<int>(list.Places.size()) + list.LeftOut + 1;
      const std::string where = "point " + std::to_string(number) + " of " + what;
      if (!point.isObject())
      {
        throw InputError(where + " is not a JSON object.");
      }
      const Json::Value& status = point["positionStatus"];
      if (status.isString() && status.asString() != "defined")
      {
        ++list.LeftOut;
        continue;
      }
      const Json::Value& position = point["position"];
      Place place;
      for (int a = 0; a < 3; ++a)
      {
        if (!position.isArray() || position.size() != 3 || !position[a].isNumeric() ||
            !std::isfinite(position[a].asDouble()))
        {
          throw InputError(where + ": its \"position\" must be three numbers.");
        }
        place[a] = position[a].asDouble();
      }
      list.Places.push_back(place);
      list.Labels.push_back(point["label"].isString() ? point["label"].asString() : "");
    }
    lists.push_back(list);
  }
  return lists;
}

//------------------------------------------------------------------------------
Place PlaceIn(const std::vector<std::string>& fields, const std::array<int, 3>& columns, const Line& line)
{
  Place place;
  for (int a = 0; a < 3; ++a)
  {
    const auto column = static_cast<std::size_t>(columns[a]);
    const std::string field = column < fields.size() ? fields[column] : "";
    if (!ToNumber(field, place[a]))
    {
      throw InputError("line " + std::to_string(line.Number) + ", column " + std::to_string(column + 1) + ": \"" +
                       field + "\" is not a number.");
    }
  }
  return place;
}

/// The number of the first column that has one of these names, in lower case; -1: none.
int ColumnOf(const std::vector<std::string>& header, std::initializer_list<const char*> names)
{
  for (const char* const name : names)
  {
    for (std::size_t n = 0; n < header.size(); ++n)
    {
      if (LowerCase(header[n]) == name)
      {
        return static_cast<int>(n);
      }
    }
  }
  return -1;
}

/// Slicer's .fcsv: comments with the axes and the names of the columns, then one landmark a line.
LandmarkList ReadFiducials(const std::vector<Line>& lines)
{
  LandmarkList list;
  list.SaysAxes = true;
  list.Axes = RAS; // old versions do not name their axes
  list.Who = "the format (the file names none)";
  std::vector<std::string> header = { "id", "x", "y", "z", "ow", "ox", "oy", "oz", "vis", "sel", "lock", "label" };
  for (const Line& line : lines)
  {
    if (line.Text[0] == '#')
    {
      const std::size_t equals = line.Text.find('=');
      const std::string name = LowerCase(Trimmed(line.Text.substr(1, equals == std::string::npos ? 0 : equals - 1)));
      const std::string value = equals == std::string::npos ? "" : Trimmed(line.Text.substr(equals + 1));
      if (name == "coordinatesystem")
      {
        list.Axes = AxesNamed(value);
        list.Who = "the file";
      }
      if (name == "columns")
      {
        header = FieldsOf(value, ',');
      }
      continue;
    }
    const std::array<int, 3> columns = { ColumnOf(header, { "x" }), ColumnOf(header, { "y" }),
      ColumnOf(header, { "z" }) };
    if (*std::min_element(columns.begin(), columns.end()) < 0)
    {
      throw InputError("the line \"# columns = ...\" does not name the columns x, y and z.");
    }
    const std::vector<std::string> fields = FieldsOf(line.Text, ',');
    list.Places.push_back(PlaceIn(fields, columns, line));
    const int label = ColumnOf(header, { "label" });
    list.Labels.push_back(label >= 0 && label < static_cast<int>(fields.size()) ? fields[label] : "");
  }
  return list;
}

//------------------------------------------------------------------------------
bool IsPointFile(const std::vector<Line>& lines)
{
  const std::string first = LowerCase(lines[0].Text);
  return first == "point" || first == "index";
}

/// Point files of elastix and transformix: a line "point" or "index", the number of points, then one point a line.
LandmarkList ReadPointFile(const std::vector<Line>& lines)
{
  LandmarkList list;
  list.SaysAxes = true;
  list.Who = "the format of elastix";
  list.AreIndices = LowerCase(lines[0].Text) == "index";
  long long count = 0;
  if (lines.size() < 2 || !ToInteger(lines[1].Text, count))
  {
    throw InputError("the second line of a point file must be the number of points.");
  }
  for (std::size_t n = 2; n < lines.size(); ++n)
  {
    list.Places.push_back(PlaceIn(FieldsOf(lines[n].Text, ' '), { { 0, 1, 2 } }, lines[n]));
    list.Labels.emplace_back();
  }
  if (static_cast<long long>(list.Places.size()) != count)
  {
    throw InputError("the second line gives " + std::to_string(count) + " points, but the file has " +
                     std::to_string(list.Places.size()) + ".");
  }
  return list;
}

//------------------------------------------------------------------------------
bool HasNumber(const std::vector<std::string>& fields)
{
  double number = 0.0;
  return std::any_of(fields.begin(), fields.end(), [&](const std::string& field) { return ToNumber(field, number); });
}

/// A table, with or without names of its columns. Each row has a place, optionally a label and a target.
LandmarkList ReadTable(std::vector<Line> lines)
{
  lines.erase(
    std::remove_if(lines.begin(), lines.end(), [](const Line& line) { return line.Text[0] == '#'; }), lines.end());
  if (lines.empty())
  {
    throw InputError("the file has only comments.");
  }
  const char separator = SeparatorOf(lines[0].Text);
  const std::vector<std::string> first = FieldsOf(lines[0].Text, separator);
  LandmarkList list;
  list.Who = "the table";
  int label = -1;
  int defined = -1;
  std::array<int, 3> from = { { -1, -1, -1 } };
  std::array<int, 3> to = from;
  if (!HasNumber(first))
  {
    const auto triple = [&](const char* x, const char* y, const char* z) -> std::array<int, 3> {
      return { { ColumnOf(first, { x }), ColumnOf(first, { y }), ColumnOf(first, { z }) } };
    };
    const auto isThere = [](const std::array<int, 3>& columns)
    { return *std::min_element(columns.begin(), columns.end()) >= 0; };
    label = ColumnOf(first, { "label", "name", "landmark", "id" });
    defined = ColumnOf(first, { "defined" });
    from = triple("x", "y", "z");
    for (const PatientAxes axes : { LPS, RAS }) // as Slicer exports them
    {
      const std::array<int, 3> columns = axes == LPS ? triple("l", "p", "s") : triple("r", "a", "s");
      if (!isThere(from) && isThere(columns))
      {
        from = columns;
        list.SaysAxes = true;
        list.Axes = axes;
      }
    }
    for (const auto& columns : { triple("x1", "y1", "z1"), triple("points:0", "points:1", "points:2"),
           triple("points_0", "points_1", "points_2") })
    {
      from = isThere(from) ? from : columns;
    }
    if (!isThere(from))
    {
      throw InputError("the table has no columns x, y and z (or l, p, s or r, a, s). It has: " + lines[0].Text);
    }
    to = triple("x2", "y2", "z2");
    lines.erase(lines.begin());
  }
  else
  {
    // Without column names: an optional label, then three or six numbers.
    double number = 0.0;
    const auto size = static_cast<int>(first.size());
    const bool isNamed = size == 4 || size == 7 || !ToNumber(first[0], number);
    label = isNamed ? 0 : -1;
    const int column = isNamed ? 1 : 0;
    if (size - column != 3 && size - column != 6)
    {
      throw InputError("line " + std::to_string(lines[0].Number) + " is \"" + lines[0].Text +
                       "\". A row needs three numbers (a position) or six (a position and its target), with or without "
                       "a label before them.");
    }
    from = { { column, column + 1, column + 2 } };
    to = size - column == 6 ? std::array<int, 3>{ { column + 3, column + 4, column + 5 } } : to;
  }
  for (const Line& line : lines)
  {
    const std::vector<std::string> fields = FieldsOf(line.Text, separator);
    if (defined >= 0 && defined < static_cast<int>(fields.size()) && fields[defined] == "0")
    {
      ++list.LeftOut;
      continue;
    }
    list.Places.push_back(PlaceIn(fields, from, line));
    if (to[0] >= 0)
    {
      list.Targets.push_back(PlaceIn(fields, to, line));
    }
    list.Labels.push_back(label >= 0 && label < static_cast<int>(fields.size()) ? fields[label] : "");
  }
  return list;
}

bool IsFiducials(const std::vector<Line>& lines, const std::string& fileName)
{
  return StartsWith(lines[0].Text, "# Markups fiducial file") || StartsWith(lines[0].Text, "# Fiducial List file") ||
         EndsWith(LowerCase(fileName), ".fcsv");
}

}

//------------------------------------------------------------------------------
std::vector<LandmarkList> ReadLandmarks(const std::string& fileName)
{
  const std::string content = ReadFile(fileName);
  const std::vector<Line> lines = LinesOf(content);
  std::vector<LandmarkList> lists;
  try
  {
    if (lines[0].Text[0] == '{')
    {
      lists = ReadMarkups(content);
    }
    else if (IsPointFile(lines))
    {
      lists = { ReadPointFile(lines) };
    }
    else if (IsFiducials(lines, fileName))
    {
      lists = { ReadFiducials(lines) };
    }
    else
    {
      lists = { ReadTable(lines) };
    }
  }
  catch (const InputError& error)
  {
    throw InputError("\"" + fileName + "\": " + error.what());
  }
  const bool isEmpty =
    std::all_of(lists.begin(), lists.end(), [](const LandmarkList& list) { return list.Places.empty(); });
  if (isEmpty)
  {
    throw InputError("\"" + fileName + "\" has no landmarks.");
  }
  return lists;
}

bool IsLandmarkFile(const std::string& fileName)
{
  try
  {
    const std::string content = ReadBeginOfFile(fileName);
    const std::vector<Line> lines = LinesOf(content);
    if (lines[0].Text[0] == '{')
    {
      return content.find("\"markups\"") != std::string::npos;
    }
    if (IsPointFile(lines) || IsFiducials(lines, fileName))
    {
      return true;
    }
    // Without the last line, which may be incomplete.
    ReadTable({ lines.begin(), lines.begin() + std::min<std::size_t>(std::max<std::size_t>(lines.size(), 2) - 1, 20) });
    return true;
  }
  catch (const chainmail::Error&)
  {
    return false;
  }
}

}
