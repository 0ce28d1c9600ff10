// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailDeformation
 * @brief   deform a volume like tissue: grab it with probes, cut it with blades, carve parts away
 *
 * Every voxel of the input whose scalar is at least TissueThreshold becomes a ChainMail element; the others are air. An
 * element follows its face neighbours with some slack. Let D_a(i) be the constraint of element i along axis a of the
 * image: a fraction of the spacing in [0, 1), from MaterialFunction or ConstraintArray, times the spacing. With the
 * displacement u(i), every link between two elements i and j obeys
 *
 *     |u_a(i) - u_a(j)| <= D_a(i,j) = (D_a(i) + D_a(j)) / 2                 (C)
 *
 * Elements with D = 0 (bone) are rigid and move as one. An update takes four steps. With MODE_FROM_REST it always
 * begins at rest, so that its result is a function of the inputs alone.
 *
 * 1. Cuts and carves: removes every link whose segment crosses a polygon of the `Cuts` input, and every element inside
 *    a closed surface of the `Carves` input, with its links.
 * 2. Probes: holds all probes at their displacements t at once, and tissue follows as little as (C) allows:
 *    u_a(i) = clamp(u0_a(i), max_k(t_k - d_a(k,i)), min_k(t_k + d_a(k,i))), with u0 the displacement before (0 at rest)
 *    and d_a the length of the shortest path of links of length D_a. ConflictPolicy says what happens to a probe that
 *    would tear the tissue; the array `ProbeReached` says how far each one came. When its wave has come to its end, a
 *    probe that got less than half of the length it asks for is warned about, with what holds it.
 * 3. Relaxation: in at most RelaxationIterations steps lowers the energy, the sum over links and axes of
 *    (u_a(i) - u_a(j))^2 / D_a(i,j), under (C) and with probes and anchors held.
 * 4. Resampling: output voxel y shows the material at X with X + u(X) = y. Voxels that did not change are copies of the
 *    input, bit for bit; voxels that tissue left show BackgroundValue.
 *
 * Method after "Parallel deformation of heterogeneous ChainMail models: application to interactive deformation of large
 * medical volumes" by Rodriguez, Leon and Arroyo. Propagation by envelopes, relaxation by projection and resampling
 * across cuts are this library's own. The published propagation and relaxation are here as well: PROPAGATION_TIMESTAMP
 * and RELAXATION_PAPER. Data/Method.md of the project has the details and all sources.
 *
 * The computation runs on an OpenCL device, see Device. As with any VTK algorithm, a filter is for one thread at a time.
 *
 * @section vtkChainMailDeformation-interactive Interactive use
 *
 * With MODE_INTERACTIVE the state is kept from one update to the next. Only changes since the last update are applied,
 * to the tissue as it is deformed now, in this order:
 *
 * 1. Every `Cuts` surface that the last update did not have cuts. A surface that moved cuts again at its new place, as
 *    a knife does. A surface that is gone changes nothing: cuts stay.
 * 2. Every `Carves` surface that the last update did not have carves, likewise. A surface that comes back to where it
 *    was since rest, as with Undo in ParaView, is warned about once: it brings back no tissue, Reset() does.
 * 3. Probes. A probe with the position and radius of one that is already held is that same probe; it goes to its
 *    present `Displacement`, counted from where its tissue was when it was grabbed. Any other probe grabs the tissue
 *    that is at its position now. Probes that are gone let go of their tissue where it is.
 * 4. Waves travel for at most PropagationIterations, then tissue settles for at most RelaxationIterations. This happens
 *    in every update that a changed input or Modified() calls for. GetNeedsUpdate() tells whether there is more to do,
 *    and makes the next Update() do it:
 * `do { filter->Update(); show(); } while (filter->GetNeedsUpdate());`
 *
 * Other tissue (the image, its scalars, place or spacing, material, anchors, ModelReduction, Device, BrickSize), or
 * switching to this mode, starts from rest and applies everything that is connected. Reset() is the way back to rest.
 * Equal values in new arrays, say from a reader that ran again, are the same tissue, which goes on from where it was.
 *
 * An update that fails, say for a probe in air, leaves the state usable: the next one goes on from where it was, and
 * does not repeat a cut that came before the failure. An update that is stopped (AbortExecute) lets go of all probes
 * and leaves tissue at rest, with its cuts and carves; the next one grabs anew.
 *
 * @section vtkChainMailDeformation-errors Errors
 *
 * A number that stands for nothing in an enumerated property is an error of the next update. An update that fails
 * reports one error, sets the error code (GetErrorCode()) and goes on showing: both outputs are the last good ones or,
 * where none fits the image, the image as it is. They have the message in the field array `Error`, which good outputs do
 * not have. The pipeline counts the update as done, so that views recover with the next update that succeeds.
 *
 * @section vtkChainMailDeformation-inputs Input ports
 *
 * All positions and vectors are in world axes and in the image's physical units (mm for medical data).
 *
 * - 0, the image: vtkImageData with point scalars of any numeric type, volume or single slice. Of scalars with several
 *   components the first is read. Scalars that are NaN or infinite are air; their number is warned about once. The
 *   direction matrix has to be orthonormal; flipped axes are fine.
 * - 1, `Probes` (optional, repeatable): vtkPointSet; every point is a probe that grabs tissue. Point arrays:
 *   `Displacement` (3 components, [mm]; needed unless every point is an anchor), `Radius` (optional, [mm], default 0:
 *   the nearest element), `Anchor` (optional, default 0; not 0: the tissue is held where it is). An element has one
 *   holder. A probe whose tissue other probes hold, or whose tissue was carved away, moves nothing and is warned about
 *   once. Warnings count the probes that they are about and name the first few.
 * - 2, `Cuts` (optional, repeatable): vtkPolyData; polygons and triangle strips are blades.
 * - 3, `Carves` (optional, repeatable): vtkPolyData; each input is one closed surface of polygons and triangle strips,
 *   of any number of parts. Elements inside it are removed and show BackgroundValue. One not closed is an error.
 *
 * Vertices and lines of Cuts and Carves are ignored. A surface that meets no tissue is warned about once, until it does.
 * Probes, cuts and carves may be composite datasets, which count as the list of their datasets. In a composite input of
 * `Carves` each closed dataset is a surface of its own, and all that are not closed together form one surface. A
 * composite image is an error: one image is deformed at a time. The outputs have the time steps of all inputs together.
 *
 * @section vtkChainMailDeformation-outputs Output ports
 *
 * - 0, the deformed image: the input's geometry, extended by OutputPadding, and all its point arrays, each resampled in
 *   its own type. Global ids become an ordinary array, as they are not unique any more. Cell arrays are not passed on,
 *   as they belong to cells of the undeformed grid: they are warned about once. Ghosts and blanks (of voxels and of
 *   cells, `vtkGhostType`) belong to the grid and stay where they are; padding has none.
 * - 1, the model at rest on the input's grid, with those point arrays that were chosen (ModelArrays): `Displacement`
 *   (3 floats, world axes, [mm]), `Element` (unsigned char: 0 air or carved away, 1 tissue), `Constraint` (float,
 *   fraction of the spacing; 1 component, or 3 along the image's axes; 0 in air) and `Cluster` (int, number of the rigid
 *   cluster, -1 none; components as `Constraint`). With PropagationTimes it also has `PropagationTime` (float,
 *   components as `Constraint`: how far the last wave that came to the element had travelled from its probe, as the sum
 *   of D along its links [mm]; with 1 component along the image's x axis; -1: no wave came) and `Wavefront` (int,
 *   likewise: the number of that wave since rest, from 1 on; 0 none).
 *
 * Both have the input's field data and these field arrays: `ProbeReached` (3 per probe: its displacement since it
 * grabbed, world axes, [mm]), `ProbeForce` (3 per probe: the gradient of the energy at the elements it holds, which is
 * the force it pulls them with, world axes, no unit), `Energy` [mm] (with ElasticRecovery r below 1 only strain of more
 * than (1 - r) D counts), `MaxLinkExcess` (largest violation of (C), fraction of the spacing),
 * `PropagationIterationsUsed`, `RelaxationIterationsUsed`, `CoarseToFineStep` (the share of the correction by coarser
 * grids that was taken: 1 all, 0 none; -1 where the last relaxation did not start on any), `DisplacedElements`
 * (elements away from their rest place; also by its deprecated name `ActiveElements`), `Milliseconds` (upload,
 * propagate, relax, resample, download; 0 for steps that did not have to be done again), `PeakDeviceMemory` (the most
 * memory that all these filters of the process held on the device during this update [MB]) and `DeviceName`.
 *
 * @section vtkChainMailDeformation-parallel Pieces and processes
 *
 * Any piece of the outputs is that piece of the whole, to the bit. A wave can come from anywhere, so every update asks
 * for all of all inputs and computes the whole, once for all its pieces. The processes of a parallel server (see
 * SetController()) give their inputs to the first one, which computes for all and hands out the pieces. A dataset that
 * several processes have alike, as from a source that each of them can run, counts once. Probes and parts of the image
 * or of a surface that only some processes have are put together in order of the processes. Errors and field data are
 * the same everywhere. The first process needs the memory of one that works alone; the others need that of their pieces
 * and of what their readers read, which is the whole image where they can. Neighbouring pieces share a plane of points,
 * as those of all images do in VTK. So anything that counts cells or composites volumes counts everything once, and
 * anything that counts points (Histogram) counts these planes twice. They are not marked as duplicates, since volume
 * mappers would leave gaps.
 *
 * @section vtkChainMailDeformation-limitations Limitations
 *
 * Constraints are geometric limits, not moduli: forces have no physical unit. Links join face neighbours only, so
 * stiffness depends on the directions of the grid. With constraints above 1/3, or between flaps that a cut separates,
 * tissue can fold over itself; the resampling then shows one layer, always the same. There may be at most 2^31 voxels,
 * padding included. In parallel one process computes, so more of them make it neither faster nor the image larger. A
 * knife or a carving tool that moves between two updates works at the places where updates find it, not along its way.
 * The state of MODE_INTERACTIVE is not part of a saved pipeline: a loaded one starts from rest.
 * @sa vtkChainMailProbeSource
 */

#ifndef vtkChainMailDeformation_h
#define vtkChainMailDeformation_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkImageAlgorithm.h"
#include "vtkNew.h" // for ModelArraySelection
#include "vtkSmartPointer.h" // for MaterialFunction

#include <memory> // for std::unique_ptr
#include <string> // for std::string
#include <vector> // for LabelArrays
class vtkDataArraySelection;
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

  vtkImageData* GetModelOutput(); ///< the model at rest, output port 1

  enum MaterialPresets
  {
    MATERIAL_FUNCTION = 0,
    MATERIAL_CT = 1,
    MATERIAL_MR = 2
  };

  ///@{
  /**
   * Where the material comes from. MATERIAL_FUNCTION (0): from MaterialFunction and TissueThreshold. MATERIAL_CT (1):
   * scalars are Hounsfield units, air is below -300, skin and fat are soft, spongy bone is stiff, compact bone is rigid
   * from 600 up (contrast agent ends below that). MATERIAL_MR (2): T1-weighted, any range: air below a tenth of the
   * finite range, fat (bright) softer than muscle, nothing rigid as bone is as dark as air. Both presets bring their
   * own threshold and leave MaterialFunction and TissueThreshold unread. Default: MATERIAL_FUNCTION.
   */
  vtkSetMacro(MaterialPreset, int);
  vtkGetMacro(MaterialPreset, int);
  void SetMaterialPresetToFunction() { this->SetMaterialPreset(MATERIAL_FUNCTION); }
  void SetMaterialPresetToCT() { this->SetMaterialPreset(MATERIAL_CT); }
  void SetMaterialPresetToMR() { this->SetMaterialPreset(MATERIAL_MR); }
  ///@}

  ///@{
  /**
   * The function from scalar to constraint, as a fraction of the spacing. Every node has to lie in [0, 1); 0 is rigid.
   * Default: null, the function that FitMaterial() fits to the finite range of the scalars.
   */
  virtual void SetMaterialFunction(vtkPiecewiseFunction* function);
  vtkPiecewiseFunction* GetMaterialFunction();
  ///@}

  ///@{
  /**
   * Name of a point array that gives the constraint itself, as a fraction of the spacing in [0, 1): 1 component, or 3
   * for the image's axes. It takes the place of the material function, but not of TissueThreshold. Default: "", none.
   */
  vtkSetStdStringFromCharMacro(ConstraintArray);
  vtkGetCharFromStdStringMacro(ConstraintArray);
  ///@}

  ///@{
  /**
   * Voxels with a smaller scalar are air. Any number is possible; NaN stands for the threshold that FitMaterial() fits
   * to the finite range of the scalars. Default: NaN.
   */
  virtual void SetTissueThreshold(double threshold);
  vtkGetMacro(TissueThreshold, double);
  ///@}

  /**
   * Fits a material to scalars of the given range. A signed, CT-like range (range[0] < -200) gets that of MATERIAL_CT.
   * Any other range has no unit and bone cannot be told from it: air is below a tenth of the range, and stiffness grows
   * with the scalar without ever becoming rigid. `function` is emptied and filled; it may be null.
   */
  static void FitMaterial(const double range[2], double& tissueThreshold, vtkPiecewiseFunction* function);

  /**
   * Gives the material of a preset for scalars of the given range; that of MATERIAL_FUNCTION is FitMaterial()'s.
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
   * x- x+ y- y+ z- z+ along the image's axes; 0 leaves a face free. An axis with a single voxel has no faces.
   * Default: 1 1 1 1 1 1.
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
   * alone. MODE_INTERACTIVE (1): an update goes on from the state of the last one, see "Interactive use" above.
   * Default: MODE_FROM_REST.
   */
  vtkSetMacro(Mode, int);
  vtkGetMacro(Mode, int);
  void SetModeToFromRest() { this->SetMode(MODE_FROM_REST); }
  void SetModeToInteractive() { this->SetMode(MODE_INTERACTIVE); }
  ///@}

  /**
   * With MODE_INTERACTIVE the next update starts at rest, with all links whole, carved tissue back in place and all
   * probes released. Probes and surfaces that are connected at that time count as seen: they act again only when they
   * change (a probe pulled elsewhere, a blade moved) or are connected anew. So the output of that update is the input,
   * bit for bit. With MODE_FROM_REST this does nothing.
   */
  void Reset();

  /**
   * Whether another update would change the output though no input or property did. That is so with MODE_INTERACTIVE
   * after an update that ended before its waves had finished or before relaxation converged, and after Reset(). If it
   * is true the filter is Modified(), so that the next Update() goes on; where several processes update it together,
   * call Modified() on each of them instead. False after an update that failed or was stopped. ParaView's window asks
   * this some times a second and updates the filter for as long as it is true; scripts ask by the property of this
   * name.
   */
  bool GetNeedsUpdate();

  /**
   * What the last update did, a line for each sentence: how far every probe came and what holds one that came less than
   * 90 % of its way, how much moved, whether it has settled, time and memory; or why it failed. Empty before the first.
   */
  const char* GetReport();

  enum PropagationMethods
  {
    PROPAGATION_ENVELOPE = 0,
    PROPAGATION_TIMESTAMP = 1
  };

  ///@{
  /**
   * How a wave of displacement travels. PROPAGATION_ENVELOPE (0): every element goes into the bounds that moved
   * neighbours set, until nothing changes; a wave ends where nothing is violated. PROPAGATION_TIMESTAMP (1), the
   * published method: one link an iteration, the earliest arrival counts. A single wave gives the same displacements
   * either way, to float rounding. With MODE_INTERACTIVE a change of this property finishes the waves that are under
   * way. Default: PROPAGATION_ENVELOPE.
   */
  vtkSetMacro(PropagationMethod, int);
  vtkGetMacro(PropagationMethod, int);
  void SetPropagationMethodToEnvelope() { this->SetPropagationMethod(PROPAGATION_ENVELOPE); }
  void SetPropagationMethodToTimestamp() { this->SetPropagationMethod(PROPAGATION_TIMESTAMP); }
  ///@}

  ///@{
  /**
   * Largest number of propagation iterations of an update, [0, VTK_INT_MAX]; 0: until all waves have ended. With
   * MODE_INTERACTIVE a wave that is under way goes on in the next update. With MODE_FROM_REST the output shows it where
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
   * published: the later probe gets its whole displacement and drags the tissue of earlier ones along. Default:
   * CONFLICT_LIMIT.
   */
  vtkSetMacro(ConflictPolicy, int);
  vtkGetMacro(ConflictPolicy, int);
  void SetConflictPolicyToLimit() { this->SetConflictPolicy(CONFLICT_LIMIT); }
  void SetConflictPolicyToLatest() { this->SetConflictPolicy(CONFLICT_LATEST); }
  ///@}

  ///@{
  /**
   * Whether output 1 has the arrays PropagationTime and Wavefront. They take 8 bytes a voxel, and as much on the device
   * where waves came. With MODE_INTERACTIVE a change applies to waves that start from then on. Default: off.
   */
  vtkSetMacro(PropagationTimes, bool);
  vtkGetMacro(PropagationTimes, bool);
  vtkBooleanMacro(PropagationTimes, bool);
  ///@}

  /**
   * ModelArrays: which of the arrays Displacement, Element, Constraint and Cluster output 1 has. The others take no time
   * and no memory; one that is chosen later comes without another deformation. Default: Displacement and Element.
   */
  vtkDataArraySelection* GetModelArraySelection();

  enum RelaxationMethods
  {
    RELAXATION_PROJECTED = 0,
    RELAXATION_PAPER = 1
  };

  ///@{
  /**
   * How tissue settles. RELAXATION_PROJECTED (0): over-relaxation within (C), in which the energy never rises.
   * RELAXATION_PAPER (1), the published method, for comparison: all elements go at once to the weighted mean of their
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
    RELAXATION_INTERACTIVE = RELAXATION_FAST ///< deprecated
  };

  ///@{
  /**
   * How long tissue settles in an update. RELAXATION_CUSTOM (0): as CoarseToFine, RelaxationIterations and
   * RelaxationTolerance say. The others stand for values of these three, in this order, and leave the properties
   * themselves alone; Data/Choosing.md of the project has their cost and error. RELAXATION_FAST (1), for dragging:
   * off, 10, 1e-3. RELAXATION_BALANCED (2), for a picture: on, 20, 1e-3. RELAXATION_ACCURATE (3), for a measurement:
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
   * Whether RELAXATION_PROJECTED starts on coarser grids after a pull, cut or carve. A few iterations then come as far
   * as hundreds on the fine grid alone, for the price of some tens. Tissue settles as far as it is free to, also far
   * from the probes; tissue that no link joins to tissue that moves stays, however close. Default: off.
   */
  vtkSetMacro(CoarseToFine, bool);
  vtkGetMacro(CoarseToFine, bool);
  vtkBooleanMacro(CoarseToFine, bool);
  ///@}

  ///@{
  /**
   * How much of the strain goes back when tissue is released, r in [0, 1]. Strain of a link up to (1 - r) of its limit
   * D costs no energy and stays. 1: elastic, all strain goes back; 0: plastic, all of it stays. Default: 1.
   */
  vtkSetClampMacro(ElasticRecovery, double, 0.0, 1.0);
  vtkGetMacro(ElasticRecovery, double);
  ///@}

  ///@{
  /**
   * Whether tissue and bones turn. Off: the published model, in which a bone slides and tissue resists being turned.
   * On: every element has a rotation, and turning tissue as a whole costs no energy; a bone turns about the voxels that
   * a probe holds of it, freely about one, about an axis through two, and not at all with more or an anchor. About
   * twice the time of relaxation. Needs PROPAGATION_ENVELOPE, RELAXATION_PROJECTED and an ElasticRecovery of 1. With
   * three constraints a voxel bones do not turn. A change starts from rest. Default: off.
   */
  vtkSetMacro(Rotations, bool);
  vtkGetMacro(Rotations, bool);
  vtkBooleanMacro(Rotations, bool);
  ///@}

  ///@{
  /**
   * Largest number of relaxation iterations of an update, [0, VTK_INT_MAX]; 0 leaves propagation alone. Default: 40.
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
   * Number of voxels per element along each axis (of more than one voxel): 1, 2, 4 or 8. Propagation and relaxation
   * become faster by nearly its cube, and less exact; the rest of an update takes as long as ever, and memory is not
   * less. Images are still resampled, cut and carved voxel by voxel, and both outputs are on the input's grid:
   * displacements are interpolated between elements that lie on the same side of every cut. An element exists where one
   * of its voxels is tissue, and its constraint is their mean. It is rigid or anchored where one of them is, so bone
   * never bends, but is up to ModelReduction - 1 voxels thicker. Bodies closer than an element may stick together.
   * Energy and forces compare with those of the whole model; MaxLinkExcess, DisplacedElements and RelaxationTolerance
   * are about the elements. Any other number is an error. Default: 1.
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
   * How arrays are sampled. INTERPOLATION_LINEAR (0): trilinear, with integers rounded to the nearest; voxels outside
   * tissue that are not finite have no weight beside others. INTERPOLATION_NEAREST (1): the nearest voxel. Label
   * arrays, ids and arrays of bits, strings and variants always take the nearest voxel. Default: INTERPOLATION_LINEAR.
   */
  vtkSetMacro(Interpolation, int);
  vtkGetMacro(Interpolation, int);
  void SetInterpolationToLinear() { this->SetInterpolation(INTERPOLATION_LINEAR); }
  void SetInterpolationToNearest() { this->SetInterpolation(INTERPOLATION_NEAREST); }
  ///@}

  ///@{
  /**
   * Names of the point arrays that hold labels and so take the nearest voxel. Each has to be the name of a point array
   * of the input. Default: none.
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
   * Value of the scalars (the array that the material function reads) in places that tissue has left and in the
   * padding, brought into the range of the array's type. With NaN it is the array's own smallest finite value. All
   * other arrays show their own smallest finite value there, by component; bits are 0 and strings empty. Default: NaN.
   */
  virtual void SetBackgroundValue(double value);
  vtkGetMacro(BackgroundValue, double);
  ///@}

  ///@{
  /**
   * Voxels added on every side of output 0, for tissue that leaves the image, [0, 4096]. A single slice stays a single
   * slice: axes with one voxel are not padded. More than 2^31 voxels with the padding are an error. Default: 0.
   */
  vtkSetClampMacro(OutputPadding, int, 0, 4096);
  vtkGetMacro(OutputPadding, int);
  ///@}

  ///@{
  /**
   * The OpenCL device: the first one whose name contains this text, in upper or lower case. Default: "", the best GPU,
   * else the best other device.
   */
  vtkSetStdStringFromCharMacro(Device);
  vtkGetCharFromStdStringMacro(Device);
  ///@}

  /**
   * Names of the OpenCL devices of this machine, best first; empty where there are none. The array belongs to the
   * filter and is filled anew by every call.
   */
  vtkStringArray* GetAvailableDevices();

  ///@{
  /**
   * Elements per brick, the unit of memory and work on the device: each 0 or a power of two, x in [4, 64], y and z in
   * [2, 32]; 0 stands for the best number for the device. It changes speed alone, no result. Default: 0 0 0.
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
   * The time of the last change, also of the material function.
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
  bool PropagationTimes = false;
  vtkNew<vtkDataArraySelection> ModelArraySelection;
  int RelaxationMethod = RELAXATION_PROJECTED;
  int RelaxationPreset = RELAXATION_CUSTOM;
  bool CoarseToFine = false;
  double ElasticRecovery = 1.0;
  bool Rotations = false;
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

  // State that is kept between updates: the engine's model and simulation, and what they were made from.
  class vtkInternals;
  std::unique_ptr<vtkInternals> Internals;
};

#endif
