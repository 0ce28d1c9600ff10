// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailDeformation
 * @brief   deform a volume like tissue: grab it with probes, cut it with blades
 *
 * Every voxel of the input whose scalar is at least TissueThreshold becomes a ChainMail element; the others are air. An
 * element may follow its face neighbour with some slack: with D_a(i) the constraint of element i along axis a of the
 * image (a fraction of the spacing in [0, 1), from MaterialFunction or ConstraintArray, times the spacing) and u(i) its
 * displacement, every link between two elements i and j obeys
 *
 *     |u_a(i) - u_a(j)| <= D_a(i,j) = (D_a(i) + D_a(j)) / 2                 (C)
 *
 * Elements with D = 0 (bone) are rigid and move as one. An update computes, always from rest and so as a function of
 * the inputs alone:
 *
 * 1. Cuts: a link whose segment crosses a polygon of the `Cuts` input is removed.
 * 2. Probes: all probes are held at their displacements t at once, and tissue follows as little as (C) allows:
 *    u_a(i) = clamp(0, max_k(t_k - d_a(k,i)), min_k(t_k + d_a(k,i))), with d_a the length of the shortest path of links
 *    of length D_a. A probe that would tear the tissue is shortened: earlier probes and anchors win over later ones.
 *    The array `ProbeReached` tells what each one got.
 * 3. Relaxation: at most RelaxationIterations steps lower the energy, the sum over links and axes of
 *    (u_a(i) - u_a(j))^2 / D_a(i,j), under (C) and with probes and anchors held.
 * 4. Resampling: output voxel y shows the material at X with X + u(X) = y. Voxels that did not change are copies of the
 *    input, bit for bit; voxels that tissue left show BackgroundValue.
 *
 * Method after "Parallel deformation of heterogeneous ChainMail models: application to interactive deformation of large
 * medical volumes" by Rodriguez, Leon and Arroyo; propagation by envelopes, relaxation by projection and resampling
 * across cuts are this library's own. The computation runs on an OpenCL device, see Device.
 *
 * @section vtkChainMailDeformation-inputs Input ports
 *
 * All positions and vectors are in world axes and in the image's physical units (mm for medical data), whatever the
 * image's extent, origin, spacing and direction matrix.
 *
 * - 0, the image: vtkImageData with point scalars of any numeric type, volume or single slice. Of scalars with several
 *   components the first is read. Scalars that are NaN or infinite are air; their number is warned about once. The
 *   direction matrix has to be orthonormal; flipped axes are fine.
 * - 1, `Probes` (optional, repeatable): vtkPointSet; every point is a probe that grabs tissue at rest. Point arrays:
 *   `Displacement` (3 components, [mm]; needed unless every point is an anchor), `Radius` (optional, [mm], default 0:
 *   the nearest element), `Anchor` (optional, default 0; not 0: the tissue is held where it is).
 * - 2, `Cuts` (optional, repeatable): vtkPolyData; polygons and triangle strips are blades. Vertices and lines are
 *   ignored, an empty dataset cuts nothing.
 *
 * @section vtkChainMailDeformation-outputs Output ports
 *
 * - 0, the deformed image: the input's geometry, extended by OutputPadding, and all its point arrays, resampled each
 *   in its own type. Cell arrays are not passed on: they belong to cells of the undeformed grid.
 * - 1, the model at rest on the input's grid, with the point arrays `Displacement` (3 floats, world axes, [mm]),
 *   `Constraint` (float, fraction of the spacing; 1 component, or 3 along the image's axes; 0 in air), `Element`
 *   (unsigned char: 0 air, 1 tissue) and `Cluster` (int, number of the rigid cluster, -1 none; components as
 *   `Constraint`).
 *
 * Both have the input's field data and these field arrays: `ProbeReached` (3 per probe: the displacement it got, world
 * axes, [mm]), `ProbeForce` (3 per probe: the energy's gradient at the elements it holds, which is what the hand pulls
 * them with, world axes, no unit), `Energy` [mm], `MaxLinkExcess` (largest violation of (C), fraction of the
 * spacing), `RelaxationIterationsUsed`, `ActiveElements` (elements away from their rest place), `Milliseconds` (upload,
 * propagate, relax, resample, download; 0 for what this update did not have to do again) and `DeviceName`.
 *
 * @section vtkChainMailDeformation-limitations Limitations
 *
 * Constraints are geometric limits, not moduli: forces have no physical unit. Links join face neighbours only, so
 * stiffness depends on the directions of the grid. With constraints above 1/3, or between flaps that a cut separates,
 * tissue can fold over itself; the resampling then shows one layer, always the same. At most 2^28 voxels. In parallel
 * every process computes the whole image.
 *
 * @sa vtkChainMailProbeSource
 */

#ifndef vtkChainMailDeformation_h
#define vtkChainMailDeformation_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkImageAlgorithm.h"
#include "vtkSmartPointer.h" // for MaterialFunction

#include <memory> // for std::unique_ptr
#include <string> // for std::string
#include <vector> // for LabelArrays

class vtkPiecewiseFunction;
class vtkStringArray;

class CHAINMAILFILTERS_EXPORT vtkChainMailDeformation : public vtkImageAlgorithm
{
public:
  static vtkChainMailDeformation* New();
  vtkTypeMacro(vtkChainMailDeformation, vtkImageAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Add, replace or remove the producers of probes (port 1) and cuts (port 2). Null removes them all.
   */
  void SetProbesConnection(vtkAlgorithmOutput* producer);
  void AddProbesConnection(vtkAlgorithmOutput* producer);
  void SetCutsConnection(vtkAlgorithmOutput* producer);
  void AddCutsConnection(vtkAlgorithmOutput* producer);
  void RemoveAllProbes() { this->SetProbesConnection(nullptr); }
  void RemoveAllCuts() { this->SetCutsConnection(nullptr); }
  ///@}

  /**
   * The model at rest, output port 1.
   */
  vtkImageData* GetModelOutput();

  /**
   * Where the material comes from, see SetMaterialPreset().
   */
  enum MaterialPresets
  {
    MATERIAL_FUNCTION = 0,
    MATERIAL_CT = 1,
    MATERIAL_MR = 2
  };

  ///@{
  /**
   * MATERIAL_FUNCTION (0): MaterialFunction and TissueThreshold apply. MATERIAL_CT (1): scalars are Hounsfield units,
   * air is below -300, skin and fat are soft, spongy bone is stiff, compact bone is rigid from 600 up (contrast agent
   * ends below that). MATERIAL_MR (2): T1-weighted, any range: air below a tenth of the finite range, fat (bright)
   * softer than muscle, nothing rigid as bone is as dark as air. The presets bring their own threshold:
   * MaterialFunction and TissueThreshold are not read. Default: MATERIAL_FUNCTION.
   */
  vtkSetClampMacro(MaterialPreset, int, MATERIAL_FUNCTION, MATERIAL_MR);
  vtkGetMacro(MaterialPreset, int);
  void SetMaterialPresetToFunction() { this->SetMaterialPreset(MATERIAL_FUNCTION); }
  void SetMaterialPresetToCT() { this->SetMaterialPreset(MATERIAL_CT); }
  void SetMaterialPresetToMR() { this->SetMaterialPreset(MATERIAL_MR); }
  ///@}

  ///@{
  /**
   * Scalar -> constraint as a fraction of the spacing. Every node has to lie in [0, 1); 0 is rigid. Default: null, the
   * function that FitMaterial() fits to the finite range of the scalars.
   */
  virtual void SetMaterialFunction(vtkPiecewiseFunction* function);
  vtkPiecewiseFunction* GetMaterialFunction();
  ///@}

  ///@{
  /**
   * Name of a point array that gives the constraint itself, as a fraction of the spacing in [0, 1): 1 component, or 3
   * for the image's axes. It wins over the material function, not over TissueThreshold. Default: "", none.
   */
  vtkSetStdStringFromCharMacro(ConstraintArray);
  vtkGetCharFromStdStringMacro(ConstraintArray);
  ///@}

  ///@{
  /**
   * Voxels with a smaller scalar are air. Any number; NaN: the threshold that FitMaterial() fits to the finite range of
   * the scalars. Default: NaN.
   */
  virtual void SetTissueThreshold(double threshold);
  vtkGetMacro(TissueThreshold, double);
  ///@}

  /**
   * A material for scalars of the given range. A signed, CT-like range (range[0] < -200): as MATERIAL_CT. Any other
   * range has no unit and bone cannot be told: air is below a tenth of the range and stiffness grows with the scalar
   * without ever becoming rigid. `function` is emptied and filled; it may be null.
   */
  static void FitMaterial(const double range[2], double& tissueThreshold, vtkPiecewiseFunction* function);

  /**
   * The material of a preset for scalars of the given range; MATERIAL_FUNCTION is FitMaterial().
   */
  static void GetPresetMaterial(
    int preset, const double range[2], double& tissueThreshold, vtkPiecewiseFunction* function);

  ///@{
  /**
   * Hold all rigid tissue (constraint 0) where it is. Default: off.
   */
  vtkSetMacro(AnchorRigid, bool);
  vtkGetMacro(AnchorRigid, bool);
  vtkBooleanMacro(AnchorRigid, bool);
  ///@}

  ///@{
  /**
   * Hold the tissue that touches these faces of the image where it is, since the body goes on beyond the scan there:
   * x- x+ y- y+ z- z+ along the image's axes, 0 is free. An axis with a single voxel has no faces. Default: 1 1 1 1
   * 1 1.
   */
  vtkSetVector6Macro(AnchoredFaces, int);
  vtkGetVector6Macro(AnchoredFaces, int);
  ///@}

  ///@{
  /**
   * Largest number of relaxation iterations, [0, VTK_INT_MAX]; 0 is propagation alone. Default: 40.
   */
  vtkSetClampMacro(RelaxationIterations, int, 0, VTK_INT_MAX);
  vtkGetMacro(RelaxationIterations, int);
  ///@}

  ///@{
  /**
   * Relaxation stops when no element moved more than this fraction of the spacing in one iteration,
   * [0, VTK_DOUBLE_MAX]. Default: 1e-3.
   */
  vtkSetClampMacro(RelaxationTolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(RelaxationTolerance, double);
  ///@}

  enum InterpolationTypes
  {
    INTERPOLATION_LINEAR = 0,
    INTERPOLATION_NEAREST = 1
  };

  ///@{
  /**
   * How arrays are sampled: INTERPOLATION_LINEAR (0, trilinear, integers rounded to the nearest) or
   * INTERPOLATION_NEAREST (1, nearest voxel). Label arrays, `vtkGhostType` and arrays of bits, strings and variants
   * always take the nearest voxel. Default: INTERPOLATION_LINEAR.
   */
  vtkSetClampMacro(Interpolation, int, INTERPOLATION_LINEAR, INTERPOLATION_NEAREST);
  vtkGetMacro(Interpolation, int);
  void SetInterpolationToLinear() { this->SetInterpolation(INTERPOLATION_LINEAR); }
  void SetInterpolationToNearest() { this->SetInterpolation(INTERPOLATION_NEAREST); }
  ///@}

  ///@{
  /**
   * Names of the point arrays that hold labels and so take the nearest voxel. Every name has to be one of the input's
   * point arrays. Default: none.
   */
  void AddLabelArray(const char* name);
  void RemoveLabelArray(const char* name);
  void ClearLabelArrays();
  int GetNumberOfLabelArrays() const;
  const char* GetLabelArray(int index) const;
  bool HasLabelArray(const char* name) const;
  ///@}

  ///@{
  /**
   * Value of the scalars (the array that the material function reads) where tissue was and is no more, and in the
   * padding; brought into the range of the array's type. Other arrays show their own smallest finite value there, by
   * component, bits 0 and strings nothing. NaN: so do the scalars. Default: NaN.
   */
  virtual void SetBackgroundValue(double value);
  vtkGetMacro(BackgroundValue, double);
  ///@}

  ///@{
  /**
   * Voxels added on every side of output 0, for tissue that leaves the image, [0, 4096]. A single slice stays a single
   * slice: axes with one voxel are not padded. Default: 0.
   */
  vtkSetClampMacro(OutputPadding, int, 0, 4096);
  vtkGetMacro(OutputPadding, int);
  ///@}

  ///@{
  /**
   * The OpenCL device: a part of its name, upper and lower case are the same. Default: "", the best GPU, else the best
   * other device.
   */
  vtkSetStdStringFromCharMacro(Device);
  vtkGetCharFromStdStringMacro(Device);
  ///@}

  /**
   * Names of the OpenCL devices of this machine, best first; empty when there is none. The array belongs to the filter
   * and is filled anew by every call.
   */
  vtkStringArray* GetAvailableDevices();

  ///@{
  /**
   * Elements per brick, the unit of memory and work on the device: each 0 or a power of two, x in [4, 64], y and z in
   * [2, 32]; 0 is the best for the device. Changes speed alone, no result. Default: 0 0 0.
   */
  vtkSetVector3Macro(BlockSize, int);
  vtkGetVector3Macro(BlockSize, int);
  ///@}

  /**
   * Includes the material function's.
   */
  vtkMTimeType GetMTime() override;

protected:
  vtkChainMailDeformation();
  ~vtkChainMailDeformation() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestUpdateExtent(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkChainMailDeformation(const vtkChainMailDeformation&) = delete;
  void operator=(const vtkChainMailDeformation&) = delete;

  int MaterialPreset = MATERIAL_FUNCTION;
  vtkSmartPointer<vtkPiecewiseFunction> MaterialFunction;
  std::string ConstraintArray;
  double TissueThreshold;
  bool AnchorRigid = false;
  int AnchoredFaces[6] = { 1, 1, 1, 1, 1, 1 };
  int RelaxationIterations = 40;
  double RelaxationTolerance = 1e-3;
  int Interpolation = INTERPOLATION_LINEAR;
  std::vector<std::string> LabelArrays;
  double BackgroundValue;
  int OutputPadding = 0;
  std::string Device;
  int BlockSize[3] = { 0, 0, 0 };
  vtkSmartPointer<vtkStringArray> AvailableDevices;

  // What is kept between updates: the engine's model and simulation, and what they were made from.
  class vtkInternals;
  std::unique_ptr<vtkInternals> Internals;
};

#endif
