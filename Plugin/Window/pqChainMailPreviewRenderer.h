// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailPreviewRenderer_h
#define pqChainMailPreviewRenderer_h

#include "vtkSmartPointer.h"
#include "vtkWeakPointer.h"

#include "vtkChainMailQuickMapper.h"

class vtkImageData;
class vtkImageVolumeRepresentation;
class vtkSMProxy;
class vtkSMViewProxy;
class vtkVolumeMapper;

/// Draws a volume that a view shows quickly: while it is on, ParaView's volume has another mapper, and everything else
/// is as it was set. For volumes that this process draws itself; where a server does, or where something is chosen that
/// the mapper does not know, ParaView goes on drawing.
class pqChainMailPreviewRenderer
{
public:
  pqChainMailPreviewRenderer() = default;
  ~pqChainMailPreviewRenderer() { this->close(); }

  /// Turns it on for what a view shows of the first output of a source. False where that is no volume of the kind.
  bool open(vtkSMProxy* source, vtkSMViewProxy* view);
  void close();
  bool isOpen() const { return this->Representation != nullptr; }

  /// Draws the view: an image instead of the volume, or with null the volume itself. Fine: with a ray for every pixel.
  void draw(vtkImageData* image, bool fine);
  /// Draws what was drawn last.
  void redraw(bool fine);

  /// Null where it is not on.
  vtkChainMailQuickMapper* mapper() const { return this->Mapper; }

private:
  pqChainMailPreviewRenderer(const pqChainMailPreviewRenderer&) = delete;
  void operator=(const pqChainMailPreviewRenderer&) = delete;

  void setSmoothing(bool smooth);

  vtkWeakPointer<vtkSMViewProxy> View;
  vtkSmartPointer<vtkImageVolumeRepresentation> Representation;
  vtkSmartPointer<vtkVolumeMapper> Kept; // ParaView's
  vtkSmartPointer<vtkChainMailQuickMapper> Mapper;
  int Step = 4; // of the last mapper
};

#endif
