// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class vtkChainMailForearmSource
 * @brief A forearm as a CT scanner would see it, to try the deformation filter on: the image of Data/make_forearm.py.
 *
 * The script is part of the plugin and runs in ParaView's Python, with numpy, in names of its own: those of a user's
 * script stay as they are, which ParaView's Programmable Source does not leave alone. The point array "CT" (short)
 * holds Hounsfield units. The same size gives the same voxels, whatever part of them is asked for. Without Python an
 * update fails and says so.
 */

#ifndef vtkChainMailForearmSource_h
#define vtkChainMailForearmSource_h

#include "ChainMailServerManagerModule.h" // for the export macro
#include "vtkImageAlgorithm.h"

class CHAINMAILSERVERMANAGER_EXPORT vtkChainMailForearmSource : public vtkImageAlgorithm
{
public:
  static vtkChainMailForearmSource* New();
  vtkTypeMacro(vtkChainMailForearmSource, vtkImageAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The voxels along x, y and z, at least 32 each: less is taken for 32. The box measures 132 x 124 x 230 mm whatever
   * its size in voxels. Default: 110 100 130.
   */
  void SetSize(int x, int y, int z);
  vtkGetVector3Macro(Size, int);
  ///@}

protected:
  vtkChainMailForearmSource();
  ~vtkChainMailForearmSource() override = default;

  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector* output) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* output) override;

private:
  vtkChainMailForearmSource(const vtkChainMailForearmSource&) = delete;
  void operator=(const vtkChainMailForearmSource&) = delete;

  int Size[3] = { 110, 100, 130 };
};

#endif
