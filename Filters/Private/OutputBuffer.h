// SPDX-License-Identifier: BSD-3-Clause
// Memory for the values of an output array, which is used again when nobody reads them any more.

#ifndef OutputBuffer_h
#define OutputBuffer_h

#include "Fingerprint.h"
#include "Grids.h"

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

  char* GetData() const { return this->Memory.get(); }

  /// Whether no array has the memory any more.
  bool IsFree() const;

  /// The number of the resampling whose result is in here; 0 where there is none, or where somebody has written to it
  /// since. A filter downstream may do so without this filter's knowledge, so all contents are read.
  std::uint64_t GetNumber();

  /// To be called before these bytes are written.
  void Touch(std::size_t first, std::size_t bytes);
  void TouchAll() { this->Touch(0, this->Bytes); }
  /// The same of all voxels of these boxes.
  void Touch(const std::vector<chainmail::ResampledBox>& boxes, const Grids& grids, std::size_t bytesOfVoxel);
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

/// Two buffers for an array that is written anew, or on from an older state, in every update: one is on show and stays
/// as it is until an update has succeeded; the next update writes to the other one.
class OutputBuffers
{
public:
  /// Begins an update. Returns the number of the resampling whose result it goes on from; 0 where there is none.
  std::uint64_t Begin();

  /// Sees to it that there is a buffer of so many bytes to write to. Returns whether it holds anything, and is to be
  /// written from the beginning. Throws std::bad_alloc.
  bool Open(std::size_t bytes);
  bool IsOpen() const { return this->Opened; }

  /// The open buffer.
  OutputBuffer& Get() { return *this->Current; }

private:
  std::array<std::unique_ptr<OutputBuffer>, 2> Buffers;
  OutputBuffer* Current = nullptr; // of the update that is under way
  std::uint64_t Since = 0;         // the resampling whose result it held when the update began
  bool Opened = false;
};

}

#endif
