// SPDX-License-Identifier: BSD-3-Clause
// Finds tissue where a view shows it, and how the view looks at it: for new probes, blades and drills, and for the
// mouse.

#ifndef Sight_h
#define Sight_h

#include <array>
#include <string>
#include <vector>

class vtkSMProxy;
class vtkSMSessionProxyManager;
class vtkSMSourceProxy;

namespace vtkChainMail
{

using Place = std::array<double, 3>;

/// The deformation that a proxy is, or that it is an input of; null where there is none.
vtkSMProxy* DeformationOf(vtkSMProxy* proxy);

/// The direction matrix of the image that an output port has, row by row; all 0 where it has none yet.
std::array<double, 9> DirectionOf(vtkSMSourceProxy* source, int port);

/// The name of the array that a deformation makes of scalars with ScalarSmoothing.
std::string Smoothed(const std::string& scalars);

/// The name of the scalars that a deformation smoothed (ScalarSmoothing) for an array of this name; the name itself
/// where it is that of no such array.
std::string Unsmoothed(const std::string& name);

class ViewRay
{
public:
  /// Looks at the tissue that the user works on, as the active view does: at that of the deformation that is selected
  /// or that the selected probe, blade or drill belongs to (in the Mode FromRest where it rests, else where it is now);
  /// else at the image that is selected; else at the last one there is. Not valid where there is none with data.
  /// With `selected` as if that were selected.
  explicit ViewRay(vtkSMSessionProxyManager* manager, vtkSMProxy* selected = nullptr);

  bool IsValid() const { return this->Source != nullptr; }

  /// Whether there is a render view. Without one it looks from the front, against the image's y axis.
  bool HasView() const { return this->View != nullptr; }

  double GetDiagonal() const { return this->Diagonal; }
  const std::array<double, 6>& GetBounds() const { return this->Bounds; }

  /// Finds tissue that is seen near the middle of the view and that a probe can pull: well away from the
  /// faces of the image that hold it. Where the view shows none, turns to one that does, see HasTurned().
  bool FindSpot();

  /// Keeps spots away from what is connected to an input of the deformation. To be called before FindSpot().
  void Avoid(const std::string& input);

  /// How much of each face of the image (x, x, y, y, z, z) tissue touches, and so is cut off by, from 0 to 1.
  std::array<double, 6> GetSharesCutOff() const;

  /// Parallel rays along the view around its middle, the nearest to it first: 6 numbers each, its two ends.
  std::vector<double> GetRays() const;

  /// All such tissue, the nearest to the middle first.
  const std::vector<Place>& GetSpots() const { return this->Spots; }
  bool HasTurned() const { return this->Turned; }

  /// A direction from shares of the view's axes: to the right, up, and towards the viewer.
  Place ToWorld(const Place& shares) const;

  /// The place so far from the spot, in shares of the diagonal; with `onTissue` moved along the line of sight to where
  /// tissue is seen, if any is.
  Place GetPlace(const Place& shares, bool onTissue) const;

  /// Where a ray from one place to another meets tissue that is seen: on the slice, where the view shows one. False
  /// where it does not.
  bool Pick(const Place& from, const Place& to, Place& hit) const;

private:
  void FindImage(vtkSMSessionProxyManager* manager, vtkSMProxy* selected);
  void FindLook();
  void FindOpacity(vtkSMProxy* source, int port);
  bool FindSpot(const Place& middle, double step, bool anywhere);
  std::vector<double> RaysAround(const Place& middle, double step) const;
  double GetStep() const;
  void KeepFree();
  double DepthOf(const Place& place) const;
  std::vector<double> Cast(const std::vector<double>& rays, bool asSeen) const;

  vtkSMSourceProxy* Source = nullptr;
  int Port = 0;
  vtkSMProxy* Deformation = nullptr;
  vtkSMProxy* View = nullptr;
  std::array<double, 6> Bounds{};
  std::array<int, 6> Extent{};
  double Diagonal = 0.0;

  std::string Scalars;
  double Threshold;
  std::vector<double> Opacity;
  double OpacityUnitDistance = 1.0;
  int SliceAxis = -1; // of the slice that is shown, if one is
  double SlicePlace = 0.0;
  double Spacing = 1.0;

  Place Middle{}; // of the view, as far away as what it looks at
  double HalfHeight = 0.0;
  Place Right{ { 1, 0, 0 } };
  Place Up{ { 0, 0, 1 } };
  Place Toward{ { 0, -1, 0 } };

  std::array<bool, 6> HeldFaces{};
  std::vector<Place> Taken;
  std::vector<Place> Spots;
  bool Turned = false;
};

}

#endif
