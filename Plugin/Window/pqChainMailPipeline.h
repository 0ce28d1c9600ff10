// SPDX-License-Identifier: BSD-3-Clause
// How the buttons make sources and deformations, and show them.

#ifndef pqChainMailPipeline_h
#define pqChainMailPipeline_h

#include "vtkSmartPointer.h"

#include <string>

class pqOutputPort;
class pqPipelineSource;
class vtkSMProxy;
class vtkSMSessionProxyManager;
class vtkSMSourceProxy;

namespace pqChainMailPipeline
{

vtkSmartPointer<vtkSMSourceProxy> create(vtkSMSessionProxyManager* manager, const char* group, const char* name);

/// What the button Apply would mark.
pqPipelineSource* applied(vtkSMProxy* proxy);

bool isImage(pqOutputPort* port);

/// Makes a deformation of a scan, with a probe where one is given, and registers it.
vtkSmartPointer<vtkSMSourceProxy> deform(pqOutputPort* scan, vtkSMProxy* probe);

/// How the scan is shown in the active view, where that says something of a volume or a slice; else null.
vtkSMProxy* lookOf(pqOutputPort* scan);

/// Shows a deformation in the active view instead of its scan, with the scan's look or, where that is null, one that
/// shows its tissue (pqChainMailLook.h).
void show(vtkSMSourceProxy* deformation, pqOutputPort* scan, vtkSMProxy* look, const std::string& preset);

}

#endif
