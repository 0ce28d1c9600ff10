// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class vtkSMChainMailRangeDomain
 * @brief The finite range of the chosen scalars, with a default that parts air from tissue.
 *
 * As vtkSMArrayRangeDomain, for the component that vtkChainMailDeformation reads and without infinities. The default is
 * what vtkChainMailScanStatistics finds: the threshold of tissue where `fit` is "tissue", what air is shown as where it
 * is "air"; without `fit` it is what the superclass's `default_mode` says. Use it as
 * @code{xml}
 * <ChainMailRangeDomain name="range" fit="tissue">
 *   <RequiredProperties>
 *     <Property name="Input" function="Input"/>
 *     <Property name="Scalars" function="ArraySelection"/>
 *   </RequiredProperties>
 * </ChainMailRangeDomain>
 * @endcode
 */

#ifndef vtkSMChainMailRangeDomain_h
#define vtkSMChainMailRangeDomain_h

#include "ChainMailServerManagerModule.h" // for the export macro
#include "vtkSMDoubleRangeDomain.h"

class vtkPVChainMailScanInformation;

class CHAINMAILSERVERMANAGER_EXPORT vtkSMChainMailRangeDomain : public vtkSMDoubleRangeDomain
{
public:
  static vtkSMChainMailRangeDomain* New();
  vtkTypeMacro(vtkSMChainMailRangeDomain, vtkSMDoubleRangeDomain);

  void Update(vtkSMProperty* requestingProperty) override;
  int SetDefaultValues(vtkSMProperty* property, bool use_unchecked_values) override;

  /**
   * The finite range of the array that `domain`'s required properties `Input` and `ArraySelection` name. False, and
   * `range` as it was, where there is no such array or nothing finite in it.
   */
  static bool FindRange(vtkSMDomain* domain, double range[2]);

  /**
   * Asks the server what the scalars that these properties name are. False where there are none.
   */
  static bool FindStatistics(vtkSMDomain* domain, vtkPVChainMailScanInformation* answer);

  /**
   * Brings the source of `domain`'s required property `Input` up to date where it never was. In a script nobody has
   * pressed Apply on the reader when the filter is made, and the defaults need its data.
   */
  static void EnsureData(vtkSMDomain* domain);

protected:
  vtkSMChainMailRangeDomain() = default;
  ~vtkSMChainMailRangeDomain() override = default;

  int ReadXMLAttributes(vtkSMProperty* property, vtkPVXMLElement* element) override;

private:
  vtkSMChainMailRangeDomain(const vtkSMChainMailRangeDomain&) = delete;
  void operator=(const vtkSMChainMailRangeDomain&) = delete;

  enum
  {
    NOTHING,
    TISSUE,
    AIR
  } Fit = NOTHING;
};

#endif
