// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailFieldProbes
 * @brief   a field of displacements as probes for vtkChainMailDeformation
 *
 * Other programs give a displacement for each voxel of an image, or each point of a mesh [mm, world axes]. This class
 * takes places of it, some Spacing apart, and asks the tissue there to go along: all of it, or what is inside a mask
 * (port 1). Places where the field is not finite have none, as in the array `PullBack`.
 *
 * Probes have to be in tissue. So the mask is a mask of the tissue that is meant, or the scan itself with MaskMinimum
 * as its tissue threshold. It may be of another grid than the field: the nearest voxel counts.
 *
 * With Tolerance the tissue follows a noisy field as far as its mechanics like. Without it the probes are met as far as
 * the tissue gives way, and where they do not fit together they share.
 *
 * The output is for the `Probes` of vtkChainMailDeformation: points with `Displacement`, `Radius` and `Tolerance`.
 * Fields may come in pieces; the mask is read whole.
 *
 * @sa vtkChainMailDeformation vtkChainMailSurfaceMotion
 */

#ifndef vtkChainMailFieldProbes_h
#define vtkChainMailFieldProbes_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkPolyDataAlgorithm.h"

#include <string> // for Field

class CHAINMAILFILTERS_EXPORT vtkChainMailFieldProbes : public vtkPolyDataAlgorithm
{
public:
  static vtkChainMailFieldProbes* New();
  vtkTypeMacro(vtkChainMailFieldProbes, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The image that says where the field counts, port 1; may be empty.
   */
  void SetMaskConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(1, output); }
  void SetMaskData(vtkDataObject* data) { this->SetInputData(1, data); }
  ///@}

  ///@{
  /**
   * The point array of 3 components with the displacements [mm]. Default: "", which is `Displacement`, else the active
   * vectors.
   */
  vtkSetStdStringFromCharMacro(Field);
  vtkGetCharFromStdStringMacro(Field);
  ///@}

  ///@{
  /**
   * The point array of the mask. Default: "", its active scalars.
   */
  vtkSetStdStringFromCharMacro(MaskArray);
  vtkGetCharFromStdStringMacro(MaskArray);
  ///@}

  ///@{
  /**
   * Inside is where the mask has this value or more. Default: 1.
   */
  vtkSetMacro(MaskMinimum, double);
  vtkGetMacro(MaskMinimum, double);
  ///@}

  ///@{
  /**
   * How far apart the places are [mm], [0, VTK_DOUBLE_MAX]: every so many voxels of an image, rounded; of a mesh one
   * point in each cube of that size. 0 takes all. Default: 0.
   */
  vtkSetClampMacro(Spacing, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Spacing, double);
  ///@}

  ///@{
  /**
   * Tissue within this distance of a place moves with it [mm], [0, VTK_DOUBLE_MAX]; 0 stands for the nearest element
   * alone. Default: 0.
   */
  vtkSetClampMacro(Radius, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Radius, double);
  ///@}

  ///@{
  /**
   * How far off the field may be [mm], [0, VTK_DOUBLE_MAX]; 0: it is met as far as tissue goes. Default: 0.
   */
  vtkSetClampMacro(Tolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Tolerance, double);
  ///@}

  /**
   * How many probes the last update made, and how far they go, in words.
   */
  vtkGetCharFromStdStringMacro(Report);

protected:
  vtkChainMailFieldProbes();
  ~vtkChainMailFieldProbes() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestUpdateExtent(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkChainMailFieldProbes(const vtkChainMailFieldProbes&) = delete;
  void operator=(const vtkChainMailFieldProbes&) = delete;

  std::string Field;
  std::string MaskArray;
  double MaskMinimum = 1.0;
  double Spacing = 0.0;
  double Radius = 0.0;
  double Tolerance = 0.0;
  std::string Report;
};

#endif
