// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailReportWidget_h
#define pqChainMailReportWidget_h

#include "pqPropertyWidget.h"

#include <QTimer>

class QLabel;
class vtkSMProperty;

/// Shows in words what the last update did, once the hand rests.
class pqChainMailReportWidget : public pqPropertyWidget
{
  Q_OBJECT
  typedef pqPropertyWidget Superclass;

public:
  pqChainMailReportWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent = nullptr);

protected:
  /// Follows the width of the panel that is seen, as other properties may be wider than that.
  void showEvent(QShowEvent* event) override;
  bool eventFilter(QObject* panel, QEvent* event) override;

private:
  Q_DISABLE_COPY(pqChainMailReportWidget)

  void read();
  /// A report with the names that the Pipeline Browser has for the inputs, where the filter has but numbers.
  QString named(const QString& report) const;

  vtkSMProperty* Report;
  QLabel* Label;
  QTimer Rest;
};

#endif
