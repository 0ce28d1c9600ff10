// SPDX-License-Identifier: BSD-3-Clause
// Landmarks in the formats of 3D Slicer and elastix and in tables: places, labels and pairs come out in the scan's
// axes, whichever the file has; what is wrong with a file is said with its line.

#include "../TemporaryFolder.h"
#include "FilterTest.h"

#include "vtkChainMailLandmarkReader.h"
#include "vtkChainMailLandmarks.h"

#include <filesystem>
#include <fstream>

using namespace FilterTest;

namespace
{

/// The same two landmarks, L1 at (10, -20, 30) and L2 at (-1.5, 2.25, -300), to the left, back and head.
const char* const markups = R"({
  "@schema": "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#",
  "markups": [ { "type": "Fiducial", "coordinateSystem": "LPS", "coordinateUnits": "mm", "controlPoints": [
    { "id": "1", "label": "L1", "position": [ 10.0, -20.0, 30.0 ], "positionStatus": "defined" },
    { "id": "2", "label": "L2", "position": [ -1.5, 2.25, -300.0 ] } ] } ] })";
const char* const markupsRAS = R"({ "markups": [ { "type": "Fiducial", "coordinateSystem": "RAS", "controlPoints": [
    { "label": "L1", "position": [ -10.0, 20.0, 30.0 ] }, { "label": "L2", "position": [ 1.5, -2.25, -300.0 ] } ] } ] })";
const char* const markupsTwo = R"({ "markups": [
  { "coordinateSystem": "RAS", "controlPoints": [ { "label": "L1", "position": [ -10, 20, 30 ] } ] },
  { "coordinateSystem": "LPS", "controlPoints": [ { "label": "L2", "position": [ -1.5, 2.25, -300 ] },
    { "label": "L3", "position": [ 0, 0, 0 ], "positionStatus": "undefined" } ] } ] })";
const char* const fiducials = "# Markups fiducial file version = 4.11\r\n# CoordinateSystem = LPS\r\n"
                              "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\r\n"
                              "vtkMRMLMarkupsFiducialNode_0,10,-20,30,0,0,0,1,1,1,0,L1,,\r\n"
                              "vtkMRMLMarkupsFiducialNode_1,-1.5,2.25,-300,0,0,0,1,1,1,0,L2,\"a, b\",\r\n";
const char* const fiducialsRAS = "# Markups fiducial file version = 4.6\n# CoordinateSystem = 0\n"
                                 "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
                                 "a,-10,20,30,0,0,0,1,1,1,0,L1,,\nb,1.5,-2.25,-300,0,0,0,1,1,1,0,L2,,\n";
const char* const fiducialsOld = "# Fiducial List file /tmp/L.fcsv\n# name = L\n# columns = label,x,y,z,sel,vis\n"
                                 "L1,-10,20,30,1,1\nL2,1.5,-2.25,-300,1,1\n";

std::vector<Vector> PlacesOf(vtkPolyData* data)
{
  std::vector<Vector> places(static_cast<std::size_t>(data->GetNumberOfPoints()));
  for (std::size_t n = 0; n < places.size(); ++n)
  {
    data->GetPoint(static_cast<vtkIdType>(n), places[n].data());
  }
  return places;
}

std::string LabelsOf(vtkPolyData* data)
{
  std::string all;
  auto* labels = vtkStringArray::SafeDownCast(data->GetPointData()->GetAbstractArray("Label"));
  for (vtkIdType n = 0; labels && n < labels->GetNumberOfValues(); ++n)
  {
    all += (n ? "," : "") + labels->GetValue(n);
  }
  return all;
}

}

int TestChainMailLandmarkReader(int, char*[])
{
  Checks check;
  const TemporaryFolder folder;
  const auto write = [&](const std::string& name, const std::string& content)
  {
    const std::string path = (folder.path / name).string();
    std::ofstream(path, std::ios::binary) << content;
    return path;
  };
  vtkNew<vtkChainMailLandmarkReader> reader;
  EventLog log(reader);
  check.Equal(reader->GetWorld(), 0, "World is LPS by default");
  check.Equal(reader->GetFileWorld(), 0, "FileWorld is what the file says by default");

  const std::vector<Vector> lps = { { { 10.0, -20.0, 30.0 } }, { { -1.5, 2.25, -300.0 } } };
  const std::vector<Vector> ras = { { { -10.0, 20.0, 30.0 } }, { { 1.5, -2.25, -300.0 } } };
  struct Case
  {
    const char* Name;
    std::string Content;
    int FileWorld;
    const char* Labels;
    const char* Said;
  };
  const std::string table = "10,-20,30\n-1.5,2.25,-300\n";
  const Case cases[] = {
    { "lps.mrk.json", markups, 0, "L1,L2", "axes LPS, from the file" },
    { "ras.mrk.json", markupsRAS, 0, "L1,L2", "axes RAS, from the file" },
    { "lps.fcsv", fiducials, 0, "L1,L2", "axes LPS, from the file" },
    { "ras.fcsv", fiducialsRAS, 0, "L1,L2", "axes RAS, from the file" },
    { "old.fcsv", fiducialsOld, 0, "L1,L2", "axes RAS, from the format (the file names none)" },
    { "point.txt", "point\n2\n10 -20 30\n-1.500000000000000e+00 2.25 -3.0e+02\n", 0, ",",
      "axes LPS, from the format of elastix" },
    { "point.pts", "point\r\n2\r\n10\t-20\t30\r\n-1.5\t2.25\t-300\r\n", 0, ",",
      "axes LPS, from the format of elastix" },
    { "bare.csv", table, 1, ",", "axes LPS, from FileWorld" },
    { "turned.csv", "-10;20;30\n1.5;-2.25;-300\n", 2, ",", "axes RAS, from FileWorld" },
    { "named.csv", "label,x,y,z\nL1,10,-20,30\nL2,-1.5,2.25,-300\n", 1, "L1,L2", "axes LPS, from FileWorld" },
    { "labels.csv", "L1,10,-20,30\n\"L2\",-1.5,2.25,-300\n", 1, "L1,L2", "axes LPS, from FileWorld" },
    { "slicer.csv", "label,r,a,s,defined,selected\nL1,-10,20,30,1,1\nL2,1.5,-2.25,-300,1,1\n", 0, "L1,L2",
      "axes RAS, from the table" },
    { "slicer.tsv", "label\tl\tp\ts\nL1\t10\t-20\t30\nL2\t-1.5\t2.25\t-300\n", 0, "L1,L2", "axes LPS, from the table" },
    { "excel.csv", "\xEF\xBB\xBFName;Z;Y;X\nL1;30;-20;10\nL2;-300;2.25;-1.5\n", 1, "L1,L2",
      "axes LPS, from FileWorld" },
    { "bad.mrk.json", markupsRAS, 2, "L1,L2", "axes RAS, from FileWorld" },
  };
  for (const Case& one : cases)
  {
    const std::string path = write(one.Name, one.Content);
    reader->SetFileName(path.c_str());
    reader->SetFileWorld(one.FileWorld);
    check.Equal(reader->CanReadFile(path.c_str()), 1, one.Name + std::string(" can be read"));
    for (const int world : { 0, 1 })
    {
      const std::string where = one.Name + std::string(world ? " in RAS" : " in LPS");
      reader->SetWorld(world);
      reader->Update();
      check.Equal(log.TakeErrors() + log.TakeWarnings(), std::string(), where + ": no error");
      check.That(PlacesOf(reader->GetOutput()) == (world ? ras : lps), where + ": the places");
      check.Equal(reader->GetOutput()->GetNumberOfVerts(), vtkIdType(2), where + ": are seen");
      check.Equal(LabelsOf(reader->GetOutput()), std::string(one.Labels), where + ": the labels");
      const std::string report = reader->GetReport();
      check.Contains(report, "2 landmarks; ", where);
      check.Contains(report, one.Said, where);
      check.Contains(report, world ? "the scan has RAS (World)" : "the scan has LPS (World)", where);
      const bool isRAS = report.find("axes RAS") != std::string::npos;
      check.Contains(
        report, isRAS == (world == 1) ? "nothing was converted" : "the signs of x and y were changed", where);
    }
  }
  // Against what the file says, which the report tells; and nothing said, which is the scan's own.
  reader->SetFileName(write("lie.mrk.json", markups).c_str());
  reader->SetFileWorldToRAS();
  reader->SetWorldToLPS();
  reader->Update();
  check.That(PlacesOf(reader->GetOutput()) == ras, "read as RAS though it says LPS");
  check.Contains(reader->GetReport(), "in place of LPS from the file", "the report");
  reader->SetFileName(write("silent.csv", table).c_str());
  reader->SetFileWorldToAsSaid();
  for (const int world : { 0, 1 })
  {
    reader->SetWorld(world);
    reader->Update();
    check.That(PlacesOf(reader->GetOutput()) == lps, "a table that does not say is left as it is");
    check.Contains(reader->GetReport(), "names none", "the report");
  }
  reader->SetWorldToLPS();

  // Lists of different axes in one file, and a landmark without a place.
  reader->SetFileName(write("two.mrk.json", markupsTwo).c_str());
  reader->Update();
  check.Equal(log.TakeErrors(), std::string(), "two lists");
  check.Contains(log.TakeWarnings(), "1 landmarks have no position yet", "two lists");
  check.That(PlacesOf(reader->GetOutput()) == lps, "two lists: both in one's axes");

  // Pairs.
  for (const char* const content :
    { "1,2,3,4,5,6\n7,8,9,10,11,12\n", "a 1 2 3 4 5 6\nb 7 8 9 10 11 12",
      "x1,y1,z1,x2,y2,z2\n1,2,3,4,5,6\n7,8,9,10,11,12\n", "# pairs\nz2,y2,x2,z1,y1,x1\n6,5,4,3,2,1\n12,11,10,9,8,7\n" })
  {
    reader->SetFileName(write("pairs.csv", content).c_str());
    reader->SetWorldToRAS();
    reader->SetFileWorldToLPS();
    reader->Update();
    check.Equal(log.TakeErrors(), std::string(), content);
    check.That(PlacesOf(reader->GetOutput()) == std::vector<Vector>{ { { -1, -2, 3 } }, { { -7, -8, 9 } } }, content);
    vtkDataArray* target = reader->GetOutput()->GetPointData()->GetArray("Target");
    check.That(target && target->GetComponent(1, 0) == -10 && target->GetComponent(1, 2) == 12, content);
    vtkNew<vtkChainMailLandmarks> pairs;
    pairs->SetInputConnection(reader->GetOutputPort());
    pairs->Update();
    vtkDataArray* displacement = pairs->GetOutput()->GetPointData()->GetArray("Displacement");
    check.That(displacement && displacement->GetComponent(0, 0) == -3 && displacement->GetComponent(0, 2) == 3,
      "pairs are probes");
  }
  reader->SetWorldToLPS();
  reader->SetFileWorldToAsSaid();

  // Voxels need their image. Its axes are the world's.
  auto image = MakeImage({ { 5, 9, -3, 4, 0, 9 } });
  image->SetSpacing(2.0, 3.0, 4.0);
  image->SetOrigin(100.0, 200.0, 300.0);
  image->SetDirectionMatrix(0, -1, 0, 1, 0, 0, 0, 0, 1);
  reader->SetFileName(write("index.txt", "index\n1\n1 2 3\n").c_str());
  reader->SetWorldToRAS();
  reader->Update();
  reader->SetWorldToLPS();
  check.Equal(log.TakeErrors(), std::string(), "voxels");
  check.That(PlacesOf(reader->GetOutput()) == std::vector<Vector>{ { { 1.0, 2.0, 3.0 } } }, "voxels as they are");
  check.Contains(reader->GetReport(), "voxel indices", "voxels");
  vtkNew<vtkPolyData> there; // at voxel (6, -1, 3): 12, -3, 12 along the image's axes, which go along y, -x and z
  vtkNew<vtkPoints> place;
  place->SetDataTypeToDouble();
  place->InsertNextPoint(103.0, 212.0, 313.0);
  there->SetPoints(place);
  vtkNew<vtkChainMailLandmarks> placed;
  EventLog placedLog(placed);
  placed->SetInputConnection(reader->GetOutputPort());
  placed->SetToData(there);
  placed->Update();
  check.Contains(placedLog.TakeErrors(), "Connect the image that these count in as Image", "voxels without an image");
  placed->SetImageData(image);
  placed->Update();
  check.Equal(placedLog.TakeErrors(), std::string(), "voxels with their image");
  check.That(PlacesOf(placed->GetOutput()) == std::vector<Vector>{ { { 103.0, 212.0, 312.0 } } }, "placed voxels");

  // What is wrong is said; then another file is read.
  const std::pair<const char*, const char*> wrongs[] = {
    { "", "is empty" },
    { " \n\n", "is empty" },
    { "{ \"markups\": [ { \"controlPoints\": [ ] } ", "not valid JSON" },
    { "{ \"a\": 1 }", "not a .mrk.json of 3D Slicer" },
    { "{ \"markups\": [ ] }", "has no landmarks" },
    { "{ \"markups\": [ 5 ] }", "controlPoints" },
    { "{ \"markups\": [ { \"coordinateSystem\": \"IJK\", \"controlPoints\": [ ] } ] }", "neither LPS nor RAS" },
    { "{ \"markups\": [ { \"coordinateSystem\": 7, \"controlPoints\": [ ] } ] }", "not a text" },
    { "{ \"markups\": [ { \"coordinateUnits\": \"cm\", \"controlPoints\": [ ] } ] }", "Save it in mm" },
    { "{ \"markups\": [ { \"coordinateUnits\": [\"m\", \"m\", \"m\"], \"controlPoints\": [ ] } ] }", "Save it in mm" },
    { "{ \"markups\": [ { \"controlPoints\": [ { \"position\": [ 1, \"b\", 2 ] } ] } ] }", "point 1 of list 1" },
    { "{ \"markups\": [ { \"controlPoints\": [ { \"position\": [ 1, 2 ] } ] } ] }", "must be three numbers" },
    { "{ \"markups\": [ { \"controlPoints\": [ 3 ] } ] }", "is not a JSON object" },
    { "# Markups fiducial file version = 4.6\n# CoordinateSystem = 2\na,1,2,3\n", "neither LPS nor RAS" },
    { "# Markups fiducial file version = 4.6\na,1,nan,3\n", "line 2, column 3: \"nan\" is not a number" },
    { "# Markups fiducial file version = 4.6\n", "has no landmarks" },
    { "# Markups fiducial file version = 4.6\n# columns = id,a,b\nq,1,2\n", "does not name the columns x, y and z" },
    { "point\n3\n1 2 3\n4 5 6\n", "gives 3 points, but the file has 2" },
    { "point\n1 2 3\n", "second line" },
    { "point\n1\n1 2\n", "line 3, column 3" },
    { "1,2\n", "A row needs three numbers" },
    { "1,2,3\n4,x,6\n", "line 2, column 2: \"x\" is not a number" },
    { "1,2,3\n4,5\n", "line 2, column 3: \"\" is not a number" },
    { "1,2,3\n4,1e999,3\n", "\"1e999\" is not a number" },
    { "a,b,c\n1,2,3\n", "no columns x, y and z" },
    { "# nothing\n", "only comments" },
    { "x,y,z\n", "has no landmarks" },
  };
  for (const auto& wrong : wrongs)
  {
    reader->SetFileName(write("wrong", wrong.first).c_str());
    reader->Update();
    const std::string errors = log.TakeErrors();
    check.Contains(errors, wrong.second, wrong.first);
    check.Contains(errors, "wrong\"", "names the file");
    check.Equal(reader->GetOutput()->GetNumberOfPoints(), vtkIdType(0), "nothing comes of it");
    reader->SetFileName(write("right", table).c_str());
    reader->Update();
    check.Equal(log.TakeErrors(), std::string(), "then a right one");
    check.Equal(reader->GetOutput()->GetNumberOfPoints(), vtkIdType(2), "then a right one");
  }
  reader->SetFileName((folder.path / "none.csv").string().c_str());
  reader->Update();
  check.Contains(log.TakeErrors(), "Check that the file exists", "no file");
  reader->SetFileName("");
  reader->Update();
  check.Contains(log.TakeErrors(), "set FileName", "no name");
  // Brackets without end, and what is no landmarks, in the list of readers.
  reader->SetFileName(write("deep", "{ \"markups\": " + std::string(5000, '[')).c_str());
  reader->Update();
  check.Contains(log.TakeErrors(), "not valid JSON", "brackets");
  for (const char* const other : { "time,pressure\n0,1\n1,2\n", "{ \"asset\": { } }", "Some text\nof a book.\n", "" })
  {
    check.Equal(
      reader->CanReadFile(write("other", other).c_str()), 0, std::string("is no file of landmarks: ") + other);
  }
  check.Equal(reader->CanReadFile(nullptr), 0, "no name can be read");

  std::ostringstream text;
  reader->PrintSelf(text, vtkIndent());
  for (const char* const line : { "FileName: ", "World: LPS", "FileWorld: as said", "Report: " })
  {
    check.Contains(text.str(), line, "PrintSelf");
  }
  return check.Finish();
}
