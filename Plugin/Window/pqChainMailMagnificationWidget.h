// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailMagnificationWidget_h
#define pqChainMailMagnificationWidget_h

#include "pqPropertyWidget.h"

#include "vtkNew.h" // for the connections

class QLabel;
class vtkEventQtSlotConnect;
class vtkSMProperty;

/// A number, and how many voxels and how much memory the deformed image will have with it and with what else the panel
/// says, before anything is applied.
class pqChainMailMagnificationWidget : public pqPropertyWidget
{
  Q_OBJECT
  typedef pqPropertyWidget Superclass;

public:
  pqChainMailMagnificationWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent = nullptr);
  ~pqChainMailMagnificationWidget() override;

private:
  Q_DISABLE_COPY(pqChainMailMagnificationWidget)

  QLabel* Size;
  vtkNew<vtkEventQtSlotConnect> Connections;

private Q_SLOTS:
  void tell();
};

#endif
