// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailMagnificationWidget.h"

#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkEventQtSlotConnect.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkPVDataSetAttributesInformation.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMUncheckedPropertyHelper.h"

#include <QLabel>
#include <QSpinBox>
#include <QVBoxLayout>

#include <algorithm>
#include <array>
#include <cmath>

namespace
{
/// How many voxels a deformed image has along each axis. Where the image's axes are not the world's, a part of it may
/// have some more or less.
std::array<double, 3> SizeOf(vtkSMProxy* deformation, vtkPVDataInformation* image)
{
  const int* extent = image->GetExtent();
  const double* all = image->GetBounds();
  vtkSMUncheckedPropertyHelper bounds(deformation, "OutputBounds");
  const bool isPart = vtkSMUncheckedPropertyHelper(deformation, "UseOutputBounds").GetAsInt() != 0;
  const int padding = vtkSMUncheckedPropertyHelper(deformation, "OutputPadding").GetAsInt();
  const int finer = vtkSMUncheckedPropertyHelper(deformation, "OutputMagnification").GetAsInt();
  std::array<double, 3> size;
  for (unsigned int a = 0; a < 3; ++a)
  {
    const double steps = extent[2 * a + 1] - extent[2 * a];
    double low = steps > 0 ? -padding : 0;
    double high = steps > 0 ? steps + padding : 0;
    const double spacing = (all[2 * a + 1] - all[2 * a]) / std::max(steps, 1.0);
    if (isPart && spacing > 0.0)
    {
      low = std::max(low, std::floor((bounds.GetAsDouble(2 * a) - all[2 * a]) / spacing));
      high = std::min(high, std::ceil((bounds.GetAsDouble(2 * a + 1) - all[2 * a]) / spacing));
    }
    size[a] = std::max(0.0, finer * (high - low) + 1.0);
  }
  return size;
}

/// The bytes of a voxel in all point arrays.
double BytesOfVoxel(vtkSMProxy* deformation, vtkPVDataInformation* image)
{
  const bool pullsBack = vtkSMUncheckedPropertyHelper(deformation, "PullBack").GetAsInt() != 0;
  const bool smooths = vtkSMUncheckedPropertyHelper(deformation, "ScalarSmoothing").GetAsDouble() > 0.0;
  double bytes = (pullsBack ? 3.0 * sizeof(float) : 0.0) + (smooths ? sizeof(float) : 0.0);
  vtkPVDataSetAttributesInformation* arrays = image->GetPointDataInformation();
  for (int n = 0; n < arrays->GetNumberOfArrays(); ++n)
  {
    vtkPVArrayInformation* array = arrays->GetArrayInformation(n);
    bytes += static_cast<double>(vtkDataArray::GetDataTypeSize(array->GetDataType())) * array->GetNumberOfComponents();
  }
  return bytes;
}
}

//------------------------------------------------------------------------------
pqChainMailMagnificationWidget::pqChainMailMagnificationWidget(
  vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent)
  : Superclass(proxy, parent)
  , Size(new QLabel(this))
{
  auto* box = new QVBoxLayout(this);
  box->setContentsMargins(0, 0, 0, 0);
  auto* number = new QSpinBox(this);
  number->setObjectName("Number");
  number->setRange(1, 4);
  box->addWidget(number);
  this->Size->setObjectName("Size");
  box->addWidget(this->Size);
  this->Size->setWordWrap(true);
  this->addPropertyLink(number, "value", SIGNAL(valueChanged(int)), property);
  this->setChangeAvailableAsChangeFinished(true);
  for (const char* name : { "Input", "OutputMagnification", "OutputPadding", "UseOutputBounds", "OutputBounds",
         "PullBack", "ScalarSmoothing" })
  {
    vtkSMProperty* other = proxy->GetProperty(name);
    this->Connections->Connect(other, vtkCommand::UncheckedPropertyModifiedEvent, this, SLOT(tell()));
    this->Connections->Connect(other, vtkCommand::ModifiedEvent, this, SLOT(tell()));
  }
  this->tell();
}

//------------------------------------------------------------------------------
pqChainMailMagnificationWidget::~pqChainMailMagnificationWidget() = default;

//------------------------------------------------------------------------------
void pqChainMailMagnificationWidget::tell()
{
  vtkSMPropertyHelper input(this->proxy(), "Input");
  auto* source = vtkSMSourceProxy::SafeDownCast(input.GetNumberOfElements() > 0 ? input.GetAsProxy() : nullptr);
  vtkPVDataInformation* image = source ? source->GetDataInformation(input.GetOutputPort()) : nullptr;
  if (image == nullptr || image->GetNumberOfPoints() == 0)
  {
    this->Size->clear();
    return;
  }
  const std::array<double, 3> size = SizeOf(this->proxy(), image);
  const double megabytes = 1e-6 * size[0] * size[1] * size[2] * BytesOfVoxel(this->proxy(), image);
  this->Size->setText(
    tr("%1 x %2 x %3 voxels, %4\u00a0%5")
      .arg(size[0], 0, 'f', 0)
      .arg(size[1], 0, 'f', 0)
      .arg(size[2], 0, 'f', 0)
      .arg(megabytes < 1000.0 ? megabytes : 1e-3 * megabytes, 0, 'f', megabytes < 10.0 || megabytes >= 1000.0 ? 1 : 0)
      .arg(megabytes < 1000.0 ? "MB" : "GB"));
}
