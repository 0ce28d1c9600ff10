// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailSurfaceMotion
 * @brief   a surface before and after as probes for vtkChainMailDeformation
 *
 * Two surfaces of one organ, as of segmentations at two times, say how its border moved. Where both are the same mesh
 * (equal numbers of points, as a program leaves them that deforms a mesh) each point goes to its counterpart. Else
 * points are matched by closest points, both ways, with smoothing:
 *
 * 1. The first guess is the shift of the centre of volume (of area, where one of them is not closed), or the `Start`
 *    (port 2).
 * 2. Each point of the moved first surface looks for the closest point of the second; and each point of the second for
 * the closest one of the first, which pulls at the corners of the triangle that it finds. A point takes the mean of
 * both.
 * 3. The displacements are smoothed: each becomes the mean of its own and its neighbours' mean, Smoothing times and, at
 *    first, more often.
 * 4. Steps 2 and 3 are repeated, Iterations times.
 *
 * Closest points cannot see sliding: where a surface moves along itself, as lungs along the chest wall or a ball that
 * turns, no point of it seems to move. What is known of such motion has to come from elsewhere, as from landmarks. Nor
 * can they tell one side of a thin gap from the other where the surface moves by more than the gap.
 *
 * Mechanics knows better than smoothing how tissue goes along. So the first surface may be matched again as it came out
 * of a deformation: that is the `Start`, as vtkChainMailCarry makes it of `Before`. With Iterations 1 and Smoothing 0
 * each point then goes to the second surface from where its tissue is, which may have slid meanwhile.
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
   * The first surface where it is to be matched from, port 2: its points, moved. May be empty. Where points go by their
   * order it is not read.
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
   * How points find their counterparts: MATCH_SAME_POINTS (1), by their order; MATCH_CLOSEST_POINTS (2), see above; or
   * by order where both surfaces have equal numbers of points and the same polygons, else by closest points
   * (MATCH_AUTOMATIC, 0). Default: MATCH_AUTOMATIC.
   */
  vtkSetClampMacro(Match, int, MATCH_AUTOMATIC, MATCH_CLOSEST_POINTS);
  vtkGetMacro(Match, int);
  void SetMatchToAutomatic() { this->SetMatch(MATCH_AUTOMATIC); }
  void SetMatchToSamePoints() { this->SetMatch(MATCH_SAME_POINTS); }
  void SetMatchToClosestPoints() { this->SetMatch(MATCH_CLOSEST_POINTS); }
  ///@}

  ///@{
  /**
   * How often closest points are looked for, [1, 1000]. Default: 10.
   */
  vtkSetClampMacro(Iterations, int, 1, 1000);
  vtkGetMacro(Iterations, int);
  ///@}

  ///@{
  /**
   * How often the displacements are smoothed after the last of these, [0, 1000]; after the first as many times as often
   * as there are iterations. Default: 5.
   */
  vtkSetClampMacro(Smoothing, int, 0, 1000);
  vtkGetMacro(Smoothing, int);
  ///@}

  ///@{
  /**
   * How far apart probes are [mm], [0, VTK_DOUBLE_MAX]: one in each cube of that size. 0: one at each point. Default:
   * 0.
   */
  vtkSetClampMacro(Spacing, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Spacing, double);
  ///@}

  ///@{
  /**
   * Tissue within this distance of a point moves with it [mm], [0, VTK_DOUBLE_MAX]. A surface lies between tissue and
   * air, so 0, the nearest element alone, may find none; a voxel is enough. Default: 2.
   */
  vtkSetClampMacro(Radius, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Radius, double);
  ///@}

  ///@{
  /**
   * How far off the surface may be [mm], [0, VTK_DOUBLE_MAX]; 0: it is met as far as tissue goes. Default: 0.
   */
  vtkSetClampMacro(Tolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Tolerance, double);
  ///@}

  /**
   * How the last update matched, how far points go, and how far from the second surface they end, in words.
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
