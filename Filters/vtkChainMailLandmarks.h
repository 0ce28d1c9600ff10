// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailLandmarks
 * @brief   pairs of landmarks as probes for vtkChainMailDeformation
 *
 * A pair is a landmark in the scan at rest and the target of this landmark. Pairs come from two inputs with equal
 * numbers of points, `From` (port 0) and `To` (port 1), matched by their order or by the point array `Label`
 * (MatchLabels). Or one input has both, with the targets in the array TargetArray. Inputs are point sets or tables. The
 * first three numbers in a row of a table are a place, and the next three, where there is no `To`, its target.
 *
 * The output is for the `Probes` of vtkChainMailDeformation: a point for each pair, with `Displacement`, `Radius`,
 * `Tolerance` and `Label`.
 *
 * Lists of landmarks often do not match: they differ in order, or one has its axes to the patient's right (RAS) and the
 * other to the left (LPS). Where this seems to be so there is a warning, but nothing is changed.
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
   * The targets of the landmarks: port 1.
   */
  void SetToConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(1, output); }
  void SetToData(vtkDataObject* data) { this->SetInputData(1, data); }
  ///@}

  ///@{
  /**
   * The image in which voxel indices are positions, for landmarks with the field array `Voxels` (see
   * vtkChainMailLandmarkReader), port 2. Its first voxel is 0, 0, 0. Other landmarks do not need it.
   */
  void SetImageConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(2, output); }
  void SetImageData(vtkDataObject* data) { this->SetInputData(2, data); }
  ///@}

  ///@{
  /**
   * Without an input `To`, the point array of 3 components with the target of each landmark. Default: "", which means
   * `Target`.
   */
  vtkSetStdStringFromCharMacro(TargetArray);
  vtkGetCharFromStdStringMacro(TargetArray);
  ///@}

  ///@{
  /**
   * Match the landmarks of both inputs by their array `Label`, instead of by their order. Landmarks in only one of the
   * two are left out, with a warning. Default: off.
   */
  vtkSetMacro(MatchLabels, bool);
  vtkGetMacro(MatchLabels, bool);
  vtkBooleanMacro(MatchLabels, bool);
  ///@}

  ///@{
  /**
   * Tissue within this distance of a landmark moves with it [mm], [0, VTK_DOUBLE_MAX]; 0: the nearest element alone.
   * Default: 0.
   */
  vtkSetClampMacro(Radius, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Radius, double);
  ///@}

  ///@{
  /**
   * By how much the tissue may miss the landmarks [mm], [0, VTK_DOUBLE_MAX]. Above 0 the tissue is attracted as by
   * springs, which are softer for a larger tolerance. 0: it goes exactly there, as far as it stretches. Default: 0.
   */
  vtkSetClampMacro(Tolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Tolerance, double);
  ///@}

  /**
   * A text with the number of pairs that the last update made, and their displacements.
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
