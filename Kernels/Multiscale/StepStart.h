#pragma once

#include "Bricks.h"

namespace chainmail
{

/// The displacements at the start of a step of a relaxation, to compare with those after it and to go back to.
class StepStart
{
public:
  explicit StepStart(Bricks& bricks)
    : bricks_(bricks)
  {
  }
  ~StepStart() { this->release(); }
  StepStart(const StepStart&) = delete;
  StepStart& operator=(const StepStart&) = delete;

  /// Saves the current displacements as those at the start.
  void save() { this->bricks_.saveIn(this->start_); }

  /// The displacements at the start.
  const Field& field() const { return this->start_; }

  /// The root mean square of the changes of displacements since the start, as a fraction of the largest displacement.
  /// The mean is over the elements that are displaced by more than a thousandth of that. Where there are none it is 0.
  /// Does not depend on the size of bricks.
  double change();

  /// Scales the change of every displacement since the start by `share`. Elements with equal changes, such as those of
  /// a rigid cluster, keep equal changes.
  void goBack(float share);

  /// Restores the displacements at the start, bit for bit.
  void restore();

  /// Frees the memory.
  void release() { this->bricks_.removeField(this->start_); }

private:
  float largest();

  Bricks& bricks_;
  Field start_{ 3, sizeof(cl_float), "the displacement before a relaxation" };
  Scratch list_{ "the list of bricks" };
  Scratch result_{ "the change of the state" };
};

}
