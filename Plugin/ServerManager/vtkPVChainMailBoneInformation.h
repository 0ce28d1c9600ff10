// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class vtkPVChainMailBoneInformation
 * @brief The bone of a deformation that rays meet, or that is at a place, on the server.
 *
 * A bone is a rigid cluster of the deformation; where it has labels (BodyArray), all voxels of one label. All of it is
 * at rest. To be gathered from a vtkChainMailDeformation.
 */

#ifndef vtkPVChainMailBoneInformation_h
#define vtkPVChainMailBoneInformation_h

#include "ChainMailServerManagerModule.h" // for the export macro
#include "vtkPVInformation.h"
#include "vtkType.h" // for vtkIdType

#include <array>  // for Bounds
#include <vector> // for Rays

class CHAINMAILSERVERMANAGER_EXPORT vtkPVChainMailBoneInformation : public vtkPVInformation
{
public:
  static vtkPVChainMailBoneInformation* New();
  vtkTypeMacro(vtkPVChainMailBoneInformation, vtkPVInformation);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void CopyParametersToStream(vtkMultiProcessStream& stream) override;
  void CopyParametersFromStream(vtkMultiProcessStream& stream) override;
  void CopyFromObject(vtkObject* algorithm) override;
  void AddInformation(vtkPVInformation* other) override;
  void CopyToStream(vtkClientServerStream* stream) override;
  void CopyFromStream(const vtkClientServerStream* stream) override;

  // The question: rays, each as two places, of which the first counts that meets a bone of some size; without rays the
  // bone with this label or, with -1, the one at the place.
  std::vector<double> Rays;
  std::array<double, 3> Place{};
  vtkIdType Body = -1;

  // The answer, in world axes. `Body` is then the label of the bone, -1 where it has none.
  bool IsFound = false;
  std::array<double, 6> Bounds{}; ///< of its voxels, whole
  std::array<double, 3> Middle{}; ///< of the bounds; without a label the place in the bone that is nearest to it

protected:
  vtkPVChainMailBoneInformation() = default;
  ~vtkPVChainMailBoneInformation() override = default;

private:
  vtkPVChainMailBoneInformation(const vtkPVChainMailBoneInformation&) = delete;
  void operator=(const vtkPVChainMailBoneInformation&) = delete;
};

#endif
