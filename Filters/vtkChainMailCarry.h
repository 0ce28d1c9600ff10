// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailCarry
 * @brief   carry meshes, points and images along with a deformation, or back to rest
 *
 * vtkChainMailDeformation deforms a scan. This filter takes what else there is of the same patient through the same
 * deformation: landmarks, lines, surfaces and meshes, images and labels on any grid. With DIRECTION_FORWARD what lies
 * in the tissue at rest goes to where this tissue is now; with DIRECTION_BACKWARD what was found in the deformed scan
 * goes to where its tissue was. One undoes the other.
 *
 * Both are the map by which the deformation resamples its scan: trilinear between the elements of a cell that belong
 * together, so what lies beside a cut goes with the tissue on its own side. The way back is that map inverted.
 *
 * @section vtkChainMailCarry-inputs Input ports
 *
 * - 0, `Input`: any vtkPointSet, or a vtkImageData on any grid, or a composite dataset of such.
 * - 1, `Deformation`: output 1 of vtkChainMailDeformation, the model at rest, with its arrays `Displacement`, `Element`
 *   and, where something is cut or carved, `Links`. It can be read from a file.
 *
 * Both in the same world axes. The output has the time steps of both.
 *
 * @section vtkChainMailCarry-output Output
 *
 * Of a point set the same with its points moved, each in their own type: cells, arrays and field data are the input's.
 * The active point normals turn with their surface, those of cells are left out; other vectors stay as they are. A cell
 * across a cut is stretched, as its points go with their own sides.
 *
 * Of an image the same grid, with all point arrays resampled as the deformation does: what moved is sampled, what did
 * not keeps its bits, and where tissue went away and none came, where it was carved, and where material comes from
 * outside of the image, there is background. Arrays of labels take the nearest voxel (see LabelArrays). Global ids
 * become an ordinary array; cell arrays are left out, which is warned about once; ghosts and blanks stay.
 *
 * Points in the air go along with the tissue beside them, further away with a mean over more and more of it. On the way
 * back a point that no tissue came to, such as one in an open cut, goes along with the tissue that is nearest now.
 * Carved tissue counts as air here. In images air that no tissue moves stays where it is.
 *
 * An update that fails reports one error, sets the error code, and shows the input as it is, with the message in the
 * field array `Error`.
 *
 * @section vtkChainMailCarry-parallel Pieces and processes
 *
 * The processes of a parallel server (see SetController()) each carry their own part of a point set, or the blocks that
 * they have of a composite dataset. Each gets all of the deformation, and of an image, from which it makes its part.
 *
 * @section vtkChainMailCarry-limitations Limitations
 *
 * Where tissue folded over itself a place has several origins: it gets the one that the deformed scan shows. Points in
 * float32 cannot be more exact than that.
 *
 * @par Example
 * @code
 * vtkNew<vtkChainMailCarry> carry;
 * carry->SetInputConnection(mesh->GetOutputPort());
 * carry->SetDeformationConnection(deformation->GetOutputPort(1));
 * carry->Update();
 * @endcode
 *
 * @sa vtkChainMailDeformation vtkChainMailTransformWriter
 */

#ifndef vtkChainMailCarry_h
#define vtkChainMailCarry_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkPassInputTypeAlgorithm.h"
#include "vtkSmartPointer.h" // for Controller

#include <memory> // for std::unique_ptr
#include <string> // for LabelArrays
#include <vector> // for LabelArrays

class vtkMultiProcessController;

class CHAINMAILFILTERS_EXPORT vtkChainMailCarry : public vtkPassInputTypeAlgorithm
{
public:
  static vtkChainMailCarry* New();
  vtkTypeMacro(vtkChainMailCarry, vtkPassInputTypeAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The producer of the model at rest, input port 1.
  void SetDeformationConnection(vtkAlgorithmOutput* producer) { this->SetInputConnection(1, producer); }

  enum Directions
  {
    DIRECTION_FORWARD = 0,
    DIRECTION_BACKWARD = 1
  };

  ///@{
  /**
   * DIRECTION_FORWARD (0): from rest to where tissue is now. DIRECTION_BACKWARD (1): from the deformed scan to rest.
   * Default: DIRECTION_FORWARD.
   */
  vtkSetClampMacro(Direction, int, DIRECTION_FORWARD, DIRECTION_BACKWARD);
  vtkGetMacro(Direction, int);
  void SetDirectionToForward() { this->SetDirection(DIRECTION_FORWARD); }
  void SetDirectionToBackward() { this->SetDirection(DIRECTION_BACKWARD); }
  ///@}

  enum InterpolationTypes
  {
    INTERPOLATION_LINEAR = 0,
    INTERPOLATION_NEAREST = 1
  };

  ///@{
  /**
   * How arrays of images are sampled: trilinear, integers rounded to the nearest (INTERPOLATION_LINEAR, 0), or at the
   * nearest voxel (INTERPOLATION_NEAREST, 1), as always for arrays that are taken for labels
   * (vtkChainMailScanStatistics), ids, bits, strings and variants. Default: INTERPOLATION_LINEAR.
   */
  vtkSetClampMacro(Interpolation, int, INTERPOLATION_LINEAR, INTERPOLATION_NEAREST);
  vtkGetMacro(Interpolation, int);
  void SetInterpolationToLinear() { this->SetInterpolation(INTERPOLATION_LINEAR); }
  void SetInterpolationToNearest() { this->SetInterpolation(INTERPOLATION_NEAREST); }
  ///@}

  ///@{
  /** Names of point arrays of images that hold labels and so take the nearest voxel. Default: none. */
  void AddLabelArray(const char* name);
  void RemoveLabelArray(const char* name);
  void ClearLabelArrays();
  int GetNumberOfLabelArrays() const;
  const char* GetLabelArray(int index) const;
  bool HasLabelArray(const char* name) const;
  ///@}

  ///@{
  /**
   * Whether an image shows what air is in it (vtkChainMailScanStatistics) where there is nothing to show. Off: its
   * scalars show BackgroundValue. All other arrays show their smallest finite value, by component; bits are 0, strings
   * empty. Default: on.
   */
  vtkSetMacro(FitBackground, bool);
  vtkGetMacro(FitBackground, bool);
  vtkBooleanMacro(FitBackground, bool);
  ///@}

  ///@{
  /** Value of the scalars without FitBackground, brought into the range of their type. Default: 0. */
  vtkSetMacro(BackgroundValue, double);
  vtkGetMacro(BackgroundValue, double);
  ///@}

  ///@{
  /**
   * The processes that update this filter together, as in vtkChainMailDeformation. Null: this process works alone.
   * Default: the global controller.
   */
  void SetController(vtkMultiProcessController* controller);
  vtkMultiProcessController* GetController();
  ///@}

protected:
  vtkChainMailCarry();
  ~vtkChainMailCarry() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestUpdateExtent(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkChainMailCarry(const vtkChainMailCarry&) = delete;
  void operator=(const vtkChainMailCarry&) = delete;

  int Direction = DIRECTION_FORWARD;
  int Interpolation = INTERPOLATION_LINEAR;
  std::vector<std::string> LabelArrays;
  bool FitBackground = true;
  double BackgroundValue = 0.0;
  vtkSmartPointer<vtkMultiProcessController> Controller;
  // The deformation of the last update.
  class vtkInternals;
  std::unique_ptr<vtkInternals> Internals;
};

#endif
