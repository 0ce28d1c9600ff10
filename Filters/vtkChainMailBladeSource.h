// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailBladeSource
 * @brief   one blade for vtkChainMailDeformation
 *
 * The output is a rectangle, or a parallelogram where Direction is not at right angles to the edge. It is an incision
 * from Start to End on the skin, Depth deep along Direction. On the other side it stands out by Height, so it also cuts
 * skin that bulges between the two ends. Connect it to the `Cuts` of a vtkChainMailDeformation. Lengths are in the
 * physical units of the image (mm for medical data), in world axes. As with any VTK algorithm, one thread at a time may
 * use a source.
 */

#ifndef vtkChainMailBladeSource_h
#define vtkChainMailBladeSource_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkPolyDataAlgorithm.h"

class CHAINMAILFILTERS_EXPORT vtkChainMailBladeSource : public vtkPolyDataAlgorithm
{
public:
  static vtkChainMailBladeSource* New();
  vtkTypeMacro(vtkChainMailBladeSource, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The ends of the incision [mm]. Default: -0.5 0 0 and 0.5 0 0.
   */
  vtkSetVector3Macro(Start, double);
  vtkGetVector3Macro(Start, double);
  vtkSetVector3Macro(End, double);
  vtkGetVector3Macro(End, double);
  ///@}

  ///@{
  /**
   * The direction in which the blade enters the tissue, a vector of any length except 0. Default: 0 0 -1.
   */
  vtkSetVector3Macro(Direction, double);
  vtkGetVector3Macro(Direction, double);
  ///@}

  ///@{
  /**
   * Depth of the blade below the line between the ends [mm], [0, VTK_DOUBLE_MAX]. Default: 0.5.
   */
  vtkSetClampMacro(Depth, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Depth, double);
  ///@}

  ///@{
  /**
   * Height of the blade above the line between the ends [mm], [0, VTK_DOUBLE_MAX]. Default: 0.5.
   */
  vtkSetClampMacro(Height, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Height, double);
  ///@}

protected:
  vtkChainMailBladeSource();
  ~vtkChainMailBladeSource() override = default;

  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkChainMailBladeSource(const vtkChainMailBladeSource&) = delete;
  void operator=(const vtkChainMailBladeSource&) = delete;

  double Start[3] = { -0.5, 0.0, 0.0 };
  double End[3] = { 0.5, 0.0, 0.0 };
  double Direction[3] = { 0.0, 0.0, -1.0 };
  double Depth = 0.5;
  double Height = 0.5;
};

#endif
