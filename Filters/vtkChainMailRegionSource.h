// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailRegionSource
 * @brief   a ball of other tissue for vtkChainMailDeformation
 *
 * The output is one point at Center, with a vertex so that it can be seen, and with the point arrays that
 * vtkChainMailDeformation reads from its `Regions` input: `Radius` and `Constraint` (1 double each). For several
 * regions, connect several sources to the same port; where they overlap the later one counts. Lengths are in the
 * physical units of the image (mm for medical data), in world axes. As with any VTK algorithm, one thread at a time may
 * use a source.
 */

#ifndef vtkChainMailRegionSource_h
#define vtkChainMailRegionSource_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkPolyDataAlgorithm.h"

class CHAINMAILFILTERS_EXPORT vtkChainMailRegionSource : public vtkPolyDataAlgorithm
{
public:
  static vtkChainMailRegionSource* New();
  vtkTypeMacro(vtkChainMailRegionSource, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The middle of the ball [mm]. Default: 0 0 0.
   */
  vtkSetVector3Macro(Center, double);
  vtkGetVector3Macro(Center, double);
  ///@}

  ///@{
  /**
   * Voxels within this distance of Center are in the ball [mm], [0, VTK_DOUBLE_MAX]. Default: 0.5.
   */
  vtkSetClampMacro(Radius, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Radius, double);
  ///@}

  ///@{
  /**
   * The constraint of the tissue in the ball, a fraction of the image's spacing, [0, 0.999]; 0 is rigid. Default: 0.5.
   */
  vtkSetClampMacro(Constraint, double, 0.0, 0.999);
  vtkGetMacro(Constraint, double);
  ///@}

protected:
  vtkChainMailRegionSource();
  ~vtkChainMailRegionSource() override = default;

  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkChainMailRegionSource(const vtkChainMailRegionSource&) = delete;
  void operator=(const vtkChainMailRegionSource&) = delete;

  double Center[3] = { 0.0, 0.0, 0.0 };
  double Radius = 0.5;
  double Constraint = 0.5;
};

#endif
