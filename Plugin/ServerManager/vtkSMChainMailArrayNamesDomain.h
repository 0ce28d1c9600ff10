// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class vtkSMChainMailArrayNamesDomain
 * @brief The names of arrays that a filter can make, of which any number is chosen.
 *
 * The property has the names that are chosen. For a StringListDomain the panel has a list that chooses one, whose Apply
 * empties a property of several; for an ArrayListDomain it has check boxes, but the names are those of the input. Use
 * it as
 * @code{xml}
 * <ChainMailArrayNamesDomain name="list">
 *   <String value="Displacement"/>
 *   <String value="Element"/>
 * </ChainMailArrayNamesDomain>
 * @endcode
 */

#ifndef vtkSMChainMailArrayNamesDomain_h
#define vtkSMChainMailArrayNamesDomain_h

#include "ChainMailServerManagerModule.h" // for the export macro
#include "vtkSMArrayListDomain.h"

class CHAINMAILSERVERMANAGER_EXPORT vtkSMChainMailArrayNamesDomain : public vtkSMArrayListDomain
{
public:
  static vtkSMChainMailArrayNamesDomain* New();
  vtkTypeMacro(vtkSMChainMailArrayNamesDomain, vtkSMArrayListDomain);

  /**
   * The names are those of the XML, whatever the input has.
   */
  void Update(vtkSMProperty*) override {}

protected:
  vtkSMChainMailArrayNamesDomain() = default;
  ~vtkSMChainMailArrayNamesDomain() override = default;

private:
  vtkSMChainMailArrayNamesDomain(const vtkSMChainMailArrayNamesDomain&) = delete;
  void operator=(const vtkSMChainMailArrayNamesDomain&) = delete;
};

#endif
