// SPDX-License-Identifier: BSD-3-Clause
#include "MatrixFile.h"

#include "Error.h"
#include "ItkTransform.h"
#include "TextFile.h"

#include "vtkByteSwap.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace vtkChainMail
{

namespace
{

using chainmail::InputError;

std::vector<double> NumbersOf(const std::string& text, const Line& line)
{
  std::vector<double> numbers;
  for (const std::string& field : FieldsOf(text, ' '))
  {
    numbers.push_back(0.0);
    if (!ToNumber(field, numbers.back()))
    {
      throw InputError("line " + std::to_string(line.Number) + ": \"" + field + "\" is not a number.");
    }
  }
  return numbers;
}

/// ITK's text format: "Transform: TYPE", "Parameters: ...", "FixedParameters: ..." for each transform.
std::vector<ItkTransform> ReadText(const std::vector<Line>& lines)
{
  std::vector<ItkTransform> transforms;
  for (const Line& line : lines)
  {
    const std::size_t colon = line.Text.find(':');
    if (line.Text[0] == '#' || colon == std::string::npos)
    {
      continue;
    }
    const std::string name = line.Text.substr(0, colon);
    const std::string value = Trimmed(line.Text.substr(colon + 1));
    if (name == "Transform")
    {
      transforms.emplace_back();
      transforms.back().Type = value;
    }
    else if (transforms.empty())
    {
      throw InputError("line " + std::to_string(line.Number) + " comes before the first \"Transform:\".");
    }
    else if (name == "Parameters" || name == "FixedParameters")
    {
      (name == "Parameters" ? transforms.back().Parameters : transforms.back().Fixed) = NumbersOf(value, line);
    }
  }
  return transforms;
}

/// The header of a matrix in a Matlab file of level 4, as ITK's programs write .mat.
struct MatlabHeader
{
  std::int32_t Type, Rows, Columns, IsComplex, NameLength;
};

bool ReadHeader(const std::string& content, std::size_t at, MatlabHeader& header)
{
  if (at + sizeof(header) > content.size())
  {
    return false;
  }
  std::memcpy(&header, &content[at], sizeof(header));
  vtkByteSwap::Swap4LERange(&header, 5);
  // Little-endian doubles (0) or floats (10), fewer than 1000 because a transform has few.
  return (header.Type == 0 || header.Type == 10) && header.Columns == 1 && header.IsComplex == 0 && header.Rows >= 0 &&
         header.Rows < 1000 && header.NameLength > 0 && header.NameLength < 200;
}

/// Matlab's binary format: for each transform a matrix of the parameters, named by its type, then the fixed parameters,
/// named "fixed".
std::vector<ItkTransform> ReadMatlab(const std::string& content)
{
  std::vector<ItkTransform> transforms;
  MatlabHeader header;
  for (std::size_t at = 0; at < content.size();)
  {
    const bool isHeader = ReadHeader(content, at, header);
    at += sizeof(header);
    const std::size_t width = header.Type == 0 ? 8 : 4;
    if (!isHeader || at + header.NameLength + width * header.Rows > content.size())
    {
      throw InputError("the file is cut off, or is not an ITK transform in MATLAB's format, level 4.");
    }
    const std::string name(&content[at]); // null-terminated
    at += static_cast<std::size_t>(header.NameLength);
    std::vector<double> numbers(static_cast<std::size_t>(header.Rows));
    for (double& number : numbers)
    {
      if (width == 8)
      {
        std::memcpy(&number, &content[at], 8);
        vtkByteSwap::Swap8LE(&number);
      }
      else
      {
        float single = 0.0f;
        std::memcpy(&single, &content[at], 4);
        vtkByteSwap::Swap4LE(&single);
        number = single;
      }
      at += width;
    }
    if (name != "fixed")
    {
      transforms.push_back({ name, numbers, {} });
    }
    else if (!transforms.empty())
    {
      transforms.back().Fixed = numbers;
    }
  }
  return transforms;
}

//------------------------------------------------------------------------------
/// Reads 4 x 4 numbers, or a table with a label and 16 numbers in each row.
std::vector<BodyMotion> ReadNumbers(std::vector<Line> lines)
{
  std::vector<BodyMotion> motions;
  std::vector<double> loose; // numbers from rows of four
  const auto isComment = [](const Line& line) { return line.Text[0] == '#' || line.Text[0] == '%'; };
  lines.erase(std::remove_if(lines.begin(), lines.end(), isComment), lines.end());
  for (std::size_t n = 0; n < lines.size(); ++n)
  {
    const Line& line = lines[n];
    const std::string where = "line " + std::to_string(line.Number);
    std::vector<std::string> fields = FieldsOf(line.Text, SeparatorOf(line.Text));
    double number = 0.0;
    const bool hasNumber =
      std::any_of(fields.begin(), fields.end(), [&](const std::string& field) { return ToNumber(field, number); });
    if (n == 0 && !hasNumber)
    {
      continue; // the names of the columns
    }
    if (fields.size() != 4 && fields.size() != 16 && fields.size() != 17)
    {
      throw InputError(
        where + " has " + std::to_string(fields.size()) +
        " fields. A table needs a label and 16 numbers in each row, a matrix four rows of four numbers.");
    }
    BodyMotion motion;
    motion.Name = where;
    const std::size_t first = fields.size() == 17 ? 1 : 0;
    if (first == 1 && (!ToInteger(fields[0], motion.Body) || motion.Body < 0))
    {
      throw InputError(
        where + ": \"" + fields[0] + "\" is not a label. A label must be a whole number, as in the image of labels.");
    }
    for (std::size_t k = first; k < fields.size(); ++k)
    {
      if (!ToNumber(fields[k], number))
      {
        throw InputError(where + ", field " + std::to_string(k + 1) + ": \"" + fields[k] + "\" is not a number.");
      }
      if (fields.size() == 4)
      {
        loose.push_back(number);
      }
      else
      {
        motion.Matrix[k - first] = number;
      }
    }
    if (fields.size() != 4)
    {
      motions.push_back(motion);
    }
  }
  if (!loose.empty())
  {
    if (loose.size() != 16 || !motions.empty())
    {
      throw InputError(
        "a matrix needs four rows of four numbers; the number of rows is " + std::to_string(loose.size() / 4) + ".");
    }
    BodyMotion motion;
    std::copy(loose.begin(), loose.end(), motion.Matrix.begin());
    motions.push_back(motion);
  }
  const auto hasLabel = [](const BodyMotion& motion) { return motion.Body >= 0; };
  if (motions.size() > 1 && !std::all_of(motions.begin(), motions.end(), hasLabel))
  {
    throw InputError("the file has " + std::to_string(motions.size()) +
                     " matrices, but not all have a label. Give each matrix the label of its body.");
  }
  if (motions.empty())
  {
    throw InputError("the file has no matrix.");
  }
  return motions;
}

bool IsItkText(const std::string& content)
{
  return StartsWith(content, "#Insight Transform File");
}

bool IsHdf5(const std::string& content)
{
  return StartsWith(content, "\x89HDF\r\n\x1a\n");
}

bool IsMatlab(const std::string& content)
{
  MatlabHeader header;
  return ReadHeader(content, 0, header) && std::string(&content[sizeof(header)]).find("Transform") != std::string::npos;
}

}

//------------------------------------------------------------------------------
MatrixFile ReadMatrices(const std::string& fileName)
{
  const std::string content = ReadFile(fileName);
  MatrixFile file;
  file.SaysAxes = true;
  file.Who = "the format of ITK";
  try
  {
    if (IsItkText(content))
    {
      file.Motions = { MotionOf(ReadText(LinesOf(content))) };
    }
    else if (IsHdf5(content))
    {
      throw InputError("HDF5 files (.h5) cannot be read. Save the transform as text (.tfm) with 3D Slicer or ITK.");
    }
    else if (IsMatlab(content))
    {
      file.Motions = { MotionOf(ReadMatlab(content)) };
    }
    else
    {
      file.SaysAxes = false;
      file.Who = "the file";
      file.Motions = ReadNumbers(LinesOf(content));
    }
  }
  catch (const InputError& error)
  {
    throw InputError("\"" + fileName + "\": " + error.what());
  }
  for (BodyMotion& motion : file.Motions)
  {
    motion.Name = (motion.Name.empty() ? "" : motion.Name + " of ") + "\"" + fileName + "\"";
  }
  return file;
}

bool IsMatrixFile(const std::string& fileName)
{
  try
  {
    const std::string content = ReadBeginOfFile(fileName);
    if (IsItkText(content) || IsHdf5(content) || IsMatlab(content))
    {
      return true;
    }
    std::vector<Line> lines = LinesOf(content);
    if (lines.size() > 20) // the last one may be incomplete
    {
      lines.resize(20);
    }
    ReadNumbers(lines);
    return true;
  }
  catch (const chainmail::Error&)
  {
    return false;
  }
}

}
