// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailForearmSource.h"

#include "vtkDataObject.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>

#if VTK_MODULE_ENABLE_VTK_PythonInterpreter
#include "ChainMailForearmPY.h" // made from Data/make_forearm.py
#include "vtkPythonInterpreter.h"

#include <cstdint>
#include <sstream>
#endif

vtkStandardNewMacro(vtkChainMailForearmSource);

//------------------------------------------------------------------------------
vtkChainMailForearmSource::vtkChainMailForearmSource()
{
  this->SetNumberOfInputPorts(0);
}

//------------------------------------------------------------------------------
void vtkChainMailForearmSource::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Size: " << this->Size[0] << " " << this->Size[1] << " " << this->Size[2] << "\n";
}

//------------------------------------------------------------------------------
void vtkChainMailForearmSource::SetSize(int x, int y, int z)
{
  const int size[3] = { std::max(x, 32), std::max(y, 32), std::max(z, 32) };
  if (!std::equal(size, size + 3, this->Size))
  {
    std::copy(size, size + 3, this->Size);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
int vtkChainMailForearmSource::RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkInformation* info = output->GetInformationObject(0);
  const int whole[6] = { 0, this->Size[0] - 1, 0, this->Size[1] - 1, 0, this->Size[2] - 1 };
  info->Set(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), whole, 6);
  info->Set(vtkAlgorithm::CAN_PRODUCE_SUB_EXTENT(), 1);
  vtkDataObject::SetPointDataActiveScalarInfo(info, VTK_SHORT, 1);
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailForearmSource::RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
#if VTK_MODULE_ENABLE_VTK_PythonInterpreter
  const int* extent = output->GetInformationObject(0)->Get(vtkStreamingDemandDrivenPipeline::UPDATE_EXTENT());
  // Python finds this source by its address, and the image as its output: of VTK's own classes for data, those that
  // Python extends take no address since VTK 9.6.
  std::ostringstream address;
  address << std::hex << reinterpret_cast<std::uintptr_t>(static_cast<vtkAlgorithm*>(this));
  std::ostringstream code;
  code << "def chainmail_make_forearm(image, size, extent):\n"
          "  names = { '__name__': 'make_forearm' }\n"
          "  exec(r'''"
       << ChainMailForearmPY
       << "''', names)\n"
          "  forearm = names['make_forearm'](size)\n"
          "  forearm.Crop(extent)\n"
          "  image.ShallowCopy(forearm)\n"
          "from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm as chainmail_source\n"
          "chainmail_make_forearm(chainmail_source('"
       << address.str() << "').GetOutputDataObject(0), (" << this->Size[0] << ", " << this->Size[1] << ", "
       << this->Size[2] << "), (";
  for (int i = 0; i < 6; ++i)
  {
    code << extent[i] << ", ";
  }
  code << "))\n"
          "del chainmail_make_forearm, chainmail_source\n";
  vtkPythonInterpreter::Initialize();
  if (vtkPythonInterpreter::RunSimpleString(code.str().c_str()) == 0)
  {
    return 1;
  }
  vtkErrorMacro(
    "Python could not make the forearm, for the reason printed above. The forearm needs Python's module numpy.");
#else
  (void)output;
  vtkErrorMacro("The forearm needs a ParaView with Python, but this plugin was built with a ParaView without Python.");
#endif
  return 0;
}
