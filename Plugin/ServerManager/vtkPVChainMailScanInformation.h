// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class vtkPVChainMailScanInformation
 * @brief What the scalars of an image that is on the server are: see vtkChainMailScanStatistics.
 *
 * Each process of a server counts its own part of the image, and the counts add up to those of the whole.
 */

#ifndef vtkPVChainMailScanInformation_h
#define vtkPVChainMailScanInformation_h

#include "ChainMailServerManagerModule.h" // for the export macro
#include "vtkNew.h"                       // for Statistics
#include "vtkPVInformation.h"

#include <string> // for Scalars

class vtkChainMailScanStatistics;
class vtkSMSourceProxy;

class CHAINMAILSERVERMANAGER_EXPORT vtkPVChainMailScanInformation : public vtkPVInformation
{
public:
  static vtkPVChainMailScanInformation* New();
  vtkTypeMacro(vtkPVChainMailScanInformation, vtkPVInformation);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Asks for an output port's point array. An empty name stands for the active scalars.
  void Gather(vtkSMSourceProxy* source, int port, const std::string& scalars);

  void CopyParametersToStream(vtkMultiProcessStream& stream) override;
  void CopyParametersFromStream(vtkMultiProcessStream& stream) override;
  void CopyFromObject(vtkObject* algorithm) override;
  void AddInformation(vtkPVInformation* other) override;
  void CopyToStream(vtkClientServerStream* stream) override;
  void CopyFromStream(const vtkClientServerStream* stream) override;

  /// The answer.
  vtkChainMailScanStatistics* GetStatistics() { return this->Statistics; }

protected:
  vtkPVChainMailScanInformation();
  ~vtkPVChainMailScanInformation() override;

private:
  vtkPVChainMailScanInformation(const vtkPVChainMailScanInformation&) = delete;
  void operator=(const vtkPVChainMailScanInformation&) = delete;

  int Port = 0;
  std::string Scalars;
  vtkNew<vtkChainMailScanStatistics> Statistics;
};

#endif
