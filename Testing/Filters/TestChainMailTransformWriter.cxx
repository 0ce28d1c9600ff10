// SPDX-License-Identifier: BSD-3-Clause
// What the writer of transforms says where it cannot write, and what it leaves then: nothing.
// Testing/Python/TestTransforms.py has other programs read what it writes.

#include "../TemporaryFolder.h"
#include "FilterTest.h"

#include "vtkChainMailTransformWriter.h"
#include "vtkFloatArray.h"

#include <filesystem>
#include <fstream>
#include <sstream>

using namespace FilterTest;

namespace
{

std::string ContentOf(const std::filesystem::path& path)
{
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}

int TestChainMailTransformWriter(int, char*[])
{
  Checks check;
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path / "field.mha";
  auto image = MakeImage({ { 2, 4, 0, 1, -1, 0 } });
  vtkNew<vtkChainMailTransformWriter> writer;
  EventLog log(writer);
  writer->SetInputData(image);
  writer->SetFileName(path.string().c_str());
  const auto expectError = [&](const std::string& part, const std::string& where)
  {
    check.Equal(writer->Write(), 0, where + ": fails");
    check.Contains(log.TakeErrors(), part, where + ": says why");
    check.That(!std::filesystem::exists(path), where + ": leaves no file");
  };
  expectError("Switch PullBack of ChainMail Deformation on", "no field");
  writer->SetField("Scan");
  expectError("no array Scan of 3 components", "scalars");
  writer->SetField("Nonsense");
  expectError("no array Nonsense", "a name that is none");
  writer->SetField("");

  vtkNew<vtkFloatArray> field;
  field->SetName("Displacement");
  field->SetNumberOfComponents(3);
  for (int n = 0; n < 12; ++n)
  {
    field->InsertNextTuple3(n, 0.5 * n, n == 7 ? std::nan("") : -1.0);
  }
  image->GetPointData()->AddArray(field);
  writer->SetFileName((folder.path / "none" / "field.mha").string().c_str());
  expectError("Check that the folder exists", "a folder that is none");
  if (std::filesystem::exists("/dev/full"))
  {
    writer->SetFileName("/dev/full");
    expectError("Check that the disk has free space", "a full disk");
  }

  writer->SetFileName(path.string().c_str());
  check.Equal(writer->Write(), 1, "written");
  check.Equal(log.TakeErrors(), std::string(), "no error");
  const std::string content = ContentOf(path);
  check.Contains(content, "\nOffset = 2 0 -1\n", "the first voxel's place");
  check.Contains(content, "\nDimSize = 3 2 2\n", "the size");
  const std::string end = "ElementDataFile = LOCAL\n";
  const std::size_t head = content.find(end) + end.size();
  check.Equal(content.size() - head, std::size_t(12 * 3 * 4), "three floats a voxel");
  writer->SetWorldToRAS();
  check.Equal(writer->Write(), 1, "written over");
  check.Contains(ContentOf(path), "\nOffset = -2 0 -1\n", "counted to the right");
  return check.Finish();
}
