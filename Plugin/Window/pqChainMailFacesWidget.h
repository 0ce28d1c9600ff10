// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailFacesWidget_h
#define pqChainMailFacesWidget_h

#include "pqPropertyWidget.h"

class vtkSMProperty;

/// A check box for each face of the image's box, by name: x- and so on, with the side of the patient where the image
/// is turned against the world's axes, as scans are that know how the patient lay.
class pqChainMailFacesWidget : public pqPropertyWidget
{
  Q_OBJECT
  typedef pqPropertyWidget Superclass;

public:
  pqChainMailFacesWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent = nullptr);

private:
  Q_DISABLE_COPY(pqChainMailFacesWidget)
};

#endif
