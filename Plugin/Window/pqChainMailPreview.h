// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailPreview_h
#define pqChainMailPreview_h

#include "vtkNew.h"
#include "vtkSmartPointer.h"
#include "vtkWeakPointer.h"

#include <array>

class vtkChainMailDeformation;
class vtkExtractVOI;
class vtkImageData;
class vtkSMProxy;

/// What a deformation would show if the scan had fewer voxels, for a probe, blade or drill while it is dragged: as many
/// voxels as it takes for a frame to be in time. It stands beside the pipeline, which learns of the drag when that has
/// ended, so that nothing that is made from fewer voxels ever comes to a file or to another filter.
class pqChainMailPreview
{
public:
  /// Whether it can stand for a deformation: where this process computes it, from rest, where fewer voxels make no
  /// other bodies, and where no filter waits for the result.
  static bool canShow(vtkSMProxy* deformation);

  pqChainMailPreview(vtkSMProxy* deformation, vtkSMProxy* dragged);
  ~pqChainMailPreview();

  /// Takes over what is set and connected, where that has changed since. To be called when a drag begins.
  void begin();
  /// Lets go of the scan, which may be gone before the next drag. To be called when a drag has ended.
  void end();

  /// Computes with the places that the mouse has dragged to, at a time of the pipeline. The image stays as it is until
  /// the next update.
  vtkImageData* update(double time);

  /// How long an update may take. When it takes longer, the next ones have fewer voxels; with the next drag perhaps
  /// more.
  double allowedMilliseconds = 50.0;

  /// Null when that is deleted.
  vtkSMProxy* deformation() const { return this->Deformation; }
  double milliseconds() const { return this->Milliseconds; }
  /// Every n-th voxel counts, along each axis.
  int step() const { return this->Step; }

private:
  pqChainMailPreview(const pqChainMailPreview&) = delete;
  void operator=(const pqChainMailPreview&) = delete;

  void connect();
  std::array<int, 6> extentOfScan();
  void thin();
  void adapt();

  vtkWeakPointer<vtkSMProxy> Deformation;
  vtkWeakPointer<vtkSMProxy> Dragged;
  vtkSmartPointer<vtkSMProxy> Clone;        // of the deformation, with its settings
  vtkSmartPointer<vtkSMProxy> DraggedClone; // of the source, with the places of the mouse
  vtkChainMailDeformation* Filter;          // the twin's
  vtkNew<vtkExtractVOI> Thinned;
  int Step = 0;
  double Milliseconds = 0.0;
  double LastMilliseconds = 0.0;
};

#endif
