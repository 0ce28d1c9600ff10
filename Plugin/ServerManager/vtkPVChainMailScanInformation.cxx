// SPDX-License-Identifier: BSD-3-Clause
#include "vtkPVChainMailScanInformation.h"

#include "vtkAlgorithm.h"
#include "vtkChainMailScanStatistics.h"
#include "vtkClientServerStream.h"
#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkMultiProcessStream.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkSMSourceProxy.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>
#include <array>
#include <vector>

vtkStandardNewMacro(vtkPVChainMailScanInformation);

//------------------------------------------------------------------------------
vtkPVChainMailScanInformation::vtkPVChainMailScanInformation() = default;
vtkPVChainMailScanInformation::~vtkPVChainMailScanInformation() = default;

//------------------------------------------------------------------------------
void vtkPVChainMailScanInformation::Gather(vtkSMSourceProxy* source, int port, const std::string& scalars)
{
  this->Port = port;
  this->Scalars = scalars;
  source->GatherInformation(this);
}

//------------------------------------------------------------------------------
void vtkPVChainMailScanInformation::CopyParametersToStream(vtkMultiProcessStream& stream)
{
  stream << this->Port << this->Scalars;
}

void vtkPVChainMailScanInformation::CopyParametersFromStream(vtkMultiProcessStream& stream)
{
  stream >> this->Port >> this->Scalars;
}

//------------------------------------------------------------------------------
void vtkPVChainMailScanInformation::CopyFromObject(vtkObject* object)
{
  this->Statistics->Unpack({});
  auto* algorithm = vtkAlgorithm::SafeDownCast(object);
  auto* image = vtkImageData::SafeDownCast(algorithm && this->Port < algorithm->GetNumberOfOutputPorts()
                                             ? algorithm->GetOutputDataObject(this->Port)
                                             : nullptr);
  vtkPointData* arrays = image ? image->GetPointData() : nullptr;
  vtkDataArray* scalars =
    !arrays ? nullptr : (this->Scalars.empty() ? arrays->GetScalars() : arrays->GetArray(this->Scalars.c_str()));
  if (scalars == nullptr || image->GetNumberOfPoints() == 0)
  {
    return;
  }
  std::array<int, 6> extent;
  image->GetExtent(extent.data());
  std::array<int, 6> whole = extent;
  vtkInformation* information = algorithm->GetOutputInformation(this->Port);
  if (information && information->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()))
  {
    information->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), whole.data());
  }
  if (extent == whole)
  {
    this->Statistics->Unpack(vtkChainMailScanStatistics::Of(image, scalars)->Pack()); // which may be kept
  }
  else
  {
    this->Statistics->ReadPart(image, scalars, whole.data());
  }
}

//------------------------------------------------------------------------------
void vtkPVChainMailScanInformation::AddInformation(vtkPVInformation* information)
{
  if (auto* other = vtkPVChainMailScanInformation::SafeDownCast(information))
  {
    this->Statistics->Merge(other->Statistics);
  }
}

//------------------------------------------------------------------------------
void vtkPVChainMailScanInformation::CopyToStream(vtkClientServerStream* stream)
{
  const std::vector<double> numbers = this->Statistics->Pack();
  stream->Reset();
  *stream << vtkClientServerStream::Reply
          << vtkClientServerStream::InsertArray(numbers.data(), static_cast<int>(numbers.size()))
          << vtkClientServerStream::End;
}

void vtkPVChainMailScanInformation::CopyFromStream(const vtkClientServerStream* stream)
{
  vtkTypeUInt32 size = 0;
  std::vector<double> numbers;
  if (stream->GetArgumentLength(0, 0, &size))
  {
    numbers.resize(size);
    stream->GetArgument(0, 0, numbers.data(), size);
  }
  this->Statistics->Unpack(numbers);
}

//------------------------------------------------------------------------------
void vtkPVChainMailScanInformation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Port: " << this->Port << "\n";
  os << indent << "Scalars: " << this->Scalars << "\n";
  this->Statistics->PrintSelf(os, indent);
}
