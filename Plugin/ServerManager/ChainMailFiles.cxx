// SPDX-License-Identifier: BSD-3-Clause
#include "ChainMailFiles.h"

#include "vtkPVVersion.h"
#include "vtkSMSettings.h"

#include <string>

//------------------------------------------------------------------------------
void ChainMailReadableFiles()
{
#if PARAVIEW_VERSION_NUMBER < PARAVIEW_VERSION_CHECK(5, 13, 0)
  std::string settings;
  for (const char* writer : { "XMLHierarchicalBoxDataWriter", "XMLImageDataWriter", "XMLMultiBlockDataWriter",
         "XMLPImageDataWriter", "XMLPPartitionedDataSetWriter", "XMLPPolyDataWriter", "XMLPRectilinearGridWriter",
         "XMLPStructuredGridWriter", "XMLPTableWriter", "XMLPUnstructuredGridWriter", "XMLPVDWriter",
         "XMLPartitionedDataSetCollectionWriter", "XMLPolyDataWriter", "XMLRectilinearGridWriter",
         "XMLStructuredGridWriter", "XMLTableWriter", "XMLUniformGridAMRWriter", "XMLUnstructuredGridWriter" })
  {
    settings += std::string(settings.empty() ? "" : ", ") + "\"" + writer + "\": { \"DataMode\": 1 }"; // Binary
  }
  // As those of a site: settings of the user come first.
  vtkSMSettings::GetInstance()->AddCollectionFromString("{ \"writers\": { " + settings + " } }", 0.0);
#endif
}
