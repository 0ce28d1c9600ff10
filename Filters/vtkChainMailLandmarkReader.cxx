// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailLandmarkReader.h"

#include "Error.h"
#include "Private/LandmarkFile.h"
#include "Private/ProbeSet.h"

#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkStringArray.h"
#include "vtkUnsignedCharArray.h"

vtkStandardNewMacro(vtkChainMailLandmarkReader);

//------------------------------------------------------------------------------
vtkChainMailLandmarkReader::vtkChainMailLandmarkReader()
{
  this->SetNumberOfInputPorts(0);
}

//------------------------------------------------------------------------------
int vtkChainMailLandmarkReader::CanReadFile(const char* fileName)
{
  return fileName && vtkChainMail::IsLandmarkFile(fileName) ? 1 : 0;
}

//------------------------------------------------------------------------------
int vtkChainMailLandmarkReader::RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  using namespace vtkChainMail;
  vtkPolyData* output = vtkPolyData::GetData(outputVector, 0);
  this->Report.clear();
  try
  {
    const std::vector<LandmarkList> lists = ReadLandmarks(this->FileName);
    const auto world = static_cast<PatientAxes>(this->World);
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    vtkNew<vtkDoubleArray> targets;
    targets->SetName("Target");
    targets->SetNumberOfComponents(3);
    vtkNew<vtkStringArray> labels;
    labels->SetName("Label");
    for (const LandmarkList& list : lists)
    {
      const AxesOfFile axes(list.SaysAxes, list.Axes, list.Who, this->FileWorld, world);
      const auto toWorld = [&](std::array<double, 3> place)
      {
        if (!list.AreIndices)
        {
          Convert(place.data(), axes.Axes, world);
        }
        return place;
      };
      for (const auto& place : list.Places)
      {
        points->InsertNextPoint(toWorld(place).data());
      }
      for (const auto& place : list.Targets)
      {
        targets->InsertNextTuple(toWorld(place).data());
      }
      for (const std::string& label : list.Labels)
      {
        labels->InsertNextValue(label);
      }
      this->Report += std::to_string(list.Places.size()) + (list.Targets.empty() ? " landmarks" : " pairs") + "; ";
      this->Report += list.AreIndices ? "voxel indices, which ChainMail Landmarks converts with its input Image."
                                      : axes.ToString(world);
      this->Report += "\n";
      if (list.LeftOut > 0)
      {
        const std::string text = std::to_string(list.LeftOut) + " landmarks have no position yet and were left out.";
        this->Report += text + "\n";
        vtkWarningMacro(
          << "\"" << this->FileName << "\": " << text
          << " Switch MatchLabels of ChainMail Landmarks on, because the order no longer pairs the others.");
      }
    }
    SetProbePoints(output, points);
    if (targets->GetNumberOfTuples() > 0)
    {
      output->GetPointData()->AddArray(targets);
    }
    output->GetPointData()->AddArray(labels);
    if (lists[0].AreIndices)
    {
      vtkNew<vtkUnsignedCharArray> voxels;
      voxels->SetName("Voxels");
      voxels->InsertNextValue(1);
      output->GetFieldData()->AddArray(voxels);
    }
  }
  catch (const std::exception& error)
  {
    vtkErrorMacro(<< error.what());
    return 0;
  }
  return 1;
}

//------------------------------------------------------------------------------
void vtkChainMailLandmarkReader::PrintSelf(ostream& os, vtkIndent indent)
{
  const char* const fileWorlds[] = { "as said", "LPS", "RAS" };
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << this->FileName << "\n";
  os << indent << "World: " << (this->World == WORLD_RAS ? "RAS" : "LPS") << "\n";
  os << indent << "FileWorld: " << fileWorlds[this->FileWorld] << "\n";
  os << indent << "Report: " << this->Report << "\n";
}
