#pragma once

#include "BrickExtents.h"
#include "BrickSet.h"
#include "Tissue.h"
#include "Types.h"

#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

namespace chainmail
{

/// The tissue that a part of the output shows, as plain data: what a Resampler needs of the simulation of another
/// process. Both have the same brick size, so bricks have the same numbers (BrickTable), and their elements the same
/// order (`local`). The displacements follow in further messages.
struct TissuePart
{
  struct Frame
  {
    TissueVersion version; ///< of this tissue
    TissueVersion since;   ///< what the receiver has to hold already; none: it gets everything
    Grid grid;
    Index3 brickSize{};
    Index3 padding{};
    CutSurfaces cuts = CutSurfaces::Stepped;
    OutputDetail detail;
    Sources sources;
    bool isPortion = false; ///< whether it replaces all that the receiver holds, see Simulation::portions()
  };

  Frame frame;
  std::vector<int> bricks;            ///< bricks whose tissue is included, ascending
  std::vector<std::uint8_t> elements; ///< of each of these, a bit for each place: whether it was tissue at rest
  std::vector<int> displaced;         ///< those among them with displacements, ascending
  std::vector<int> changed;           ///< those among these whose displacements follow, ascending
  Tissue::Topology topology;          ///< of `bricks`

  std::vector<char> toMessage() const;
  static TissuePart fromMessage(const std::vector<char>& message);
};

/// A message with the displacements of these bricks, which are displaced.
std::vector<char> messageOf(const Bricks& bricks, const std::vector<int>& displaced);
/// What such a message says, for Bricks::writeSlots(); null: it is that of a TissuePart.
const float* displacementsOf(const std::vector<char>& message);

/// Calls f for successive parts of a list of bricks. The displacements of each part are one message.
void inMessages(
  const Bricks& bricks, const std::vector<int>& list, const std::function<void(const std::vector<int>&)>& f);

/// Where tissue is at rest, by brick. It never changes, so what was read from the model once is kept: a bit an element.
class RestElements
{
public:
  explicit RestElements(const Bricks& bricks)
    : bricks_(bricks)
  {
  }
  /// As in TissuePart::elements.
  const std::vector<std::uint8_t>& of(int brick);
  void forget() { this->known_.clear(); }

private:
  const Bricks& bricks_;
  std::unordered_map<int, std::vector<std::uint8_t>> known_;
};

/// Displaced elements up to this far from a cell may move it: corners in air follow the elements around them [voxels].
constexpr Index3 aroundCells{ 4, 4, 4 };

/// The bricks of a part of the output.
BrickBox bricksOf(const OutputFrame& frame, const OutputDetail& detail);

/// The bricks of the grid that lie in a part of the output and that moved tissue may reach.
std::vector<int> reachedBricks(
  const Bricks& bricks, const OutputFrame& frame, const std::vector<BrickExtents>& reaches, const OutputDetail& detail);

/// The bricks with cells that move into a part of the output, and those around them that may move these cells.
BrickSet bricksAround(
  const Bricks& bricks, const OutputFrame& frame, const std::vector<BrickExtents>& reaches, const OutputDetail& detail);

Sources sourcesOf(
  const Bricks& bricks, const OutputFrame& frame, const std::vector<BrickExtents>& reaches, const OutputDetail& detail);

/// The part of the tissue of `bricks` that the output with this detail shows. `reaches` and `displaced` are those of
/// all tissue. All that is displaced counts as changed.
TissuePart partOf(Bricks& bricks, RestElements& rest, const OutputFrame& frame,
  const std::vector<BrickExtents>& reaches, const std::vector<int>& displaced, const OutputDetail& detail);

}
