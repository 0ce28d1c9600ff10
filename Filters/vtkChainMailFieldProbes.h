// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailFieldProbes
 * @brief   a field of displacements as probes for vtkChainMailDeformation
 *
 * Other programs give a displacement for each voxel of an image, or each point of a mesh [mm, world axes]. This class
 * makes probes from it, about Spacing apart: everywhere, or inside a mask (port 1). There are none where the field is
 * not finite, as in the background of the array `PullBack`.
 *
 * Probes have to be in tissue. So use a mask of that tissue, or the scan itself with MaskMinimum as its tissue
 * threshold. The grid of the mask may differ from that of the field: the nearest voxel counts.
 *
 * With Tolerance the tissue follows a noisy field in the least-squares sense, weighed against its own energy. Without
 * it probes reach their displacements as far as the limits of the tissue allow. Incompatible probes share if they are
 * more than 32 (see ConflictPolicy of vtkChainMailDeformation).
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
   * The image that says where the field counts, port 1; optional.
   */
  void SetMaskConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(1, output); }
  void SetMaskData(vtkDataObject* data) { this->SetInputData(1, data); }
  ///@}

  ///@{
  /**
   * The point array of 3 components with the displacements [mm]. Default: "", which means `Displacement`, else the
   * active vectors.
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
   * Inside the mask is where its value is at least this. Default: 1.
   */
  vtkSetMacro(MaskMinimum, double);
  vtkGetMacro(MaskMinimum, double);
  ///@}

  ///@{
  /**
   * Distance between probes [mm], [0, VTK_DOUBLE_MAX]. In an image it is rounded to a whole number of voxels along each
   * axis; of a mesh, one point is taken in each cube of this size. 0 takes all. Default: 0.
   */
  vtkSetClampMacro(Spacing, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Spacing, double);
  ///@}

  ///@{
  /**
   * Tissue within this distance of a probe moves with it [mm], [0, VTK_DOUBLE_MAX]; 0: the nearest element alone.
   * Default: 0.
   */
  vtkSetClampMacro(Radius, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Radius, double);
  ///@}

  ///@{
  /**
   * By how much the tissue may miss the field [mm], [0, VTK_DOUBLE_MAX]; 0: not at all, as far as the tissue stretches.
   * Default: 0.
   */
  vtkSetClampMacro(Tolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Tolerance, double);
  ///@}

  /**
   * A text with the number of probes that the last update made, and their largest displacement.
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
