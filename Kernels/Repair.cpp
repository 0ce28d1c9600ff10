#include "Repair.h"

#include <limits>

namespace chainmail
{

Repair::Repair(Bricks& bricks)
  : bricks_(bricks)
  , spread_(bricks, "repair.cl", "bound")
  , upper_{ 3, sizeof(cl_float), "bounds of displacements" }
{
}

Repair::~Repair()
{
  this->bricks_.drop(this->upper_);
}

void Repair::run(Propagation& propagation, const Checkpoint& checkpoint)
{
  Context& context = this->bricks_.context();
  std::vector<int> touched;
  for (const int slot : this->bricks_.touchedSlots())
  {
    touched.push_back(this->bricks_.brick(slot));
  }
  this->bricks_.keep(this->upper_);
  // New bricks are at rest and so are bounds of 0: what they get as their memory is right.
  context.queue().enqueueCopyBuffer(
    this->bricks_.displacement, this->upper_.buffer, 0, 0, sizeof(cl_float) * 3 * this->bricks_.pitch());
  this->bricks_.saveBefore();

  this->spread_.start(touched);
  this->spread_.run(0, std::numeric_limits<float>::infinity(), checkpoint,
    [this](cl::Kernel& kernel, int& argument)
    {
      kernel.setArg(argument++, this->bricks_.constraint);
      kernel.setArg(argument++, this->bricks_.cutsOrNothing());
      kernel.setArg(argument++, this->bricks_.before);
      kernel.setArg(argument++, this->upper_.buffer);
    });
  const std::vector<int> slots = this->spread_.changed();
  if (!slots.empty())
  {
    std::vector<int> bricks;
    for (const int slot : slots)
    {
      this->bricks_.touch(slot);
      bricks.push_back(this->bricks_.brick(slot));
    }
    Scratch list("the list of active bricks");
    cl::Kernel kernel = context.kernel("repair.cl", this->bricks_.defines(true), "settle");
    kernel.setArg(0, list.holding(context, slots));
    kernel.setArg(1, this->bricks_.pitch());
    kernel.setArg(2, this->bricks_.constraint);
    kernel.setArg(3, this->upper_.buffer);
    kernel.setArg(4, this->bricks_.before);
    kernel.setArg(5, this->bricks_.displacement);
    context.runGroups(kernel, slots.size(), this->bricks_.workItems(true));
    propagation.start(bricks);
    propagation.run(0, std::numeric_limits<float>::infinity(), checkpoint);
  }
  this->bricks_.drop(this->upper_);
}

}
