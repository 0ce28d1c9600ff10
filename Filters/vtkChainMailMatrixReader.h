// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailMatrixReader
 * @brief   reads matrices of bones as probes that turn
 *
 * A matrix M moves a body, usually a bone: from x at rest to M x, both in mm. This class reads
 * - transforms of ITK, ANTs, programs related to elastix and 3D Slicer as text (.tfm, .txt) and in Matlab's format
 *   (.mat): affine ones and all rigid ones, and composites of these;
 * - 4 x 4 numbers as text, row by row;
 * - tables (.csv) with a matrix for each body: a label, as in the `BodyArray` of vtkChainMailDeformation, and 16
 * numbers a row, row by row.
 *
 * The output is for the `Probes` of vtkChainMailDeformation: a point for each matrix, with `Displacement`, `Rotation`
 * [degrees], `Centre`, `Body` and `Matrix`. A matrix that is not rigid (a rotation and a translation) is an error that
 * gives its deviation. Deviations up to 1e-4, from few digits in a file, are corrected.
 *
 * Direction: transforms of ITK map points of the fixed image to the moving one. So without Invert the matrix of a
 * registration moves the bones of the fixed scan to where they are in the moving scan. To deform the moving scan, use
 * Invert. 3D Slicer writes the inverse of the transform that its window shows: use Invert, too.
 *
 * Axes: transforms of ITK are LPS. Files with 4 x 4 numbers and tables have the axes of `FileWorld`, else the scan's.
 * GetReport() tells what was found and what was converted.
 *
 * A body rotates about the centre of ITK's transform, else about a point on the axis of the rotation.
 * vtkChainMailMatrices takes the centroid of each body instead.
 *
 * @sa vtkChainMailMatrices vtkChainMailLandmarkReader
 */

#ifndef vtkChainMailMatrixReader_h
#define vtkChainMailMatrixReader_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkPolyDataAlgorithm.h"

#include <string> // for FileName

class CHAINMAILFILTERS_EXPORT vtkChainMailMatrixReader : public vtkPolyDataAlgorithm
{
public:
  static vtkChainMailMatrixReader* New();
  vtkTypeMacro(vtkChainMailMatrixReader, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The file to read. Default: "".
   */
  vtkSetStdStringFromCharMacro(FileName);
  vtkGetCharFromStdStringMacro(FileName);
  ///@}

  enum Worlds
  {
    WORLD_LPS = 0,
    WORLD_RAS = 1
  };

  ///@{
  /**
   * Where the scan's world axes go in the patient: to the left, back and head (WORLD_LPS, 0: DICOM, MetaImage, NRRD),
   * or to the right, front and head (WORLD_RAS, 1: NIfTI). Default: WORLD_LPS.
   */
  vtkSetClampMacro(World, int, WORLD_LPS, WORLD_RAS);
  vtkGetMacro(World, int);
  void SetWorldToLPS() { this->SetWorld(WORLD_LPS); }
  void SetWorldToRAS() { this->SetWorld(WORLD_RAS); }
  ///@}

  enum FileWorlds
  {
    FILE_WORLD_AS_SAID = 0,
    FILE_WORLD_LPS = 1,
    FILE_WORLD_RAS = 2
  };

  ///@{
  /**
   * The file's axes. FILE_WORLD_AS_SAID (0): as its format says, else the scan's. FILE_WORLD_LPS (1) or FILE_WORLD_RAS
   * (2): LPS or RAS, whatever the format says. Default: FILE_WORLD_AS_SAID.
   */
  vtkSetClampMacro(FileWorld, int, FILE_WORLD_AS_SAID, FILE_WORLD_RAS);
  vtkGetMacro(FileWorld, int);
  void SetFileWorldToAsSaid() { this->SetFileWorld(FILE_WORLD_AS_SAID); }
  void SetFileWorldToLPS() { this->SetFileWorld(FILE_WORLD_LPS); }
  void SetFileWorldToRAS() { this->SetFileWorld(FILE_WORLD_RAS); }
  ///@}

  ///@{
  /**
   * Take the inverse instead, as for the moving scan of a registration and for transforms of 3D Slicer. Default: off.
   */
  vtkSetMacro(Invert, bool);
  vtkGetMacro(Invert, bool);
  vtkBooleanMacro(Invert, bool);
  ///@}

  ///@{
  /**
   * The label of the body that the matrix moves, [-1, VTK_INT_MAX], for a file without labels, which has one matrix;
   * -1: the body at Position. Default: -1.
   */
  vtkSetClampMacro(Body, int, -1, VTK_INT_MAX);
  vtkGetMacro(Body, int);
  ///@}

  ///@{
  /**
   * A place in that body, at rest, where Body is -1 [mm]. Default: 0 0 0.
   */
  vtkSetVector3Macro(Position, double);
  vtkGetVector3Macro(Position, double);
  ///@}

  /**
   * A text about what the last update read, along which axes, and what was converted.
   */
  vtkGetCharFromStdStringMacro(Report);

  /**
   * Whether the content of a file looks like one that this class reads.
   */
  int CanReadFile(const char* fileName);

protected:
  vtkChainMailMatrixReader();
  ~vtkChainMailMatrixReader() override = default;

  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkChainMailMatrixReader(const vtkChainMailMatrixReader&) = delete;
  void operator=(const vtkChainMailMatrixReader&) = delete;

  std::string FileName;
  int World = WORLD_LPS;
  int FileWorld = FILE_WORLD_AS_SAID;
  bool Invert = false;
  int Body = -1;
  double Position[3] = { 0.0, 0.0, 0.0 };
  std::string Report;
};

#endif
