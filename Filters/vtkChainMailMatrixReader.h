// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailMatrixReader
 * @brief   reads matrices of bones as probes that turn
 *
 * A matrix moves a body, a bone as a rule: what is at x at rest goes to M x, both in mm. This class reads
 * - transforms of ITK, ANTs, elastix' kin and 3D Slicer as text (.tfm, .txt) and in Matlab's format (.mat): affine ones
 *   and all rigid ones, and composites of these;
 * - 4 x 4 numbers as text, row by row;
 * - tables (.csv) with a matrix for each body: a label, as in the `BodyArray` of vtkChainMailDeformation, and 16
 * numbers a row, row by row.
 *
 * The output is for the `Probes` of vtkChainMailDeformation: a point for each matrix, with `Displacement`, `Rotation`
 * [degrees], `Centre`, `Body` and `Matrix`. A matrix that is no rotation and shift is an error that says how far off it
 * is; off by up to 1e-4, as by few digits in a file, it is put right.
 *
 * Direction: transforms of ITK take a point of the fixed image to the moving one. So as it is the matrix of a
 * registration moves the bones of the fixed scan to where they are in the moving one; to deform the moving scan,
 * Invert. 3D Slicer, too, writes the inverse of the transform that its window shows: Invert.
 *
 * Axes: transforms of ITK are LPS; of 4 x 4 numbers and tables `FileWorld` says it, else they have the scan's axes.
 * GetReport() says what was found and what was converted.
 *
 * The centre about which a body turns on its way is that of ITK's transform, else a point on the axis of the rotation.
 * vtkChainMailMatrices takes the middle of each body instead.
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
   * Where the file's axes go: as its format says, and as the scan's where that does not (FILE_WORLD_AS_SAID, 0); or LPS
   * (FILE_WORLD_LPS, 1) or RAS (FILE_WORLD_RAS, 2), whatever the format says. Default: FILE_WORLD_AS_SAID.
   */
  vtkSetClampMacro(FileWorld, int, FILE_WORLD_AS_SAID, FILE_WORLD_RAS);
  vtkGetMacro(FileWorld, int);
  void SetFileWorldToAsSaid() { this->SetFileWorld(FILE_WORLD_AS_SAID); }
  void SetFileWorldToLPS() { this->SetFileWorld(FILE_WORLD_LPS); }
  void SetFileWorldToRAS() { this->SetFileWorld(FILE_WORLD_RAS); }
  ///@}

  ///@{
  /**
   * Take the way back instead, as for the moving scan of a registration and for transforms of 3D Slicer. Default: off.
   */
  vtkSetMacro(Invert, bool);
  vtkGetMacro(Invert, bool);
  vtkBooleanMacro(Invert, bool);
  ///@}

  ///@{
  /**
   * The label of the body that the one matrix of a file without labels moves, [-1, VTK_INT_MAX]; -1 is the body at
   * Position. Default: -1.
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
   * What the last update read, along which axes, and what was converted, in words.
   */
  vtkGetCharFromStdStringMacro(Report);

  /**
   * Whether a file looks like one that this class reads.
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
