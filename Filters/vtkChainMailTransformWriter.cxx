// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailTransformWriter.h"

#include "Private/PullBack.h"

#include "vtkByteSwap.h"
#include "vtkDataArray.h"
#include "vtkErrorCode.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkMatrix3x3.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <vector>

vtkStandardNewMacro(vtkChainMailTransformWriter);

namespace
{

/// The header of a MetaImage. `flip`: the signs that convert world axes to LPS.
std::string HeaderOf(vtkImageData* image, const double flip[3])
{
  int extent[6];
  image->GetExtent(extent);
  double first[3];
  image->TransformIndexToPhysicalPoint(extent[0], extent[2], extent[4], first);
  std::ostringstream text;
  text.precision(std::numeric_limits<double>::max_digits10);
  text << "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n";
  text << "TransformMatrix =";
  for (int axis = 0; axis < 3; ++axis) // column by column: one image axis after the other
  {
    for (int a = 0; a < 3; ++a)
    {
      text << ' ' << flip[a] * image->GetDirectionMatrix()->GetElement(a, axis) + 0.0; // no -0
    }
  }
  text << "\nOffset =";
  for (int a = 0; a < 3; ++a)
  {
    text << ' ' << flip[a] * first[a] + 0.0;
  }
  text << "\nCenterOfRotation = 0 0 0\nAnatomicalOrientation = LPS\nElementSpacing =";
  for (int a = 0; a < 3; ++a)
  {
    text << ' ' << image->GetSpacing()[a];
  }
  text << "\nDimSize =";
  for (int a = 0; a < 3; ++a)
  {
    text << ' ' << extent[2 * a + 1] - extent[2 * a] + 1;
  }
  text << "\nElementNumberOfChannels = 3\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n";
  return text.str();
}

}

int vtkChainMailTransformWriter::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  return 1;
}

void vtkChainMailTransformWriter::WriteData()
{
  auto* image = vtkImageData::SafeDownCast(this->GetInput());
  vtkPointData* arrays = image->GetPointData();
  vtkDataArray* field =
    arrays->GetArray(this->Field.empty() ? vtkChainMail::PullBackSampler::Name : this->Field.c_str());
  if (!field && this->Field.empty())
  {
    field = arrays->GetArray("Displacement");
  }
  if (!field || field->GetNumberOfComponents() != 3)
  {
    this->SetErrorCode(vtkErrorCode::UserError);
    vtkErrorMacro("The image has no array "
                  << (this->Field.empty() ? "PullBack or Displacement" : this->Field.c_str())
                  << " of 3 components. Switch PullBack of ChainMail Deformation on and write its first output, or "
                     "write its second output, the model at rest, with Displacement.");
    return;
  }
  std::ofstream file(this->FileName, std::ios::binary);
  if (!file)
  {
    this->SetErrorCode(vtkErrorCode::CannotOpenFileError);
    vtkErrorMacro(
      "Cannot write to \"" << this->FileName << "\". Check that the folder exists and that you may write to it.");
    return;
  }

  const double turn = this->World == WORLD_RAS ? -1.0 : 1.0;
  const double flip[3] = { turn, turn, 1.0 };
  const std::string header = HeaderOf(image, flip);
  file.write(header.data(), static_cast<std::streamsize>(header.size()));
  // A displacement that leads from any voxel out of any image of the same patient.
  const auto far = static_cast<float>(1e3 * std::max(1.0, image->GetLength()));
  int size[3];
  image->GetDimensions(size);
  const vtkIdType portion = static_cast<vtkIdType>(size[0]) * size[1];
  std::vector<float> values(static_cast<std::size_t>(3 * portion));
  for (vtkIdType first = 0; file && first < field->GetNumberOfTuples(); first += portion)
  {
    for (vtkIdType n = 0; n < portion; ++n)
    {
      double way[3];
      field->GetTuple(first + n, way);
      const bool isSome = std::isfinite(way[0]) && std::isfinite(way[1]) && std::isfinite(way[2]);
      for (int a = 0; a < 3; ++a)
      {
        values[3 * n + a] = isSome ? static_cast<float>(flip[a] * way[a]) : far;
      }
    }
    vtkByteSwap::Swap4LERange(values.data(), values.size());
    file.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(4 * values.size()));
    this->UpdateProgress(static_cast<double>(first + portion) / static_cast<double>(field->GetNumberOfTuples()));
  }
  file.close();
  if (!file)
  {
    this->SetErrorCode(vtkErrorCode::OutOfDiskSpaceError);
    vtkErrorMacro(
      "Writing \"" << this->FileName << "\" failed, and the file is now empty. Check that the disk has free space.");
    std::ofstream(this->FileName, std::ios::trunc); // an empty file rather than half of the field
  }
}

void vtkChainMailTransformWriter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << this->FileName << "\n";
  os << indent << "Field: " << this->Field << "\n";
  os << indent << "World: " << (this->World == WORLD_RAS ? "RAS" : "LPS") << "\n";
}
