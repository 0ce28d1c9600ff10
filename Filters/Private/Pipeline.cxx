// SPDX-License-Identifier: BSD-3-Clause
#include "Pipeline.h"

#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>
#include <limits>
#include <set>

namespace vtkChainMail
{

using Executive = vtkStreamingDemandDrivenPipeline;

namespace
{

template <typename F> void ForEachInput(vtkInformationVector** inputs, int ports, const F& f)
{
  for (int port = 0; port < ports; ++port)
  {
    for (int n = 0; n < inputs[port]->GetNumberOfInformationObjects(); ++n)
    {
      f(inputs[port]->GetInformationObject(n));
    }
  }
}

}

MergedTimes::MergedTimes(vtkInformationVector** inputs, int ports)
  : Range{ std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity() }
{
  std::set<double> steps;
  ForEachInput(inputs, ports,
    [&](vtkInformation* input)
    {
      if (input->Has(Executive::TIME_STEPS()))
      {
        const double* first = input->Get(Executive::TIME_STEPS());
        steps.insert(first, first + input->Length(Executive::TIME_STEPS()));
      }
      if (input->Has(Executive::TIME_RANGE()))
      {
        this->Range[0] = std::min(this->Range[0], input->Get(Executive::TIME_RANGE())[0]);
        this->Range[1] = std::max(this->Range[1], input->Get(Executive::TIME_RANGE())[1]);
      }
    });
  if (!steps.empty())
  {
    this->Range[0] = std::min(this->Range[0], *steps.begin());
    this->Range[1] = std::max(this->Range[1], *steps.rbegin());
  }
  this->Steps.assign(steps.begin(), steps.end());
}

void MergedTimes::Tell(vtkInformation* output) const
{
  output->Remove(Executive::TIME_STEPS());
  output->Remove(Executive::TIME_RANGE());
  if (!this->Steps.empty())
  {
    output->Set(Executive::TIME_STEPS(), this->Steps.data(), static_cast<int>(this->Steps.size()));
  }
  if (this->Range[0] <= this->Range[1])
  {
    output->Set(Executive::TIME_RANGE(), this->Range, 2);
  }
}

void DescribeImage(vtkInformation* info, vtkImageData* image)
{
  if (info->Has(Executive::WHOLE_EXTENT())) // a composite dataset has none
  {
    image->SetExtent(info->Get(Executive::WHOLE_EXTENT()));
  }
  if (info->Has(vtkDataObject::ORIGIN()))
  {
    image->SetOrigin(info->Get(vtkDataObject::ORIGIN()));
  }
  if (info->Has(vtkDataObject::SPACING()))
  {
    image->SetSpacing(info->Get(vtkDataObject::SPACING()));
  }
  if (info->Has(vtkDataObject::DIRECTION()))
  {
    image->SetDirectionMatrix(info->Get(vtkDataObject::DIRECTION()));
  }
}

void AskForAll(vtkInformationVector** inputs, int ports)
{
  ForEachInput(inputs, ports,
    [](vtkInformation* input)
    {
      if (input->Has(Executive::WHOLE_EXTENT()))
      {
        int extent[6];
        input->Get(Executive::WHOLE_EXTENT(), extent);
        input->Set(Executive::UPDATE_EXTENT(), extent, 6);
      }
      input->Set(Executive::UPDATE_PIECE_NUMBER(), 0);
      input->Set(Executive::UPDATE_NUMBER_OF_PIECES(), 1);
      input->Set(Executive::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
    });
}

void AskForPiece(vtkInformationVector* inputs, int piece, int pieces)
{
  // The executive of the source divides the whole extent, where it can.
  if (vtkInformation* input = inputs->GetInformationObject(0))
  {
    input->Set(Executive::UPDATE_PIECE_NUMBER(), piece);
    input->Set(Executive::UPDATE_NUMBER_OF_PIECES(), pieces);
  }
}

void AskAlike(vtkInformationVector* outputs, int asked)
{
  vtkInformation* from = outputs->GetInformationObject(std::max(0, asked));
  for (int port = 0; port < outputs->GetNumberOfInformationObjects(); ++port)
  {
    vtkInformation* output = outputs->GetInformationObject(port);
    if (output != from)
    {
      output->CopyEntry(from, Executive::UPDATE_PIECE_NUMBER());
      output->CopyEntry(from, Executive::UPDATE_NUMBER_OF_PIECES());
      output->CopyEntry(from, Executive::UPDATE_NUMBER_OF_GHOST_LEVELS());
    }
  }
}

}
