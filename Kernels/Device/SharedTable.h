#pragma once

#include "Context.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace chainmail
{

/// A table of integers that device and host use alternately. Only toDevice() and fromDevice() synchronise the copies of
/// the host and the device.
class SharedTable
{
public:
  SharedTable(int columns, const char* purpose)
    : columns_(columns)
    , buffer_(purpose)
  {
  }

  /// Sets the number of rows and fills all with zeros, on the host.
  void clear(int rows) { this->values_.assign(static_cast<std::size_t>(rows) * this->columns_, 0); }
  /// Changes the number of rows, on the host. New rows are zeros.
  void resize(int rows) { this->values_.resize(static_cast<std::size_t>(rows) * this->columns_); }
  /// Exchanges two rows, on the host.
  void exchange(int a, int b) { std::swap_ranges((*this)[a], (*this)[a] + this->columns_, (*this)[b]); }
  int rows() const { return static_cast<int>(this->values_.size()) / this->columns_; }

  cl_int* operator[](int row) { return this->values_.data() + static_cast<std::size_t>(row) * this->columns_; }
  const cl_int* operator[](int row) const { return const_cast<SharedTable&>(*this)[row]; }

  /// Writes or reads a float whose bits an integer of the table holds.
  void setReal(int row, int column, float value) { std::memcpy((*this)[row] + column, &value, sizeof(value)); }
  float real(int row, int column) const
  {
    float value;
    std::memcpy(&value, (*this)[row] + column, sizeof(value));
    return value;
  }

  void toDevice(Context& context) { this->buffer_.holding(context, this->values_); }
  void fromDevice(Context& context) { context.read(this->buffer(), this->values_); }
  const cl::Buffer& buffer() const { return this->buffer_.get(); }

private:
  int columns_;
  std::vector<cl_int> values_;
  Scratch buffer_;
};

}
