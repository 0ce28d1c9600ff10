// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailLandmarks
 * @brief   pairs of landmarks as probes for vtkChainMailDeformation
 *
 * A pair is a landmark in the scan at rest and the same landmark where it is to go. Two inputs of as many points have
 * them: `From` (port 0) and `To` (port 1), the first with the first, and so on, or by the point array `Label`
 * (MatchLabels). Or one input has both, in the array TargetArray. Inputs are point sets or tables; of a table the first
 * three numbers of a row are a place, and the next three, where there is no `To`, its target.
 *
 * The output is for the `Probes` of vtkChainMailDeformation: a point for each pair, with `Displacement`, `Radius`,
 * `Tolerance` and `Label`.
 *
 * Lists of landmarks are mixed up more often than not: one is in another order than the other, or counts to the
 * patient's right (RAS) where the other counts to the left (LPS). Where that looks so, a warning says it; it changes
 * nothing.
 *
 * @sa vtkChainMailLandmarkReader vtkChainMailDeformation
 */

#ifndef vtkChainMailLandmarks_h
#define vtkChainMailLandmarks_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkPolyDataAlgorithm.h"

#include <string> // for TargetArray

class CHAINMAILFILTERS_EXPORT vtkChainMailLandmarks : public vtkPolyDataAlgorithm
{
public:
  static vtkChainMailLandmarks* New();
  vtkTypeMacro(vtkChainMailLandmarks, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Where the landmarks go: port 1.
   */
  void SetToConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(1, output); }
  void SetToData(vtkDataObject* data) { this->SetInputData(1, data); }
  ///@}

  ///@{
  /**
   * The image whose voxels landmarks of vtkChainMailLandmarkReader count, where their field array `Voxels` says so:
   * port
   * 2. Its first voxel is 0, 0, 0. Others do not need it.
   */
  void SetImageConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(2, output); }
  void SetImageData(vtkDataObject* data) { this->SetInputData(2, data); }
  ///@}

  ///@{
  /**
   * Without an input `To`, the point array of 3 components that has where each landmark goes. Default: "", which is
   * `Target`.
   */
  vtkSetStdStringFromCharMacro(TargetArray);
  vtkGetCharFromStdStringMacro(TargetArray);
  ///@}

  ///@{
  /**
   * Match the landmarks of both inputs by their array `Label`, instead of by their order. What only one of the two has
   * is left out, with a warning. Default: off.
   */
  vtkSetMacro(MatchLabels, bool);
  vtkGetMacro(MatchLabels, bool);
  vtkBooleanMacro(MatchLabels, bool);
  ///@}

  ///@{
  /**
   * Tissue within this distance of a landmark moves with it [mm], [0, VTK_DOUBLE_MAX]; 0 stands for the nearest element
   * alone. Default: 0.
   */
  vtkSetClampMacro(Radius, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Radius, double);
  ///@}

  ///@{
  /**
   * How far off the landmarks may be [mm], [0, VTK_DOUBLE_MAX]: tissue is drawn to them as if by springs, the softer
   * the more. 0: they are met, as far as tissue goes. Default: 0.
   */
  vtkSetClampMacro(Tolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Tolerance, double);
  ///@}

  /**
   * How many pairs the last update made, and how far they go, in words.
   */
  vtkGetCharFromStdStringMacro(Report);

protected:
  vtkChainMailLandmarks();
  ~vtkChainMailLandmarks() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkChainMailLandmarks(const vtkChainMailLandmarks&) = delete;
  void operator=(const vtkChainMailLandmarks&) = delete;

  std::string TargetArray;
  bool MatchLabels = false;
  double Radius = 0.0;
  double Tolerance = 0.0;
  std::string Report;
};

#endif
