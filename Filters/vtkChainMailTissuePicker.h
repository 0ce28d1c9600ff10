// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailTissuePicker
 * @brief   finds the first tissue that a ray through an image meets
 *
 * A probe has to be where tissue is seen: this is for the mouse, and for placing probes at first. The ray is sampled
 * every half voxel, at the nearest voxel. Voxels are tissue from TissueThreshold up, as in vtkChainMailDeformation.
 * With an opacity function, as of a volume that is shown, the ray ends where it has become half opaque (of tissue
 * alone: haze in the air stops nothing); else, and where tissue never becomes so opaque, at the first voxel of tissue
 * that the function lets see at all. Lengths are in the image's physical units, in world axes, whatever its extent,
 * origin, spacing and direction matrix.
 *
 * Of VTK's pickers vtkVolumePicker is closest; it needs a volume in a renderer, which a server without a window that
 * has only the data has not.
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
   * Voxels with a smaller scalar are air. NaN stands for what fits the scalars, see vtkChainMailScanStatistics; its
   * padding is no tissue, either. Default: NaN.
   */
  vtkSetMacro(TissueThreshold, double);
  vtkGetMacro(TissueThreshold, double);
  ///@}

  ///@{
  /**
   * From scalar to opacity, [0, 1], of OpacityUnitDistance of material. Default: null, all tissue is opaque.
   */
  void SetOpacity(vtkPiecewiseFunction* opacity);
  vtkPiecewiseFunction* GetOpacity();
  ///@}

  ///@{
  /**
   * The length [mm] that Opacity is meant for, above 0. Default: 1.
   */
  vtkSetMacro(OpacityUnitDistance, double);
  vtkGetMacro(OpacityUnitDistance, double);
  ///@}

  /**
   * Follows the ray from one place to another. Returns where it meets tissue, as a share of the way in [0, 1], or -1
   * where it does not, or where the image has no such scalars.
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
