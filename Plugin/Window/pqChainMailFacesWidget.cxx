// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailFacesWidget.h"

#include "ViewRay.h"

#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"
#include "vtkSMSourceProxy.h"

#include <QCheckBox>
#include <QGridLayout>

#include <array>
#include <cmath>

namespace
{
/// The side of the patient that a face looks to, in the coordinates of DICOM, NRRD and ITK: x to the patient's left, y
/// to the back, z to the head. Empty where the image's axes are the world's, as then nobody has said how the patient
/// lay.
QString SideOf(const std::array<double, 9>& direction, int face)
{
  const std::array<double, 9> unrotated{ { 1, 0, 0, 0, 1, 0, 0, 0, 1 } };
  if (direction == unrotated || direction == std::array<double, 9>{})
  {
    return {};
  }
  const char* const sides[] = { "right", "left", "front", "back", "feet", "head" };
  int row = 0;
  for (int r = 1; r < 3; ++r)
  {
    row = std::fabs(direction[3 * r + face / 2]) > std::fabs(direction[3 * row + face / 2]) ? r : row;
  }
  const bool positive = (direction[3 * row + face / 2] > 0.0) == (face % 2 == 1);
  return QString(" (%1)").arg(sides[2 * row + (positive ? 1 : 0)]);
}
}

//------------------------------------------------------------------------------
pqChainMailFacesWidget::pqChainMailFacesWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent)
  : Superclass(proxy, parent)
{
  vtkSMPropertyHelper input(proxy, "Input");
  auto* source = vtkSMSourceProxy::SafeDownCast(input.GetNumberOfElements() > 0 ? input.GetAsProxy() : nullptr);
  const std::array<double, 9> direction =
    source ? vtkChainMail::DirectionOf(source, static_cast<int>(input.GetOutputPort())) : std::array<double, 9>{};

  auto* grid = new QGridLayout(this);
  grid->setContentsMargins(0, 0, 0, 0);
  const char* const names[] = { "x-", "x+", "y-", "y+", "z-", "z+" };
  for (int face = 0; face < 6; ++face)
  {
    auto* box = new QCheckBox(names[face] + SideOf(direction, face), this);
    box->setObjectName(QString("Face%1").arg(face));
    grid->addWidget(box, face / 2, face % 2);
    this->addPropertyLink(box, "checked", SIGNAL(toggled(bool)), property, face);
  }
  this->setChangeAvailableAsChangeFinished(true);
}
