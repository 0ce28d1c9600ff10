// SPDX-License-Identifier: BSD-3-Clause
// The defaults that the header documents are the real ones, ranges are kept, and setters report changes and only those.

#include "DeformationProperties.h"

#include <fstream>
#include <iterator>
#include <regex>
#include <set>

using namespace FilterTest;

namespace
{

/// The class's header, and what it documents.
class Header
{
public:
  Header()
  {
    const std::string here = __FILE__;
    std::ifstream file(here.substr(0, here.find_last_of('/')) + "/../../Filters/vtkChainMailDeformation.h");
    const std::string lines{ std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>() };
    this->Content = std::regex_replace(lines, std::regex("\n *\\* "), " "); // each paragraph of a comment in one line
  }

  bool Contains(const std::string& code) const { return this->Content.find(code) != std::string::npos; }

  /// Where the comment before `code` begins; npos where there is none.
  std::size_t CommentBefore(const std::string& code) const
  {
    const std::size_t at = this->Content.find(code);
    return at == std::string::npos ? at : this->Content.rfind("/**", at);
  }

  /// What stands after "Default: " in the comment before `code`, a number as Text() writes it.
  std::string DefaultBefore(const std::string& code) const
  {
    const std::size_t comment = this->CommentBefore(code);
    if (comment == std::string::npos)
    {
      return "no comment for " + code;
    }
    const std::string text = this->Content.substr(comment, this->Content.find("*/", comment) - comment);
    const std::size_t start = text.find("Default: ");
    if (start == std::string::npos)
    {
      return "no default documented for " + code;
    }
    // Up to the end of the sentence, or to an explanation after a comma.
    const std::string rest = text.substr(start + 9);
    std::smatch end;
    const std::string value = std::regex_search(rest, end, std::regex(",|\\.(\\s|$)")) ? end.prefix().str() : rest;
    char* unread = nullptr;
    const double number = std::strtod(value.c_str(), &unread);
    return unread != value.c_str() && *unread == '\0' ? Text(number) : value;
  }

  /// The comments that document a default, by where they begin.
  std::set<std::size_t> CommentsWithDefault() const
  {
    std::set<std::size_t> comments;
    const std::string word = "Default: ";
    for (std::size_t at = this->Content.find(word); at != std::string::npos; at = this->Content.find(word, at + 1))
    {
      comments.insert(this->Content.rfind("/**", at));
    }
    return comments;
  }

  /// What is declared below a comment.
  std::string DeclaredAfter(std::size_t comment) const
  {
    const std::size_t start = this->Content.find_first_not_of(" \n", this->Content.find("*/", comment) + 2);
    return this->Content.substr(start, this->Content.find(';', start) - start);
  }

  /// The properties that VTK's macros declare with a getter, and that can be set.
  std::set<std::string> Properties() const
  {
    std::set<std::string> names;
    const std::regex getter("vtkGet\\w*Macro\\((\\w+)");
    for (std::sregex_iterator found(this->Content.begin(), this->Content.end(), getter), end; found != end; ++found)
    {
      const std::string name = (*found)[1];
      if (std::regex_search(this->Content, std::regex("vtkSet\\w*Macro\\(" + name + "\\b|\\bSet" + name + "\\(")))
      {
        names.insert(name);
      }
    }
    return names;
  }

private:
  std::string Content;
};

/// Every property has a row. What a default is documented for is a property, too, however it is declared.
void CheckRows(Checks& check, const std::vector<DeformationProperty>& properties, const Header& header)
{
  std::set<std::string> rows;
  std::set<std::size_t> documented;
  for (const DeformationProperty& property : properties)
  {
    check.That(rows.insert(property.Name).second, property.Name + " has one row");
    documented.insert(header.CommentBefore(property.Getter));
  }
  for (const std::string& name : header.Properties())
  {
    check.That(rows.count(name) == 1, name + " has a row in DeformationProperties.h");
  }
  // These are no properties of the deformation, but of the process.
  documented.insert(header.CommentBefore("void SetGlobalProbeWarnings("));
  documented.insert(header.CommentBefore("void SetController("));
  for (std::size_t comment : header.CommentsWithDefault())
  {
    check.That(documented.count(comment) == 1,
      "what has this documented default has a row in DeformationProperties.h: " + header.DeclaredAfter(comment));
  }
}

/// PrintSelf writes this line.
void CheckPrinted(Checks& check, Deformation* filter, const std::string& line)
{
  std::ostringstream text;
  filter->PrintSelf(text, vtkIndent());
  check.That(text.str().find('\n' + line + '\n') != std::string::npos, "PrintSelf writes " + line);
}

}

int TestChainMailDefaults(int, char*[])
{
  Checks check;
  const Header header;
  const std::vector<DeformationProperty> properties = DeformationProperties();
  check.That(header.Contains("class "), "the header is found beside the test");
  CheckRows(check, properties, header);

  vtkNew<vtkChainMailDeformation> fresh;
  vtkNew<vtkChainMailDeformation> changed;
  vtkNew<vtkChainMailDeformation> copy;
  for (const DeformationProperty& property : properties)
  {
    const std::string& name = property.Name;
    check.Equal(property.Value(fresh), header.DefaultBefore(property.Getter), "the documented default of " + name);

    // Ranges.
    check.Equal(!property.Limits.empty(), header.Contains("vtkSetClampMacro(" + name + ","), name + " has a range");
    for (const auto& limit : property.Limits)
    {
      vtkNew<vtkChainMailDeformation> limited;
      limit.Set(limited);
      check.Equal(property.Value(limited), limit.Value, name + " beyond its range");
      CheckPrinted(check, limited, limit.Printed);
    }

    // A setter that changes something modifies the filter, once; repeated it does not, not even with NaN.
    check.That(!property.Changes.empty(), name + " can be changed");
    for (const auto& change : property.Changes)
    {
      const vtkMTimeType before = changed->GetMTime();
      change.Set(changed);
      const vtkMTimeType after = changed->GetMTime();
      change.Set(changed);
      const std::string now = name + " changed to " + change.Value;
      check.That(after > before, now + " modifies");
      check.That(changed->GetMTime() == after, now + " again does not");
      check.Equal(property.Value(changed), change.Value, now);
      CheckPrinted(check, changed, change.Printed);
      property.Copy(changed, copy);
      check.Equal(property.Value(copy), change.Value, now + ", of a copy");
    }
  }
  // All changes together are there and copied, and so are the defaults.
  for (const DeformationProperty& property : properties)
  {
    const auto& last = property.Changes.back();
    check.Equal(property.Value(changed), last.Value, "the changed " + property.Name);
    check.Equal(property.Value(copy), last.Value, "the copied " + property.Name);
    CheckPrinted(check, changed, last.Printed);
    property.Copy(fresh, copy);
    check.Equal(property.Value(copy), property.Value(fresh), "the default of " + property.Name + ", copied");
  }

  // Reset() always has something to do in Interactive mode and never in the other; before the first update nothing is
  // left to do.
  vtkNew<vtkChainMailDeformation> filter;
  filter->SetModeToInteractive();
  vtkMTimeType now = filter->GetMTime();
  filter->Reset();
  check.That(filter->GetMTime() > now, "Reset modifies");
  check.That(!filter->GetNeedsUpdate(), "a filter that was never updated needs no other update");
  vtkNew<vtkChainMailDeformation> fromRest;
  now = fromRest->GetMTime();
  fromRest->Reset();
  check.That(fromRest->GetMTime() == now, "Reset from rest does nothing");

  vtkNew<vtkPiecewiseFunction> function;
  filter->SetMaterialFunction(function);
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
