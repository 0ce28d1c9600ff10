// SPDX-License-Identifier: BSD-3-Clause
// Matches two surfaces by closest points both ways, with smoothing: see vtkChainMailSurfaceMotion.

#ifndef ClosestPoints_h
#define ClosestPoints_h

#include "vtkPolyData.h"
#include "vtkSmartPointer.h"

#include <array>
#include <functional>
#include <vector>

namespace vtkChainMail
{

class ClosestPoints
{
public:
  /// Surfaces of triangles, each point once. With `start`, an array of displacements of the first one's points,
  /// matching begins there, else with the shift of the centre.
  ClosestPoints(vtkPolyData* before, vtkPolyData* after, vtkDataArray* start);

  /// Finds the displacements. `progress` gets the share that is done and says whether to go on.
  void Match(int iterations, int smoothing, const std::function<bool(double)>& progress);

  const std::vector<std::array<double, 3>>& GetDisplacements() const { return this->Displacements; }

  /// How far the moved points are from the second surface, on average [mm].
  double GetDistance();

private:
  void Look();
  void Smooth();
  /// Moves the points of Moved to where the displacements say.
  void Move();

  vtkSmartPointer<vtkPolyData> Before;
  vtkSmartPointer<vtkPolyData> After;
  vtkSmartPointer<vtkPolyData> Moved; ///< Before, at present
  std::vector<std::array<double, 3>> Displacements;
  std::vector<vtkIdType> FirstNeighbour; ///< where those of a point begin in Neighbours
  std::vector<vtkIdType> Neighbours;
};

}

#endif
