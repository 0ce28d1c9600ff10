// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailPickDecorator_h
#define pqChainMailPickDecorator_h

#include "pqPropertyWidgetDecorator.h"

#include <QPointer>

class pqView;

/// Lets the mouse place ParaView's line and sphere widgets on tissue that is shown as a volume, where ParaView's own
/// picking knows surfaces alone: the same keys (1, 2 and P), and a miss changes nothing. A pose holds the bone under
/// it. Also shows the widget whenever its source is selected; ParaView would hide it together with the source's data.
class pqChainMailPickDecorator : public pqPropertyWidgetDecorator
{
  Q_OBJECT
  typedef pqPropertyWidgetDecorator Superclass;

public:
  pqChainMailPickDecorator(vtkPVXMLElement* xml, pqPropertyWidget* parent);

protected:
  bool eventFilter(QObject* widget, QEvent* event) override;

private:
  Q_DISABLE_COPY(pqChainMailPickDecorator)

  /// Binds a key to one of the widget's slots that take a place.
  void addKey(const QString& key, const char* slot);
  void pick(const char* slot);
  /// What was picked does, like a drag that has ended.
  void countAtOnce();

  QPointer<pqView> View;
  bool NextIsFirst = true; // of the line's ends, for the key P
};

#endif
