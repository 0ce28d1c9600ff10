// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class vtkSMChainMailDeformationProxy
 * @brief The deformation filter in the pipeline: shown as a volume, or as a slice where the image is one, and settling
 * in all processes of the server.
 *
 * The XML's hint `RepresentationType` makes ParaView show the filter's output as a volume from the start, where it
 * would draw the outline of an image's box alone. A single slice has nothing to render as a volume; for it, this proxy
 * keeps that hint back, and ParaView shows a slice as it does by itself.
 */

#ifndef vtkSMChainMailDeformationProxy_h
#define vtkSMChainMailDeformationProxy_h

#include "ChainMailServerManagerModule.h" // for the export macro
#include "vtkSMSourceProxy.h"
#include "vtkSmartPointer.h" // for SliceHints

class CHAINMAILSERVERMANAGER_EXPORT vtkSMChainMailDeformationProxy : public vtkSMSourceProxy
{
public:
  static vtkSMChainMailDeformationProxy* New();
  vtkTypeMacro(vtkSMChainMailDeformationProxy, vtkSMSourceProxy);

  vtkPVXMLElement* GetHints() override;

  /**
   * Where this proxy itself was modified, so is the filter, in all processes of the server. To go on settling, who asks
   * for it (the window's timer, or a script) has marked nothing but the proxy, and asked one process.
   */
  void MarkModified(vtkSMProxy* modifiedProxy) override;

protected:
  vtkSMChainMailDeformationProxy() = default;
  ~vtkSMChainMailDeformationProxy() override = default;

private:
  vtkSMChainMailDeformationProxy(const vtkSMChainMailDeformationProxy&) = delete;
  void operator=(const vtkSMChainMailDeformationProxy&) = delete;

  vtkSmartPointer<vtkPVXMLElement> SliceHints;
};

#endif
