// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class vtkSMChainMailPlacementDomain
 * @brief Places a new source's point in the data that is active when the source is made.
 *
 * A source has no input to take its size from. The default is `at` of the way through the bounds of the active source,
 * from the lower to the upper corner (three numbers, [0, 1]); the property keeps its XML default when nothing is active
 * or the active source has no extent. It restricts nothing: a probe may be anywhere. Use it as
 * @code{xml}
 * <ChainMailPlacementDomain name="place" at="0.5 0.5 0.5"/>
 * @endcode
 */

#ifndef vtkSMChainMailPlacementDomain_h
#define vtkSMChainMailPlacementDomain_h

#include "ChainMailServerManagerModule.h" // for the export macro
#include "vtkSMDoubleRangeDomain.h"

class CHAINMAILSERVERMANAGER_EXPORT vtkSMChainMailPlacementDomain : public vtkSMDoubleRangeDomain
{
public:
  static vtkSMChainMailPlacementDomain* New();
  vtkTypeMacro(vtkSMChainMailPlacementDomain, vtkSMDoubleRangeDomain);

  int SetDefaultValues(vtkSMProperty* property, bool use_unchecked_values) override;

protected:
  vtkSMChainMailPlacementDomain() = default;
  ~vtkSMChainMailPlacementDomain() override = default;

  int ReadXMLAttributes(vtkSMProperty* property, vtkPVXMLElement* element) override;

private:
  vtkSMChainMailPlacementDomain(const vtkSMChainMailPlacementDomain&) = delete;
  void operator=(const vtkSMChainMailPlacementDomain&) = delete;

  double At[3] = { 0.5, 0.5, 0.5 };
};

#endif
