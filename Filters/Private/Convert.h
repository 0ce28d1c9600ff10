// SPDX-License-Identifier: BSD-3-Clause
// Converts VTK's arrays and functions to what the engine reads.

#ifndef Convert_h
#define Convert_h

#include "Model.h"

#include "vtkDataArray.h"
#include "vtkPiecewiseFunction.h"
#include "vtkSmartPointer.h"

#include <functional>

namespace vtkChainMail
{

/// The array in a form that the engine can read: bits as bytes, anything else in its own type, interleaved.
vtkSmartPointer<vtkDataArray> ToEngineArray(vtkDataArray* array);

/// A view of an array from ToEngineArray(); an empty view for null.
chainmail::ArrayView View(vtkDataArray* array);

/// A function with the same values. It holds a copy of the nodes where straight lines join them, which is nearly always
/// so, and else a reference to `function`. With the copy it is much faster: vtkPiecewiseFunction::GetValue() is slow,
/// and the engine calls the function for every voxel of a scan.
std::function<double(double)> ToEngineFunction(const vtkSmartPointer<vtkPiecewiseFunction>& function);

}

#endif
