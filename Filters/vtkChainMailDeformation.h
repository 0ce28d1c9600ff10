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
 * Linked elements with D = 0 (bone) are rigid and move as one. An update takes four steps. With MODE_FROM_REST every
 * update begins at rest, so its result depends on the inputs and properties alone.
 *
 * 1. Cuts and carves: removes every link whose segment crosses a polygon of the `Cuts` input, and every element inside
 *    a closed surface of the `Carves` input, with its links.
 * 2. Probes: holds all probes k at their displacements t_k at once. Tissue follows by as little as (C) allows, to
 *    u_a(i) = clamp(u0_a(i), max_k(t_k - d_a(k,i)), min_k(t_k + d_a(k,i))). Here u0 is the displacement before (0 at
 *    rest), and d_a(k,i) the length of the shortest path from k to i, with D_a as the length of a link. `ProbeReached`
 *    is the displacement that each probe reached. When its wave has ended, a probe that reached less than half of its
 *    displacement or rotation is warned about, with what holds it.
 * 3. Relaxation: lowers the energy, the sum over links and axes of (u_a(i) - u_a(j))^2 / D_a(i,j), in at most
 *    RelaxationIterations steps. (C) holds, and probes and anchors stay where they are. Soft probes, those with a
 *    tolerance T, hold nothing: each element i that a soft probe grips adds (u_a(i) - t_a)^2 / T to the energy, for
 *    every axis.
 * 4. Resampling: output voxel y shows the material at X with X + u(X) = y. Voxels that did not change are copies of the
 *    input, bit for bit; voxels that tissue left show BackgroundValue. Voxels at cut and carved surfaces show a mixture
 *    of tissue and background (SmoothCuts).
 *
 * The method follows "Parallel deformation of heterogeneous ChainMail models: application to interactive deformation of
 * large medical volumes" by Rodriguez, Leon and Arroyo. Its propagation and relaxation are PROPAGATION_TIMESTAMP and
 * RELAXATION_PAPER; the other methods are this library's own (Data/Method.md). All run on an OpenCL device, see Device.
 *
 * @section vtkChainMailDeformation-interactive Interactive use
 *
 * With MODE_INTERACTIVE the state is kept from one update to the next. Only changes since the last update are applied,
 * to the tissue in its present deformed state, in this order:
 *
 * 1. Every `Cuts` surface that is new since the last update, or has moved, cuts. Removing a surface changes nothing.
 * 2. Every `Carves` surface that is new or has moved carves. A surface of either input that returns to a place where it
 *    was since rest, for example by Undo in ParaView, is warned about once: it restores no tissue; Reset() does.
 * 3. Probes. A probe with the position and radius of one that is already held is that same probe. It moves to its
 *    present `Displacement`, which counts from the place of its tissue when it was grabbed. Any other probe grabs the
 *    tissue that is at its position now. Probes that are no longer connected release their tissue where it is.
 * 4. Waves travel for at most PropagationIterations, then relaxation runs for at most RelaxationIterations. This
 *    happens in every update that a changed input or Modified() triggers. GetNeedsUpdate() tells whether there is more
 *    to do, and makes the next Update() do it:
 * `do { filter->Update(); show(); } while (filter->GetNeedsUpdate());`
 *
 * A change of the tissue (the image, its scalars, place or spacing, material, bodies, anchors, ModelReduction, Device,
 * BrickSize), or a switch to this mode, starts from rest and applies everything that is connected. New arrays with
 * equal values, for example from a reader that ran again, are the same tissue: the state is kept.
 *
 * An update that fails leaves the state usable: the next update continues from it, without repeating a cut that was
 * made before the failure. An update that is stopped (AbortExecute) releases all probes and leaves tissue at rest, with
 * its cuts and carves.
 *
 * @section vtkChainMailDeformation-errors Errors
 *
 * An update that fails reports one error and sets the error code (GetErrorCode()). A number without a meaning in an
 * enumerated property is an error, too. Both outputs are then the last good ones. Where none fits the image, output 0
 * is the image as it is, and output 1 its grid without point arrays. The message is in the field array `Error` of both.
 * The pipeline counts the update as done.
 *
 * @section vtkChainMailDeformation-inputs Input ports
 *
 * All positions and vectors are in world axes and in the image's physical units (mm for medical data).
 *
 * - 0, the image: vtkImageData with point scalars of any numeric type, volume or single slice. Of scalars with several
 *   components the first is read. Scalars that are NaN or infinite are air; a warning gives their number once. Padding
 *   above all other scalars is air, too, see vtkChainMailScanStatistics. The direction matrix has to be orthonormal;
 *   flipped axes are fine. Cell data alone are an error: convert them with vtkCellDataToPointData.
 * - 1, `Probes` (optional, repeatable): vtkPointSet; every point is a probe that grabs tissue. Point arrays:
 *   `Displacement` (3 components, [mm]; needed unless every point is an anchor), `Radius` (optional, [mm], default 0:
 *   the nearest element), `Anchor` (optional, default 0; not 0: the tissue is held where it is), `Tolerance` (optional,
 *   [mm], default 0; above 0 the probe is soft: relaxation weighs it against the tissue, so it moves nothing with
 *   RelaxationIterations 0). With the point array `Rotation` (3 components: a rotation vector, along the axis and as
 *   long as the angle [degrees], of any length) a probe also rotates what it grabs, about `Centre` (3 components,
 *   optional, [mm], default the point itself): x moves to Centre + Displacement + R (x - Centre). Such a probe grips
 *   the whole rigid cluster of each rigid element that it grabs. The cluster reaches exactly this pose unless the probe
 *   is soft; relaxation determines the rotations of all other elements. `Body` (optional) is a label of BodyArray: the
 *   probe grips the voxels with this label, and the rigid clusters that they belong to, instead of what is at the
 *   point; -1: what is at the point. A rotation needs Rotations, a constraint that is the same along all axes and
 *   PropagationIterations 0. An element has one holder, and any number of soft probes besides. For a soft probe
 *   `ProbeReached` is the mean over its elements, and `ProbeForce` the force with which the probe pulls them. A probe
 *   whose tissue is held by other probes, or was carved away, moves nothing and is warned about once. Warnings give the
 *   number of the probes concerned and name the first few.
 * - 2, `Cuts` (optional, repeatable): vtkPolyData; polygons and triangle strips are blades.
 * - 3, `Carves` (optional, repeatable): vtkPolyData; each input is one closed surface of polygons and triangle strips,
 *   of any number of parts. Elements inside any part are removed and show BackgroundValue; normals may point outwards
 *   or inwards. A part that lies within others and faces the other way is a hollow: what is inside it stays. If the
 *   triangles of a part face both ways, every part within others is a hollow. Both cases are warned about once. A
 *   surface that is not closed is an error.
 * - 4, `Regions` (optional, repeatable): vtkPointSet; every point is the centre of a ball with the radius in the point
 *   array `Radius` [mm]. Tissue in the ball gets the constraint in `Constraint`. Where balls overlap the later one
 *   counts. A ball without tissue is warned about.
 *
 * A surface that meets no tissue is warned about once, until it meets some, and named in GetReport(). A polygon that
 * crosses itself is warned about. The inputs 1 to 4 may be composite datasets, which count as the list of their
 * datasets. Each closed dataset of `Carves` is a surface of its own, and all open ones together form one surface. A
 * composite image is an error. The outputs have the time steps of all inputs together.
 *
 * @section vtkChainMailDeformation-outputs Output ports
 *
 * - 0, the deformed image: the input's geometry, extended by OutputPadding, finer by OutputMagnification and limited by
 *   OutputBounds, and all its point arrays, each resampled in its own type. Global ids become an ordinary array. Cell
 *   arrays are not passed on, which is warned about once. With PullBack it also has `PullBack` (3 floats, world axes,
 *   [mm]): the vector from a voxel to where its material was at rest, 0 where nothing moved, NaN in the background. An
 *   input array of that name is then not passed on. With ScalarSmoothing it also has the smoothed scalars (float),
 *   named like the scalars with " smooth" appended. They replace an input array of that name, too. A smoothed value is
 *   the mean of the scalars, weighted by the Gaussian up to three standard deviations away. Values that are not finite,
 *   and paddings of a scanner, stay as they are and have no weight for other voxels. Marks of ghost and blank voxels
 *   and cells (`vtkGhostType`) belong to the grid and stay in place; voxels added by OutputPadding have none.
 * - 1, the model at rest on the input's grid, with those point arrays that were chosen (ModelArrays): `Displacement` (3
 *   floats, world axes, [mm]), `Element` (unsigned char: 0 air or carved away, 1 tissue), `Constraint` (float, fraction
 *   of the spacing; 1 component, or 3 along the image's axes; 0 in air) and `Cluster` (int, number of the rigid
 *   cluster, -1 none; components as `Constraint`). The active scalars are `Displacement`, because some writers write no
 *   other array; without it `Element`. With PropagationTimes it also has `PropagationTime` (float, components as
 *   `Constraint`: the length of the path from its probe by which the last wave came to the element, as the sum of D
 *   along its links [mm]; with 1 component along the image's x axis; -1: no wave came) and `Wavefront` (int, components
 *   as `Constraint`: the number of that wave since rest, from 1 on; 0 none). Where something is cut or carved,
 *   `Displacement` comes with `Links` (unsigned char), by which vtkChainMailCarry tells the sides of a cut apart. It is
 *   the sum of 1 for a link to the neighbour at x-, 2 for x+, 4 for y-, 8 for y+, 16 for z- and 32 for z+; 64 where
 *   tissue was carved away; 0 in air.
 *
 * Both have the input's field data, except arrays of the names below, and these field arrays: `ProbeReached` (3 per
 * probe: its displacement since it grabbed, world axes, [mm]), `ProbeForce` (3 per probe: the gradient of the energy by
 * the displacement of the elements it holds, which is the force it pulls them with, world axes, no unit), `ProbeTurned`
 * (3 per probe: its rotation vector since it grabbed [degrees], world axes; 0 without `Rotation`; with it,
 * `ProbeReached` is the displacement of `Centre`), `ProbeTorque` (3 per probe: the gradient of the energy by its
 * rotation about the displaced `Centre`, per radian, world axes; 0 without `Rotation`), `Energy` [mm] (with
 * ElasticRecovery r below 1 only strain of more than (1 - r) D counts), `MaxLinkExcess` (largest violation of (C),
 * fraction of the spacing), `PropagationIterationsUsed`, `RelaxationIterationsUsed`, `CoarseToFineStep` (the share of
 * the correction by coarser grids that was applied: 1 all, 0 none; -1 where the last relaxation did not start on
 * coarser grids), `DisplacedElements` (number of elements away from their rest place), `Milliseconds` (upload,
 * propagate, relax, resample, download; 0 for steps that were not needed),
 * `PeakDeviceMemory` (the peak during this update of the memory that all filters of this class in the process held on
 * the device [MB]) and `DeviceName`. With BodyArray or JointSize there are also, one row for each number of `Cluster`,
 * `BodyVoxels`, `BodyLabel` (with BodyArray) and `BodyHeldBy` (0 nothing, 1 a face of the image, 2 AnchorRigid, 3 a
 * probe). Where `Cluster` has 3 components, these rows are about the clusters along x.
 *
 * @section vtkChainMailDeformation-parallel Pieces and processes
 *
 * Any piece of the outputs equals that piece of the whole, bit for bit. Every update requests all of all inputs and
 * computes the whole, once for all its pieces. The processes of a parallel server (see SetController()) send their
 * inputs to the first process, which computes and distributes the pieces. Equal datasets of several processes count
 * once; other datasets are joined in order of the processes. Errors and field data are the same everywhere. As with all
 * images in VTK, neighbouring pieces share a plane of points: filters that count points (Histogram) count such planes
 * twice.
 *
 * @section vtkChainMailDeformation-limitations Limitations
 *
 * Constraints are geometric limits, not moduli: forces have no physical unit. Links join face neighbours only, so
 * stiffness depends on the direction relative to the grid. With constraints above 1/3, or between flaps that a cut
 * separates, tissue can fold over itself; the resampling then shows one layer. Where two cut surfaces meet in a cell
 * they are shown in steps of a voxel, and vtkChainMailCarry follows these steps. There may be at most 2^31 voxels with
 * padding. OutputMagnification shows displacements and cuts finer; between the scan's voxels its values are
 * interpolated. More processes make updates no faster and allow no larger image. A blade that moves between two updates
 * cuts where updates find it, not along its path. A saved pipeline does not contain the state of MODE_INTERACTIVE: it
 * starts from rest.
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
   * Gives an image the grid of the scan, the BodyArray, if there is one, and the present point array `Cluster` of
   * output 1, whether ModelArrays has it or not. Returns false where there is no result: before the first update, after
   * an update that failed or was stopped, and on a process for which another one computes.
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
   * The source of the material. MATERIAL_FUNCTION (0): MaterialFunction and TissueThreshold. MATERIAL_CT (1): scalars
   * are Hounsfield units, air is below -300, skin and fat are soft, spongy bone is stiff, compact bone is rigid from
   * 600 up (contrast agent stays below that). MATERIAL_MR (2): T1-weighted, any range: air ends at a tenth of the way
   * from air to the brightest voxels, fat (bright) is softer than muscle, and nothing is rigid because bone is as dark
   * as air. Both presets have their own threshold and do not read MaterialFunction and TissueThreshold. A preset that
   * does not suit the scalars is warned about once. Default: MATERIAL_FUNCTION.
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
   * for the image's axes. It replaces the material function, but not TissueThreshold. Default: "", none.
   */
  vtkSetStdStringFromCharMacro(ConstraintArray);
  vtkGetCharFromStdStringMacro(ConstraintArray);
  ///@}

  ///@{
  /**
   * Name of a point array of labels, whole numbers such as one for each bone. Rigid voxels of different labels belong
   * to different bodies, with a joint where the bodies touch. 0 is no label: connected rigid voxels without a label are
   * a body of their own. Resampling takes the nearest voxel of this array, see LabelArrays. Not with ModelReduction.
   * Default: "", none.
   */
  vtkSetStdStringFromCharMacro(BodyArray);
  vtkGetCharFromStdStringMacro(BodyArray);
  ///@}

  ///@{
  /**
   * Rigid tissue without a label is a joint where it is thinner than this number of voxels and connects parts of at
   * least twice this thickness (with their marrow). Thin tissue belongs to the nearest body. A larger size finds
   * thicker joints, but fewer in total. [0, 256], 0: none; not with ModelReduction. Default: 0.
   */
  vtkSetClampMacro(JointSize, int, 0, 256);
  vtkGetMacro(JointSize, int);
  ///@}

  ///@{
  /**
   * Constraint of joints, [0, 1], as a fraction of the spacing. A joint is the layer of voxels of the larger of two
   * bodies that touch the other one. 0: bodies that touch stay in one piece. 1: joints are free, so bodies slide and
   * rotate in them, because no links connect the tissue of two bodies (JointMargin). The image is continuous across
   * free joints. Default: 0.5.
   */
  vtkSetClampMacro(JointConstraint, double, 0.0, 1.0);
  vtkGetMacro(JointConstraint, double);
  ///@}

  ///@{
  /**
   * Where joints are free (JointConstraint 1), tissue within this number of voxels of a body belongs to it, nearest
   * body first. This is how far joints extend into the tissue between and around two bodies. [1, 100]. Default: 4.
   */
  vtkSetClampMacro(JointMargin, int, 1, 100);
  vtkGetMacro(JointMargin, int);
  ///@}

  ///@{
  /**
   * Voxels with a smaller scalar are air. NaN: a threshold that fits the scalars, see vtkChainMailScanStatistics.
   * GetReport() tells what the scalars were taken for; doubts about it are warned about once. Default: NaN.
   */
  virtual void SetTissueThreshold(double threshold);
  vtkGetMacro(TissueThreshold, double);
  ///@}

  /**
   * The material for a known range of scalars, for example that of a modality. With range[0] < -200 it is MATERIAL_CT.
   * Otherwise air ends at a tenth of the range, and stiffness grows with the scalar without ever becoming rigid. One
   * wrong voxel spoils the range of a scan: for scans use vtkChainMailScanStatistics::GetMaterial(). `function` may be
   * null.
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
   * Hold the tissue that touches these faces of the image, because the patient's body continues there: x- x+ y- y+ z-
   * z+ along the image's axes; 0 leaves a face free. An axis with a single voxel has no faces. Default: 1 1 1 1 1 1.
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
   * MODE_INTERACTIVE (1): an update continues from the state of the last one, see "Interactive use" above. Default:
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
   * so the output is the input, bit for bit. No effect with MODE_FROM_REST.
   */
  void Reset();

  /**
   * Whether another update would change the output although no input and no property did. With MODE_INTERACTIVE this is
   * so until waves have finished and relaxation has converged, and after Reset(), but not after an update that failed
   * or was stopped. This function then calls Modified(), so Update() continues. With several processes it does not:
   * call Modified() on each process.
   */
  bool GetNeedsUpdate();

  /**
   * What the last update did, a line for each sentence: what every probe reached, what holds a probe that reached less
   * than 90 % of its displacement or rotation, surfaces that removed nothing, bodies and which of them are held, the
   * number of elements that moved, whether relaxation converged, time and memory; or why the update failed.
   */
  const char* GetReport();

  /**
   * `ProbeReached` of the outputs, a tuple of 3 for each probe; without tuples before the first update.
   */
  vtkDataArray* GetProbeReached();

  ///@{
  /**
   * Whether filters of this process warn about a probe that holds no tissue of its own, or that reached less than half
   * of its displacement or rotation, and about probes that share although ConflictPolicy is not CONFLICT_SHARE. The
   * report always tells the first two, so an application that shows the report needs no warnings. Default: on.
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
   * How a wave of displacement travels. PROPAGATION_ENVELOPE (0): every element is clamped to the bounds that moved
   * neighbours set, until nothing changes. PROPAGATION_TIMESTAMP (1), the published method: one link per iteration, the
   * earliest arrival counts. A single wave gives the same displacements either way, up to float rounding. With
   * MODE_INTERACTIVE a change of this property first completes the waves that are under way. Default:
   * PROPAGATION_ENVELOPE.
   */
  vtkSetMacro(PropagationMethod, int);
  vtkGetMacro(PropagationMethod, int);
  void SetPropagationMethodToEnvelope() { this->SetPropagationMethod(PROPAGATION_ENVELOPE); }
  void SetPropagationMethodToTimestamp() { this->SetPropagationMethod(PROPAGATION_TIMESTAMP); }
  ///@}

  ///@{
  /**
   * Maximum number of propagation iterations of an update, [0, VTK_INT_MAX]; 0: until all waves have ended. With
   * MODE_INTERACTIVE an unfinished wave continues in the next update; until then links at its front may violate (C).
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
   * What happens where probes pull tissue further apart than it stretches; anchors always hold. CONFLICT_LIMIT (0): the
   * displacement of the later probe is limited, per axis, to what the earlier ones allow. CONFLICT_LATEST (1), as
   * published: the later probe wins and drags the tissue of earlier ones along. CONFLICT_SHARE (2), with
   * PROPAGATION_ENVELOPE: probes that start together share. Each element that they hold moves to the mean of the least
   * and the greatest displacement that the targets of all other probes allow it, so elements of one probe may separate.
   * Sharing takes the time of a few waves for any number of probes. So with PROPAGATION_ENVELOPE more than 32 probes
   * that start together and are incompatible share under every policy, and a warning says so. With MODE_FROM_REST all
   * probes start together. Default: CONFLICT_LIMIT.
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
   * waves came. With MODE_INTERACTIVE a change applies to later waves only. Default: off.
   */
  vtkSetMacro(PropagationTimes, bool);
  vtkGetMacro(PropagationTimes, bool);
  vtkBooleanMacro(PropagationTimes, bool);
  ///@}

  /**
   * ModelArrays: which of the arrays Displacement, Element, Constraint and Cluster output 1 has. The others cost
   * nothing; choosing one later adds it without another deformation. Default: Displacement and Element.
   */
  vtkDataArraySelection* GetModelArraySelection();

  enum RelaxationMethods
  {
    RELAXATION_PROJECTED = 0,
    RELAXATION_PAPER = 1
  };

  ///@{
  /**
   * How the energy is lowered. RELAXATION_PROJECTED (0): over-relaxation projected to (C), in which the energy never
   * rises. RELAXATION_PAPER (1), as published, for comparison: moves all elements at once (Jacobi) to the weighted mean
   * of their neighbours. It leaves links too long (`MaxLinkExcess`), locks rigid tissue, and may never converge.
   * Default: RELAXATION_PROJECTED.
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
   * How thorough the relaxation of an update is. RELAXATION_CUSTOM (0): as CoarseToFine, RelaxationIterations and
   * RelaxationTolerance say. The other presets stand for values of these three, in this order, and leave the properties
   * unchanged (costs and errors: Data/Choosing.md). RELAXATION_FAST (1), for dragging: off, 10, 1e-3.
   * RELAXATION_BALANCED (2), for a picture: on, 20, 1e-3. RELAXATION_ACCURATE (3), for measuring: on, 170 (with
   * Rotations or RELAXATION_PAPER 1000), 1e-5. Default: RELAXATION_CUSTOM.
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
   * Whether RELAXATION_PROJECTED starts on coarser grids after a pull, cut or carve. A few iterations then achieve what
   * takes hundreds on the fine grid alone, at the cost of some tens. Tissue far from the probes relaxes, too. Default:
   * off.
   */
  vtkSetMacro(CoarseToFine, bool);
  vtkGetMacro(CoarseToFine, bool);
  vtkBooleanMacro(CoarseToFine, bool);
  ///@}

  ///@{
  /**
   * The share r of the strain that recovers when tissue is released, in [0, 1]: strain of a link up to (1 - r) of its
   * limit D costs no energy and stays. 1: elastic; 0: plastic, all strain stays. Default: 1.
   */
  vtkSetClampMacro(ElasticRecovery, double, 0.0, 1.0);
  vtkGetMacro(ElasticRecovery, double);
  ///@}

  ///@{
  /**
   * Whether tissue and bones rotate. Off: the published model, in which a bone only translates and tissue resists
   * rotation. On: a rotation of tissue as a whole costs no energy. A bone rotates freely about one voxel that a probe
   * holds, and about the axis through two held voxels. It does not rotate with more held voxels, with an anchor, or
   * with three constraints per voxel. Relaxation takes 2 to 4 times as long. Needs PROPAGATION_ENVELOPE,
   * RELAXATION_PROJECTED and ElasticRecovery 1. A change starts from rest. Default: off.
   */
  vtkSetMacro(Rotations, bool);
  vtkGetMacro(Rotations, bool);
  vtkBooleanMacro(Rotations, bool);
  ///@}

  ///@{
  /**
   * Poisson's ratio n of tissue that rotates, in [0, 0.49]: tissue compressed by a strain s expands sideways by n s,
   * and loses (1 - 2 n) s of its volume. Other than 0 it needs Rotations and twice their memory. An iteration takes 2
   * to 3 times as long, and from 0.4 on more iterations are needed (Data/Choosing.md). A change starts from rest.
   * Default: 0.
   */
  vtkSetClampMacro(PoissonRatio, double, 0.0, 0.49);
  vtkGetMacro(PoissonRatio, double);
  ///@}

  ///@{
  /** Maximum number of relaxation iterations of an update, [0, VTK_INT_MAX]; 0: propagation only. Default: 40. */
  vtkSetClampMacro(RelaxationIterations, int, 0, VTK_INT_MAX);
  vtkGetMacro(RelaxationIterations, int);
  ///@}

  ///@{
  /**
   * Relaxation stops after an iteration in which no element moved more than this fraction of the spacing, [0,
   * VTK_DOUBLE_MAX]. Default: 1e-3.
   */
  vtkSetClampMacro(RelaxationTolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(RelaxationTolerance, double);
  ///@}

  ///@{
  /**
   * Number of voxels per element along each axis (of more than one voxel): 1, 2, 4 or 8. Propagation and relaxation
   * become faster by nearly its cube, and less exact. All other parts of an update take as long as before, and memory
   * is not reduced. Images are still resampled, cut and carved voxel by voxel; displacements are interpolated between
   * elements on the same side of every cut. An element exists where one of its voxels is tissue, and its constraint is
   * their mean. It is rigid or anchored where one of its voxels is. So bone never bends, but is thicker, and bodies
   * closer than an element may stick together. Energy and forces are comparable with those of the whole model;
   * MaxLinkExcess, DisplacedElements and RelaxationTolerance refer to the reduced elements. Any other number is an
   * error. Default: 1.
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
   * How arrays are sampled. INTERPOLATION_LINEAR (0): trilinear, integers rounded to the nearest. Values outside tissue
   * that are not finite, and paddings, have no weight in this. INTERPOLATION_NEAREST (1): the nearest voxel, which
   * labels (also scalars taken for labels), ids, bits, strings and variants always take. Default: INTERPOLATION_LINEAR.
   */
  vtkSetMacro(Interpolation, int);
  vtkGetMacro(Interpolation, int);
  void SetInterpolationToLinear() { this->SetInterpolation(INTERPOLATION_LINEAR); }
  void SetInterpolationToNearest() { this->SetInterpolation(INTERPOLATION_NEAREST); }
  ///@}

  ///@{
  /** Names of the input's point arrays that hold labels, which are sampled at the nearest voxel. Default: none. */
  void AddLabelArray(const char* name);
  void RemoveLabelArray(const char* name);
  void ClearLabelArrays();
  int GetNumberOfLabelArrays() const;
  const char* GetLabelArray(int index) const;
  bool HasLabelArray(const char* name) const;
  ///@}

  ///@{
  /**
   * Value of the scalars where tissue has left and in the padding, clamped to the range of the array's type. NaN: the
   * value of air, see vtkChainMailScanStatistics. In all other arrays, and scalars of several components, it is the
   * smallest finite value, by component; bits are 0, strings empty. Default: NaN.
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
   * How many voxels output 0 has along each axis for one of the input, 1 to 4. The image keeps its place, and its
   * spacing is divided by this number. Values between the input's voxels are interpolated, but displacements and cut
   * surfaces are known there: so deformed, cut and carved tissue is shown finer. An axis with a single voxel keeps that
   * one. With 2 each array has 8 times as many values, with 4 it has 64 times as many; OutputBounds limit the output to
   * a box. An output that does not fit into the free main memory is an error, which names its size. Default: 1.
   */
  vtkSetClampMacro(OutputMagnification, int, 1, 4);
  vtkGetMacro(OutputMagnification, int);
  ///@}

  ///@{
  /**
   * Whether output 0 is only a part of the image: the smallest extent that holds the box of OutputBounds, within the
   * image and its padding. All tissue is deformed, whatever is shown. Default: off.
   */
  vtkSetMacro(UseOutputBounds, bool);
  vtkGetMacro(UseOutputBounds, bool);
  vtkBooleanMacro(UseOutputBounds, bool);
  ///@}

  ///@{
  /**
   * The box for UseOutputBounds: xmin, xmax, ymin, ymax, zmin, zmax [mm, world axes]. Where the image's axes are
   * oblique, output 0 is the smallest part of the image that holds the box. A box that the image does not meet is an
   * error. Default: 0 1 0 1 0 1.
   */
  vtkSetVector6Macro(OutputBounds, double);
  vtkGetVector6Macro(OutputBounds, double);
  ///@}

  ///@{
  /**
   * Whether cut and carved surfaces are shown where the blade went, and not in steps of a voxel. A voxel at a surface
   * shows a mixture: the share of it on the tissue's side shows tissue, the rest BackgroundValue. So surfaces are
   * smooth at any angle. Off: each voxel shows tissue or background, depending on its nearest element. Labels, all
   * arrays with INTERPOLATION_NEAREST and PullBack are never mixed: the larger share decides. Default: on.
   */
  vtkSetMacro(SmoothCuts, bool);
  vtkGetMacro(SmoothCuts, bool);
  vtkBooleanMacro(SmoothCuts, bool);
  ///@}

  ///@{
  /**
   * Whether output 0 has the array PullBack: 12 bytes a voxel, and as much again for the next update. It is the inverse
   * map that resampling uses, so it includes cuts and carves, which the displacements of the model at rest do not.
   * Default: off.
   */
  vtkSetMacro(PullBack, bool);
  vtkGetMacro(PullBack, bool);
  vtkBooleanMacro(PullBack, bool);
  ///@}

  ///@{
  /**
   * The standard deviation of a Gaussian filter [voxels of the input], from 0 to 2. Above 0, output 0 also has a
   * smoothed copy of the scalars, for a picture of the volume without grain. The edge of skin is a voxel wide in a
   * scan, so its steps and noise look like wood in a rendering. 0.75 removes the grain and keeps the rest; above 1
   * wounds lose their colours. The copy takes 4 bytes a voxel, and as much again for the next update. Labels, and all
   * scalars with INTERPOLATION_NEAREST, are copied without smoothing. Default: 0.
   */
  vtkSetClampMacro(ScalarSmoothing, double, 0.0, 2.0);
  vtkGetMacro(ScalarSmoothing, double);
  ///@}

  ///@{
  /**
   * The OpenCL device: the one of this name, else the first whose name contains this text, in upper or lower case.
   * AvailableDevices lists the names, which are unique. Default: "", the best GPU, else PoCL's processor. A GPU whose
   * driver is not from its vendor is used only if it is named here or was tested (Data/Install.md).
   */
  vtkSetStdStringFromCharMacro(Device);
  vtkGetCharFromStdStringMacro(Device);
  ///@}

  /// Names of the OpenCL devices of this machine, best first. Devices of equal names get the name of their platform,
  /// "NAME (PLATFORM)", or a number, "NAME (2)". The filter owns the array; every call creates a new one.
  vtkStringArray* GetAvailableDevices();

  ///@{
  /**
   * Elements per brick, the unit of memory and work on the device: each 0 (the best for the device) or a power of two,
   * x in [4, 64], y and z in [2, 32]. It changes the speed, but no result. Default: 0 0 0.
   */
  vtkSetVector3Macro(BrickSize, int);
  vtkGetVector3Macro(BrickSize, int);
  ///@}

  ///@{
  /**
   * The processes that update this filter together, each requesting its own piece, as on a parallel server. Null: this
   * process works alone. Default: the global controller.
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
  vtkNew<vtkDoubleArray> NoProbes; // in place of null, which servers cannot send
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
  // State kept between updates: the engine's model and simulation, and what they were made from.
  class vtkInternals;
  std::unique_ptr<vtkInternals> Internals;
};

#endif
