// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailTissuePicker
 * @brief   finds the first tissue that a ray through an image meets
 *
 * Probes have to be on visible tissue. This class finds it for the mouse, and for the initial place of a probe. The ray
 * is sampled every half voxel, at the nearest voxel. Voxels are tissue from TissueThreshold up, as in
 * vtkChainMailDeformation. Without an opacity function the ray ends at the first voxel of tissue. With one, for example
 * that of the volume shown, it ends where the accumulated opacity reaches one half. Only tissue counts for this, so
 * haze in the air does not stop the ray. If the opacity stays below one half, the ray ends at the first voxel of tissue
 * with an opacity above 0. Lengths are in the image's physical units, in world axes, whatever its extent, origin,
 * spacing and direction matrix.
 *
 * The most similar VTK class is vtkVolumePicker. It needs a volume in a renderer, which a data server does not have.
 *
 * @sa vtkChainMailDeformation, vtkChainMailProbeSource
 */

#ifndef vtkChainMailTissuePicker_h
#define vtkChainMailTissuePicker_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkObject.h"
#include "vtkSmartPointer.h" // for Opacity

#include <string> // for Scalars

class vtkImageData;
class vtkPiecewiseFunction;

class CHAINMAILFILTERS_EXPORT vtkChainMailTissuePicker : public vtkObject
{
public:
  static vtkChainMailTissuePicker* New();
  vtkTypeMacro(vtkChainMailTissuePicker, vtkObject);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Name of the point array that tells tissue from air. Default: "", the active scalars.
   */
  vtkSetStdStringFromCharMacro(Scalars);
  vtkGetCharFromStdStringMacro(Scalars);
  ///@}

  ///@{
  /**
   * Voxels with a smaller scalar are air. NaN: a threshold that fits the scalars, see vtkChainMailScanStatistics, whose
   * high padding is never tissue. Default: NaN.
   */
  vtkSetMacro(TissueThreshold, double);
  vtkGetMacro(TissueThreshold, double);
  ///@}

  ///@{
  /**
   * The function from scalar to opacity, [0, 1], of a layer of thickness OpacityUnitDistance. Default: null, all tissue
   * is opaque.
   */
  void SetOpacity(vtkPiecewiseFunction* opacity);
  vtkPiecewiseFunction* GetOpacity();
  ///@}

  ///@{
  /**
   * The thickness [mm] to which Opacity refers, above 0. Default: 1.
   */
  vtkSetMacro(OpacityUnitDistance, double);
  vtkGetMacro(OpacityUnitDistance, double);
  ///@}

  /**
   * Follows the ray between two points. Returns where it meets tissue, as a fraction of the distance in [0, 1]; -1
   * where it meets none, or where the image has no such scalars.
   */
  double Pick(vtkImageData* image, const double from[3], const double to[3]);

protected:
  vtkChainMailTissuePicker();
  ~vtkChainMailTissuePicker() override;

private:
  vtkChainMailTissuePicker(const vtkChainMailTissuePicker&) = delete;
  void operator=(const vtkChainMailTissuePicker&) = delete;

  std::string Scalars;
  double TissueThreshold;
  vtkSmartPointer<vtkPiecewiseFunction> Opacity;
  double OpacityUnitDistance = 1.0;
};

#endif
