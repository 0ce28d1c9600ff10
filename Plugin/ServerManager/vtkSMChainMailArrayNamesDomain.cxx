// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSMChainMailArrayNamesDomain.h"

#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkSMChainMailArrayNamesDomain);
