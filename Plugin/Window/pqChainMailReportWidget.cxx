// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailReportWidget.h"

#include "Probes.h"

#include "pqApplicationCore.h"
#include "pqPipelineSource.h"
#include "pqServerManagerModel.h"

#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"

#include <QEvent>
#include <QLabel>
#include <QRegularExpression>
#include <QScrollArea>
#include <QVBoxLayout>

namespace
{
/// The name of the n-th source of an input and, where it has several probes, the number of the point. Empty where it is
/// not known.
QString nameOf(vtkSMProxy* deformation, const QString& property, unsigned int n, long long point)
{
  vtkSMPropertyHelper input(deformation, property.toUtf8().constData());
  pqServerManagerModel* model = pqApplicationCore::instance()->getServerManagerModel();
  auto* source = n < input.GetNumberOfElements() ? model->findItem<pqPipelineSource*>(input.GetAsProxy(n)) : nullptr;
  if (source == nullptr)
  {
    return {};
  }
  const bool hasSeveral = property == "Probes" && vtkChainMail::PointsOf(input, n) > 1;
  return source->getSMName() + (hasSeveral ? QString(", point %1").arg(point) : QString());
}

/// The name of a probe by its number among all.
QString nameOfProbe(vtkSMProxy* deformation, long long probe)
{
  vtkSMPropertyHelper probes(deformation, "Probes");
  for (unsigned int n = 0; n < probes.GetNumberOfElements(); ++n)
  {
    const long long points = vtkChainMail::PointsOf(probes, n);
    if (points < 0)
    {
      return {};
    }
    if (probe < points)
    {
      return nameOf(deformation, "Probes", n, probe);
    }
    probe -= points;
  }
  return {};
}
}

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
  QObject::connect(model, &pqServerManagerModel::nameChanged, &this->Rest, QOverload<>::of(&QTimer::start));
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
  this->Label->setText(
    text && *text ? this->named(QString::fromUtf8(text)) : tr("Nothing has been computed yet. Press Apply."));
}

//------------------------------------------------------------------------------
QString pqChainMailReportWidget::named(const QString& report) const
{
  // What the filter writes: "Probe 3", counted over all points of all inputs, or "Cuts input 0, point 2", from 0 on.
  static const QRegularExpression pattern(
    "\\bProbe (\\d+)\\b|\\b(\\w+) input (\\d+)(?:, point (\\d+))?");
  QString text;
  int end = 0;
  for (auto all = pattern.globalMatch(report); all.hasNext();)
  {
    const QRegularExpressionMatch match = all.next();
    const QString name = match.captured(1).isEmpty() ? nameOf(this->proxy(), match.captured(2),
                                                         match.captured(3).toUInt(), match.captured(4).toLongLong())
                                                     : nameOfProbe(this->proxy(), match.captured(1).toLongLong() - 1);
    text += report.mid(end, match.capturedStart() - end) + (name.isEmpty() ? match.captured() : name);
    end = match.capturedEnd();
  }
  return text + report.mid(end);
}
