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

/// A view of an array from ToEngineArray(); of null, a view of nothing.
chainmail::ArrayView View(vtkDataArray* array);

/// A function of the same values, which shares the ownership of `function`. It is much faster where straight lines join
/// the nodes, as they nearly always do; vtkPiecewiseFunction::GetValue() is slow, and the engine asks for every voxel
/// of a scan.
std::function<double(double)> ToEngineFunction(const vtkSmartPointer<vtkPiecewiseFunction>& function);

}

#endif
