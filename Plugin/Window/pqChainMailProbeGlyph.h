// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailProbeGlyph_h
#define pqChainMailProbeGlyph_h

#include <QObject>

#include "vtkNew.h"
#include "vtkWeakPointer.h"

#include <array>

class pqInteractivePropertyWidget;
class vtkActor;
class vtkBillboardTextActor3D;
class vtkCallbackCommand;
class vtkDataArray;
class vtkLineRepresentation;
class vtkProp;
class vtkRenderer;
class vtkSphereSource;

/// Draws what a probe grips, while its line is shown: a ball of its radius around its position; and where its tissue
/// could not follow to the target, how far it came: a white mark with both lengths. The ends of the line have colours
/// of their own, so that position and target are told apart.
class pqChainMailProbeGlyph : public QObject
{
  Q_OBJECT

public:
  explicit pqChainMailProbeGlyph(pqInteractivePropertyWidget* widget);
  ~pqChainMailProbeGlyph() override;

  /// What the probes of the deformation reached, a tuple for each, as far as a drag has come.
  void setReached(vtkDataArray* reached);

private Q_SLOTS:
  void render();

private:
  Q_DISABLE_COPY(pqChainMailProbeGlyph)

  vtkLineRepresentation* line() const;
  std::array<vtkProp*, 3> props() const;
  void show(bool shown);
  /// Asks the deformation what the probe reached.
  void readReached();
  /// Puts all of it where the line is, before each frame.
  void place();
  void placeMark(const double position[3], const double target[3]);

  pqInteractivePropertyWidget* Widget;
  vtkNew<vtkSphereSource> Ball;
  vtkNew<vtkActor> Actor;
  vtkNew<vtkSphereSource> Mark;
  vtkNew<vtkActor> MarkActor;
  vtkNew<vtkBillboardTextActor3D> Label;
  vtkNew<vtkCallbackCommand> BeforeFrame;
  vtkWeakPointer<vtkRenderer> Renderer;
  bool HasReached = false; ///< whether it is known how far the tissue came
  std::array<double, 3> Reached{};
};

#endif
