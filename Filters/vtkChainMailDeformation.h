// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailDeformation
 * @brief   deform a volume like tissue: grab it with probes, cut it with blades, carve parts away
 *
 * Every voxel of the input whose scalar is at least TissueThreshold becomes a ChainMail element; the others are air. An
 * element may follow its face neighbour with some slack: with D_a(i) the constraint of element i along axis a of the
 * image (a fraction of the spacing in [0, 1), from MaterialFunction or ConstraintArray, times the spacing) and u(i) its
 * displacement, every link between two elements i and j obeys
 *
 *     |u_a(i) - u_a(j)| <= D_a(i,j) = (D_a(i) + D_a(j)) / 2                 (C)
 *
 * Elements with D = 0 (bone) are rigid and move as one. An update computes, with MODE_FROM_REST always from rest and so
 * as a function of the inputs alone:
 *
 * 1. Cuts and carves: a link whose segment crosses a polygon of the `Cuts` input is removed, and every element inside a
 *    closed surface of the `Carves` input, with its links.
 * 2. Probes: all probes are held at their displacements t at once, and tissue follows as little as (C) allows:
 *    u_a(i) = clamp(u0_a(i), max_k(t_k - d_a(k,i)), min_k(t_k + d_a(k,i))), with u0 the displacement before (0 at rest)
 *    and d_a the length of the shortest path of links of length D_a. What happens to a probe that would tear the
 *    tissue, ConflictPolicy tells; the array `ProbeReached` tells what each one got. A probe that got less than half of
 *    the length it asks for is warned about, with what holds it, when its wave has come to its end.
 * 3. Relaxation: at most RelaxationIterations steps lower the energy, the sum over links and axes of
 *    (u_a(i) - u_a(j))^2 / D_a(i,j), under (C) and with probes and anchors held.
 * 4. Resampling: output voxel y shows the material at X with X + u(X) = y. Voxels that did not change are copies of the
 *    input, bit for bit; voxels that tissue left show BackgroundValue.
 *
 * Method after "Parallel deformation of heterogeneous ChainMail models: application to interactive deformation of large
 * medical volumes" by Rodriguez, Leon and Arroyo; propagation by envelopes, relaxation by projection and resampling
 * across cuts are this library's own. Both of the published ways are here too: PROPAGATION_TIMESTAMP and
 * RELAXATION_PAPER. The computation runs on an OpenCL device, see Device.
 *
 * @section vtkChainMailDeformation-interactive Interactive use
 *
 * With MODE_INTERACTIVE the state is kept from one update to the next, and only what changed since is applied, at the
 * current deformation, in this order:
 *
 * 1. Every `Cuts` surface that the last update did not have cuts. A surface that moved cuts again at its new place, as
 *    a knife does; one that is gone changes nothing: what is cut stays cut.
 * 2. Every `Carves` surface that the last update did not have carves, likewise. A surface that comes back to where it
 *    was since rest, as Undo in ParaView makes it, brings back no tissue, and is warned about once: Reset() does.
 * 3. Probes. One with the position and radius of a probe that is held already is that probe, and goes where its
 *    `Displacement` says now, counted from where its tissue was when it was grabbed. Any other one grabs the tissue
 *    that is at its position now. Probes that are gone let go of their tissue where it is.
 * 4. Waves travel for at most PropagationIterations, then tissue settles for at most RelaxationIterations. This happens
 *    in every update that the contents of an input or Modified() call for. GetNeedsUpdate() tells whether there is more
 *    to do, and makes the next Update() do it:
 * @code
 * do
 * {
 *   filter->Update();
 *   // show it
 * } while (filter->GetNeedsUpdate());
 * @endcode
 *
 * Other tissue (the image, its scalars, place or spacing, material, anchors, ModelReduction, Device, BrickSize), and
 * switching to this mode, start from rest, and everything that is connected is applied anew. Reset() is the way back to
 * rest. Whether tissue is another is told by the contents of its arrays: equal values in new arrays, from a reader that
 * ran again say, go on from where it was.
 *
 * An update that fails, for a probe in air say, leaves the state usable: the next one goes on from where it was, and a
 * cut that came before the failure is not made twice. One that is stopped (AbortExecute) lets go of all probes and
 * leaves tissue at rest, cuts and carves as they are; the next one grabs anew.
 *
 * @section vtkChainMailDeformation-errors Errors
 *
 * Enumerated properties take any number; one that stands for nothing is an error of the next update.
 *
 * An update that fails reports one error, sets the error code (GetErrorCode()), and goes on showing: both outputs are
 * the last good ones, or the image as it is where there is none that fits it, with the message in the field array
 * `Error`, which good outputs do not have. The pipeline counts it as done, so that views that show the output recover
 * with the next update that succeeds.
 *
 * @section vtkChainMailDeformation-inputs Input ports
 *
 * All positions and vectors are in world axes and in the image's physical units (mm for medical data), whatever the
 * image's extent, origin, spacing and direction matrix.
 *
 * - 0, the image: vtkImageData with point scalars of any numeric type, volume or single slice. Of scalars with several
 *   components the first is read. Scalars that are NaN or infinite are air; their number is warned about once. The
 *   direction matrix has to be orthonormal; flipped axes are fine.
 * - 1, `Probes` (optional, repeatable): vtkPointSet; every point is a probe that grabs tissue. Point arrays:
 *   `Displacement` (3 components, [mm]; needed unless every point is an anchor), `Radius` (optional, [mm], default 0:
 *   the nearest element), `Anchor` (optional, default 0; not 0: the tissue is held where it is). An element has one
 *   holder; a probe whose tissue others hold, or whose tissue was carved away, moves nothing and is warned about once.
 *   Warnings count the probes that they are about and name the first few.
 * - 2, `Cuts` (optional, repeatable): vtkPolyData; polygons and triangle strips are blades. Vertices and lines are
 *   ignored, an empty dataset cuts nothing. One that meets no tissue is warned about once, until it does.
 * - 3, `Carves` (optional, repeatable): vtkPolyData; each input is one closed surface of polygons and triangle strips,
 *   of any number of parts; elements inside it are removed and show BackgroundValue. A surface that is not closed is an
 *   error. Vertices and lines are ignored, an empty dataset carves nothing. One that meets no tissue is warned about
 *   once, until it does.
 *
 * Probes, cuts and carves may be composite datasets: they are what their datasets are together, in order; of carves each
 * dataset that is closed is a surface of its own, and those of one input that are not are parts of one surface. A
 * composite image is an error: one image is deformed at a time. The outputs have the time steps of all inputs together.
 *
 * @section vtkChainMailDeformation-outputs Output ports
 *
 * - 0, the deformed image: the input's geometry, extended by OutputPadding, and all its point arrays, resampled each
 *   in its own type. Global ids are an array like others there, as they are not unique any more. Cell arrays are not
 *   passed on, as they belong to cells of the undeformed grid: they are warned about once. Ghosts and blanks (of
 *   voxels and of cells, `vtkGhostType`) belong to the grid and stay where they are; padding has none.
 * - 1, the model at rest on the input's grid, with the point arrays `Displacement` (3 floats, world axes, [mm]),
 *   `Constraint` (float, fraction of the spacing; 1 component, or 3 along the image's axes; 0 in air), `Element`
 *   (unsigned char: 0 air or carved away, 1 tissue) and `Cluster` (int, number of the rigid cluster, -1 none;
 *   components as `Constraint`). With PropagationTimes also `PropagationTime` (float, components as `Constraint`: how far
 *   along links the last wave that came here had travelled from its probe, the sum of the D of these links [mm]; of 1
 *   component it is that along the image's x axis; -1: no wave came) and `Wavefront` (int, likewise: the number of that
 *   wave since rest, from 1 on; 0 none).
 *
 * Both have the input's field data and these field arrays: `ProbeReached` (3 per probe: the displacement it got since
 * it grabbed, world axes, [mm]), `ProbeForce` (3 per probe: the energy's gradient at the elements it holds, which is
 * what the probe pulls them with, world axes, no unit), `Energy` [mm] (with ElasticRecovery r below 1 only strain of
 * more than (1 - r) D counts), `MaxLinkExcess` (largest violation of (C), fraction of the spacing),
 * `PropagationIterationsUsed`, `RelaxationIterationsUsed`, `CoarseToFineStep` (the share of what came from coarser grids
 * that was taken: 1 all, 0 none; -1 where the last relaxation did not start on any), `DisplacedElements` (elements away
 * from their rest place; also by its deprecated name `ActiveElements`),
 * `Milliseconds` (upload, propagate, relax, resample, download; 0 for what did not have to be done again),
 * `PeakDeviceMemory` (the most that all these filters of the process held on the device during this update [MB]) and
 * `DeviceName`.
 *
 * @section vtkChainMailDeformation-parallel Pieces and processes
 *
 * Whatever piece of the outputs is asked for is that piece of the whole, to the bit: a wave can come from anywhere, so
 * every update asks for all of all inputs and computes the whole, once for all pieces of it. The processes of a parallel
 * server (see SetController()) give their inputs to the first one, which computes for all and hands out the pieces. What
 * several have alike, as of a source that every process can run, counts once; what only some have, probes or parts of
 * the image or of a surface, is put together in order of the processes. Errors and field data are the same everywhere. The
 * first process needs the memory of one that works alone, the others that of their pieces and of what their readers
 * read, which is the whole image where they can. Pieces share the plane of points between them, as those of all images
 * do in VTK: what counts cells or composites volumes counts everything once, what counts points (Histogram) counts these
 * planes twice. They are not marked as duplicates, since volume mappers leave gaps there then.
 *
 * @section vtkChainMailDeformation-limitations Limitations
 *
 * Constraints are geometric limits, not moduli: forces have no physical unit. Links join face neighbours only, so
 * stiffness depends on the directions of the grid. With constraints above 1/3, or between flaps that a cut separates,
 * tissue can fold over itself; the resampling then shows one layer, always the same. At most 2^28 voxels, padding
 * included. In parallel one process computes, so more of them make it neither faster nor the image larger. A knife or a
 * carving tool that moves between two updates works at the places where updates find it, not along its way. The state of
 * MODE_INTERACTIVE is not part of a saved pipeline: a loaded one starts from rest.
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

class vtkMultiProcessController;
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
   * Add, replace or remove the producers of probes (port 1), cuts (port 2) and carves (port 3). Null removes them all.
   */
  void SetProbesConnection(vtkAlgorithmOutput* producer);
  void AddProbesConnection(vtkAlgorithmOutput* producer);
  void SetCutsConnection(vtkAlgorithmOutput* producer);
  void AddCutsConnection(vtkAlgorithmOutput* producer);
  void SetCarvesConnection(vtkAlgorithmOutput* producer);
  void AddCarvesConnection(vtkAlgorithmOutput* producer);
  void RemoveAllProbes() { this->SetProbesConnection(nullptr); }
  void RemoveAllCuts() { this->SetCutsConnection(nullptr); }
  void RemoveAllCarves() { this->SetCarvesConnection(nullptr); }
  ///@}

  /**
   * The model at rest, output port 1.
   */
  vtkImageData* GetModelOutput();

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
  vtkSetMacro(MaterialPreset, int);
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

  enum Modes
  {
    MODE_FROM_REST = 0,
    MODE_INTERACTIVE = 1
  };

  ///@{
  /**
   * MODE_FROM_REST (0): an update computes from rest, so that the output is a function of the inputs and properties
   * alone. MODE_INTERACTIVE (1): an update goes on from the state that the last one left, see above. Default:
   * MODE_FROM_REST.
   */
  vtkSetMacro(Mode, int);
  vtkGetMacro(Mode, int);
  void SetModeToFromRest() { this->SetMode(MODE_FROM_REST); }
  void SetModeToInteractive() { this->SetMode(MODE_INTERACTIVE); }
  ///@}

  /**
   * With MODE_INTERACTIVE: the next update finds tissue at rest, its links whole, what was carved back in place and all
   * probes released. What is connected by then counts as seen and acts again only when it changes (a probe pulled
   * elsewhere, a blade moved) or is connected anew; so that update's output is the input, bit for bit. With
   * MODE_FROM_REST it does nothing.
   */
  void Reset();

  /**
   * Whether another update would change the output though no input or property did: with MODE_INTERACTIVE, after an
   * update that ended before its waves had finished or before relaxation converged, and after Reset(). Where it is true
   * the filter is Modified(), so that the next Update() does it; not where several processes update it together: then
   * call Modified() on each of them. False after an update that failed or was stopped. ParaView's window asks this some
   * times a second and updates the filter for as long as it is true; scripts ask by the property of this name.
   */
  bool GetNeedsUpdate();

  enum PropagationMethods
  {
    PROPAGATION_ENVELOPE = 0,
    PROPAGATION_TIMESTAMP = 1
  };

  ///@{
  /**
   * How a wave of displacement travels. PROPAGATION_ENVELOPE (0): every element into the bounds that moved neighbours
   * set, until nothing changes; where nothing is violated the wave ends. PROPAGATION_TIMESTAMP (1), the published
   * method: one link an iteration, the earliest arrival counts. One wave gives the same displacements either way, to
   * float rounding. With MODE_INTERACTIVE a change finishes the waves that are under way. Default:
   * PROPAGATION_ENVELOPE.
   */
  vtkSetMacro(PropagationMethod, int);
  vtkGetMacro(PropagationMethod, int);
  void SetPropagationMethodToEnvelope() { this->SetPropagationMethod(PROPAGATION_ENVELOPE); }
  void SetPropagationMethodToTimestamp() { this->SetPropagationMethod(PROPAGATION_TIMESTAMP); }
  ///@}

  ///@{
  /**
   * Largest number of propagation iterations of an update, [0, VTK_INT_MAX]; 0: until all waves have ended. With
   * MODE_INTERACTIVE a wave that is under way goes on in the next update; with MODE_FROM_REST the output shows it where
   * it stopped, and links at its front may be longer than (C) allows. Default: 0.
   */
  vtkSetClampMacro(PropagationIterations, int, 0, VTK_INT_MAX);
  vtkGetMacro(PropagationIterations, int);
  ///@}

  enum ConflictPolicies
  {
    CONFLICT_LIMIT = 0,
    CONFLICT_LATEST = 1
  };

  ///@{
  /**
   * What happens where probes pull tissue further apart than it can stretch; anchors hold in any case. CONFLICT_LIMIT
   * (0): the later probe is shortened, along each axis, to what the earlier ones allow. CONFLICT_LATEST (1), as
   * published: the later one gets all, and drags the tissue of the earlier ones along. Default: CONFLICT_LIMIT.
   */
  vtkSetMacro(ConflictPolicy, int);
  vtkGetMacro(ConflictPolicy, int);
  void SetConflictPolicyToLimit() { this->SetConflictPolicy(CONFLICT_LIMIT); }
  void SetConflictPolicyToLatest() { this->SetConflictPolicy(CONFLICT_LATEST); }
  ///@}

  ///@{
  /**
   * Whether output 1 has the arrays PropagationTime and Wavefront; without them updates are faster and need less
   * memory. With MODE_INTERACTIVE a change applies to waves that start from then on. Default: on.
   */
  vtkSetMacro(PropagationTimes, bool);
  vtkGetMacro(PropagationTimes, bool);
  vtkBooleanMacro(PropagationTimes, bool);
  ///@}

  enum RelaxationMethods
  {
    RELAXATION_PROJECTED = 0,
    RELAXATION_PAPER = 1
  };

  ///@{
  /**
   * How tissue settles. RELAXATION_PROJECTED (0): over-relaxation within (C), the energy never rises.
   * RELAXATION_PAPER (1), the published method, for comparison: all elements at once to the weighted mean of their
   * neighbours, whatever (C) says. It leaves links too long (`MaxLinkExcess`), locks rigid tissue, and may go on
   * without end. Default: RELAXATION_PROJECTED.
   */
  vtkSetMacro(RelaxationMethod, int);
  vtkGetMacro(RelaxationMethod, int);
  void SetRelaxationMethodToProjected() { this->SetRelaxationMethod(RELAXATION_PROJECTED); }
  void SetRelaxationMethodToPaper() { this->SetRelaxationMethod(RELAXATION_PAPER); }
  ///@}

  enum RelaxationPresets
  {
    RELAXATION_CUSTOM = 0,
    RELAXATION_FAST = 1,
    RELAXATION_BALANCED = 2,
    RELAXATION_ACCURATE = 3,
    RELAXATION_INTERACTIVE = RELAXATION_FAST ///< deprecated: a mode has that name
  };

  ///@{
  /**
   * How long tissue settles in an update. RELAXATION_CUSTOM (0): as CoarseToFine, RelaxationIterations and
   * RelaxationTolerance say. The others stand for values of these three and leave the properties themselves alone;
   * Data/Choosing.md of the project has their cost and error. RELAXATION_FAST (1), for dragging: off, 10, 1e-3.
   * RELAXATION_BALANCED (2), for a picture: on, 20, 1e-3. RELAXATION_ACCURATE (3), for a measurement:
   * on, 1000, 1e-5. Default: RELAXATION_CUSTOM.
   */
  vtkSetMacro(RelaxationPreset, int);
  vtkGetMacro(RelaxationPreset, int);
  void SetRelaxationPresetToCustom() { this->SetRelaxationPreset(RELAXATION_CUSTOM); }
  void SetRelaxationPresetToFast() { this->SetRelaxationPreset(RELAXATION_FAST); }
  void SetRelaxationPresetToBalanced() { this->SetRelaxationPreset(RELAXATION_BALANCED); }
  void SetRelaxationPresetToAccurate() { this->SetRelaxationPreset(RELAXATION_ACCURATE); }
  void SetRelaxationPresetToInteractive() { this->SetRelaxationPresetToFast(); } ///< deprecated
  ///@}

  ///@{
  /**
   * Whether RELAXATION_PROJECTED starts on coarser grids after a pull, cut or carve: a few iterations then get to where
   * hundreds on the fine grid alone do, for the price of some tens. Tissue then settles as far as it is free to, also
   * far from the probes; what no link joins to tissue that moves stays, however close. Default: off.
   */
  vtkSetMacro(CoarseToFine, bool);
  vtkGetMacro(CoarseToFine, bool);
  vtkBooleanMacro(CoarseToFine, bool);
  ///@}

  ///@{
  /**
   * How much of the strain goes back when tissue is released, r in [0, 1]: strain of a link up to (1 - r) of its limit
   * D costs no energy and stays. 1: elastic, all goes back; 0: plastic, all stays. Default: 1.
   */
  vtkSetClampMacro(ElasticRecovery, double, 0.0, 1.0);
  vtkGetMacro(ElasticRecovery, double);
  ///@}

  ///@{
  /**
   * Largest number of relaxation iterations of an update, [0, VTK_INT_MAX]; 0 is propagation alone. Default: 40.
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

  ///@{
  /**
   * 1, 2, 4 or 8: an element stands for so many voxels along each axis (of more than one voxel). Propagation and
   * relaxation are faster by nearly its cube, and less exact; the rest of an update takes as long as ever, and memory
   * is not less. Images are still resampled, cut and carved voxel by voxel, and both outputs are on the input's grid:
   * displacements are interpolated between elements, on their own side of every cut. An element is where one of its
   * voxels is, and gives as much as they do on average; it is rigid or anchored where one of them is, so bone never
   * bends, but is up to ModelReduction - 1 voxels thicker. Bodies closer than an element may stick together. Energy and
   * forces count as those of the whole model; MaxLinkExcess, DisplacedElements and RelaxationTolerance are of the
   * elements. Any other number is an error. Default: 1.
   */
  vtkSetMacro(ModelReduction, int);
  vtkGetMacro(ModelReduction, int);
  ///@}

  enum InterpolationTypes
  {
    INTERPOLATION_LINEAR = 0,
    INTERPOLATION_NEAREST = 1
  };

  ///@{
  /**
   * How arrays are sampled: INTERPOLATION_LINEAR (0, trilinear, integers rounded to the nearest; voxels that are no
   * tissue and not finite have no weight beside others) or INTERPOLATION_NEAREST (1, nearest voxel). Label arrays, ids
   * and arrays of bits, strings and variants always take the nearest voxel. Default: INTERPOLATION_LINEAR.
   */
  vtkSetMacro(Interpolation, int);
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
   * slice: axes with one voxel are not padded. More than 2^28 voxels with the padding are an error. Default: 0.
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
  vtkSetVector3Macro(BrickSize, int);
  vtkGetVector3Macro(BrickSize, int);
  ///@}

  // Deprecated names of the brick size.
  void SetBlockSize(int x, int y, int z) { this->SetBrickSize(x, y, z); }
  void SetBlockSize(const int size[3]) { this->SetBrickSize(size); }
  int* GetBlockSize() VTK_SIZEHINT(3) { return this->GetBrickSize(); }

  ///@{
  /**
   * The processes that update this filter together, each asking for its own piece, as those of a parallel server do.
   * Null: this process works alone. Default: the global controller.
   */
  void SetController(vtkMultiProcessController* controller);
  vtkMultiProcessController* GetController();
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
  int Mode = MODE_FROM_REST;
  int PropagationMethod = PROPAGATION_ENVELOPE;
  int PropagationIterations = 0;
  int ConflictPolicy = CONFLICT_LIMIT;
  bool PropagationTimes = true;
  int RelaxationMethod = RELAXATION_PROJECTED;
  int RelaxationPreset = RELAXATION_CUSTOM;
  bool CoarseToFine = false;
  double ElasticRecovery = 1.0;
  int RelaxationIterations = 40;
  double RelaxationTolerance = 1e-3;
  int ModelReduction = 1;
  int Interpolation = INTERPOLATION_LINEAR;
  std::vector<std::string> LabelArrays;
  double BackgroundValue;
  int OutputPadding = 0;
  std::string Device;
  int BrickSize[3] = { 0, 0, 0 };
  vtkSmartPointer<vtkStringArray> AvailableDevices;
  vtkSmartPointer<vtkMultiProcessController> Controller;

  // What is kept between updates: the engine's model and simulation, and what they were made from.
  class vtkInternals;
  std::unique_ptr<vtkInternals> Internals;
};

#endif
