// SPDX-License-Identifier: BSD-3-Clause
// Converts VTK's arrays and functions to what the engine reads.

#ifndef Convert_h
#define Convert_h

#include "Model.h"

#include "vtkDataArray.h"
#include "vtkSmartPointer.h"

#include <functional>
#include <vector>

namespace vtkChainMail
{

/// The array in a form that the engine can read: bits as bytes, anything else in its own type, interleaved.
vtkSmartPointer<vtkDataArray> ToEngineArray(vtkDataArray* array);

/// A view of an array from ToEngineArray(); an empty view for null.
chainmail::ArrayView View(vtkDataArray* array);

/// A function with the values of the vtkPiecewiseFunction that TissueSource::Function describes; null for none. Where
/// straight lines join the nodes, which is nearly always so, it does not use that class: its GetValue() is slow, and
/// the engine calls the function for every voxel of a scan.
std::function<double(double)> ToEngineFunction(const std::vector<double>& function);

}

#endif
