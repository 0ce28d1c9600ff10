// SPDX-License-Identifier: BSD-3-Clause
// Memory for the values of an output array, which is used again when nobody reads them any more.

#ifndef OutputBuffer_h
#define OutputBuffer_h

#include "Fingerprint.h"

#include "vtkDataArray.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace vtkChainMail
{

class OutputBuffer
{
public:
  /// Throws std::bad_alloc.
  explicit OutputBuffer(std::size_t bytes);

  char* GetData() const { return this->Memory.get(); }

  /// Whether no array has the memory any more.
  bool IsFree() const;

  /// The number of the resampling whose result is in here; 0 where there is none, or where somebody has written to it
  /// since. A filter downstream may do so without this filter's knowledge, so all contents are read.
  std::uint64_t GetNumber();

  /// To be called before these bytes are written.
  void Touch(std::size_t first, std::size_t bytes);
  void TouchAll() { this->Touch(0, this->Bytes); }
  /// To be called when all that belongs to a resampling is written.
  void Finish(std::uint64_t number);

  /// Gives the memory to an array, which has it until it and all that share its values are deleted.
  void Lend(vtkDataArray* array) const;

private:
  static void GiveBack(void* memory);

  std::size_t Bytes;
  std::shared_ptr<char> Memory;
  std::uint64_t Number = 0;
  std::vector<Fingerprint> Parts;
  std::vector<char> Touched; // for each part
};

}

#endif
