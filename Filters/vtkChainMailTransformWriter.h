// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailTransformWriter
 * @brief   writes a deformation as a displacement field that ITK's programs read
 *
 * elastix, plastimatch, ANTs, 3D Slicer and SimpleITK resample images by a pull-back field: for each voxel of the
 * result, the displacement to where its material was. This is the array `PullBack` of vtkChainMailDeformation's output
 * 0, which includes cuts and carves. With it these programs deform other images of the same patient as the scan was
 * deformed. Points need the forward map: for them write the model at rest, output 1, with its array `Displacement`.
 *
 * The file is a MetaImage (.mha) of three float32 values a voxel [mm], with the image's origin, spacing and direction,
 * not compressed. The axes of ITK's physical space go to the patient's left, back and head (LPS), as do those of scans
 * from DICOM, .mha and .nrrd. If the image's world axes go to the right, front and head, set WORLD_RAS. NaN, the
 * background, is written as a displacement far out of any image, so programs show their own background there.
 *
 * Limitations: a program that interpolates between voxels of the field, for example for a finer grid, interpolates
 * across cuts. The image has to be whole in one process.
 *
 * @par Example
 * @code
 * vtkNew<vtkChainMailTransformWriter> writer;
 * writer->SetInputConnection(deformation->GetOutputPort()); // with PullBackOn()
 * writer->SetFileName("deformed-from.mha");
 * writer->Write(); // 1, or 0 after an error
 * @endcode
 *
 * @sa vtkChainMailDeformation
 */

#ifndef vtkChainMailTransformWriter_h
#define vtkChainMailTransformWriter_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkWriter.h"

#include <string> // for FileName

class CHAINMAILFILTERS_EXPORT vtkChainMailTransformWriter : public vtkWriter
{
public:
  static vtkChainMailTransformWriter* New();
  vtkTypeMacro(vtkChainMailTransformWriter, vtkWriter);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Where to write to; the name should end with .mha. Default: "".
   */
  vtkSetStdStringFromCharMacro(FileName);
  vtkGetCharFromStdStringMacro(FileName);
  ///@}

  ///@{
  /**
   * The array of 3 components that is written. Default: "", which means `PullBack`, else `Displacement`.
   */
  vtkSetStdStringFromCharMacro(Field);
  vtkGetCharFromStdStringMacro(Field);
  ///@}

  enum Worlds
  {
    WORLD_LPS = 0,
    WORLD_RAS = 1
  };

  ///@{
  /**
   * Where the image's world axes go in the patient: to the left, back and head (WORLD_LPS, 0), or to the right, front
   * and head (WORLD_RAS, 1). Default: WORLD_LPS.
   */
  vtkSetClampMacro(World, int, WORLD_LPS, WORLD_RAS);
  vtkGetMacro(World, int);
  void SetWorldToLPS() { this->SetWorld(WORLD_LPS); }
  void SetWorldToRAS() { this->SetWorld(WORLD_RAS); }
  ///@}

protected:
  vtkChainMailTransformWriter() = default;
  ~vtkChainMailTransformWriter() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  void WriteData() override;

private:
  vtkChainMailTransformWriter(const vtkChainMailTransformWriter&) = delete;
  void operator=(const vtkChainMailTransformWriter&) = delete;

  std::string FileName;
  std::string Field;
  int World = WORLD_LPS;
};

#endif
