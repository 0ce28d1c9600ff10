#include "ActiveBricks.h"

namespace chainmail
{

void ActiveBricks::begin()
{
  this->turn_ = 0;
  this->activity_.assign(this->bricks_.slots(), Activity());
  for (const int slot : this->bricks_.touchedSlots())
  {
    this->note(slot, everyFace);
  }
}

void ActiveBricks::note(int slot, int faces)
{
  if (faces == 0)
  {
    return;
  }
  this->bricks_.touch(slot);
  // Others than pending() may have given memory to bricks.
  this->activity_.resize(this->bricks_.slots());
  Activity& activity = this->activity_[slot];
  activity.any = this->turn_;
  for (int d = 0; d < 6; ++d)
  {
    if (faces & (1 << d))
    {
      activity.face[d] = this->turn_;
    }
  }
}

std::vector<int> ActiveBricks::pending()
{
  this->activity_.resize(this->bricks_.slots());
  const int since = this->turn_ - this->turns_;
  std::vector<int> bricks;
  for (int slot = 1; slot < this->bricks_.slots(); ++slot)
  {
    const int brick = this->bricks_.brick(slot);
    bool active = this->activity_[slot].any >= since;
    for (int d = 0; !active && d < 6; ++d)
    {
      const int near = this->bricks_.slot(this->bricks_.neighbour(brick, d));
      active = near > 0 && this->activity_[near].face[Bricks::opposite(d)] >= since;
    }
    if (active)
    {
      bricks.push_back(brick);
    }
  }
  this->bricks_.require(bricks);
  return bricks;
}

}
