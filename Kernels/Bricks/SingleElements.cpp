// Bricks: values of single elements, and of slots, between host and device.

#include "Bricks.h"
#include "ElementRule.h"

#include <algorithm>

namespace chainmail
{

void Bricks::scatter(const cl::Buffer& field, cl_uint pitch, std::size_t components,
  const std::vector<std::uint32_t>& addresses, const cl::Buffer& values)
{
  Context& context = *this->context_;
  context.launchOver(context.kernel("scatter.cl", "", "scatter"), addresses.size(), field, pitch,
    static_cast<cl_int>(components), this->addresses_.holding(context, addresses), values);
}

void Bricks::setDisplacements(const std::vector<std::uint32_t>& addresses, const std::vector<float>& values)
{
  this->set(this->displacement, this->pitch(), 3, addresses, values);
}

void Bricks::setConstraints(const std::vector<std::uint32_t>& addresses, const std::vector<float>& values)
{
  this->set(this->constraint, this->tissuePitch(), this->model_->axes(), addresses, values);
}

std::vector<float> Bricks::get(
  const cl::Buffer& field, cl_uint pitch, std::size_t components, const std::vector<std::uint32_t>& addresses)
{
  Context& context = *this->context_;
  std::vector<float> values(components * addresses.size());
  if (!addresses.empty())
  {
    const cl::Buffer& out = this->values_.sized(context, sizeof(float) * values.size());
    // From the address pitch - skew on there are zeros: elements without a state are at rest.
    context.launchOver(context.kernel("scatter.cl", "", "gather"), addresses.size(), field, pitch,
      static_cast<cl_uint>(pitch - skew), static_cast<cl_int>(components), this->addresses_.holding(context, addresses),
      out);
    context.read(out, values);
  }
  return values;
}

std::vector<float> Bricks::displacements(const std::vector<std::uint32_t>& addresses)
{
  return this->get(this->displacement, this->pitch(), 3, addresses);
}

void Bricks::setSpins(const std::vector<std::uint32_t>& addresses, const std::vector<float>& values)
{
  this->set(this->spins_->spin.buffer, this->pitch(), 3, addresses, values);
  this->spins_->any =
    this->spins_->any || std::any_of(values.begin(), values.end(), [](float value) { return value != 0.0f; });
}

std::vector<float> Bricks::spinsAt(const std::vector<std::uint32_t>& addresses)
{
  return this->get(this->spins_->spin.buffer, this->pitch(), 3, addresses);
}

std::vector<float> Bricks::pressuresAt(const std::vector<std::uint32_t>& addresses)
{
  const std::vector<float> spins = this->get(this->spins_->spin.buffer, this->pitch(), 4, addresses);
  std::vector<float> pressures(addresses.size());
  for (std::size_t n = 0; n < pressures.size(); ++n)
  {
    pressures[n] = spins[4 * n + 3];
  }
  return pressures;
}

std::vector<float> Bricks::constraints(const std::vector<std::uint32_t>& addresses)
{
  return this->get(this->constraint, this->tissuePitch(), this->model_->axes(), addresses);
}

float Spins::restOffset(const float* spinI, const float* spinJ, int direction, int axis) const
{
  const int along = direction / 2;
  float byI[3];
  float byJ[3];
  rule::single::turnedAxis(spinI, along, byI);
  rule::single::turnedAxis(spinJ, along, byJ);
  const float way = direction % 2 == 0 ? -0.5f : 0.5f;
  return way * (byI[axis] + byJ[axis]) * (this->proportions.s[along] / this->proportions.s[axis]);
}

void Bricks::readSlot(int slot, std::vector<float>& out)
{
  this->readSlot(this->displacement, slot, out);
}

void Bricks::readSpins(int slot, std::vector<float>& out)
{
  this->readSlot(this->spins_->spin.buffer, slot, out);
}

void Bricks::readSlot(const cl::Buffer& field, int slot, std::vector<float>& out)
{
  const std::size_t count = static_cast<std::size_t>(this->elements_);
  out.resize(3 * count);
  for (std::size_t a = 0; a < 3; ++a)
  {
    this->context_->queue().enqueueReadBuffer(field, CL_TRUE, sizeof(float) * (a * this->pitch() + slot * count),
      sizeof(float) * count, out.data() + a * count);
  }
}

}
