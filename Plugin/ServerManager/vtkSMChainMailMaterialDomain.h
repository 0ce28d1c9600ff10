// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class vtkSMChainMailMaterialDomain
 * @brief A material function whose default suits the chosen scalars.
 *
 * Gives its property a piecewise function of its own, with the points that vtkChainMailScanStatistics finds for the
 * scalars. ParaView's vtkSMRangedTransferFunctionDomain stretches the function it has over the range; here the function
 * itself depends on what the scalars are. Use it as
 * @code{xml}
 * <ChainMailMaterialDomain name="function">
 *   <RequiredProperties>
 *     <Property name="Input" function="Input"/>
 *     <Property name="Scalars" function="ArraySelection"/>
 *   </RequiredProperties>
 * </ChainMailMaterialDomain>
 * @endcode
 */

#ifndef vtkSMChainMailMaterialDomain_h
#define vtkSMChainMailMaterialDomain_h

#include "ChainMailServerManagerModule.h" // for the export macro
#include "vtkSMProxyListDomain.h"

class CHAINMAILSERVERMANAGER_EXPORT vtkSMChainMailMaterialDomain : public vtkSMProxyListDomain
{
public:
  static vtkSMChainMailMaterialDomain* New();
  vtkTypeMacro(vtkSMChainMailMaterialDomain, vtkSMProxyListDomain);

  void Update(vtkSMProperty* requestingProperty) override;
  int SetDefaultValues(vtkSMProperty* property, bool use_unchecked_values) override;

protected:
  vtkSMChainMailMaterialDomain() = default;
  ~vtkSMChainMailMaterialDomain() override = default;

  int ReadXMLAttributes(vtkSMProperty* property, vtkPVXMLElement* element) override;

private:
  vtkSMChainMailMaterialDomain(const vtkSMChainMailMaterialDomain&) = delete;
  void operator=(const vtkSMChainMailMaterialDomain&) = delete;

  double Range[2] = { 1.0, 0.0 }; // empty
};

#endif
