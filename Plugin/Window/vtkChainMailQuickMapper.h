// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class vtkChainMailQuickMapper
 * @brief Draws a volume that changes with every frame, with no more rays than there is time for.
 *
 * ParaView's own mapper for images makes another renderer for every new image, with all that this has on the graphics
 * device, and thereby forgets how long drawing takes. This one keeps it all, measures, and casts a ray for every n-th
 * pixel along each axis, so that drawing takes no longer than it is given.
 */

#ifndef vtkChainMailQuickMapper_h
#define vtkChainMailQuickMapper_h

#include "vtkSmartPointer.h"
#include "vtkSmartVolumeMapper.h"

class vtkImageData;

class vtkChainMailQuickMapper : public vtkSmartVolumeMapper
{
public:
  static vtkChainMailQuickMapper* New();
  vtkTypeMacro(vtkChainMailQuickMapper, vtkSmartVolumeMapper);

  /// What is drawn instead of the input, whatever that is; null: the input.
  void SetImage(vtkImageData* image);

  /// How long drawing may take. Default: 40.
  vtkSetMacro(AllowedMilliseconds, double);

  /// Whether every pixel gets its ray, however long that takes. Default: off.
  vtkSetMacro(Fine, bool);

  /// How long drawing took the last time.
  vtkGetMacro(Milliseconds, double);

  /// How long it would have taken with a ray for every pixel.
  vtkGetMacro(FineMilliseconds, double);

  ///@{
  /// A ray is cast for every n-th pixel along each axis: 1, 2, 3, 4 or 6, to begin with. Default: 4.
  vtkSetMacro(Step, int);
  vtkGetMacro(Step, int);
  ///@}

  void Render(vtkRenderer* renderer, vtkVolume* volume) override;

protected:
  vtkChainMailQuickMapper();
  ~vtkChainMailQuickMapper() override = default;

private:
  vtkChainMailQuickMapper(const vtkChainMailQuickMapper&) = delete;
  void operator=(const vtkChainMailQuickMapper&) = delete;

  void Adapt();

  vtkSmartPointer<vtkImageData> Image;
  double AllowedMilliseconds = 40.0;
  double Milliseconds = 0.0;
  double FineMilliseconds = 0.0;
  double LastMilliseconds = 0.0; // of the frame before, where that was drawn with the same step
  int Step = 4;
  bool Fine = false;
};

#endif
