#pragma once

#include "BrickStorage.h"

#include <vector>

namespace chainmail
{

/// The displacements of some slots as they were before a wave. It has memory only while a wave needs it; its values in
/// slots that nobody saved are undefined.
class Snapshot
{
public:
  /// `storage` and `displacement`, a field of it, must outlive this object.
  Snapshot(BrickStorage& storage, Field& displacement)
    : storage_(storage)
    , displacement_(displacement)
  {
  }

  /// Allocates memory, or frees it when no wave needs it any more.
  void allocate() { this->storage_.addField(this->saved_); }
  void release() { this->storage_.removeField(this->saved_); }

  /// Saves the displacements of these slots. Kernels also do so, brick by brick (fixedpoint.clh).
  void save(const std::vector<int>& slots)
  {
    this->storage_.addField(this->saved_, Field::Start::Anything);
    this->storage_.copy(this->displacement_, this->saved_, slots);
  }
  /// Restores the displacements of these slots.
  void restore(const std::vector<int>& slots) { this->storage_.copy(this->saved_, this->displacement_, slots); }

  /// float [axis][address].
  const cl::Buffer& buffer() const { return this->saved_.buffer; }

private:
  BrickStorage& storage_;
  Field& displacement_;
  Field saved_{ 3, sizeof(float), "the displacement before a wave" };
};

}
