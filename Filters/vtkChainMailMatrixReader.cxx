// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailMatrixReader.h"

#include "Private/MatrixFile.h"
#include "Private/ProbeSet.h"

#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"

#include <algorithm>

vtkStandardNewMacro(vtkChainMailMatrixReader);

//------------------------------------------------------------------------------
vtkChainMailMatrixReader::vtkChainMailMatrixReader()
{
  this->SetNumberOfInputPorts(0);
}

//------------------------------------------------------------------------------
int vtkChainMailMatrixReader::CanReadFile(const char* fileName)
{
  return fileName && vtkChainMail::IsMatrixFile(fileName) ? 1 : 0;
}

//------------------------------------------------------------------------------
int vtkChainMailMatrixReader::RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  using namespace vtkChainMail;
  vtkPolyData* output = vtkPolyData::GetData(outputVector, 0);
  this->Report.clear();
  try
  {
    MatrixFile file = ReadMatrices(this->FileName);
    const auto world = static_cast<PatientAxes>(this->World);
    const AxesOfFile axes(file.SaysAxes, file.Axes, file.Who, this->FileWorld, world);
    for (BodyMotion& motion : file.Motions)
    {
      for (int i = 0; i < 3; ++i)
      {
        for (int j = 0; j < 4; ++j)
        {
          motion.Matrix[4 * i + j] *= SignOf(axes.Axes, world, i) * (j < 3 ? SignOf(axes.Axes, world, j) : 1.0);
        }
      }
      Convert(motion.Centre.data(), axes.Axes, world);
      CheckRigid(motion); // before inverting, so that an error message has the file's numbers
      if (this->Invert)
      {
        motion.Matrix = Inverted(motion.Matrix);
      }
      if (motion.Body < 0)
      {
        motion.Body = this->Body;
        motion.HasPosition = this->Body < 0;
        std::copy(this->Position, this->Position + 3, motion.Position.begin());
      }
    }
    MakeProbes(file.Motions, output);
    this->Report = std::to_string(file.Motions.size()) + (file.Motions.size() == 1 ? " matrix; " : " matrices; ") +
                   axes.ToString(world) + "\n" + SummaryOf(output) + "\n";
  }
  catch (const std::exception& error)
  {
    vtkErrorMacro(<< error.what());
    return 0;
  }
  return 1;
}

//------------------------------------------------------------------------------
void vtkChainMailMatrixReader::PrintSelf(ostream& os, vtkIndent indent)
{
  const char* const fileWorlds[] = { "as said", "LPS", "RAS" };
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << this->FileName << "\n";
  os << indent << "World: " << (this->World == WORLD_RAS ? "RAS" : "LPS") << "\n";
  os << indent << "FileWorld: " << fileWorlds[this->FileWorld] << "\n";
  os << indent << "Invert: " << (this->Invert ? "On" : "Off") << "\n";
  os << indent << "Body: " << this->Body << "\n";
  os << indent << "Position: " << this->Position[0] << " " << this->Position[1] << " " << this->Position[2] << "\n";
  os << indent << "Report: " << this->Report << "\n";
}
