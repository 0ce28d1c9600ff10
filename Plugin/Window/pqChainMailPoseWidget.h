// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailPoseWidget_h
#define pqChainMailPoseWidget_h

#include "pqInteractivePropertyWidget.h"

#include "Bones.h"

#include <vector>

/// The panel of a pose, and ParaView's box in the view, which turns and moves a bone. The box is around the bone at
/// rest, less the centre of the pose: so the position of the box is the target, and its orientation the rotation, to
/// the digit, whatever the centre is. It has no handles for its size.
class pqChainMailPoseWidget : public pqInteractivePropertyWidget
{
  Q_OBJECT
  typedef pqInteractivePropertyWidget Superclass;

public:
  pqChainMailPoseWidget(vtkSMProxy* proxy, vtkSMPropertyGroup* group, QWidget* parent = nullptr);

  /// Holds another bone, at rest: the one that a ray meets. Returns whether there is one.
  bool hold(const std::vector<double>& ray);

protected Q_SLOTS:
  /// Puts the box around the bone, as the panel has it.
  void placeWidget() override;

private:
  Q_DISABLE_COPY(pqChainMailPoseWidget)

  void hideHandles();
  vtkChainMail::Place centre() const;
  /// Where the bone is at rest; a small cube around the centre where there is none.
  std::array<double, 6> boundsOfBone();

  // Of the bone that was found last, so that the server is asked once for each.
  vtkSMProxy* Deformation = nullptr;
  vtkIdType Body = -1;
  vtkChainMail::Place Asked{};
  bool IsFound = false;
  vtkChainMail::Bone Bone;
};

#endif
