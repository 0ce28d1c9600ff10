// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class vtkPVChainMailTissueInformation
 * @brief Where rays meet the tissue of an image that is on the server.
 *
 * The client asks with rays and what is tissue; the server answers with a number for each, see
 * vtkChainMailTissuePicker::Pick(), and with the image's direction matrix. Of several processes the first hit counts.
 */

#ifndef vtkPVChainMailTissueInformation_h
#define vtkPVChainMailTissueInformation_h

#include "ChainMailServerManagerModule.h" // for the export macro
#include "vtkPVInformation.h"

#include <array>  // for Direction
#include <string> // for Scalars
#include <vector> // for Rays

class CHAINMAILSERVERMANAGER_EXPORT vtkPVChainMailTissueInformation : public vtkPVInformation
{
public:
  static vtkPVChainMailTissueInformation* New();
  vtkTypeMacro(vtkPVChainMailTissueInformation, vtkPVInformation);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void CopyParametersToStream(vtkMultiProcessStream& stream) override;
  void CopyParametersFromStream(vtkMultiProcessStream& stream) override;
  void CopyFromObject(vtkObject* algorithm) override;
  void AddInformation(vtkPVInformation* other) override;
  void CopyToStream(vtkClientServerStream* stream) override;
  void CopyFromStream(const vtkClientServerStream* stream) override;

  // The question: the output port, what is tissue, and each ray as two places.
  int Port = 0;
  std::string Scalars;
  double TissueThreshold;
  std::vector<double> Opacity; ///< nodes of a piecewise function, 4 numbers each; empty where all tissue is opaque
  double OpacityUnitDistance = 1.0;
  std::vector<double> Rays;

  // The answer. `Direction` is all 0 where there is no image.
  std::vector<double> Shares;
  std::array<double, 9> Direction{};

protected:
  vtkPVChainMailTissueInformation();
  ~vtkPVChainMailTissueInformation() override = default;

private:
  vtkPVChainMailTissueInformation(const vtkPVChainMailTissueInformation&) = delete;
  void operator=(const vtkPVChainMailTissueInformation&) = delete;
};

#endif
