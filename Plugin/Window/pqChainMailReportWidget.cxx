// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailReportWidget.h"

#include "pqApplicationCore.h"
#include "pqPipelineSource.h"
#include "pqServerManagerModel.h"

#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"

#include <QEvent>
#include <QLabel>
#include <QScrollArea>
#include <QVBoxLayout>

//------------------------------------------------------------------------------
pqChainMailReportWidget::pqChainMailReportWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent)
  : Superclass(proxy, parent)
  , Report(property)
  , Label(new QLabel(this))
{
  this->setShowLabel(false);
  auto* box = new QVBoxLayout(this);
  box->setContentsMargins(0, 0, 0, 0);
  box->addWidget(this->Label);
  this->Label->setObjectName("Text");
  this->Label->setWordWrap(true);
  this->Label->setTextInteractionFlags(Qt::TextSelectableByMouse);

  // What holds a probe takes a search, which must not slow down a drag.
  this->Rest.setSingleShot(true);
  this->Rest.setInterval(300);
  QObject::connect(&this->Rest, &QTimer::timeout, this, &pqChainMailReportWidget::read);
  pqServerManagerModel* model = pqApplicationCore::instance()->getServerManagerModel();
  if (auto* source = model->findItem<pqPipelineSource*>(proxy))
  {
    QObject::connect(source, SIGNAL(dataUpdated(pqPipelineSource*)), &this->Rest, SLOT(start()));
  }
  this->read();
}

//------------------------------------------------------------------------------
void pqChainMailReportWidget::showEvent(QShowEvent* event)
{
  for (QWidget* outer = this->parentWidget(); outer; outer = outer->parentWidget())
  {
    if (auto* panel = qobject_cast<QScrollArea*>(outer))
    {
      panel->viewport()->installEventFilter(this); // once, however often that is asked for
      this->Label->setMaximumWidth(panel->viewport()->width());
      break;
    }
  }
  this->Superclass::showEvent(event);
}

//------------------------------------------------------------------------------
bool pqChainMailReportWidget::eventFilter(QObject* panel, QEvent* event)
{
  if (event->type() == QEvent::Resize)
  {
    this->Label->setMaximumWidth(static_cast<QWidget*>(panel)->width());
  }
  return this->Superclass::eventFilter(panel, event);
}

//------------------------------------------------------------------------------
void pqChainMailReportWidget::read()
{
  this->proxy()->UpdatePropertyInformation(this->Report);
  const char* text = vtkSMPropertyHelper(this->Report).GetAsString();
  this->Label->setText(text && *text ? QString::fromUtf8(text) : tr("Nothing has been computed yet: press Apply."));
}
