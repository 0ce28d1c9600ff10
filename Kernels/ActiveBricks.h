#pragma once

#include "Bricks.h"

#include <array>
#include <vector>

namespace chainmail
{

/// Which bricks a relaxation has to visit: those in which something can change. That is exact: an element stays put, to
/// the bit, when neither it nor a neighbour moved since its last turn, so results do not depend on the size of bricks.
class ActiveBricks
{
public:
  /// Faces of a brick, as movedFaces() of brick.clh has them; all, and something within.
  static constexpr int everyFace = 127;

  /// `turns`: an element has its turn once in so many.
  ActiveBricks(Bricks& bricks, int turns)
    : bricks_(bricks)
    , turns_(turns)
  {
  }

  /// All that was ever touched may move.
  void begin();

  /// The next turn.
  void advance() { ++this->turn_; }

  /// Something moved in a slot in this turn.
  void note(int slot, int faces);

  /// Bricks that something moved in, or beside, since the last turn of the same elements. Gives them memory.
  std::vector<int> pending();

private:
  struct Activity
  {
    int any = -1000;                                                         ///< turn in which an element last moved
    std::array<int, 6> face{ { -1000, -1000, -1000, -1000, -1000, -1000 } }; ///< one that touches this face
  };

  Bricks& bricks_;
  int turns_;
  std::vector<Activity> activity_;
  int turn_ = 0;
};

}
