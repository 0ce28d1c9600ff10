// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailLandmarkReader
 * @brief   reads landmarks, in the scan's world axes
 *
 * Reads what other programs save: lists of 3D Slicer (.mrk.json, .fcsv), point files of elastix and transformix (.txt,
 * .pts) and tables (.csv, .tsv, with the columns x, y, z, or l, p, s or r, a, s as Slicer exports them; or without
 * column names, three numbers a row, optionally with a label before them). A table with six numbers a row, or with the
 * columns x1 to z1 and x2 to z2, has pairs: the place of a landmark, and where it goes.
 *
 * The axes of such files point to the patient's left, back and head (LPS) or right, front and head (RAS), and so do
 * those of scans. The output is in the scan's axes, whichever the file has. Files .mrk.json and .fcsv name their axes,
 * but old .fcsv files do not and are RAS; elastix has LPS; for tables `FileWorld` tells. GetReport() tells what was
 * found and what was converted.
 *
 * Output: points, with a vertex each, the string array `Label` and, of pairs, the array `Target` (3). With
 * vtkChainMailLandmarks two lists, or pairs, are probes for vtkChainMailDeformation.
 *
 * Point files that begin with `index` give voxel indices. These are passed on unconverted and marked by the field array
 * `Voxels`; vtkChainMailLandmarks converts them to the positions of these voxels in an image.
 *
 * @sa vtkChainMailLandmarks vtkChainMailMatrixReader
 */

#ifndef vtkChainMailLandmarkReader_h
#define vtkChainMailLandmarkReader_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkPolyDataAlgorithm.h"

#include <string> // for FileName

class CHAINMAILFILTERS_EXPORT vtkChainMailLandmarkReader : public vtkPolyDataAlgorithm
{
public:
  static vtkChainMailLandmarkReader* New();
  vtkTypeMacro(vtkChainMailLandmarkReader, vtkPolyDataAlgorithm);
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
   * The file's axes. FILE_WORLD_AS_SAID (0): as the file or its format says, else the scan's. FILE_WORLD_LPS (1) or
   * FILE_WORLD_RAS (2): LPS or RAS, whatever the file says. Default: FILE_WORLD_AS_SAID.
   */
  vtkSetClampMacro(FileWorld, int, FILE_WORLD_AS_SAID, FILE_WORLD_RAS);
  vtkGetMacro(FileWorld, int);
  void SetFileWorldToAsSaid() { this->SetFileWorld(FILE_WORLD_AS_SAID); }
  void SetFileWorldToLPS() { this->SetFileWorld(FILE_WORLD_LPS); }
  void SetFileWorldToRAS() { this->SetFileWorld(FILE_WORLD_RAS); }
  ///@}

  /**
   * A text about what the last update read, along which axes, and what was converted.
   */
  vtkGetCharFromStdStringMacro(Report);

  /**
   * Whether a file looks like one that this class reads: by its content, or by the name .fcsv.
   */
  int CanReadFile(const char* fileName);

protected:
  vtkChainMailLandmarkReader();
  ~vtkChainMailLandmarkReader() override = default;

  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkChainMailLandmarkReader(const vtkChainMailLandmarkReader&) = delete;
  void operator=(const vtkChainMailLandmarkReader&) = delete;

  std::string FileName;
  int World = WORLD_LPS;
  int FileWorld = FILE_WORLD_AS_SAID;
  std::string Report;
};

#endif
