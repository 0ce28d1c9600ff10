// SPDX-License-Identifier: BSD-3-Clause
#include "vtkPVChainMailTissueInformation.h"

#include "vtkAlgorithm.h"
#include "vtkChainMailTissuePicker.h"
#include "vtkClientServerStream.h"
#include "vtkImageData.h"
#include "vtkMath.h"
#include "vtkMatrix3x3.h"
#include "vtkMultiProcessStream.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPiecewiseFunction.h"

#include <algorithm>

vtkStandardNewMacro(vtkPVChainMailTissueInformation);

namespace
{
void Write(vtkMultiProcessStream& stream, const std::vector<double>& numbers)
{
  stream << static_cast<int>(numbers.size());
  for (const double number : numbers)
  {
    stream << number;
  }
}

void Read(vtkMultiProcessStream& stream, std::vector<double>& numbers)
{
  int size = 0;
  stream >> size;
  numbers.resize(static_cast<std::size_t>(size));
  for (double& number : numbers)
  {
    stream >> number;
  }
}
}

//------------------------------------------------------------------------------
vtkPVChainMailTissueInformation::vtkPVChainMailTissueInformation()
  : TissueThreshold(vtkMath::Nan())
{
}

//------------------------------------------------------------------------------
void vtkPVChainMailTissueInformation::CopyParametersToStream(vtkMultiProcessStream& stream)
{
  stream << this->Port << this->Scalars << this->TissueThreshold << this->OpacityUnitDistance;
  Write(stream, this->Opacity);
  Write(stream, this->Rays);
}

void vtkPVChainMailTissueInformation::CopyParametersFromStream(vtkMultiProcessStream& stream)
{
  stream >> this->Port >> this->Scalars >> this->TissueThreshold >> this->OpacityUnitDistance;
  Read(stream, this->Opacity);
  Read(stream, this->Rays);
}

//------------------------------------------------------------------------------
void vtkPVChainMailTissueInformation::CopyFromObject(vtkObject* object)
{
  this->Shares.assign(this->Rays.size() / 6, -1.0);
  this->Direction.fill(0.0);
  auto* algorithm = vtkAlgorithm::SafeDownCast(object);
  auto* image = vtkImageData::SafeDownCast(algorithm && this->Port < algorithm->GetNumberOfOutputPorts()
                                             ? algorithm->GetOutputDataObject(this->Port)
                                             : nullptr);
  if (image == nullptr)
  {
    return;
  }
  std::copy_n(image->GetDirectionMatrix()->GetData(), 9, this->Direction.data());

  vtkNew<vtkChainMailTissuePicker> picker;
  picker->SetScalars(this->Scalars.c_str());
  picker->SetTissueThreshold(this->TissueThreshold);
  if (!this->Opacity.empty())
  {
    vtkNew<vtkPiecewiseFunction> opacity;
    for (std::size_t n = 0; n + 4 <= this->Opacity.size(); n += 4)
    {
      opacity->AddPoint(this->Opacity[n], this->Opacity[n + 1], this->Opacity[n + 2], this->Opacity[n + 3]);
    }
    picker->SetOpacity(opacity);
    picker->SetOpacityUnitDistance(this->OpacityUnitDistance);
  }
  for (std::size_t n = 0; n < this->Shares.size(); ++n)
  {
    this->Shares[n] = picker->Pick(image, this->Rays.data() + 6 * n, this->Rays.data() + 6 * n + 3);
  }
}

//------------------------------------------------------------------------------
void vtkPVChainMailTissueInformation::AddInformation(vtkPVInformation* information)
{
  auto* other = vtkPVChainMailTissueInformation::SafeDownCast(information);
  if (other == nullptr)
  {
    return;
  }
  this->Shares.resize(std::max(this->Shares.size(), other->Shares.size()), -1.0);
  for (std::size_t n = 0; n < other->Shares.size(); ++n)
  {
    const double share = other->Shares[n];
    if (share >= 0.0 && (this->Shares[n] < 0.0 || share < this->Shares[n]))
    {
      this->Shares[n] = share;
    }
  }
  if (std::count(this->Direction.begin(), this->Direction.end(), 0.0) == 9)
  {
    this->Direction = other->Direction;
  }
}

//------------------------------------------------------------------------------
void vtkPVChainMailTissueInformation::CopyToStream(vtkClientServerStream* stream)
{
  stream->Reset();
  *stream << vtkClientServerStream::Reply
          << vtkClientServerStream::InsertArray(this->Direction.data(), static_cast<int>(this->Direction.size()))
          << vtkClientServerStream::InsertArray(this->Shares.data(), static_cast<int>(this->Shares.size()))
          << vtkClientServerStream::End;
}

void vtkPVChainMailTissueInformation::CopyFromStream(const vtkClientServerStream* stream)
{
  this->Shares.clear();
  this->Direction.fill(0.0);
  vtkTypeUInt32 size = 0;
  if (stream->GetArgument(0, 0, this->Direction.data(), static_cast<vtkTypeUInt32>(this->Direction.size())) &&
      stream->GetArgumentLength(0, 1, &size))
  {
    this->Shares.resize(size);
    stream->GetArgument(0, 1, this->Shares.data(), size);
  }
}

//------------------------------------------------------------------------------
void vtkPVChainMailTissueInformation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Port: " << this->Port << "\n";
  os << indent << "Rays: " << this->Rays.size() / 6 << "\n";
}
