// SPDX-License-Identifier: BSD-3-Clause
#include "TextFile.h"

#include "Error.h"

#include <vtksys/FStream.hxx>
#include <vtksys/SystemTools.hxx>

#include <cctype>
#include <cmath>
#include <locale>
#include <sstream>

namespace vtkChainMail
{

namespace
{

std::string Read(const std::string& name, std::size_t limit)
{
  if (name.empty())
  {
    throw chainmail::InputError("No file is chosen: set FileName.");
  }
  vtksys::ifstream file(name.c_str(), std::ios::binary);
  if (!file || vtksys::SystemTools::FileIsDirectory(name))
  {
    throw chainmail::InputError("Cannot read \"" + name + "\". Check that the file exists and that you may read it.");
  }
  std::string text;
  char portion[1 << 16];
  while (text.size() < limit && (file.read(portion, sizeof(portion)), file.gcount() > 0))
  {
    text.append(portion, static_cast<std::size_t>(file.gcount()));
  }
  if (StartsWith(text, "\xEF\xBB\xBF")) // a byte order mark, which spreadsheets write
  {
    text.erase(0, 3);
  }
  if (Trimmed(text).empty())
  {
    throw chainmail::InputError("\"" + name + "\" is empty.");
  }
  return text;
}

}

std::string ReadFile(const std::string& name)
{
  return Read(name, std::string::npos);
}

std::string ReadBeginOfFile(const std::string& name)
{
  return Read(name, 1);
}

std::vector<Line> LinesOf(const std::string& content)
{
  std::vector<Line> lines;
  std::size_t start = 0;
  for (int number = 1; start < content.size(); ++number)
  {
    std::size_t end = content.find_first_of("\r\n", start);
    end = end == std::string::npos ? content.size() : end;
    const Line line = { Trimmed(content.substr(start, end - start)), number };
    if (!line.Text.empty())
    {
      lines.push_back(line);
    }
    start = end + (content.compare(end, 2, "\r\n") == 0 ? 2 : 1);
  }
  return lines;
}

std::string Trimmed(const std::string& text)
{
  const char* const blanks = " \t\r\n\v\f";
  const std::size_t first = text.find_first_not_of(blanks);
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::string LowerCase(std::string text)
{
  for (char& letter : text)
  {
    letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  }
  return text;
}

bool StartsWith(const std::string& text, const std::string& start)
{
  return text.compare(0, start.size(), start) == 0;
}

bool EndsWith(const std::string& text, const std::string& end)
{
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

char SeparatorOf(const std::string& line)
{
  for (const char separator : { '\t', ';', ',' })
  {
    if (line.find(separator) != std::string::npos)
    {
      return separator;
    }
  }
  return ' ';
}

std::vector<std::string> FieldsOf(const std::string& line, char separator)
{
  std::vector<std::string> fields;
  if (separator == ' ')
  {
    std::istringstream words(line);
    for (std::string word; words >> word;)
    {
      fields.push_back(word);
    }
    return fields;
  }
  std::string field;
  bool isQuoted = false;
  for (std::size_t n = 0; n < line.size(); ++n)
  {
    if (line[n] == '"' && isQuoted && n + 1 < line.size() && line[n + 1] == '"')
    {
      field += line[n++];
    }
    else if (line[n] == '"')
    {
      isQuoted = !isQuoted;
    }
    else if (line[n] == separator && !isQuoted)
    {
      fields.push_back(Trimmed(field));
      field.clear();
    }
    else
    {
      field += line[n];
    }
  }
  fields.push_back(Trimmed(field));
  return fields;
}

bool ToNumber(const std::string& field, double& number)
{
  std::istringstream text(field);
  text.imbue(std::locale::classic());
  char more = 0;
  return text >> number && !(text >> more) && std::isfinite(number);
}

bool ToInteger(const std::string& field, long long& number)
{
  std::istringstream text(field);
  text.imbue(std::locale::classic());
  char more = 0;
  if (text >> number && !(text >> more))
  {
    return true;
  }
  double real = 0.0; // some tables write labels as 25.0
  if (ToNumber(field, real) && std::fabs(real) < 9e15 && real == std::nearbyint(real))
  {
    number = static_cast<long long>(real);
    return true;
  }
  return false;
}

}
