// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class vtkSMChainMailPlacementDomain
 * @brief Fits a new probe, blade or drill to the tissue that is there when it is made.
 *
 * A source has no input to take its place and size from, so the default comes from what the active view shows, see
 * vtkChainMail::ViewRay: lengths are shares of the data's diagonal, and directions go along the view's axes (to the
 * right, up, towards the viewer) from a spot of tissue that is seen in it. One of these attributes says what the
 * default is:
 *
 * - `offset`: a place, so far from the spot; with `on_tissue="1"` moved along the line of sight onto tissue
 * - `vector`: a direction of length 1
 * - `size`: a length
 *
 * The spot is well apart from what is connected already to those inputs of the deformation that the attribute `avoid`
 * lists; properties of one place need the same list.
 *
 * Where there is no render view, as in most scripts, a property with the attribute `at` is instead that share of the
 * way through the bounds of the active source, from the lower to the upper corner (three numbers, [0, 1]); with `at=""`
 * it keeps the default of its XML. The same goes for all where there is no data. The domain restricts nothing. Use it
 * as
 * @code{xml}
 * <ChainMailPlacementDomain name="place" offset="0 0 0" at="0.5 0.5 0.5"/>
 * @endcode
 */

#ifndef vtkSMChainMailPlacementDomain_h
#define vtkSMChainMailPlacementDomain_h

#include "ChainMailServerManagerModule.h" // for the export macro
#include "vtkSMDoubleRangeDomain.h"

#include <string> // for Avoided
#include <vector> // for Avoided

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

  enum
  {
    PLACE,
    VECTOR,
    SIZE
  } Kind = PLACE;
  double Shares[3] = { 0.0, 0.0, 0.0 };
  double Size = 0.0;
  std::vector<std::string> Avoided;
  bool OnTissue = false;
  bool NeedsView = false;
  bool HasAt = false;
  double At[3] = { 0.5, 0.5, 0.5 };
};

#endif
