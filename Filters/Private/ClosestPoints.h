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
  /// Both are surfaces of triangles without duplicate points. `start`: initial displacements of the points of `before`;
  /// with null all points start with the displacement of the centroid.
  ClosestPoints(vtkPolyData* before, vtkPolyData* after, vtkDataArray* start);

  /// Finds the displacements. `progress` gets the fraction done and returns whether to go on.
  void Match(int iterations, int smoothing, const std::function<bool(double)>& progress);

  const std::vector<std::array<double, 3>>& GetDisplacements() const { return this->Displacements; }

  /// The mean distance of the moved points from the second surface [mm].
  double GetDistance();

private:
  void Look();
  void Smooth();
  /// Sets the points of Moved by the displacements.
  void Move();

  vtkSmartPointer<vtkPolyData> Before;
  vtkSmartPointer<vtkPolyData> After;
  vtkSmartPointer<vtkPolyData> Moved; ///< Before with the present displacements
  std::vector<std::array<double, 3>> Displacements;
  std::vector<vtkIdType> FirstNeighbour; ///< index in Neighbours of the first neighbour of each point
  std::vector<vtkIdType> Neighbours;
};

}

#endif
