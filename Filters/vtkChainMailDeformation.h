// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailDeformation
 * @brief   deform a volume like tissue: grab it with probes, cut it with blades, carve parts away
 *
 * Every voxel whose scalar is at least TissueThreshold becomes a ChainMail element; the others are air. An element
 * follows its face neighbours with some slack: with the displacement u(i), and the constraint D_a(i) of element i along
 * axis a, a fraction of the spacing in [0, 1) times the spacing, every link obeys
 *
 *     |u_a(i) - u_a(j)| <= D_a(i,j) = (D_a(i) + D_a(j)) / 2                 (C)
 *
 * Linked elements with D = 0 (bone) are rigid and move as one. An update takes four steps:
 *
 * 1. `Cuts` remove the links that they cross, and `Carves` the elements inside them.
 * 2. `Probes` hold tissue at their displacements. All other tissue follows by as little as (C) allows.
 * 3. Relaxation lowers the energy, the sum over links and axes of (u_a(i) - u_a(j))^2 / D_a(i,j). (C) holds, and probes
 *    and anchors stay where they are.
 * 4. Resampling: voxel y of output 0 shows the material at X with X + u(X) = y. Output 1 is the model at rest.
 *
 * The method follows "Parallel deformation of heterogeneous ChainMail models: application to interactive deformation of
 * large medical volumes" by Rodriguez, Leon and Arroyo. Its propagation and relaxation are PROPAGATION_TIMESTAMP and
 * RELAXATION_PAPER; the other methods are this library's own (Data/Method.md). All run on an OpenCL device, see Device.
 *
 * The manual is in Data/: Using.md (modes, errors), Arrays.md (ports and their arrays), Bones.md, Output.md and
 * Processes.md. The README lists the limitations.
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
   * an update that failed or was stopped, and on all processes of a parallel run but the first. Where the image is
   * spread over processes, CollectBodies() has to come first.
   */
  bool GetBodies(vtkImageData* image);

  /**
   * Collects in the first process of a parallel run what GetBodies() gives there until the next update. All processes
   * have to call it together, because the first one asks the others for voxels. Elsewhere it does nothing.
   */
  void CollectBodies();

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
   * Rigid tissue without a label is a joint where it is thinner than this number of voxels and connects parts more than
   * twice as thick (with their marrow). Smaller parts belong to a neighbour. A larger size finds the same joints and
   * thicker ones. [0, 256], 0: none; not with ModelReduction. Default: 0.
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
   * MODE_INTERACTIVE (1): an update continues from the state of the last one, see Data/Using.md. Default:
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
   * How thorough the relaxation of an update is. RELAXATION_CUSTOM (0): as CoarseToFine, RelaxationIterations,
   * RelaxationTolerance and RelaxationError say. The other presets stand for values of these four, in this order, and
   * leave the properties unchanged (costs and errors: Data/Choosing.md). RELAXATION_FAST (1), for dragging: off, 10,
   * 1e-3, 0. RELAXATION_BALANCED (2), for a picture: on, 68, 1e-4, 0.01 (with Rotations or RELAXATION_PAPER 20, 1e-3,
   * 0). RELAXATION_ACCURATE (3), for measuring: on, 220, 1e-5, 7e-4 (with Rotations or RELAXATION_PAPER 1000, 1e-5,
   * 0). Default: RELAXATION_CUSTOM.
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
   * takes hundreds on the fine grid alone, at the cost of some tens. Tissue far from the probes relaxes, too. Some
   * of 20 or more iterations are spent on corrections, each of which counts as 12 (Data/Method.md). Default: off.
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
   * With CoarseToFine relaxation also stops where tissue is estimated to be this close to the optimum, [0,
   * VTK_DOUBLE_MAX]: the root mean square of the distances of displaced elements, as a fraction of the largest
   * displacement. The estimate follows from how far the last iterations have moved the tissue (Data/Method.md). It is
   * made every 16 iterations at first, later less often. About one in ten random pulls ends further from the optimum
   * than estimated (Data/Choosing.md); with Rotations this was not measured. With RELAXATION_PAPER, and without
   * CoarseToFine, there is no estimate, nor with 0. Default: 0.
   */
  vtkSetClampMacro(RelaxationError, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(RelaxationError, double);
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
   * padded. More than 2^38 voxels with the padding, or more than fit into the main memory, are an error. Default: 0.
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
   * The processes that update this filter together, each requesting its own piece, as on a parallel server. Each asks
   * its source for its own piece of the image, and makes its own pieces of the outputs; the first one computes the
   * deformation. Null: this process works alone. Default: the global controller.
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
  double RelaxationError = 0.0;
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
