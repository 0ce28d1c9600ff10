// SPDX-License-Identifier: BSD-3-Clause
// What the engine reads of VTK's data.

#ifndef Convert_h
#define Convert_h

#include "Model.h"

#include "vtkDataArray.h"
#include "vtkPiecewiseFunction.h"
#include "vtkSmartPointer.h"

#include <functional>

namespace vtkChainMail
{

/// What the engine can read: bits as bytes, anything else in its own type, interleaved.
vtkSmartPointer<vtkDataArray> ToEngineArray(vtkDataArray* array);

/// A view of such an array; none of null.
chainmail::ArrayView View(vtkDataArray* array);

/// The values of a function, which is kept. vtkPiecewiseFunction::GetValue() is slow, and the engine asks for every
/// voxel of a scan: where straight lines join the nodes, as they nearly always do, this is much faster.
std::function<double(double)> ToEngineFunction(const vtkSmartPointer<vtkPiecewiseFunction>& function);

}

#endif
