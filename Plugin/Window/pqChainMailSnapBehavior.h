// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailSnapBehavior_h
#define pqChainMailSnapBehavior_h

#include <QObject>

#include "vtkNew.h"
#include "vtkWeakPointer.h"

#include <array>
#include <memory>

class pqInteractivePropertyWidget;
class vtkAbstractWidget;
class vtkCallbackCommand;
class vtkLineRepresentation;
class vtkRenderer;
class vtkSMProxy;

namespace vtkChainMail
{
class ViewRay;
}

/// Keeps the ends of a line to the tissue under the mouse while they are dragged, where ParaView moves them parallel to
/// the screen: the Position of a probe, which takes its Target along and stays on tissue, and both ends of a blade,
/// which may leave it. The keys that keep a drag to an axis or to the line still do.
class pqChainMailSnapBehavior : public QObject
{
  Q_OBJECT

public:
  using Place = std::array<double, 3>;

  explicit pqChainMailSnapBehavior(pqInteractivePropertyWidget* widget);
  ~pqChainMailSnapBehavior() override;

  /// Whether a line is that of a probe, whose first end takes the second one along.
  static bool isPull(vtkSMProxy* source);

  /// What is seen at a pixel: from the front to the back.
  static std::array<Place, 2> ray(vtkRenderer* renderer, double x, double y);

  /// The tissue that is seen at a pixel. False where there is none.
  static bool pick(const vtkChainMail::ViewRay& sight, vtkRenderer* renderer, double x, double y, Place& hit);

private:
  Q_DISABLE_COPY(pqChainMailSnapBehavior)

  vtkLineRepresentation* line() const;
  vtkRenderer* renderer() const;
  const int* mouse() const;
  Place end(int n) const;
  void setEnd(int n, const Place& place);
  std::array<double, 2> onScreen(const Place& place) const;

  void start();
  void move();

  pqInteractivePropertyWidget* Widget;
  vtkWeakPointer<vtkAbstractWidget> Mouse;
  vtkNew<vtkCallbackCommand> Observer;

  // Of the drag that is under way.
  std::unique_ptr<vtkChainMail::ViewRay> ViewRay;
  bool IsDragged[2];
  std::array<double, 2> FromMouse[2]; // of the ends, in pixels
  Place Last;                         // of the first end, on tissue
  Place Pull;                         // from the first end to the second
};

#endif
