// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailMatrices
 * @brief   a table of matrices, one for each bone, as probes that turn
 *
 * A matrix M moves a body, usually a bone: from x at rest to M x, in mm along the scan's world axes. The input has a
 * label, as in the `BodyArray` of vtkChainMailDeformation, and 16 numbers a row: a vtkTable whose columns are, in this
 * order, the label and the matrix row by row; or a data set with the point arrays `Body` (1) and `Matrix` (16), as
 * vtkChainMailMatrixReader makes it.
 *
 * With the image of the labels (port 1), each body rotates about its own centroid, where its probe is, too. So bodies
 * take the shortest path, and the probes are seen at their bones. Without this image each body rotates about a point on
 * the axis of its rotation. The final pose is the same.
 *
 * The output is for the `Probes` of vtkChainMailDeformation: a point for each matrix, with `Displacement`, `Rotation`
 * [degrees], `Centre`, `Body` and `Matrix`. A matrix that is not rigid (a rotation and a translation) is an error that
 * names its row.
 *
 * The image of labels may come in pieces, on the processes of a parallel server.
 *
 * @sa vtkChainMailMatrixReader vtkChainMailDeformation
 */

#ifndef vtkChainMailMatrices_h
#define vtkChainMailMatrices_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkPolyDataAlgorithm.h"

#include <string> // for LabelArray

class CHAINMAILFILTERS_EXPORT vtkChainMailMatrices : public vtkPolyDataAlgorithm
{
public:
  static vtkChainMailMatrices* New();
  vtkTypeMacro(vtkChainMailMatrices, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The image of the labels, port 1; optional.
   */
  void SetLabelsConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(1, output); }
  void SetLabelsData(vtkDataObject* data) { this->SetInputData(1, data); }
  ///@}

  ///@{
  /**
   * The point array of that image with the labels. Default: "", its active scalars.
   */
  vtkSetStdStringFromCharMacro(LabelArray);
  vtkGetCharFromStdStringMacro(LabelArray);
  ///@}

  ///@{
  /**
   * Take the inverse of each matrix instead. Default: off.
   */
  vtkSetMacro(Invert, bool);
  vtkGetMacro(Invert, bool);
  vtkBooleanMacro(Invert, bool);
  ///@}

  /**
   * A text about what the last update made.
   */
  vtkGetCharFromStdStringMacro(Report);

protected:
  vtkChainMailMatrices();
  ~vtkChainMailMatrices() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestUpdateExtent(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkChainMailMatrices(const vtkChainMailMatrices&) = delete;
  void operator=(const vtkChainMailMatrices&) = delete;

  std::string LabelArray;
  bool Invert = false;
  std::string Report;
};

#endif
