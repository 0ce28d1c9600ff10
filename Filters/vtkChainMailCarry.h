// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailCarry
 * @brief   carry meshes, points and images along with a deformation, or back to rest
 *
 * vtkChainMailDeformation deforms a scan. This filter applies the same deformation to other data of the same patient:
 * landmarks, lines, surfaces and meshes, images and labels on any grid. DIRECTION_FORWARD moves what lies in the tissue
 * at rest to where this tissue is now. DIRECTION_BACKWARD moves what was found in the deformed scan to where its tissue
 * was at rest. One is the inverse of the other.
 *
 * The forward map is the one by which the deformation resamples its scan: trilinear in each cell, between those of its
 * elements that are still connected. So what lies beside a cut moves with the tissue on its own side. The backward map
 * is its inverse.
 *
 * @section vtkChainMailCarry-inputs Input ports
 *
 * - 0, `Input`: any vtkPointSet, or a vtkImageData on any grid, or a composite dataset of such.
 * - 1, `Deformation`: output 1 of vtkChainMailDeformation, the model at rest, with its arrays `Displacement`, `Element`
 *   and, where something is cut or carved, `Links`. It can be read from a file.
 *
 * Both inputs have to be in the same world axes. The output has the time steps of both.
 *
 * @section vtkChainMailCarry-output Output
 *
 * For a point set: the same point set with its points moved, in their own type. Cells, arrays and field data are the
 * input's. The active point normals rotate with their surface, cell normals are left out, and other vectors stay as
 * they are. A cell across a cut is stretched because its points move with their own sides.
 *
 * For an image: the same grid, with all point arrays resampled as the deformation does. Voxels whose material moved are
 * sampled; all others keep their bits. Background is shown where tissue left and none came, where tissue was carved
 * away, and where material comes from outside of the image. Arrays of labels take the nearest voxel (see LabelArrays).
 * Global ids become an ordinary array. Cell arrays are left out, which is warned about once. Ghost and blank marks stay
 * in place.
 *
 * Points in the air move with the nearby tissue; the further away they are, the more tissue their mean displacement
 * includes. In the backward map a point that no tissue came to, such as one in an open cut, moves with the tissue that
 * is nearest now. Carved tissue counts as air here. In images, air that no tissue moves stays where it is.
 *
 * An update that fails reports one error, sets the error code, and shows the input as it is, with the message in the
 * field array `Error`.
 *
 * @section vtkChainMailCarry-parallel Pieces and processes
 *
 * The processes of a parallel server (see SetController()) each carry their own part of a point set, or their own
 * blocks of a composite dataset. Each process gets the whole deformation, and the whole of an image, of which it
 * computes its part.
 *
 * @section vtkChainMailCarry-limitations Limitations
 *
 * Where tissue folded over itself a place has several origins; the one that the deformed scan shows is taken. Points
 * stored in float32 are only as accurate as float32.
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
   * nearest voxel (INTERPOLATION_NEAREST, 1). Arrays that are taken for labels (vtkChainMailScanStatistics), ids, bits,
   * strings and variants always take the nearest voxel. Default: INTERPOLATION_LINEAR.
   */
  vtkSetClampMacro(Interpolation, int, INTERPOLATION_LINEAR, INTERPOLATION_NEAREST);
  vtkGetMacro(Interpolation, int);
  void SetInterpolationToLinear() { this->SetInterpolation(INTERPOLATION_LINEAR); }
  void SetInterpolationToNearest() { this->SetInterpolation(INTERPOLATION_NEAREST); }
  ///@}

  ///@{
  /** Names of point arrays of images that hold labels, which are sampled at the nearest voxel. Default: none. */
  void AddLabelArray(const char* name);
  void RemoveLabelArray(const char* name);
  void ClearLabelArrays();
  int GetNumberOfLabelArrays() const;
  const char* GetLabelArray(int index) const;
  bool HasLabelArray(const char* name) const;
  ///@}

  ///@{
  /**
   * Whether the background of an image is the value of air in it (vtkChainMailScanStatistics). Off: the background of
   * the scalars is BackgroundValue. The background of all other arrays is their smallest finite value, by component;
   * bits are 0, strings empty. Default: on.
   */
  vtkSetMacro(FitBackground, bool);
  vtkGetMacro(FitBackground, bool);
  vtkBooleanMacro(FitBackground, bool);
  ///@}

  ///@{
  /** Background of the scalars without FitBackground, clamped to the range of their type. Default: 0. */
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
