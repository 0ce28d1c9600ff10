// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class vtkChainMailSmooth
 * @brief Takes the grain from a volume that is drawn: the scalars of an image, smoothed with a Gaussian of three
 * quarters of a voxel.
 *
 * The edge of a scan's skin is a voxel wide. Drawn, its steps and noise are lit and coloured like wood, the more so in
 * integers of 8 bits, between which renderers interpolate coarsely. The output has the array that is smoothed alone,
 * under its name and in floats: the active scalars, or the first point array where none is active. Of the forearm
 * phantom with an incision, what is finer than 8 pixels then is 0.016 of the brightness instead of 0.027 (root mean
 * square). It is for pictures, and nothing else: what is measured should come from before it.
 *
 * It is vtkImageGaussianSmooth, in floats and with the array's name. Voxels within the radius of the image's border
 * take the mean over those that there are. NaN spreads that far, too. An image without point arrays is an error.
 * Of an image in pieces it asks for ghost points; where these are not given, it does so at the borders of pieces.
 */

#ifndef vtkChainMailSmooth_h
#define vtkChainMailSmooth_h

#include "ChainMailServerManagerModule.h" // for the export macro
#include "vtkImageAlgorithm.h"

class CHAINMAILSERVERMANAGER_EXPORT vtkChainMailSmooth : public vtkImageAlgorithm
{
public:
  static vtkChainMailSmooth* New();
  vtkTypeMacro(vtkChainMailSmooth, vtkImageAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The standard deviation of the Gaussian [voxels], from 0, which smooths nothing, to 4: less and what is no number is
   * taken for 0, more for 4. By more than 1, wounds lose their colours. Default: 0.75.
   */
  void SetStandardDeviation(double voxels);
  vtkGetMacro(StandardDeviation, double);
  ///@}

protected:
  vtkChainMailSmooth();
  ~vtkChainMailSmooth() override = default;

  int RequestInformation(vtkInformation*, vtkInformationVector** inputs, vtkInformationVector* outputs) override;
  int RequestUpdateExtent(vtkInformation*, vtkInformationVector** inputs, vtkInformationVector* outputs) override;
  int RequestData(vtkInformation*, vtkInformationVector** inputs, vtkInformationVector* outputs) override;

private:
  vtkChainMailSmooth(const vtkChainMailSmooth&) = delete;
  void operator=(const vtkChainMailSmooth&) = delete;

  int GetRadius() const;

  double StandardDeviation = 0.75;
};

#endif
