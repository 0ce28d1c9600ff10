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
 *    and d_a the length of the shortest path of links of length D_a. `ProbeReached` says how far each one came. When
 *    its wave has ended, a probe that got less than half of what it asks for is warned about, with what holds it.
 * 3. Relaxation: in at most RelaxationIterations steps lowers the energy, the sum over links and axes of
 *    (u_a(i) - u_a(j))^2 / D_a(i,j), under (C) and with probes and anchors held. Soft probes, those with a tolerance T,
 *    hold nothing: each element i that one grips adds (u_a(i) - t_a)^2 / T to the energy, for every axis.
 * 4. Resampling: output voxel y shows the material at X with X + u(X) = y. Voxels that did not change are copies of the
 *    input, bit for bit; voxels that tissue left show BackgroundValue, and those at cut and carved surfaces a mixture
 *    (SmoothCuts).
 *
 * Method after "Parallel deformation of heterogeneous ChainMail models: application to interactive deformation of large
 * medical volumes" by Rodriguez, Leon and Arroyo, whose propagation and relaxation are here as PROPAGATION_TIMESTAMP
 * and RELAXATION_PAPER; the others are this library's own (Data/Method.md). It runs on an OpenCL device, see Device.
 *
 * @section vtkChainMailDeformation-interactive Interactive use
 *
 * With MODE_INTERACTIVE the state is kept from one update to the next. Only changes since the last update are applied,
 * to the tissue as it is deformed now, in this order:
 *
 * 1. Every `Cuts` surface that the last update did not have, or that moved, cuts. One that is gone changes nothing.
 * 2. Every `Carves` surface likewise. One that comes back to where it was since rest, as with Undo in ParaView, is
 *    warned about once: it brings back no tissue, Reset() does.
 * 3. Probes. A probe with the position and radius of one that is already held is that same probe; it goes to its
 *    present `Displacement`, counted from where its tissue was when it was grabbed. Any other probe grabs the tissue
 *    that is at its position now. Probes that are gone let go of their tissue where it is.
 * 4. Waves travel for at most PropagationIterations, then tissue settles for at most RelaxationIterations. This happens
 *    in every update that a changed input or Modified() calls for. GetNeedsUpdate() tells whether there is more to do,
 *    and makes the next Update() do it:
 * `do { filter->Update(); show(); } while (filter->GetNeedsUpdate());`
 *
 * Other tissue (the image, its scalars, place or spacing, material, bodies, anchors, ModelReduction, Device,
 * BrickSize), or switching to this mode, starts from rest and applies everything that is connected. Equal values in new
 * arrays, say from a reader that ran again, are the same tissue, which goes on from where it was.
 *
 * An update that fails leaves the state usable: the next one goes on from where it was, and does not repeat a cut that
 * came before the failure. One that is stopped (AbortExecute) lets go of all probes and leaves tissue at rest, with its
 * cuts and carves.
 *
 * @section vtkChainMailDeformation-errors Errors
 *
 * An update that fails (also for a number that stands for nothing in an enumerated property) reports one error, sets
 * the error code (GetErrorCode()) and goes on showing: both outputs are the last good ones or, where none fits the
 * image, the image as it is. They have the message in the field array `Error`. The pipeline counts the update as done.
 *
 * @section vtkChainMailDeformation-inputs Input ports
 *
 * All positions and vectors are in world axes and in the image's physical units (mm for medical data).
 *
 * - 0, the image: vtkImageData with point scalars of any numeric type, volume or single slice. Of scalars with several
 *   components the first is read. Scalars that are NaN or infinite are air; their number is warned about once. Air
 *   is also padding above all other scalars, see vtkChainMailScanStatistics. The direction matrix has to be
 * orthonormal; flipped axes are fine. Cell data alone are an error: vtkCellDataToPointData makes points.
 * - 1, `Probes` (optional, repeatable): vtkPointSet; every point is a probe that grabs tissue. Point arrays:
 *   `Displacement` (3 components, [mm]; needed unless every point is an anchor), `Radius` (optional, [mm], default 0:
 *   the nearest element), `Anchor` (optional, default 0; not 0: the tissue is held where it is), `Tolerance` (optional,
 *   [mm], default 0; above 0 the probe is soft: relaxation weighs it against tissue, so that nothing moves with
 *   RelaxationIterations 0). With the point array `Rotation` (3 components: a rotation vector along the axis, as long
 * as the angle [degrees], of any length) a probe also rotates what it grabs, about `Centre` (3 components, optional,
 *   [mm], default the point itself): it goes from x to Centre + Displacement + R (x - Centre). With each rigid element
 *   it then grips the whole rigid cluster, which goes exactly there unless the probe is soft; the rotations of other
 *   elements settle. `Body` (optional) is the label of BodyArray whose voxels it grips in place of what is at the
 * point, with the rigid clusters that these are part of; -1: what is at the point. A rotation needs Rotations, a
 * constraint that is the same along all axes and PropagationIterations 0. An element has one holder, and any number of
 * soft probes besides. Of a soft probe `ProbeReached` is the mean over its elements, and `ProbeForce` what its links
 * pull with. A probe whose tissue other probes hold, or whose tissue was carved away, moves nothing and is warned about
 *   once. Warnings count the probes that they are about and name the first few.
 * - 2, `Cuts` (optional, repeatable): vtkPolyData; polygons and triangle strips are blades.
 * - 3, `Carves` (optional, repeatable): vtkPolyData; each input is one closed surface of polygons and triangle strips,
 *   of any number of parts. Elements inside any part are removed and show BackgroundValue; normals may point outwards
 * or inwards. A part within others that faces the other way is a hollow: what is in it stays. Where triangles of a part
 *   face both ways, every part within others is one. Both are warned about once. A surface not closed is an error.
 * - 4, `Regions` (optional, repeatable): vtkPointSet; every point is a ball whose tissue has the constraint in the
 * point array `Constraint`, with the radius in `Radius` [mm]. The later of two wins. One without tissue is warned
 * about.
 *
 * A surface that meets no tissue is warned about once, until it does, and named in GetReport(). A polygon that crosses
 * itself is warned about. Probes, cuts and carves may be composite datasets, which count as the list of their datasets;
 * of `Carves` each closed dataset is a surface of its own, and all that are not closed together form one. A composite
 * image is an error. The outputs have the time steps of all inputs together.
 *
 * @section vtkChainMailDeformation-outputs Output ports
 *
 * - 0, the deformed image: the input's geometry, extended by OutputPadding, finer by OutputMagnification and limited by
 *   OutputBounds, and all its point arrays, each resampled in its own type. Global ids become an ordinary array. Cell
 *   arrays are not passed on, which is warned about once. With PullBack it also has `PullBack` (3 floats, world axes,
 *   [mm]): from a voxel to where its material was at rest, 0 where nothing moved, NaN where there is background. An
 *   array of that name in the input is not passed on then. With ScalarSmoothing it likewise has the scalars smoothed
 *   (float), named like them with " smooth" behind: the mean over what is up to three standard deviations away, weighted
 *   by the Gaussian. Values that are not finite, and paddings of a scanner, stay as they are and count for no other
 *   voxel. Ghosts and blanks (of voxels and of cells, `vtkGhostType`) belong to the grid and stay where they are;
 *   padding has none.
 * - 1, the model at rest on the input's grid, with those point arrays that were chosen (ModelArrays): `Displacement`
 *   (3 floats, world axes, [mm]), `Element` (unsigned char: 0 air or carved away, 1 tissue), `Constraint` (float,
 *   fraction of the spacing; 1 component, or 3 along the image's axes; 0 in air) and `Cluster` (int, number of the
 * rigid cluster, -1 none; components as `Constraint`). The active scalars are `Displacement`, as some writers write no
 * other array; without it `Element`. With PropagationTimes it also has `PropagationTime` (float, components as
 * `Constraint`: how far the last wave that came to the element had travelled from its probe, as the sum of D along its
 * links [mm]; with 1 component along the image's x axis; -1: no wave came) and `Wavefront` (int, likewise: the number
 * of that wave since rest, from 1 on; 0 none). With `Displacement`, where something is cut or carved, it has `Links`
 * (unsigned char), which vtkChainMailCarry reads to tell sides apart: 1 where an element is linked to its neighbour
 * at x-, 2 x+, 4 y-, 8 y+, 16 z-, 32 z+, summed up; 64 where tissue was carved away; 0 in air.
 *
 * Both have the input's field data, except arrays of the names below, and these field arrays: `ProbeReached` (3 per
 * probe: its displacement since it grabbed, world axes, [mm]), `ProbeForce` (3 per probe: the gradient of the energy at
 * the elements it holds, which is the force it pulls them with, world axes, no unit), `ProbeTurned` (3 per probe: its
 * rotation vector since it grabbed [degrees], world axes; 0 without `Rotation`; `ProbeReached` is then the displacement
 * of `Centre`), `ProbeTorque` (3 per probe: the gradient of the energy by its rotation about `Centre` as moved, per
 * radian, likewise), `Energy` [mm] (with
 * ElasticRecovery r below 1 only strain of more than (1 - r) D counts), `MaxLinkExcess` (largest violation of (C),
 * fraction of the spacing), `PropagationIterationsUsed`, `RelaxationIterationsUsed`, `CoarseToFineStep` (the share of
 * the correction by coarser grids that was taken: 1 all, 0 none; -1 where the last relaxation did not start on any),
 * `DisplacedElements` (elements away from their rest place),
 * `Milliseconds` (upload, propagate, relax, resample, download; 0 for steps that did not have to be done again),
 * `PeakDeviceMemory` (the most memory that all these filters of the process held on the device during this update [MB])
 * and `DeviceName`. With BodyArray or JointSize there are also, one row for each number of `Cluster`, `BodyVoxels`,
 * `BodyLabel` (with BodyArray) and `BodyHeldBy` (0 nothing, 1 a face of the image, 2 AnchorRigid, 3 a probe; one that
 * holds along x, see `Cluster`).
 *
 * @section vtkChainMailDeformation-parallel Pieces and processes
 *
 * Any piece of the outputs is that piece of the whole, to the bit. Every update asks for all of all inputs and computes
 * the whole, once for all its pieces. The processes of a parallel server (see SetController()) give their inputs to the
 * first one, which computes for all and hands out the pieces. A dataset that several processes have alike counts once;
 * what only some have is put together in order of the processes. Errors and field data are the same everywhere. Pieces
 * share planes of points, as those of all images do in VTK: what counts points (Histogram) counts these planes twice.
 *
 * @section vtkChainMailDeformation-limitations Limitations
 *
 * Constraints are geometric limits, not moduli: forces have no physical unit. Links join face neighbours only, so
 * stiffness depends on the directions of the grid. With constraints above 1/3, or between flaps that a cut separates,
 * tissue can fold over itself; the resampling then shows one layer. Cut surfaces are shown in steps of a voxel where
 * two of them meet in a cell, and vtkChainMailCarry goes by these steps. There may be at most 2^31 voxels with padding.
 * OutputMagnification shows displacements and cuts finer; between the scan's voxels its values are interpolated.
 * More processes make it neither faster nor the image larger. A knife that moves between two updates works where
 * updates find it, not along its way. A saved pipeline has no state of MODE_INTERACTIVE: it starts from rest.
 * @sa vtkChainMailProbeSource vtkChainMailCarry
 */

#ifndef vtkChainMailDeformation_h
#define vtkChainMailDeformation_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkImageAlgorithm.h"
#include "vtkNew.h"          // for ModelArraySelection
#include "vtkSmartPointer.h" // for MaterialFunction

#include <memory> // for std::unique_ptr
#include <string> // for std::string
#include <vector> // for LabelArrays
class vtkDataArray;
class vtkDataArraySelection;
class vtkDoubleArray;
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
  /** Add, replace or remove the producers of the input ports 1 to 4. Null removes them all. */
  void SetProbesConnection(vtkAlgorithmOutput* producer);
  void AddProbesConnection(vtkAlgorithmOutput* producer);
  void SetCutsConnection(vtkAlgorithmOutput* producer);
  void AddCutsConnection(vtkAlgorithmOutput* producer);
  void SetCarvesConnection(vtkAlgorithmOutput* producer);
  void AddCarvesConnection(vtkAlgorithmOutput* producer);
  void SetRegionsConnection(vtkAlgorithmOutput* producer) { this->SetInputConnection(4, producer); }
  void AddRegionsConnection(vtkAlgorithmOutput* producer) { this->AddInputConnection(4, producer); }
  void RemoveAllProbes() { this->SetProbesConnection(nullptr); }
  void RemoveAllCuts() { this->SetCutsConnection(nullptr); }
  void RemoveAllCarves() { this->SetCarvesConnection(nullptr); }
  void RemoveAllRegions() { this->SetRegionsConnection(nullptr); }
  ///@}

  vtkImageData* GetModelOutput(); ///< the model at rest, output port 1

  /**
   * Gives an image the grid of the scan, the point array `Cluster`, as the model at rest would have it now whatever
   * ModelArrays says, and the BodyArray, if there is one. Returns false where nothing is known: before the first
   * update, after one that failed, and on a process for which another one computes.
   */
  bool GetBodies(vtkImageData* image);

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
   * way up from air, fat (bright) softer than muscle, nothing rigid as bone is as dark as air. Both presets bring their
   * own threshold and leave MaterialFunction and TissueThreshold unread. One that does not suit the scalars is warned
   * about once. Default: MATERIAL_FUNCTION.
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
   * Default: null, the function that fits the scalars, see vtkChainMailScanStatistics.
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
   * Name of a point array of labels, whole numbers such as one for each bone: rigid voxels of different labels belong
   * to different bodies, with a joint where they touch. 0 is no label: what is connected of it is a body of its own.
   * The array takes the nearest voxel, see LabelArrays. Not with ModelReduction. Default: "", none.
   */
  vtkSetStdStringFromCharMacro(BodyArray);
  vtkGetCharFromStdStringMacro(BodyArray);
  ///@}

  ///@{
  /**
   * Where rigid tissue without a label is thinner than so many voxels, between parts at least twice as thick (with
   * their marrow), it is a joint; thin tissue is of the nearest body. So a larger size finds thicker joints, but fewer
   * in all. [0, 256], 0: none; not with ModelReduction. Default: 0.
   */
  vtkSetClampMacro(JointSize, int, 0, 256);
  vtkGetMacro(JointSize, int);
  ///@}

  ///@{
  /**
   * Constraint of joints: of the layer of voxels of one body, the larger one, that touch another. [0, 1], as a fraction
   * of the spacing; 0 leaves bodies that touch in one piece. With 1 joints are free: bodies glide and turn in them, as
   * no links join what is within JointMargin of two bodies. The picture goes on across them. Default: 0.5.
   */
  vtkSetClampMacro(JointConstraint, double, 0.0, 1.0);
  vtkGetMacro(JointConstraint, double);
  ///@}

  ///@{
  /**
   * How many voxels around each body belong to it where joints are free (JointConstraint 1), nearest first: so far the
   * joint goes into tissue between and around two bodies. [1, 100]. Default: 4.
   */
  vtkSetClampMacro(JointMargin, int, 1, 100);
  vtkGetMacro(JointMargin, int);
  ///@}

  ///@{
  /**
   * Voxels with a smaller scalar are air. NaN: the threshold that fits, see vtkChainMailScanStatistics; GetReport()
   * says what the scalars were taken for, and what is doubtful is warned about once. Default: NaN.
   */
  virtual void SetTissueThreshold(double threshold);
  vtkGetMacro(TissueThreshold, double);
  ///@}

  /**
   * The material for a range that is known, say of a modality: with range[0] < -200 that of MATERIAL_CT, else air is
   * below a tenth of it, and stiffness grows with the scalar without ever becoming rigid. One wrong voxel spoils the
   * range of a scan: for that there is vtkChainMailScanStatistics::GetMaterial(). `function` may be null.
   */
  static void FitMaterial(const double range[2], double& tissueThreshold, vtkPiecewiseFunction* function);

  /// Gives the material of a preset for scalars of the given range; that of MATERIAL_FUNCTION is FitMaterial()'s.
  static void GetPresetMaterial(
    int preset, const double range[2], double& tissueThreshold, vtkPiecewiseFunction* function);

  ///@{
  /** Hold all rigid tissue (constraint 0) where it is. Default: off. */
  vtkSetMacro(AnchorRigid, bool);
  vtkGetMacro(AnchorRigid, bool);
  vtkBooleanMacro(AnchorRigid, bool);
  ///@}

  ///@{
  /**
   * Hold the tissue that touches these faces of the image, as the body goes on there: x- x+ y- y+ z- z+ along the
   * image's axes; 0 leaves a face free. An axis with a single voxel has no faces. Default: 1 1 1 1 1 1.
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
   * MODE_FROM_REST (0): an update computes from rest, as a function of the inputs and properties alone.
   * MODE_INTERACTIVE (1): it goes on from the state of the last one, see "Interactive use" above. Default:
   * MODE_FROM_REST.
   */
  vtkSetMacro(Mode, int);
  vtkGetMacro(Mode, int);
  void SetModeToFromRest() { this->SetMode(MODE_FROM_REST); }
  void SetModeToInteractive() { this->SetMode(MODE_INTERACTIVE); }
  ///@}

  /**
   * With MODE_INTERACTIVE the next update starts at rest, with all links whole, carved tissue back in place and all
   * probes released. Probes and surfaces that are connected then act again only when they change or are connected anew,
   * so the output is the input, bit for bit. Nothing with MODE_FROM_REST.
   */
  void Reset();

  /**
   * Whether another update would change the output though no input or property did: with MODE_INTERACTIVE before waves
   * have finished or relaxation converged, and after Reset(), but not after an update that failed or was stopped. If so
   * the filter is Modified(), and Update() goes on; of several processes call Modified() on each instead.
   */
  bool GetNeedsUpdate();

  /**
   * What the last update did, a line for each sentence: how far every probe came and what holds one that came less than
   * 90 % of its way, surfaces that removed nothing, bodies and which are held, how much moved, whether it settled,
   * time, memory; or why it failed.
   */
  const char* GetReport();

  /**
   * `ProbeReached` of the outputs, a tuple of 3 for each probe; without tuples before the first update.
   */
  vtkDataArray* GetProbeReached();

  ///@{
  /**
   * Whether filters of this process warn about a probe that holds no tissue of its own, or that got less than half of
   * its displacement. The report says so in any case, so a window that shows it has no need of the warnings. Default:
   * on.
   */
  static void SetGlobalProbeWarnings(bool warn);
  static bool GetGlobalProbeWarnings();
  ///@}

  enum PropagationMethods
  {
    PROPAGATION_ENVELOPE = 0,
    PROPAGATION_TIMESTAMP = 1
  };

  ///@{
  /**
   * How a wave of displacement travels. PROPAGATION_ENVELOPE (0): every element goes into the bounds that moved
   * neighbours set, until nothing changes. PROPAGATION_TIMESTAMP (1), the published method: one link an iteration, the
   * earliest arrival counts. A single wave gives the same displacements either way, to float rounding. With
   * MODE_INTERACTIVE a change finishes the waves that are under way. Default: PROPAGATION_ENVELOPE.
   */
  vtkSetMacro(PropagationMethod, int);
  vtkGetMacro(PropagationMethod, int);
  void SetPropagationMethodToEnvelope() { this->SetPropagationMethod(PROPAGATION_ENVELOPE); }
  void SetPropagationMethodToTimestamp() { this->SetPropagationMethod(PROPAGATION_TIMESTAMP); }
  ///@}

  ///@{
  /**
   * Largest number of propagation iterations of an update, [0, VTK_INT_MAX]; 0: until all waves have ended. A wave
   * under way goes on in the next update with MODE_INTERACTIVE; links at its front may be longer than (C) allows.
   * Default: 0.
   */
  vtkSetClampMacro(PropagationIterations, int, 0, VTK_INT_MAX);
  vtkGetMacro(PropagationIterations, int);
  ///@}

  enum ConflictPolicies
  {
    CONFLICT_LIMIT = 0,
    CONFLICT_LATEST = 1,
    CONFLICT_SHARE = 2
  };

  ///@{
  /**
   * What happens where probes pull tissue apart further than it stretches; anchors always hold. CONFLICT_LIMIT (0): the
   * later probe is shortened, by axis, to what the earlier ones allow. CONFLICT_LATEST (1), as published: the later
   * probe wins and drags the tissue of earlier ones along. CONFLICT_SHARE (2), with PROPAGATION_ENVELOPE: probes that
   * start together all give way, each element that they hold to the mean of the least and the greatest displacement
   * that the requests of all others leave it, so the tissue of one probe may part. It takes the time of some waves,
   * however many probes there are, so more than 32 probes that start together and do not fit share whatever the policy;
   * a warning then says so. With MODE_FROM_REST all probes start together. Default: CONFLICT_LIMIT.
   */
  vtkSetMacro(ConflictPolicy, int);
  vtkGetMacro(ConflictPolicy, int);
  void SetConflictPolicyToLimit() { this->SetConflictPolicy(CONFLICT_LIMIT); }
  void SetConflictPolicyToLatest() { this->SetConflictPolicy(CONFLICT_LATEST); }
  void SetConflictPolicyToShare() { this->SetConflictPolicy(CONFLICT_SHARE); }
  ///@}

  ///@{
  /**
   * Whether output 1 has the arrays PropagationTime and Wavefront: 8 bytes a voxel, and as much on the device where
   * waves came. With MODE_INTERACTIVE a change applies to waves that start from then on. Default: off.
   */
  vtkSetMacro(PropagationTimes, bool);
  vtkGetMacro(PropagationTimes, bool);
  vtkBooleanMacro(PropagationTimes, bool);
  ///@}

  /**
   * ModelArrays: which of the arrays Displacement, Element, Constraint and Cluster output 1 has. The others cost
   * nothing; one that is chosen later comes without another deformation. Default: Displacement and Element.
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
   * RELAXATION_PAPER (1), published, for comparison: all elements at once to the weighted mean of their neighbours. It
   * leaves links too long (`MaxLinkExcess`), locks rigid tissue, and may go on without end. Default:
   * RELAXATION_PROJECTED.
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
    RELAXATION_ACCURATE = 3
  };

  ///@{
  /**
   * How long tissue settles in an update. RELAXATION_CUSTOM (0): as CoarseToFine, RelaxationIterations and
   * RelaxationTolerance say. The others stand for values of these three, in this order, and leave the properties alone
   * (costs and errors: Data/Choosing.md). RELAXATION_FAST (1), to drag: off, 10, 1e-3. RELAXATION_BALANCED (2), for a
   * picture: on, 20, 1e-3. RELAXATION_ACCURATE (3), to measure: on, 170 (Rotations, Paper: 1000), 1e-5. Default:
   * RELAXATION_CUSTOM.
   */
  vtkSetMacro(RelaxationPreset, int);
  vtkGetMacro(RelaxationPreset, int);
  void SetRelaxationPresetToCustom() { this->SetRelaxationPreset(RELAXATION_CUSTOM); }
  void SetRelaxationPresetToFast() { this->SetRelaxationPreset(RELAXATION_FAST); }
  void SetRelaxationPresetToBalanced() { this->SetRelaxationPreset(RELAXATION_BALANCED); }
  void SetRelaxationPresetToAccurate() { this->SetRelaxationPreset(RELAXATION_ACCURATE); }
  ///@}

  ///@{
  /**
   * Whether RELAXATION_PROJECTED starts on coarser grids after a pull, cut or carve. A few iterations then come as far
   * as hundreds on the fine grid alone, for the price of some tens. Tissue far from the probes settles, too. Default:
   * off.
   */
  vtkSetMacro(CoarseToFine, bool);
  vtkGetMacro(CoarseToFine, bool);
  vtkBooleanMacro(CoarseToFine, bool);
  ///@}

  ///@{
  /**
   * How much of the strain goes back when tissue is released, r in [0, 1]: strain of a link up to (1 - r) of its limit
   * D costs no energy and stays. 1: elastic; 0: plastic, all of it stays. Default: 1.
   */
  vtkSetClampMacro(ElasticRecovery, double, 0.0, 1.0);
  vtkGetMacro(ElasticRecovery, double);
  ///@}

  ///@{
  /**
   * Whether tissue and bones turn. Off: the published model, in which a bone slides and tissue resists being turned.
   * On: turning tissue as a whole costs no energy. A bone turns freely about one voxel that a probe holds, about an
   * axis through two, and not with more, an anchor, or three constraints a voxel. Relaxation takes 2 to 4 times as
   * long. Needs PROPAGATION_ENVELOPE, RELAXATION_PROJECTED and ElasticRecovery 1. A change starts from rest. Default:
   * off.
   */
  vtkSetMacro(Rotations, bool);
  vtkGetMacro(Rotations, bool);
  vtkBooleanMacro(Rotations, bool);
  ///@}

  ///@{
  /**
   * Poisson's ratio n of tissue that turns, in [0, 0.49]: squeezed by a share s it goes n s aside, and loses (1 - 2 n)
   * s of its volume. Other than 0 it needs Rotations and twice their memory; an iteration takes 2 to 3 times as long,
   * and from 0.4 on more of them are needed (Data/Choosing.md). A change starts from rest. Default: 0.
   */
  vtkSetClampMacro(PoissonRatio, double, 0.0, 0.49);
  vtkGetMacro(PoissonRatio, double);
  ///@}

  ///@{
  /** Most relaxation iterations of an update, [0, VTK_INT_MAX]; 0 leaves propagation alone. Default: 40. */
  vtkSetClampMacro(RelaxationIterations, int, 0, VTK_INT_MAX);
  vtkGetMacro(RelaxationIterations, int);
  ///@}

  ///@{
  /** Relaxation stops when nothing moved more than this fraction of the spacing, [0, VTK_DOUBLE_MAX]. Default: 1e-3. */
  vtkSetClampMacro(RelaxationTolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(RelaxationTolerance, double);
  ///@}

  ///@{
  /**
   * Number of voxels per element along each axis (of more than one voxel): 1, 2, 4 or 8. Propagation and relaxation
   * become faster by nearly its cube, and less exact; the rest of an update takes as long as ever, and memory is not
   * less. Images are still resampled, cut and carved voxel by voxel, and displacements are interpolated between
   * elements on the same side of every cut. An element exists where one of its voxels is tissue, and its constraint is
   * their mean. It is rigid or anchored where one of them is, so bone never bends, but is thicker, and bodies closer
   * than an element may stick together. Energy and forces compare with those of the whole model; MaxLinkExcess,
   * DisplacedElements and RelaxationTolerance are about the elements. Any other number is an error. Default: 1.
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
   * tissue that are not finite, and padding, have no weight beside others. INTERPOLATION_NEAREST (1): the nearest
   * voxel, as always for labels (also scalars that are taken for such), ids, bits, strings, variants. Default:
   * INTERPOLATION_LINEAR.
   */
  vtkSetMacro(Interpolation, int);
  vtkGetMacro(Interpolation, int);
  void SetInterpolationToLinear() { this->SetInterpolation(INTERPOLATION_LINEAR); }
  void SetInterpolationToNearest() { this->SetInterpolation(INTERPOLATION_NEAREST); }
  ///@}

  ///@{
  /** Names of the input's point arrays that hold labels and so take the nearest voxel. Default: none. */
  void AddLabelArray(const char* name);
  void RemoveLabelArray(const char* name);
  void ClearLabelArrays();
  int GetNumberOfLabelArrays() const;
  const char* GetLabelArray(int index) const;
  bool HasLabelArray(const char* name) const;
  ///@}

  ///@{
  /**
   * Value of the scalars where tissue has left and in the padding, brought into the range of the array's type. With NaN
   * it is what air is, see vtkChainMailScanStatistics. In all other arrays, and scalars of several components, it is
   * the smallest finite value, by component; bits are 0, strings empty. Default: NaN.
   */
  virtual void SetBackgroundValue(double value);
  vtkGetMacro(BackgroundValue, double);
  ///@}

  ///@{
  /**
   * Voxels added on every side of output 0, for tissue that leaves the image, [0, 4096]. Axes with one voxel are not
   * padded. More than 2^31 voxels with the padding are an error. Default: 0.
   */
  vtkSetClampMacro(OutputPadding, int, 0, 4096);
  vtkGetMacro(OutputPadding, int);
  ///@}

  ///@{
  /**
   * How many voxels output 0 has along each axis for one of the input, 1 to 4. The image stays where it is, and its
   * spacing is divided by this. Between the input's voxels its values are interpolated. Displacements and cut surfaces
   * are known there, so what was deformed, cut or carved is shown finer. An axis with a single voxel keeps that one.
   * With 2 each array has 8 times as many values, with 4 64 times; OutputBounds limit them to a box. An output that
   * does not fit into the free main memory is an error, which names its size. Default: 1.
   */
  vtkSetClampMacro(OutputMagnification, int, 1, 4);
  vtkGetMacro(OutputMagnification, int);
  ///@}

  ///@{
  /**
   * Whether output 0 is a part of the image: the smallest extent that holds the box of OutputBounds, within the image
   * and its padding. All tissue is deformed, whatever is shown. Default: off.
   */
  vtkSetMacro(UseOutputBounds, bool);
  vtkGetMacro(UseOutputBounds, bool);
  vtkBooleanMacro(UseOutputBounds, bool);
  ///@}

  ///@{
  /**
   * The box that UseOutputBounds asks for: xmin, xmax, ymin, ymax, zmin, zmax [mm, world axes]. Where the image's axes
   * are oblique, the smallest part of it that holds the box. A box that the image does not meet is an error. Default:
   * 0 1 0 1 0 1.
   */
  vtkSetVector6Macro(OutputBounds, double);
  vtkGetVector6Macro(OutputBounds, double);
  ///@}

  ///@{
  /**
   * Whether cut and carved surfaces are shown where the blade went: a voxel there shows tissue in the share of it that
   * lies on the tissue's side, and BackgroundValue in the rest. So surfaces are smooth at any angle. Off: each voxel
   * shows one or the other, by the element that is nearest, in steps of a voxel. Labels, all arrays with
   * INTERPOLATION_NEAREST and PullBack are never mixed. They go by which share is larger. Default: on.
   */
  vtkSetMacro(SmoothCuts, bool);
  vtkGetMacro(SmoothCuts, bool);
  vtkBooleanMacro(SmoothCuts, bool);
  ///@}

  ///@{
  /**
   * Whether output 0 has the array PullBack: 12 bytes a voxel, and as much for the update that comes next. It is the
   * way back that resampling takes, so cuts and carves are in it, as no displacement of the model at rest has them.
   * Default: off.
   */
  vtkSetMacro(PullBack, bool);
  vtkGetMacro(PullBack, bool);
  vtkBooleanMacro(PullBack, bool);
  ///@}

  ///@{
  /**
   * The standard deviation of a Gaussian [voxels of the input], from 0 to 2. Above 0, output 0 has the scalars once
   * more, smoothed, for a picture of the volume without grain: the edge of a scan's skin is a voxel wide, and drawn, its
   * steps and noise look like wood. 0.75 takes the grain and keeps the rest; by more than 1, wounds lose their colours.
   * It takes 4 bytes a voxel, and as much for the update that comes next. Labels, and all with INTERPOLATION_NEAREST,
   * are there as they are. Default: 0.
   */
  vtkSetClampMacro(ScalarSmoothing, double, 0.0, 2.0);
  vtkGetMacro(ScalarSmoothing, double);
  ///@}

  ///@{
  /**
   * The OpenCL device: the one of this name, else the first whose name has this text, in any case. AvailableDevices has
   * the names, of which no two are the same. Default: "", the best GPU, else PoCL's processor. A GPU whose driver is
   * not one of its maker is taken only where it is named or was tried (Data/Install.md).
   */
  vtkSetStdStringFromCharMacro(Device);
  vtkGetCharFromStdStringMacro(Device);
  ///@}

  /// Names of the OpenCL devices of this machine, best first. Two of one name get that of their platform, "NAME
  /// (PLATFORM)", or a number, "NAME (2)". The array is the filter's and filled anew by every call.
  vtkStringArray* GetAvailableDevices();

  ///@{
  /**
   * Elements per brick, the unit of memory and work on the device: each 0 (the best for it) or a power of two, x in
   * [4, 64], y and z in [2, 32]. It changes speed alone, no result. Default: 0 0 0.
   */
  vtkSetVector3Macro(BrickSize, int);
  vtkGetVector3Macro(BrickSize, int);
  ///@}

  ///@{
  /**
   * The processes that update this filter together, each asking for its own piece, as those of a parallel server do.
   * Null: this process works alone. Default: the global controller.
   */
  void SetController(vtkMultiProcessController* controller);
  vtkMultiProcessController* GetController();
  ///@}

  /// The time of the last change, also of the material function.
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
  std::string BodyArray;
  int JointSize = 0;
  double JointConstraint = 0.5;
  int JointMargin = 4;
  double TissueThreshold;
  bool AnchorRigid = false;
  int AnchoredFaces[6] = { 1, 1, 1, 1, 1, 1 };
  int Mode = MODE_FROM_REST;
  int PropagationMethod = PROPAGATION_ENVELOPE;
  int PropagationIterations = 0;
  int ConflictPolicy = CONFLICT_LIMIT;
  bool PropagationTimes = false;
  vtkNew<vtkDataArraySelection> ModelArraySelection;
  vtkNew<vtkDoubleArray> NoProbes; // servers cannot send a null
  int RelaxationMethod = RELAXATION_PROJECTED;
  int RelaxationPreset = RELAXATION_CUSTOM;
  bool CoarseToFine = false;
  double ElasticRecovery = 1.0;
  bool Rotations = false;
  double PoissonRatio = 0.0;
  int RelaxationIterations = 40;
  double RelaxationTolerance = 1e-3;
  int ModelReduction = 1;
  int Interpolation = INTERPOLATION_LINEAR;
  std::vector<std::string> LabelArrays;
  double BackgroundValue;
  int OutputPadding = 0;
  int OutputMagnification = 1;
  bool UseOutputBounds = false;
  double OutputBounds[6] = { 0.0, 1.0, 0.0, 1.0, 0.0, 1.0 };
  bool SmoothCuts = true;
  bool PullBack = false;
  double ScalarSmoothing = 0.0;
  std::string Device;
  int BrickSize[3] = { 0, 0, 0 };
  vtkSmartPointer<vtkStringArray> AvailableDevices;
  vtkSmartPointer<vtkMultiProcessController> Controller;
  // State that is kept between updates: the engine's model and simulation, and what they were made from.
  class vtkInternals;
  std::unique_ptr<vtkInternals> Internals;
};

#endif
