// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailGrip_h
#define pqChainMailGrip_h

#include <QObject>

#include "vtkNew.h"
#include "vtkWeakPointer.h"

class pqInteractivePropertyWidget;
class vtkActor;
class vtkCallbackCommand;
class vtkLineRepresentation;
class vtkRenderer;
class vtkSphereSource;

/// Draws what a probe grips, while its line is shown: a ball of its radius around its position. The ends of the line
/// have colours of their own, so that position and target are told apart.
class pqChainMailGrip : public QObject
{
  Q_OBJECT

public:
  explicit pqChainMailGrip(pqInteractivePropertyWidget* widget);
  ~pqChainMailGrip() override;

private Q_SLOTS:
  void render();

private:
  Q_DISABLE_COPY(pqChainMailGrip)

  vtkLineRepresentation* line() const;
  void show(bool shown);
  /// Puts the ball where the line begins, before each frame.
  void place();

  pqInteractivePropertyWidget* Widget;
  vtkNew<vtkSphereSource> Ball;
  vtkNew<vtkActor> Actor;
  vtkNew<vtkCallbackCommand> BeforeFrame;
  vtkWeakPointer<vtkRenderer> Renderer;
};

#endif
