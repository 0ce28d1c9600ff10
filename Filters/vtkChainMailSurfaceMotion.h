// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailSurfaceMotion
 * @brief   a surface before and after as probes for vtkChainMailDeformation
 *
 * Two surfaces of one organ, for example from segmentations at two times, show how its border moved. Where both are the
 * same mesh (equal numbers of points and equal polygons, as from a program that deforms a mesh) each point moves to its
 * counterpart. Otherwise points are matched by closest points in both directions, with smoothing:
 *
 * 1. The initial displacement is that of the centre of volume (of area, where one surface is not closed), or the
 *    `Start` (port 2).
 * 2. For each point of the moved first surface the closest point of the second is found. For each point of the second
 *    surface the closest point of the first is found, which attracts the corners of its triangle by their weights
 *    there. The target of a point is the mean of both.
 * 3. The displacements are smoothed: each becomes the mean of itself and the mean of its neighbours. This is done
 *    Smoothing times, and more often in the first iterations.
 * 4. Steps 2 and 3 are repeated, Iterations times.
 *
 * Closest points do not detect sliding: where a surface moves along itself, as lungs along the chest wall or a rotating
 * ball, no point seems to move. Such motion has to come from other data, such as landmarks. Closest points may also
 * take the wrong side of a thin gap where the surface moves by more than the gap.
 *
 * Mechanics predicts the motion of tissue better than smoothing does. So the first surface may be matched again after a
 * deformation: vtkChainMailCarry deforms the first input (Before), and the result is the `Start`. With Iterations 1 and
 * Smoothing 0 each point then moves to the second surface from the present place of its tissue, which may have slid.
 *
 * The output is for the `Probes` of vtkChainMailDeformation: points of the first surface with `Displacement`, `Radius`
 * and `Tolerance`; one for each voxel is plenty (Spacing). Matched surfaces are noisy, so give them a Tolerance. The
 * surfaces have to be whole in one process.
 *
 * @sa vtkChainMailCarry vtkChainMailLandmarks vtkChainMailFieldProbes
 */

#ifndef vtkChainMailSurfaceMotion_h
#define vtkChainMailSurfaceMotion_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkPolyDataAlgorithm.h"

#include <string> // for Report

class CHAINMAILFILTERS_EXPORT vtkChainMailSurfaceMotion : public vtkPolyDataAlgorithm
{
public:
  static vtkChainMailSurfaceMotion* New();
  vtkTypeMacro(vtkChainMailSurfaceMotion, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The surface after the motion: port 1.
   */
  void SetAfterConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(1, output); }
  void SetAfterData(vtkDataObject* data) { this->SetInputData(1, data); }
  ///@}

  ///@{
  /**
   * The first surface with its points moved to where matching starts, port 2; optional. Not used where points are
   * matched by their order.
   */
  void SetStartConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(2, output); }
  void SetStartData(vtkDataObject* data) { this->SetInputData(2, data); }
  ///@}

  enum Matches
  {
    MATCH_AUTOMATIC = 0,
    MATCH_SAME_POINTS = 1,
    MATCH_CLOSEST_POINTS = 2
  };

  ///@{
  /**
   * How points are matched. MATCH_AUTOMATIC (0): by order where both surfaces have equal numbers of points and the same
   * polygons, else by closest points. MATCH_SAME_POINTS (1): by order. MATCH_CLOSEST_POINTS (2): by closest points, see
   * above. Default: MATCH_AUTOMATIC.
   */
  vtkSetClampMacro(Match, int, MATCH_AUTOMATIC, MATCH_CLOSEST_POINTS);
  vtkGetMacro(Match, int);
  void SetMatchToAutomatic() { this->SetMatch(MATCH_AUTOMATIC); }
  void SetMatchToSamePoints() { this->SetMatch(MATCH_SAME_POINTS); }
  void SetMatchToClosestPoints() { this->SetMatch(MATCH_CLOSEST_POINTS); }
  ///@}

  ///@{
  /**
   * Number of iterations of the search for closest points, [1, 1000]. Default: 10.
   */
  vtkSetClampMacro(Iterations, int, 1, 1000);
  vtkGetMacro(Iterations, int);
  ///@}

  ///@{
  /**
   * Number of smoothing passes after the last iteration, [0, 1000]. Iteration n of N, counted from 1, has N - n + 1
   * times as many. Default: 5.
   */
  vtkSetClampMacro(Smoothing, int, 0, 1000);
  vtkGetMacro(Smoothing, int);
  ///@}

  ///@{
  /**
   * Distance between probes [mm], [0, VTK_DOUBLE_MAX]: one probe in each cube of this size. 0: one at each point.
   * Default: 0.
   */
  vtkSetClampMacro(Spacing, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Spacing, double);
  ///@}

  ///@{
  /**
   * Tissue within this distance of a point moves with it [mm], [0, VTK_DOUBLE_MAX]. With 0, the nearest element alone,
   * a probe may find no tissue because a surface lies between tissue and air; one voxel is enough. Default: 2.
   */
  vtkSetClampMacro(Radius, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Radius, double);
  ///@}

  ///@{
  /**
   * By how much the tissue may miss the surface [mm], [0, VTK_DOUBLE_MAX]; 0: not at all, as far as the tissue
   * stretches. Default: 0.
   */
  vtkSetClampMacro(Tolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Tolerance, double);
  ///@}

  /**
   * A text about how the last update matched points, how far they move, and their final distance from the second
   * surface.
   */
  vtkGetCharFromStdStringMacro(Report);

protected:
  vtkChainMailSurfaceMotion();
  ~vtkChainMailSurfaceMotion() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkChainMailSurfaceMotion(const vtkChainMailSurfaceMotion&) = delete;
  void operator=(const vtkChainMailSurfaceMotion&) = delete;

  int Match = MATCH_AUTOMATIC;
  int Iterations = 10;
  int Smoothing = 5;
  double Spacing = 0.0;
  double Radius = 2.0;
  double Tolerance = 0.0;
  std::string Report;
};

#endif
