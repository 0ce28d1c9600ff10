// SPDX-License-Identifier: BSD-3-Clause
// Reads text files of numbers: whole, as lines, as fields.

#ifndef TextFile_h
#define TextFile_h

#include <string>
#include <vector>

namespace vtkChainMail
{

/// The content of a file. Throws chainmail::InputError where it cannot be read or is empty.
std::string ReadFile(const std::string& name);

/// The first 64 KiB of a file, to tell what it is.
std::string ReadBeginOfFile(const std::string& name);

/// One line with its number, counted from 1, for messages.
struct Line
{
  std::string Text; ///< without blanks at its ends, and without the line end of any system
  int Number = 0;
};

/// All lines that are not blank.
std::vector<Line> LinesOf(const std::string& content);

std::string Trimmed(const std::string& text);
std::string LowerCase(std::string text);
bool StartsWith(const std::string& text, const std::string& start);
bool EndsWith(const std::string& text, const std::string& end);

/// The separator of a table: a tab, a semicolon or a comma, whichever comes first in that order; else blank.
char SeparatorOf(const std::string& line);

/// The fields of a line. Within quotes ("...") a separator is text, and "" is a quote. With blanks as separators there
/// are no empty fields.
std::vector<std::string> FieldsOf(const std::string& line, char separator);

/// Reads a number, independent of the user's locale. Returns false where the field is no number, or not finite.
bool ToNumber(const std::string& field, double& number);

/// Reads a whole number, also one like 25.0.
bool ToInteger(const std::string& field, long long& number);

}

#endif
