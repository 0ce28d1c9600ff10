// SPDX-License-Identifier: BSD-3-Clause
// Memory for the values of an output array. It is reused when no array refers to it any more.

#ifndef OutputBuffer_h
#define OutputBuffer_h

#include "Fingerprint.h"
#include "Grids.h"
#include "LentMemory.h"

#include "Types.h"

#include "vtkDataArray.h"

#include <array>
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

  char* GetData() const { return this->Memory.GetData(); }

  /// Whether no array refers to the memory any more.
  bool IsFree() const { return this->Memory.IsFree(); }

  /// The number of the resampling whose result the buffer holds; 0 where there is none, or where somebody has written
  /// to the buffer since. A filter downstream may do so unnoticed, so all contents are compared with their
  /// fingerprints.
  std::uint64_t GetNumber();

  /// To be called before these bytes are written.
  void Touch(std::size_t first, std::size_t bytes);
  void TouchAll() { this->Touch(0, this->Memory.GetSize()); }
  /// The same for all voxels of these boxes.
  void Touch(const std::vector<chainmail::ResampledBox>& boxes, const Grids& grids, std::size_t bytesOfVoxel);
  /// To be called when a resampling is completely written.
  void Finish(std::uint64_t number);

  /// Lends the memory to an array, until this array and all arrays that share its values are deleted.
  void Lend(vtkDataArray* array) const { this->Memory.Lend(array); }

private:
  LentMemory Memory;
  std::uint64_t Number = 0;
  std::vector<Fingerprint> Parts;
  std::vector<char> Touched; // for each part
};

/// Double buffering for an array that every update writes, from the beginning or as changes to an older result. One
/// buffer is shown and is not written until an update has succeeded. The next update writes to the other one.
class OutputBuffers
{
public:
  /// Begins an update. Returns the number of the resampling whose result it continues from; 0 where there is none.
  std::uint64_t Begin();

  /// Opens a buffer of `bytes` bytes to write to. Returns true where it holds no result and has to be written from the
  /// beginning. Throws std::bad_alloc.
  bool Open(std::size_t bytes);
  bool IsOpen() const { return this->Opened; }

  /// The open buffer.
  OutputBuffer& Get() { return *this->Current; }

private:
  std::array<std::unique_ptr<OutputBuffer>, 2> Buffers;
  OutputBuffer* Current = nullptr; // buffer of the current update
  std::uint64_t Since = 0;         // resampling whose result it held when the update began
  bool Opened = false;
};

}

#endif
