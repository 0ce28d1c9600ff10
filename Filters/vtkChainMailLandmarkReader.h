// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailLandmarkReader
 * @brief   reads landmarks, in the scan's world axes
 *
 * Reads what other programs save: lists of 3D Slicer (.mrk.json, .fcsv), point files of elastix and transformix (.txt,
 * .pts) and tables (.csv, .tsv, with the columns x, y, z, or l, p, s or r, a, s as Slicer exports them; or without
 * names, three numbers a row, a label before them if wanted). A table of six numbers a row, or of the columns x1 to z1
 * and x2 to z2, has pairs: where a landmark is, and where it goes.
 *
 * Such files count to the patient's left, back and head (LPS) or right, front and head (RAS), and so do scans. The
 * output is in the scan's axes, whichever the file has: .mrk.json and .fcsv say it, old .fcsv are RAS, elastix has LPS,
 * of tables `FileWorld` says it. GetReport() says what was found and what was converted.
 *
 * Output: points, with a vertex each, the string array `Label` and, of pairs, the array `Target` (3). With
 * vtkChainMailLandmarks two lists, or pairs, are probes for vtkChainMailDeformation.
 *
 * Points that are counted in voxels (point files that begin with `index`) come out as they are, and the field array
 * `Voxels` says so: vtkChainMailLandmarks puts them where these voxels of an image are.
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
   * Where the file's axes go: as the file or its format says, and as the scan's where neither does
   * (FILE_WORLD_AS_SAID, 0); or LPS (FILE_WORLD_LPS, 1) or RAS (FILE_WORLD_RAS, 2), whatever the file says. Default:
   * FILE_WORLD_AS_SAID.
   */
  vtkSetClampMacro(FileWorld, int, FILE_WORLD_AS_SAID, FILE_WORLD_RAS);
  vtkGetMacro(FileWorld, int);
  void SetFileWorldToAsSaid() { this->SetFileWorld(FILE_WORLD_AS_SAID); }
  void SetFileWorldToLPS() { this->SetFileWorld(FILE_WORLD_LPS); }
  void SetFileWorldToRAS() { this->SetFileWorld(FILE_WORLD_RAS); }
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
