// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailDeformation.h"

#include "Device.h"
#include "Error.h"
#include "Model.h"
#include "Private/Exchange.h"
#include "Private/Fingerprint.h"
#include "Private/Inputs.h"
#include "Private/ProbeWarnings.h"
#include "Private/SurfaceHistory.h"
#include "Simulation.h"
#include "vtkChainMailSampling.h"

#include "vtkBitArray.h"
#include "vtkCellArray.h"
#include "vtkCellArrayIterator.h"
#include "vtkCellData.h"
#include "vtkCleanPolyData.h"
#include "vtkCommand.h"
#include "vtkDoubleArray.h"
#include "vtkErrorCode.h"
#include "vtkFeatureEdges.h"
#include "vtkFieldData.h"
#include "vtkFloatArray.h"
#include "vtkIdList.h"
#include "vtkIdTypeArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkMath.h"
#include "vtkMatrix3x3.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPointData.h"
#include "vtkPointSet.h"
#include "vtkPolyData.h"
#include "vtkSMPTools.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkStringArray.h"
#include "vtkTriangleFilter.h"
#include "vtkUnsignedCharArray.h"
#include "vtkVersionMacros.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <iomanip>
#include <iterator>
#include <limits>
#include <map>
#include <new>
#include <numeric>
#include <set>
#include <sstream>
#include <tuple>

using chainmail::InputError;
using chainmail::Vector3;
using vtkChainMail::CARVES;
using vtkChainMail::CUTS;
using vtkChainMail::Exchange;
using vtkChainMail::Fingerprint;
using vtkChainMail::FingerprintOf;
using vtkChainMail::IMAGE;
using vtkChainMail::Inputs;
using vtkChainMail::InputSurface;
using vtkChainMail::Leaf;
using vtkChainMail::Outcome;
using vtkChainMail::PROBES;
using vtkChainMail::SurfaceHistory;

namespace
{

// The rows of the field array Milliseconds.
enum Times
{
  UPLOAD,
  PROPAGATE,
  RELAX,
  RESAMPLE,
  DOWNLOAD,
  NUMBER_OF_TIMES
};

//------------------------------------------------------------------------------
std::string ToString(const double p[3])
{
  std::ostringstream text;
  text << "(" << p[0] << ", " << p[1] << ", " << p[2] << ")";
  return text.str();
}

bool IsFinite(const double p[3])
{
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/// "It has: a, b." for messages about names that are not there.
std::string ListArrays(vtkFieldData* arrays)
{
  std::string list;
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    const char* name = arrays->GetArrayName(a);
    if (name)
    {
      list += (list.empty() ? "" : ", ") + std::string(name);
    }
  }
  return list.empty() ? "It has none." : "It has: " + list + ".";
}

//------------------------------------------------------------------------------
/// A new array of numbers with room for so many tuples, see vtkChainMailSampling::Allocate().
template <typename ArrayType>
vtkSmartPointer<ArrayType> MakeArray(const char* name, int components, vtkIdType tuples, bool zeros = false)
{
  auto array = vtkSmartPointer<ArrayType>::New();
  array->SetName(name);
  array->SetNumberOfComponents(components);
  vtkChainMailSampling::Allocate(array, tuples, zeros);
  return array;
}

//------------------------------------------------------------------------------
/// World space against the engine's: lengths along the image's axes from the centre of its first voxel.
class Frame
{
public:
  explicit Frame(vtkImageData* image)
  {
    image->GetOrigin(this->Origin.data());
    image->GetSpacing(this->Spacing.data());
    std::copy_n(image->GetDirectionMatrix()->GetData(), 9, this->Direction.data());
    int extent[6];
    image->GetExtent(extent);
    for (int a = 0; a < 3; ++a)
    {
      this->First[a] = extent[2 * a] * this->Spacing[a];
    }
    for (int a = 0; a < 3; ++a)
    {
      for (int b = 0; b < 3; ++b)
      {
        double product = 0.0;
        for (int row = 0; row < 3; ++row)
        {
          product += this->Direction[3 * row + a] * this->Direction[3 * row + b];
        }
        // Direction cosines in image files are often written with six digits.
        if (!(std::fabs(product - (a == b ? 1.0 : 0.0)) < 1e-4))
        {
          throw InputError("The direction matrix of the input image is not orthonormal: its columns have to be unit "
                           "vectors at right angles. Resample the image onto such a grid.");
        }
      }
    }
  }

  Vector3 PointToEngine(const double world[3]) const
  {
    const double fromOrigin[3] = { world[0] - this->Origin[0], world[1] - this->Origin[1], world[2] - this->Origin[2] };
    Vector3 engine = this->VectorToEngine(fromOrigin);
    for (int a = 0; a < 3; ++a)
    {
      engine[a] -= this->First[a];
    }
    return engine;
  }

  Vector3 VectorToEngine(const double world[3]) const
  {
    const double* d = this->Direction.data();
    return { d[0] * world[0] + d[3] * world[1] + d[6] * world[2], d[1] * world[0] + d[4] * world[1] + d[7] * world[2],
      d[2] * world[0] + d[5] * world[1] + d[8] * world[2] };
  }

  template <typename T> void VectorToWorld(const T engine[3], T world[3]) const
  {
    const double v[3] = { engine[0], engine[1], engine[2] };
    const double* d = this->Direction.data();
    for (int a = 0; a < 3; ++a)
    {
      world[a] = static_cast<T>(d[3 * a] * v[0] + d[3 * a + 1] * v[1] + d[3 * a + 2] * v[2]);
    }
  }

  bool operator==(const Frame& other) const
  {
    return this->Origin == other.Origin && this->Spacing == other.Spacing && this->First == other.First &&
           this->Direction == other.Direction;
  }

  bool IsRotated() const { return this->Direction != std::array<double, 9>{ { 1, 0, 0, 0, 1, 0, 0, 0, 1 } }; }

  const Vector3& GetSpacing() const { return this->Spacing; }

private:
  Vector3 Origin;
  Vector3 Spacing;
  Vector3 First;
  std::array<double, 9> Direction; // row by row; its columns are the image's axes
};

//------------------------------------------------------------------------------
/// What the engine reads: bits as bytes, anything else in its own type.
vtkSmartPointer<vtkDataArray> ToEngineArray(vtkDataArray* array)
{
  if (vtkBitArray* bits = vtkBitArray::SafeDownCast(array))
  {
    const auto bytes =
      MakeArray<vtkUnsignedCharArray>(array->GetName(), array->GetNumberOfComponents(), array->GetNumberOfTuples());
    for (vtkIdType v = 0; v < bytes->GetNumberOfValues(); ++v)
    {
      bytes->SetValue(v, static_cast<unsigned char>(bits->GetValue(v)));
    }
    return bytes;
  }
  return vtkChainMailSampling::Interleaved(array);
}

template <typename T> constexpr chainmail::ArrayView::Type EngineType()
{
  using Type = chainmail::ArrayView::Type;
  if constexpr (std::is_floating_point<T>::value)
  {
    return sizeof(T) == 4 ? Type::Float32 : Type::Float64;
  }
  else if constexpr (std::is_signed<T>::value)
  {
    return sizeof(T) == 1 ? Type::Int8 : sizeof(T) == 2 ? Type::Int16 : sizeof(T) == 4 ? Type::Int32 : Type::Int64;
  }
  else
  {
    return sizeof(T) == 1 ? Type::UInt8 : sizeof(T) == 2 ? Type::UInt16 : sizeof(T) == 4 ? Type::UInt32 : Type::UInt64;
  }
}

chainmail::ArrayView View(vtkDataArray* array)
{
  chainmail::ArrayView view;
  if (array)
  {
    view.data = array->GetVoidPointer(0);
    view.components = array->GetNumberOfComponents();
    switch (array->GetDataType())
    {
      vtkTemplateMacro(view.type = EngineType<VTK_TT>());
    }
  }
  return view;
}

//------------------------------------------------------------------------------
/// vtkPiecewiseFunction::GetValue() is slow, and the engine asks for every voxel of a scan: where straight lines join
/// the nodes, as they nearly always do, this is much faster.
std::function<double(double)> ToEngineFunction(const vtkSmartPointer<vtkPiecewiseFunction>& function)
{
  std::vector<double> scalars;
  std::vector<double> constraints;
  bool straight = function->GetClamping() && !function->GetUseLogScale();
  for (int n = 0; n < function->GetSize(); ++n)
  {
    double node[4]; // scalar, constraint, midpoint, sharpness
    function->GetNodeValue(n, node);
    scalars.push_back(node[0]);
    constraints.push_back(node[1]);
    straight = straight && node[2] == 0.5 && node[3] == 0.0;
  }
  if (!straight)
  {
    return [function](double scalar) { return function->GetValue(scalar); };
  }
  return [scalars, constraints](double scalar)
  {
    const auto after = std::upper_bound(scalars.begin(), scalars.end(), scalar);
    if (after == scalars.begin() || after == scalars.end())
    {
      return after == scalars.begin() ? constraints.front() : constraints.back();
    }
    const std::size_t n = static_cast<std::size_t>(after - scalars.begin());
    const double share = (scalar - scalars[n - 1]) / (scalars[n] - scalars[n - 1]);
    return constraints[n - 1] + share * (constraints[n] - constraints[n - 1]);
  };
}

//------------------------------------------------------------------------------
/// An array that outputs share from update to update, as long as nobody has written to it: what reads an output may
/// also write to it, as far as this filter can tell.
template <typename ArrayType> class SharedArray
{
public:
  void Set(const vtkSmartPointer<ArrayType>& array)
  {
    this->Array = array;
    this->Values = FingerprintOf(array);
  }
  void Forget() { this->Array = nullptr; }
  bool IsIntact() const { return this->Array && FingerprintOf(this->Array) == this->Values; }
  ArrayType* Get() const { return this->Array; }

private:
  vtkSmartPointer<ArrayType> Array;
  Fingerprint Values = 0;
};

/// An array by its contents: an upstream filter that runs again gives the same values in another one.
struct ArrayContents
{
  vtkSmartPointer<vtkDataArray> Array;
  vtkMTimeType Time = 0;
  Fingerprint Values = 0;

  /// `imageTime`: voxels are also written in place, and then somebody says so of the image alone. What is known of the
  /// array from `before` is not looked at again.
  void Take(vtkDataArray* array, vtkMTimeType imageTime, const ArrayContents& before)
  {
    this->Array = array;
    this->Time = std::max(array->GetMTime(), imageTime);
    this->Values = array == before.Array && this->Time == before.Time ? before.Values : FingerprintOf(array);
  }

  bool operator==(const ArrayContents& other) const { return this->Values == other.Values; }
};

/// All that the engine's model and simulation are made from. Equal sources: nothing has to be built anew.
struct TissueSource
{
  ArrayContents Scalars;
  ArrayContents Constraints;
  chainmail::Index3 Size{};
  Vector3 Spacing{};
  double Threshold = 0.0;
  std::vector<double> Function; // all that GetValue() of the material function depends on
  bool AnchorRigid = false;
  std::array<bool, 6> AnchoredFaces{};
  std::string Device;
  chainmail::Index3 BlockSize{};
  int ModelReduction = 1;

  bool operator==(const TissueSource& other) const
  {
    const auto all = [](const TissueSource& t)
    {
      return std::tie(t.Scalars, t.Constraints, t.Size, t.Spacing, t.Threshold, t.Function, t.AnchorRigid,
        t.AnchoredFaces, t.Device, t.BlockSize, t.ModelReduction);
    };
    return all(*this) == all(other);
  }
};

chainmail::Grid ToGrid(const TissueSource& tissue)
{
  chainmail::Grid grid;
  grid.size = tissue.Size;
  grid.spacing = tissue.Spacing;
  return grid;
}

bool Same(const chainmail::Probe& a, const chainmail::Probe& b)
{
  return a.position == b.position && a.displacement == b.displacement && a.radius == b.radius && a.anchor == b.anchor;
}

/// Whether every edge has two sides.
bool IsClosed(vtkPolyData* surface)
{
  vtkNew<vtkCleanPolyData> mergePoints;
  mergePoints->SetInputData(surface);
  mergePoints->ToleranceIsAbsoluteOn();
  mergePoints->SetAbsoluteTolerance(0.0);
  vtkNew<vtkFeatureEdges> edges;
  edges->SetInputConnection(mergePoints->GetOutputPort());
  edges->BoundaryEdgesOn();
  edges->FeatureEdgesOff();
  edges->ManifoldEdgesOff();
  edges->NonManifoldEdgesOff();
  edges->Update();
  return edges->GetOutput()->GetNumberOfCells() == 0;
}

/// The triangles of one surface as more of another.
void Append(const InputSurface& part, InputSurface& to)
{
  to.Name = to.Name.empty() ? part.Name : to.Name;
  const int before = static_cast<int>(to.Triangles.points.size());
  to.Triangles.points.insert(to.Triangles.points.end(), part.Triangles.points.begin(), part.Triangles.points.end());
  for (const std::array<int, 3>& corners : part.Triangles.triangles)
  {
    to.Triangles.triangles.push_back({ corners[0] + before, corners[1] + before, corners[2] + before });
  }
}

bool Same(const InputSurface& a, const InputSurface& b)
{
  return a.Triangles.points == b.Triangles.points && a.Triangles.triangles == b.Triangles.triangles;
}

template <typename T> bool Same(const std::vector<T>& a, const std::vector<T>& b)
{
  return std::equal(
    a.begin(), a.end(), b.begin(), b.end(), [](const T& one, const T& other) { return Same(one, other); });
}

/// Parts what is present now from what was there before: for each element of `present` whether it was in `before`,
/// which then keeps those that still are. Equal ones count one by one; their order does not matter.
template <typename T> std::vector<bool> Recognize(const std::vector<T>& present, std::vector<T>& before)
{
  std::vector<bool> known;
  std::vector<T> kept;
  std::vector<bool> gone(before.size(), false);
  std::size_t next = 0; // most often they come in the order that they had
  for (const T& one : present)
  {
    std::size_t tried = 0;
    while (tried < before.size() && (gone[next] || !Same(one, before[next])))
    {
      ++tried;
      next = (next + 1) % before.size();
    }
    known.push_back(tried < before.size());
    if (known.back())
    {
      kept.push_back(std::move(before[next]));
      gone[next] = true;
    }
  }
  before = std::move(kept);
  return known;
}

/// How tissue is deformed, apart from where. The defaults are those of a new simulation.
struct Method
{
  int Propagation = 0;
  int PropagationIterations = 0;
  int Conflict = 0;
  int Relaxation = 0;
  bool CoarseToFine = false;
  int RelaxationIterations = 0;
  double Tolerance = 0.0;
  double ElasticRecovery = 1.0;

  bool operator==(const Method& other) const
  {
    const auto all = [](const Method& m)
    {
      return std::tie(m.Propagation, m.PropagationIterations, m.Conflict, m.Relaxation, m.CoarseToFine,
        m.RelaxationIterations, m.Tolerance, m.ElasticRecovery);
    };
    return all(*this) == all(other);
  }
};

/// Where a probe came from, for messages.
struct ProbeOrigin
{
  std::size_t Leaf; // of the scene's inputs
  vtkIdType Point;
  Vector3 Position; // world
};

/// One update's inputs, checked and in the engine's terms.
struct Scene
{
  explicit Scene(const Inputs& inputs)
    : Given(inputs)
    , Image(inputs.Image)
    , Space(inputs.Image)
  {
  }

  /// "Probes input 0, point 3 at (1, 2, 3)", for messages.
  std::string NameOf(const ProbeOrigin& origin) const
  {
    return this->Given.Leaves[origin.Leaf].ToString() + ", point " + std::to_string(origin.Point) + " at " +
           ToString(origin.Position.data());
  }

  const Inputs& Given;
  vtkImageData* Image;
  Frame Space;
  vtkDataArray* Scalars = nullptr; // the image's own array
  TissueSource Tissue;
  vtkSmartPointer<vtkPiecewiseFunction> Function; // a copy
  std::vector<chainmail::Probe> Probes;
  std::vector<ProbeOrigin> ProbeOrigins;
  std::vector<InputSurface> Cuts;
  std::vector<InputSurface> Carves;
};

}

//------------------------------------------------------------------------------
/// Turns the pipeline's data into a scene, keeps the engine in step with it and turns the results into outputs. Throws
/// the engine's exceptions; the filter turns them into VTK's errors in one place.
class vtkChainMailDeformation::vtkInternals
{
public:
  explicit vtkInternals(vtkChainMailDeformation* self)
    : Self(self)
  {
  }

  /// Computes what is shown of both outputs (Shown), also where that fails: then what was shown last stays, and says
  /// so; where there is nothing yet the image as it is.
  Outcome Compute(const Inputs& inputs);

  /// Whether nothing that an update depends on changed since this was last asked. `inputs` are those of `connected`.
  bool IsUnchanged(vtkInformationVector** connected, const Inputs& inputs);

  /// After an error of the device nothing on it can be trusted.
  void DropEngine()
  {
    this->Done = Stage::Nothing;
    this->Interacting = false;
    this->WantsUpdate = false;
    this->Simulation.reset();
    this->Model.reset();
    this->Tissue = TissueSource();
  }

  /// After an update that was stopped. Where it was stopped is a matter of chance, where the next one goes on is not.
  void Stop()
  {
    try
    {
      if (this->Interacting)
      {
        this->Simulation->reset();
      }
    }
    catch (const chainmail::DeviceError&)
    {
      this->DropEngine();
    }
  }

  /// The last interactive update left waves under way or tissue that has not settled, or Reset() was called after it.
  bool WantsUpdate = false;

  /// There is a state that interactive updates go on from.
  bool Interacting = false;

  /// Reset() was called since the last interactive update that came to the engine.
  bool ResetRequested = false;

  /// Both outputs, whole, as the last update left them. Null before the first one, and where another process computes.
  std::array<vtkSmartPointer<vtkImageData>, 2> Shown;

  /// What became of the last update.
  Outcome Last;

  /// The last update was made together with other processes.
  bool ComputedInParallel = false;

private:
  void Update(const Inputs& inputs);
  void ShowAgain(const Inputs& inputs, const std::string& error);

  // Reading.
  void ReadScalars(Scene& scene);
  void ReadMaterial(Scene& scene);
  static void ReadProbes(Scene& scene);
  static InputSurface ReadSurface(const Leaf& leaf, const Scene& scene);
  static std::vector<InputSurface> ReadCuts(const Scene& scene);
  static std::vector<InputSurface> ReadCarves(const Scene& scene);
  void CheckPointArrays(vtkImageData* image);
  void CheckPadding(const Scene& scene);

  // Computing.
  void Build(const Scene& scene);
  void Deform(const Scene& scene);
  void Interact(const Scene& scene);
  void Mend();
  void Cut(const InputSurface& surface);
  void Carve(const InputSurface& surface);
  void Warn(const std::string& text);
  void Pull(const Scene& scene, const std::vector<std::size_t>& held);
  void Relax(const Scene& scene, const std::vector<std::size_t>& held);
  Method GetMethod() const;
  void WarnAboutProbes(const Scene& scene, const std::vector<std::size_t>& held);
  void WarnAboutEmptyHands(const Scene& scene, const std::vector<std::size_t>& held);
  void WarnAboutShortProbes(const Scene& scene, const std::vector<std::size_t>& held);
  std::string WhatHolds(const Scene& scene, const std::vector<std::size_t>& held, std::size_t probe);

  // Writing.
  void WarnAboutLostArrays(vtkImageData* image);
  void WriteDeformed(const Scene& scene, vtkImageData* output);
  void WriteModel(const Scene& scene, vtkImageData* output);
  void FetchTissue(const Scene& scene);
  vtkSmartPointer<vtkFloatArray> FetchDisplacement(const Scene& scene);
  void FetchTimes(const Scene& scene, vtkPointData* output);
  void WriteFieldData(const Scene& scene, vtkImageData* output);

  /// Runs a part of the update: its time is added to a row of Milliseconds, and the engine's progress in it is mapped
  /// to [from, to].
  template <typename F> void Run(Times time, double from, double to, F&& part)
  {
    this->ProgressFrom = from;
    this->ProgressTo = to;
    this->Report(0.0);
    const auto start = std::chrono::steady_clock::now();
    part();
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
    this->Milliseconds[time] += elapsed.count();
  }

  /// Progress event; throws where somebody asked to stop.
  void Report(double share)
  {
    if (!this->Progress(share))
    {
      throw chainmail::Aborted();
    }
  }
  bool Progress(double share)
  {
    // Of several calls of the engine in one part each counts from 0.
    this->ProgressShown =
      std::max(this->ProgressShown, this->ProgressFrom + share * (this->ProgressTo - this->ProgressFrom));
    this->Self->UpdateProgress(this->ProgressShown);
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 20220823)
    return !this->Self->CheckAbort();
#else
    return !this->Self->GetAbortExecute();
#endif
  }

  vtkChainMailDeformation* Self;

  std::array<int, 6> ShownImageExtent{ { 0, -1, 0, -1, 0, -1 } }; // of the input that Shown was made from

  /// What an update was asked with.
  struct Asked
  {
    vtkMTimeType Filter = 0;
    std::vector<std::tuple<vtkDataObject*, vtkMTimeType, vtkMTimeType>> Times; // of each dataset, and when it was made
    Fingerprint Contents = 0;
  };
  Asked LastAsked;

  // How far the engine is on its way from nothing to the state deformed from rest. Lowered before it is told to do
  // something that may fail, raised after it has. An interactive state is none of these: it leaves Built.
  enum class Stage
  {
    Nothing,
    Built,
    Cut,
    Relaxed
  };
  Stage Done = Stage::Nothing;

  TissueSource Tissue;
  vtkSmartPointer<vtkDataArray> EngineScalars; // read by the model as long as it lives
  vtkSmartPointer<vtkDataArray> EngineConstraints;
  std::shared_ptr<const chainmail::Model> Model;
  std::unique_ptr<chainmail::Simulation> Simulation;

  // What the stages Cut and Relaxed were reached with. Of an interactive state: the surfaces that the last update had
  // and that have done their work.
  std::vector<InputSurface> Cuts;
  std::vector<InputSurface> Carves;
  std::vector<chainmail::Probe> Probes;
  Method MethodUsed;
  bool TimesKept = false;

  // Of an interactive state: where the image was, and probes that are there but were released by Reset().
  std::unique_ptr<Frame> Space;
  std::vector<chainmail::Probe> Released;

  // Probes that hold nothing, and those that got far less than they asked for.
  vtkChainMail::WarnedProbes EmptyHands;
  vtkChainMail::WarnedProbes ShortProbes;

  // Surfaces that met no tissue, or came back to where they were, and were warned about.
  SurfaceHistory CutHistory;
  SurfaceHistory CarveHistory;

  // Cell arrays that are not passed on and were warned about.
  std::set<std::string> LostArrays;

  // What was reached, shared by the outputs of all updates that find nothing new. The arrays are null where not
  // fetched.
  std::vector<chainmail::ProbeResult> Results;
  chainmail::PropagateResult Propagation;
  chainmail::RelaxResult Relaxation;
  chainmail::Statistics Statistics;
  SharedArray<vtkFloatArray> Constraint;
  SharedArray<vtkUnsignedCharArray> Element;
  SharedArray<vtkIntArray> Cluster;

  std::array<double, NUMBER_OF_TIMES> Milliseconds{};
  double PeakDeviceMemory = 0.0; // of this update [MB]
  double ProgressFrom = 0.0;
  double ProgressTo = 1.0;
  double ProgressShown = 0.0;
};

//------------------------------------------------------------------------------
bool vtkChainMailDeformation::vtkInternals::IsUnchanged(vtkInformationVector** connected, const Inputs& inputs)
{
  // Times tell soon that nothing changed, but not that something did: a reader runs again for every piece.
  std::vector<std::tuple<vtkDataObject*, vtkMTimeType, vtkMTimeType>> times;
  for (int port = 0; port < this->Self->GetNumberOfInputPorts(); ++port)
  {
    for (int input = 0; input < connected[port]->GetNumberOfInformationObjects(); ++input)
    {
      vtkDataObject* data = vtkDataObject::GetData(connected[port], input);
      times.emplace_back(data, data ? data->GetMTime() : 0, data ? data->GetUpdateTime() : 0);
    }
    times.emplace_back(); // the next port
  }
  const Asked before = this->LastAsked;
  this->LastAsked.Filter = this->Self->GetMTime();
  if (times != before.Times)
  {
    this->LastAsked.Times = std::move(times);
    this->LastAsked.Contents = inputs.GetFingerprint();
  }
  return this->LastAsked.Filter == before.Filter && this->LastAsked.Contents == before.Contents;
}

//------------------------------------------------------------------------------
Outcome vtkChainMailDeformation::vtkInternals::Compute(const Inputs& inputs)
{
  Outcome outcome;
  this->WantsUpdate = false;
  try // the one place where the engine's exceptions become messages
  {
    this->Update(inputs);
  }
  catch (const chainmail::Aborted&)
  {
    this->Stop();
    outcome.Stopped = true; // no error: somebody wanted it
  }
  catch (const chainmail::DeviceError& error)
  {
    this->DropEngine();
    outcome.Error = error.what();
  }
  catch (const std::bad_alloc&)
  {
    this->DropEngine();
    outcome.Error = "There is not enough main memory for this image. Crop it or resample it to fewer voxels.";
  }
  catch (const std::exception& error)
  {
    outcome.Error = error.what();
  }
  if (outcome.Stopped || !outcome.Error.empty())
  {
    this->ShowAgain(inputs, outcome.Stopped ? "The update was stopped." : outcome.Error);
  }
  outcome.NeedsUpdate = this->WantsUpdate;
  outcome.Interacting = this->Interacting;
  return outcome;
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::ShowAgain(const Inputs& inputs, const std::string& error)
{
  int extent[6] = { 0, -1, 0, -1, 0, -1 };
  if (inputs.Image)
  {
    inputs.Image->GetExtent(extent);
  }
  for (auto& shown : this->Shown)
  {
    // What was shown of another image would not be where this one's readers of the output expect it.
    const bool fits = shown && inputs.Image && std::equal(extent, extent + 6, this->ShownImageExtent.begin()) &&
                      shown->GetNumberOfPoints() > 0;
    auto again = vtkSmartPointer<vtkImageData>::New();
    if (fits)
    {
      again->ShallowCopy(shown);
    }
    else if (inputs.Image && &shown == &this->Shown[0])
    {
      again->ShallowCopy(inputs.Image);
    }
    else if (inputs.Image)
    {
      again->CopyStructure(inputs.Image);
    }
    vtkNew<vtkStringArray> message;
    message->SetName("Error");
    message->InsertNextValue(error);
    again->GetFieldData()->AddArray(message);
    shown = again;
  }
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::Update(const Inputs& inputs)
{
  if (!inputs.Problem.empty())
  {
    throw InputError(inputs.Problem);
  }
  vtkImageData* image = inputs.Image;
  if (!image || image->GetNumberOfPoints() == 0)
  {
    throw InputError("The input image is empty: give one with at least one voxel on every axis.");
  }
  this->Milliseconds.fill(0.0);
  this->ProgressShown = 0.0;

  this->CheckPointArrays(image);
  Scene scene(inputs);
  this->ReadScalars(scene);
  this->CheckPadding(scene);
  ReadProbes(scene);
  scene.Cuts = ReadCuts(scene);
  scene.Carves = ReadCarves(scene);
  this->CutHistory.Begin(scene.Cuts);
  this->CarveHistory.Begin(scene.Carves);
  this->ReadMaterial(scene); // last: it may read all scalars for their range

  if (this->Done == Stage::Nothing || !(this->Tissue == scene.Tissue))
  {
    this->Run(UPLOAD, 0.0, 0.15, [&] { this->Build(scene); });
  }
  this->Tissue = scene.Tissue; // the same values, perhaps in other arrays
  if (this->Self->Mode == MODE_INTERACTIVE)
  {
    this->Interact(scene);
  }
  else
  {
    this->Deform(scene);
  }
  const auto deformed = vtkSmartPointer<vtkImageData>::New();
  const auto model = vtkSmartPointer<vtkImageData>::New();
  this->Run(RESAMPLE, 0.75, 0.9, [&] { this->WriteDeformed(scene, deformed); });
  this->WriteModel(scene, model);
  this->PeakDeviceMemory = 1e-6 * static_cast<double>(this->Simulation->takePeakDeviceBytes());
  this->WriteFieldData(scene, deformed);
  this->WriteFieldData(scene, model);
  this->Shown = { { deformed, model } };
  image->GetExtent(this->ShownImageExtent.data());
  this->WantsUpdate =
    this->Interacting &&
    (!this->Propagation.finished || (this->MethodUsed.RelaxationIterations > 0 && !this->Relaxation.converged));
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::ReadScalars(Scene& scene)
{
  vtkPointData* arrays = scene.Image->GetPointData();
  const auto findPointArray = [&](const std::string& property, vtkAbstractArray* array)
  {
    vtkDataArray* numbers = vtkDataArray::SafeDownCast(array);
    if (!numbers)
    {
      throw InputError(property + " is the array \"" + (array->GetName() ? array->GetName() : "") +
                       "\", which does not hold numbers. Choose another one.");
    }
    return numbers;
  };

  vtkInformation* choice = this->Self->GetInputArrayInformation(0);
  const char* name = choice->Has(vtkDataObject::FIELD_NAME()) ? choice->Get(vtkDataObject::FIELD_NAME()) : nullptr;
  int association = vtkDataObject::FIELD_ASSOCIATION_POINTS;
  vtkAbstractArray* scalars = this->Self->GetInputAbstractArrayToProcess(0, scene.Image, association);
  if (!scalars && name && !*name) // a proxy that nobody has told of the image's arrays
  {
    scalars = arrays->GetScalars();
  }
  if (scalars && association != vtkDataObject::FIELD_ASSOCIATION_POINTS)
  {
    throw InputError("The scalars are cell data, but tissue is made from point data. Choose a point array, or convert "
                     "with Cell Data to Point Data.");
  }
  if (!scalars && name)
  {
    throw InputError("The input image has no point array called \"" + std::string(name) + "\" to take as scalars. " +
                     ListArrays(arrays) + " Choose one of these.");
  }
  if (!scalars)
  {
    throw InputError(
      "The input image has no active point scalars to tell tissue from air. " + ListArrays(arrays) +
      (arrays->GetNumberOfArrays() > 0 ? " Choose one of these." : " Give an image with point scalars."));
  }
  scene.Scalars = findPointArray("The array of scalars", scalars);

  const std::string& constraintName = this->Self->ConstraintArray;
  vtkDataArray* constraints = nullptr;
  if (!constraintName.empty())
  {
    vtkAbstractArray* array = arrays->GetAbstractArray(constraintName.c_str());
    if (!array)
    {
      throw InputError("The input image has no point array called \"" + constraintName +
                       "\" to take as ConstraintArray. " + ListArrays(arrays) + " Choose one of these, or none.");
    }
    constraints = findPointArray("ConstraintArray", array);
  }

  TissueSource& tissue = scene.Tissue;
  const vtkMTimeType imageTime = scene.Image->GetMTime();
  tissue.Scalars.Take(scene.Scalars, imageTime, this->Tissue.Scalars);
  if (constraints)
  {
    tissue.Constraints.Take(constraints, imageTime, this->Tissue.Constraints);
  }

  scene.Image->GetDimensions(tissue.Size.data());
  tissue.Spacing = scene.Space.GetSpacing();
  ToGrid(tissue).check(); // the model does, too, but only after all scalars were read for their range
  tissue.AnchorRigid = this->Self->AnchorRigid;
  for (int f = 0; f < 6; ++f)
  {
    // A slice is not held by the two faces that all of it lies on.
    tissue.AnchoredFaces[f] = this->Self->AnchoredFaces[f] != 0 && tissue.Size[f / 2] > 1;
  }
  tissue.Device = this->Self->Device;
  std::copy_n(this->Self->BlockSize, 3, tissue.BlockSize.begin());
  tissue.ModelReduction = this->Self->ModelReduction;
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::ReadMaterial(Scene& scene)
{
  TissueSource& tissue = scene.Tissue;
  vtkPiecewiseFunction* given =
    this->Self->MaterialPreset == MATERIAL_FUNCTION ? this->Self->MaterialFunction.Get() : nullptr;
  tissue.Threshold = this->Self->MaterialPreset == MATERIAL_FUNCTION ? this->Self->TissueThreshold : vtkMath::Nan();

  scene.Function = vtkSmartPointer<vtkPiecewiseFunction>::New();
  if (!given || std::isnan(tissue.Threshold))
  {
    double range[2];
    scene.Scalars->GetFiniteRange(range, 0);
    double fitted;
    vtkChainMailDeformation::GetPresetMaterial(this->Self->MaterialPreset, range, fitted, scene.Function);
    tissue.Threshold = std::isnan(tissue.Threshold) ? fitted : tissue.Threshold;
  }
  if (tissue.Constraints.Array)
  {
    return; // the function is not asked
  }
  if (given)
  {
    scene.Function->DeepCopy(given);
    if (given->GetSize() == 0)
    {
      throw InputError("MaterialFunction has no nodes: add some, or unset it for one fitted to the scalars.");
    }
  }
  for (int n = 0; n < scene.Function->GetSize(); ++n)
  {
    double node[4]; // scalar, constraint, midpoint, sharpness
    scene.Function->GetNodeValue(n, node);
    if (!(node[1] >= 0.0 && static_cast<float>(node[1]) < 1.0f))
    {
      std::ostringstream message;
      message << "MaterialFunction is " << node[1] << " for a scalar of " << node[0]
              << ". A constraint is a fraction of the spacing from 0 (rigid) to less than 1: move that node.";
      throw InputError(message.str());
    }
    tissue.Function.insert(tissue.Function.end(), node, node + 4);
  }
  tissue.Function.push_back(scene.Function->GetClamping());
  tissue.Function.push_back(scene.Function->GetUseLogScale());
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::ReadProbes(Scene& scene)
{
  for (std::size_t l = 0; l < scene.Given.Leaves.size(); ++l)
  {
    const Leaf& leaf = scene.Given.Leaves[l];
    if (leaf.Port != PROBES)
    {
      continue;
    }
    vtkPolyData* points = leaf.Data;
    const vtkIdType numberOfPoints = points->GetNumberOfPoints();
    const std::string where = leaf.ToString() + ": ";
    const auto find = [&](const char* name, int components) -> vtkDataArray*
    {
      vtkAbstractArray* array = points->GetPointData()->GetAbstractArray(name);
      if (!array)
      {
        return nullptr;
      }
      vtkDataArray* numbers = vtkDataArray::SafeDownCast(array);
      if (!numbers || numbers->GetNumberOfComponents() != components || numbers->GetNumberOfTuples() != numberOfPoints)
      {
        throw InputError(where + "the point array \"" + name + "\" has to hold " + std::to_string(components) +
                         (components == 1 ? " number" : " numbers") + " for every point; it holds " +
                         (numbers ? std::to_string(numbers->GetNumberOfComponents()) + " for each of " +
                                      std::to_string(numbers->GetNumberOfTuples()) + " points."
                                  : std::string("no numbers.")));
      }
      return numbers;
    };
    vtkDataArray* displacements = find("Displacement", 3);
    vtkDataArray* radii = find("Radius", 1);
    vtkDataArray* anchors = find("Anchor", 1);

    for (vtkIdType p = 0; p < numberOfPoints; ++p)
    {
      ProbeOrigin origin{ l, p, {} };
      double* position = origin.Position.data();
      points->GetPoint(p, position);
      if (!IsFinite(position))
      {
        throw InputError(scene.NameOf(origin) + ": the position has to be finite.");
      }
      chainmail::Probe probe;
      probe.position = scene.Space.PointToEngine(position);
      probe.anchor = anchors && anchors->GetTuple1(p) != 0.0;
      probe.radius = radii ? radii->GetTuple1(p) : 0.0;
      if (!(probe.radius >= 0.0) || !std::isfinite(probe.radius))
      {
        throw InputError(scene.NameOf(origin) + ": the radius is " + std::to_string(probe.radius) +
                         "; it has to be 0 (the nearest element) or a positive length.");
      }
      if (!probe.anchor && !displacements)
      {
        throw InputError(
          scene.NameOf(origin) + ": there is no point array \"Displacement\" to say how far to pull. " +
          ListArrays(points->GetPointData()) +
          " Add one with 3 components, or an array \"Anchor\" that is not 0 where tissue is to be held in place.");
      }
      if (!probe.anchor)
      {
        double displacement[3];
        displacements->GetTuple(p, displacement);
        if (!IsFinite(displacement))
        {
          throw InputError(
            scene.NameOf(origin) + ": the displacement " + ToString(displacement) + " has to be finite.");
        }
        probe.displacement = scene.Space.VectorToEngine(displacement);
      }
      scene.Probes.push_back(probe);
      scene.ProbeOrigins.push_back(origin);
    }
  }
}

//------------------------------------------------------------------------------
InputSurface vtkChainMailDeformation::vtkInternals::ReadSurface(const Leaf& leaf, const Scene& scene)
{
  vtkPolyData* surface = leaf.Data;
  const std::string where = leaf.ToString();

  // Checked before the triangulation, which may move nothing but could drop what it cannot make sense of, and reads
  // three corners of every strip.
  vtkNew<vtkCellArray> polys;
  vtkNew<vtkCellArray> strips;
  vtkNew<vtkIdList> cell;
  const std::pair<vtkCellArray*, vtkCellArray*> lists[] = { { surface->GetPolys(), polys },
    { surface->GetStrips(), strips } };
  for (const auto& [from, to] : lists)
  {
    const auto iterator = vtk::TakeSmartPointer(from->NewIterator());
    for (iterator->GoToFirstCell(); !iterator->IsDoneWithTraversal(); iterator->GoToNextCell())
    {
      iterator->GetCurrentCell(cell);
      for (vtkIdType n = 0; n < cell->GetNumberOfIds(); ++n)
      {
        double point[3];
        surface->GetPoint(cell->GetId(n), point);
        if (!IsFinite(point))
        {
          throw InputError(where + ", point " + std::to_string(cell->GetId(n)) + " at " + ToString(point) +
                           ": the position has to be finite.");
        }
      }
      if (cell->GetNumberOfIds() >= 3)
      {
        to->InsertNextCell(cell);
      }
    }
  }

  vtkNew<vtkPolyData> polygons;
  polygons->SetPoints(surface->GetPoints());
  polygons->SetPolys(polys);
  polygons->SetStrips(strips);
  vtkNew<vtkTriangleFilter> triangulate;
  triangulate->SetInputData(polygons);
  triangulate->PassVertsOff();
  triangulate->PassLinesOff();
  triangulate->Update();
  vtkPolyData* triangles = triangulate->GetOutput();
  if (triangles->GetNumberOfPoints() > std::numeric_limits<int>::max())
  {
    throw InputError(where + " has more points than can be handled: simplify it.");
  }

  InputSurface read{ where, {} };
  chainmail::Surface& to = read.Triangles;
  to.points.reserve(static_cast<std::size_t>(triangles->GetNumberOfPoints()));
  for (vtkIdType p = 0; p < triangles->GetNumberOfPoints(); ++p)
  {
    // Points of no polygon may be anything.
    double point[3];
    triangles->GetPoint(p, point);
    to.points.push_back(IsFinite(point) ? scene.Space.PointToEngine(point) : Vector3{});
  }
  to.triangles.reserve(static_cast<std::size_t>(triangles->GetNumberOfPolys()));
  const auto iterator = vtk::TakeSmartPointer(triangles->GetPolys()->NewIterator());
  for (iterator->GoToFirstCell(); !iterator->IsDoneWithTraversal(); iterator->GoToNextCell())
  {
    iterator->GetCurrentCell(cell);
    to.triangles.push_back(
      { static_cast<int>(cell->GetId(0)), static_cast<int>(cell->GetId(1)), static_cast<int>(cell->GetId(2)) });
  }
  return read;
}

//------------------------------------------------------------------------------
std::vector<InputSurface> vtkChainMailDeformation::vtkInternals::ReadCuts(const Scene& scene)
{
  std::vector<InputSurface> surfaces;
  for (const Leaf& leaf : scene.Given.Leaves)
  {
    if (leaf.Port == CUTS)
    {
      surfaces.push_back(ReadSurface(leaf, scene));
    }
  }
  return surfaces;
}

//------------------------------------------------------------------------------
std::vector<InputSurface> vtkChainMailDeformation::vtkInternals::ReadCarves(const Scene& scene)
{
  // The datasets of a composite input are surfaces of their own where they are closed, which may overlap. Where they
  // are not they are parts of one, as a process has them of a surface that is spread over several.
  std::vector<InputSurface> surfaces;
  std::map<int, InputSurface> open; // by input
  for (const Leaf& leaf : scene.Given.Leaves)
  {
    if (leaf.Port != CARVES)
    {
      continue;
    }
    InputSurface surface = ReadSurface(leaf, scene);
    const auto ofSameInput = [&](const Leaf& other) { return other.Port == CARVES && other.Input == leaf.Input; };
    const auto& leaves = scene.Given.Leaves;
    if (std::count_if(leaves.begin(), leaves.end(), ofSameInput) == 1 || IsClosed(leaf.Data))
    {
      surfaces.push_back(std::move(surface));
    }
    else
    {
      Append(surface, open[leaf.Input]);
    }
  }
  for (auto& [input, surface] : open)
  {
    surfaces.push_back(std::move(surface)); // what is still open the engine refuses
  }
  return surfaces;
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::CheckPointArrays(vtkImageData* image)
{
  const auto check = [](vtkAbstractArray* array, const char* kind, vtkIdType places, const char* ofImage)
  {
    if (array->GetNumberOfTuples() != places)
    {
      throw InputError("The " + std::string(kind) + " array \"" + (array->GetName() ? array->GetName() : "") +
                       "\" has " + std::to_string(array->GetNumberOfTuples()) + " tuples, but the input image has " +
                       std::to_string(places) + " " + ofImage + ". Remove it, or give it a value for each.");
    }
  };
  vtkPointData* arrays = image->GetPointData();
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    check(arrays->GetAbstractArray(a), "point", image->GetNumberOfPoints(), "voxels");
  }
  // The only one of the cells that is read.
  if (vtkAbstractArray* ghosts = image->GetCellData()->GetAbstractArray(vtkDataSetAttributes::GhostArrayName()))
  {
    check(ghosts, "cell", image->GetNumberOfCells(), "cells");
  }
  for (const std::string& name : this->Self->LabelArrays)
  {
    if (!arrays->HasArray(name.c_str()))
    {
      throw InputError("LabelArrays names \"" + name + "\", which is no point array of the input image. " +
                       ListArrays(arrays) + " Remove that name or choose one of these.");
    }
  }
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::CheckPadding(const Scene& scene)
{
  const int padding = this->Self->OutputPadding;
  const int fitting = vtkChainMailSampling::FittingPadding(scene.Tissue.Size, padding);
  if (fitting < padding)
  {
    const chainmail::Index3 size = vtkChainMailSampling::Padded(scene.Tissue.Size, padding).size;
    std::ostringstream message;
    message << "With an OutputPadding of " << padding << " the deformed image would have " << size[0] << " x "
            << size[1] << " x " << size[2] << " voxels; at most " << chainmail::Grid::maxVoxels
            << " can be handled. Lower it to " << fitting << " or less.";
    throw InputError(message.str());
  }
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::Build(const Scene& scene)
{
  // What there is stays until its successor is there: with tissue that cannot be used nothing is lost.
  const TissueSource& tissue = scene.Tissue;
  const vtkSmartPointer<vtkDataArray> scalars = ToEngineArray(tissue.Scalars.Array);
  const vtkSmartPointer<vtkDataArray> constraints =
    tissue.Constraints.Array ? ToEngineArray(tissue.Constraints.Array) : nullptr;

  chainmail::Material material;
  material.tissueThreshold = tissue.Threshold;
  material.constraintArray = View(constraints);
  material.constraint = ToEngineFunction(scene.Function);
  chainmail::Anchors anchors;
  anchors.rigid = tissue.AnchorRigid;
  anchors.faces = tissue.AnchoredFaces;
  chainmail::Settings settings;
  settings.device = tissue.Device;
  settings.brickSize = tissue.BlockSize;
  settings.modelReduction = tissue.ModelReduction;

  const auto model = std::make_shared<const chainmail::Model>(ToGrid(tissue), View(scalars), material, anchors);
  if (model->nonFinite() > 0)
  {
    vtkWarningWithObjectMacro(
      this->Self, << model->nonFinite() << " voxels of the scalars are NaN or infinite; they are taken as air.");
  }
  this->Report(0.5);
  std::unique_ptr<chainmail::Simulation> simulation;
  try
  {
    simulation = std::make_unique<chainmail::Simulation>(model, settings);
  }
  catch (const chainmail::MemoryError&)
  {
    throw; // what there is has to make room
  }
  catch (const chainmail::DeviceError& error)
  {
    throw InputError(error.what()); // no such device, say: the present one has no part in it
  }
  simulation->setProgress([this](double share) { return this->Progress(share); });

  this->DropEngine();
  this->EngineScalars = scalars;
  this->EngineConstraints = constraints;
  this->Model = model;
  this->Simulation = std::move(simulation);
  this->EmptyHands.Clear();
  this->ShortProbes.Clear();
  this->MethodUsed = Method(); // as the engine's
  this->Tissue = tissue;
  this->Done = Stage::Built;
}

//------------------------------------------------------------------------------
Method vtkChainMailDeformation::vtkInternals::GetMethod() const
{
  Method method;
  method.Propagation = this->Self->PropagationMethod;
  method.PropagationIterations = this->Self->PropagationIterations;
  method.Conflict = this->Self->ConflictPolicy;
  method.Relaxation = this->Self->RelaxationMethod;
  method.ElasticRecovery = this->Self->ElasticRecovery;
  switch (this->Self->RelaxationPreset)
  {
  case RELAXATION_INTERACTIVE:
    std::tie(method.CoarseToFine, method.RelaxationIterations, method.Tolerance) = std::make_tuple(false, 10, 1e-3);
    break;
  case RELAXATION_BALANCED:
    std::tie(method.CoarseToFine, method.RelaxationIterations, method.Tolerance) = std::make_tuple(true, 20, 1e-3);
    break;
  case RELAXATION_ACCURATE:
    std::tie(method.CoarseToFine, method.RelaxationIterations, method.Tolerance) = std::make_tuple(true, 1000, 1e-5);
    break;
  default:
    method.CoarseToFine = this->Self->CoarseToFine;
    method.RelaxationIterations = this->Self->RelaxationIterations;
    method.Tolerance = this->Self->RelaxationTolerance;
  }
  return method;
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::Mend()
{
  this->Simulation->mend();
  this->Cuts.clear();
  this->Carves.clear();
  this->CutHistory.Rest();
  this->CarveHistory.Rest();
  this->Constraint.Forget();
  this->Element.Forget();
  this->Cluster.Forget();
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::Cut(const InputSurface& surface)
{
  const std::size_t links = this->Simulation->cut(surface.Triangles);
  if (links > 0)
  {
    this->Cluster.Forget(); // a cut can divide a rigid cluster
  }
  this->Cuts.push_back(surface);
  this->Warn(this->CutHistory.Worked(surface, links));
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::Carve(const InputSurface& surface)
{
  std::size_t elements = 0;
  try
  {
    elements = this->Simulation->carve(surface.Triangles);
    if (elements > 0)
    {
      this->Constraint.Forget();
      this->Element.Forget();
      this->Cluster.Forget();
    }
  }
  catch (const InputError& error)
  {
    throw InputError(surface.Name + ": " + error.what());
  }
  this->Carves.push_back(surface);
  this->Warn(this->CarveHistory.Worked(surface, elements));
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::Warn(const std::string& text)
{
  if (!text.empty())
  {
    vtkWarningWithObjectMacro(this->Self, << text);
  }
}

//------------------------------------------------------------------------------
/// Moves the probes with these numbers, and those alone.
void vtkChainMailDeformation::vtkInternals::Pull(const Scene& scene, const std::vector<std::size_t>& held)
{
  const Method method = this->GetMethod();
  if (method.Propagation != this->MethodUsed.Propagation || method.Conflict != this->MethodUsed.Conflict)
  {
    // Only then: it finishes the waves that are under way.
    this->Simulation->setPropagation(method.Propagation == PROPAGATION_TIMESTAMP
                                       ? chainmail::PropagationMethod::Timestamp
                                       : chainmail::PropagationMethod::Envelope,
      method.Conflict == CONFLICT_LATEST ? chainmail::ConflictPolicy::Latest : chainmail::ConflictPolicy::Limit);
  }
  this->Simulation->setRelaxation(
    method.Relaxation == RELAXATION_PAPER ? chainmail::RelaxationMethod::Paper : chainmail::RelaxationMethod::Projected,
    method.ElasticRecovery);
  this->Simulation->setCoarseToFine(method.CoarseToFine);
  this->Simulation->setPropagationTimes(this->Self->PropagationTimes);
  this->MethodUsed = method;
  this->TimesKept = this->Self->PropagationTimes;

  std::vector<chainmail::Probe> probes;
  for (const std::size_t p : held)
  {
    probes.push_back(scene.Probes[p]);
  }
  try
  {
    this->Simulation->hold(probes);
  }
  catch (const chainmail::ProbeError& error)
  {
    // The user knows it by another name and place.
    throw InputError(scene.NameOf(scene.ProbeOrigins[held[error.probe]]) + ": the probe " + error.problem);
  }
  this->Propagation = this->Simulation->propagate(this->MethodUsed.PropagationIterations);
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::Relax(const Scene& scene, const std::vector<std::size_t>& held)
{
  this->Relaxation = this->Simulation->relax(this->MethodUsed.RelaxationIterations, this->MethodUsed.Tolerance);
  const std::vector<chainmail::ProbeResult> results = this->Simulation->probes();
  this->Results.assign(scene.Probes.size(), chainmail::ProbeResult());
  for (std::size_t n = 0; n < held.size(); ++n)
  {
    this->Results[held[n]] = results[n];
  }
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::WarnAboutProbes(const Scene& scene, const std::vector<std::size_t>& held)
{
  this->WarnAboutEmptyHands(scene, held);
  if (this->Propagation.finished) // else they may still come where they shall be
  {
    this->WarnAboutShortProbes(scene, held);
  }
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::WarnAboutEmptyHands(
  const Scene& scene, const std::vector<std::size_t>& held)
{
  std::vector<std::size_t> empty;
  std::copy_if(held.begin(), held.end(), std::back_inserter(empty),
    [this](std::size_t p) { return this->Results[p].elements == 0; });
  const std::vector<std::size_t> added = this->EmptyHands.Renew(scene.Probes, empty);
  if (added.size() == 1)
  {
    vtkWarningWithObjectMacro(this->Self, << scene.NameOf(scene.ProbeOrigins[added[0]]) << ": "
                                          << "the probe has no tissue of its own: other probes or anchors hold all "
                                             "that is within its radius, or it was carved away.");
  }
  else if (added.size() > 1)
  {
    vtkWarningWithObjectMacro(
      this->Self, << added.size() << " of " << held.size()
                  << " probes have no tissue of their own: other probes or anchors hold all "
                     "that is within their radii, or it was carved away. They are "
                  << vtkChainMail::List(added, [&](std::size_t p) { return scene.NameOf(scene.ProbeOrigins[p]); }));
  }
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::WarnAboutShortProbes(
  const Scene& scene, const std::vector<std::size_t>& held)
{
  // What is next to nothing beside a voxel may get lost.
  const Vector3& spacing = scene.Space.GetSpacing();
  const double least = 1e-3 * *std::min_element(spacing.begin(), spacing.end());
  std::vector<std::size_t> shortened;
  for (const std::size_t p : held)
  {
    const double asked = vtkMath::Norm(scene.Probes[p].displacement.data());
    if (!scene.Probes[p].anchor && this->Results[p].elements > 0 && asked > least &&
        vtkMath::Norm(this->Results[p].reached.data()) < 0.5 * asked)
    {
      shortened.push_back(p);
    }
  }
  const std::vector<std::size_t> added = this->ShortProbes.Renew(scene.Probes, shortened);
  const auto describe = [&](std::size_t p)
  {
    std::ostringstream text;
    text << std::setprecision(3) << "reached " << vtkMath::Norm(this->Results[p].reached.data()) << " of "
         << vtkMath::Norm(scene.Probes[p].displacement.data()) << " mm" << this->WhatHolds(scene, held, p);
    return text.str();
  };
  if (added.size() == 1)
  {
    vtkWarningWithObjectMacro(
      this->Self, << scene.NameOf(scene.ProbeOrigins[added[0]]) << ": " << describe(added[0]) << ".");
  }
  else if (added.size() > 1)
  {
    vtkWarningWithObjectMacro(this->Self, << added.size() << " of " << held.size()
                                          << " probes reached less than half of their displacements: "
                                          << vtkChainMail::List(added, [&](std::size_t p)
                                               { return scene.NameOf(scene.ProbeOrigins[p]) + ": " + describe(p); }));
  }
}

//------------------------------------------------------------------------------
/// What keeps a probe from going further, as the end of a sentence about it.
std::string vtkChainMailDeformation::vtkInternals::WhatHolds(
  const Scene& scene, const std::vector<std::size_t>& held, std::size_t probe)
{
  using What = chainmail::HeldBy::What;
  const auto number = std::find(held.begin(), held.end(), probe) - held.begin();
  const chainmail::HeldBy holder = this->Simulation->heldBy(static_cast<std::size_t>(number));
  const std::string what = holder.bone ? ", as the bone that it grips " : ", as it is held by tissue that ";
  const char* const faces[] = { "x-", "x+", "y-", "y+", "z-", "z+" };
  switch (holder.what)
  {
  case What::Probe:
    return what + (holder.bone ? "is held by " : "is in the hand of ") +
           scene.NameOf(scene.ProbeOrigins[held[holder.probe]]);
  case What::Face:
    return what + "touches the face " + faces[holder.face] + " of the image (AnchoredFaces)";
  case What::Rigid:
    return what + "is rigid and anchored (AnchorRigid)";
  default:
    return {};
  }
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::Deform(const Scene& scene)
{
  this->Interacting = false;
  this->ResetRequested = false;
  if (this->Done > Stage::Built && !(Same(this->Cuts, scene.Cuts) && Same(this->Carves, scene.Carves)))
  {
    this->Done = Stage::Built;
  }
  if (this->Done > Stage::Cut && (!Same(this->Probes, scene.Probes) || !(this->MethodUsed == this->GetMethod()) ||
                                   (this->Self->PropagationTimes && !this->TimesKept)))
  {
    this->Done = Stage::Cut;
  }

  if (this->Done < Stage::Cut)
  {
    this->Run(PROPAGATE, 0.15, 0.2,
      [&]
      {
        this->Mend();
        std::for_each(scene.Cuts.begin(), scene.Cuts.end(), [&](const InputSurface& one) { this->Cut(one); });
        std::for_each(scene.Carves.begin(), scene.Carves.end(), [&](const InputSurface& one) { this->Carve(one); });
      });
    this->Done = Stage::Cut;
  }

  if (this->Done < Stage::Relaxed)
  {
    std::vector<std::size_t> all(scene.Probes.size());
    std::iota(all.begin(), all.end(), 0);
    this->Run(PROPAGATE, 0.2, 0.45,
      [&]
      {
        this->Simulation->reset();
        this->Pull(scene, all);
      });
    this->Run(RELAX, 0.45, 0.75, [&] { this->Relax(scene, all); });
    this->Run(DOWNLOAD, 0.75, 0.75, [&] { this->Statistics = this->Simulation->measure(); });
    this->WarnAboutProbes(scene, all);
    this->Probes = scene.Probes;
    this->Done = Stage::Relaxed;
  }
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::Interact(const Scene& scene)
{
  this->Done = Stage::Built;
  const bool startsAnew = !this->Interacting || !(*this->Space == scene.Space);
  if (startsAnew || this->ResetRequested)
  {
    this->Mend();
    this->Released.clear();
    this->EmptyHands.Clear();
    this->ShortProbes.Clear();
    this->Space = std::make_unique<Frame>(scene.Space);
    this->Interacting = true;
  }
  if (this->ResetRequested)
  {
    this->Cuts = scene.Cuts;
    this->Carves = scene.Carves;
    std::for_each(this->Cuts.begin(), this->Cuts.end(), [&](const auto& one) { this->CutHistory.Remember(one); });
    std::for_each(this->Carves.begin(), this->Carves.end(), [&](const auto& one) { this->CarveHistory.Remember(one); });
    this->Released = scene.Probes;
    this->ResetRequested = false;
  }

  std::vector<std::size_t> held;
  this->Run(PROPAGATE, 0.15, 0.45,
    [&]
    {
      const std::vector<bool> made = Recognize(scene.Cuts, this->Cuts);
      for (std::size_t n = 0; n < made.size(); ++n)
      {
        if (!made[n])
        {
          this->Cut(scene.Cuts[n]);
        }
      }
      const std::vector<bool> carved = Recognize(scene.Carves, this->Carves);
      for (std::size_t n = 0; n < carved.size(); ++n)
      {
        if (!carved[n])
        {
          this->Carve(scene.Carves[n]);
        }
      }
      const std::vector<bool> released = Recognize(scene.Probes, this->Released);
      for (std::size_t n = 0; n < released.size(); ++n)
      {
        if (!released[n])
        {
          held.push_back(n);
        }
      }
      this->Pull(scene, held);
    });
  this->Run(RELAX, 0.45, 0.75, [&] { this->Relax(scene, held); });
  this->Run(DOWNLOAD, 0.75, 0.75, [&] { this->Statistics = this->Simulation->measure(); });
  this->WarnAboutProbes(scene, held);
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::WarnAboutLostArrays(vtkImageData* image)
{
  std::set<std::string> names;
  vtkCellData* arrays = image->GetCellData();
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    const char* name = arrays->GetArrayName(a);
    names.insert(name ? name : "");
  }
  names.erase(vtkDataSetAttributes::GhostArrayName());
  if (!names.empty() && names != this->LostArrays)
  {
    std::string list;
    for (const std::string& name : names)
    {
      list += (list.empty() ? "" : ", ") + name;
    }
    vtkWarningWithObjectMacro(
      this->Self, << "Cell arrays are not deformed and not passed on: " << list
                  << ". To have them deformed, put Cell Data to Point Data before this filter.");
  }
  this->LostArrays = std::move(names);
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::WriteDeformed(const Scene& scene, vtkImageData* output)
{
  vtkChainMailSampling::Grids grids;
  grids.Size = scene.Tissue.Size;
  int extent[6];
  scene.Image->GetExtent(extent);
  for (int a = 0; a < 3; ++a)
  {
    grids.Padding[a] = grids.Size[a] > 1 ? this->Self->OutputPadding : 0;
    extent[2 * a] -= grids.Padding[a];
    extent[2 * a + 1] += grids.Padding[a];
  }
  output->SetOrigin(scene.Image->GetOrigin());
  output->SetSpacing(scene.Image->GetSpacing());
  output->SetDirectionMatrix(scene.Image->GetDirectionMatrix());
  output->SetExtent(extent);

  // As the model tells it, which may be asked by one thread alone.
  const auto isTissue = [&](vtkIdType voxel)
  {
    const double scalar = this->EngineScalars->GetComponent(voxel, 0);
    return std::isfinite(scalar) && scalar >= scene.Tissue.Threshold;
  };
  vtkPointData* arrays = scene.Image->GetPointData();
  std::vector<std::unique_ptr<vtkChainMailSampling::ArraySampler>> samplers;
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    vtkAbstractArray* array = arrays->GetAbstractArray(a);
    const char* name = array->GetName();
    const bool nearest = this->Self->Interpolation == INTERPOLATION_NEAREST || this->Self->HasLabelArray(name) ||
                         array == arrays->GetGlobalIds() || array == arrays->GetPedigreeIds();
    const double background = array == scene.Scalars ? this->Self->BackgroundValue : vtkMath::Nan();
    if (name && std::string(name) == vtkDataSetAttributes::GhostArrayName())
    {
      samplers.push_back(std::make_unique<vtkChainMailSampling::StillArray>(array, grids));
    }
    else
    {
      samplers.push_back(vtkChainMailSampling::MakeSampler(array, grids, nearest, background, isTissue));
    }
  }

  this->Simulation->resample(grids.Padding,
    [&](const chainmail::ResampledBox& box)
    {
      for (const auto& sampler : samplers)
      {
        sampler->Sample({ box.first, box.size, box.offset });
      }
    });

  this->WarnAboutLostArrays(scene.Image);
  if (vtkAbstractArray* ghosts = scene.Image->GetCellData()->GetAbstractArray(vtkDataSetAttributes::GhostArrayName()))
  {
    output->GetCellData()->AddArray(vtkChainMailSampling::StillArray(ghosts, grids.Cells()).GetOutput());
  }
  vtkPointData* out = output->GetPointData();
  for (const auto& sampler : samplers)
  {
    out->AddArray(sampler->GetOutput());
  }
  // The same arrays are the active ones. Global ids would have to be unique: tissue that stretches shows one twice.
  for (int attribute = 0; attribute < vtkDataSetAttributes::NUM_ATTRIBUTES; ++attribute)
  {
    vtkAbstractArray* active =
      attribute == vtkDataSetAttributes::GLOBALIDS ? nullptr : arrays->GetAbstractAttribute(attribute);
    for (int a = 0; active && a < arrays->GetNumberOfArrays(); ++a)
    {
      if (arrays->GetAbstractArray(a) == active)
      {
        out->SetActiveAttribute(a, attribute);
      }
    }
  }
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::FetchTissue(const Scene& scene)
{
  const vtkIdType voxels = scene.Image->GetNumberOfPoints();
  const int axes = this->Model->axes();
  const auto constraint = MakeArray<vtkFloatArray>("Constraint", axes, voxels);
  const auto element = MakeArray<vtkUnsignedCharArray>("Element", 1, voxels);
  const int width = scene.Tissue.Size[0];
  float* c = constraint->GetPointer(0);
  unsigned char* e = element->GetPointer(0);
  this->Simulation->elements(e);
  for (int k = 0; k < scene.Tissue.Size[2]; ++k)
  {
    for (int j = 0; j < scene.Tissue.Size[1]; ++j)
    {
      this->Model->row(0, j, k, width, c);
      for (int i = 0; i < width; ++i, c += axes, ++e)
      {
        // The engine marks air by an infinite constraint and anchors by a negative one.
        for (int a = 0; a < axes; ++a)
        {
          c[a] = *e ? std::fabs(c[a]) : 0.0f;
        }
      }
    }
  }
  this->Constraint.Set(constraint);
  this->Element.Set(element);
}

//------------------------------------------------------------------------------
vtkSmartPointer<vtkFloatArray> vtkChainMailDeformation::vtkInternals::FetchDisplacement(const Scene& scene)
{
  const vtkIdType voxels = scene.Image->GetNumberOfPoints();
  const auto displacement = MakeArray<vtkFloatArray>("Displacement", 3, voxels, true);
  float* u = displacement->GetPointer(0);
  this->Simulation->displacements(u, true);
  if (scene.Space.IsRotated())
  {
    vtkSMPTools::For(0, voxels,
      [&](vtkIdType first, vtkIdType last)
      {
        for (vtkIdType v = first; v < last; ++v)
        {
          if (u[3 * v] != 0.0f || u[3 * v + 1] != 0.0f || u[3 * v + 2] != 0.0f)
          {
            scene.Space.VectorToWorld(u + 3 * v, u + 3 * v);
          }
        }
      });
  }
  return displacement;
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::FetchTimes(const Scene& scene, vtkPointData* output)
{
  const vtkIdType voxels = scene.Image->GetNumberOfPoints();
  const int axes = this->Model->axes();
  const auto time = MakeArray<vtkFloatArray>("PropagationTime", axes, voxels);
  float* t = time->GetPointer(0);
  this->Simulation->propagationTimes(t);
  const Vector3& spacing = scene.Space.GetSpacing();
  vtkSMPTools::For(0, voxels,
    [&](vtkIdType first, vtkIdType last)
    {
      for (int a = 0; a < axes; ++a)
      {
        for (vtkIdType n = first * axes + a; n < last * axes; n += axes)
        {
          // Where no wave came it is negative, and stays so.
          t[n] = t[n] > 0.0f ? static_cast<float>(t[n] * spacing[a]) : t[n];
        }
      }
    });
  const auto wavefront = MakeArray<vtkIntArray>("Wavefront", axes, voxels, true);
  this->Simulation->wavefronts(wavefront->GetPointer(0), true);
  output->AddArray(time);
  output->AddArray(wavefront);
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::WriteModel(const Scene& scene, vtkImageData* output)
{
  output->SetOrigin(scene.Image->GetOrigin());
  output->SetSpacing(scene.Image->GetSpacing());
  output->SetDirectionMatrix(scene.Image->GetDirectionMatrix());
  output->SetExtent(scene.Image->GetExtent());
  vtkPointData* arrays = output->GetPointData();

  if (!this->Element.IsIntact() || !this->Constraint.IsIntact())
  {
    this->Run(DOWNLOAD, 0.9, 0.93, [&] { this->FetchTissue(scene); });
  }
  if (!this->Cluster.IsIntact())
  {
    this->Run(DOWNLOAD, 0.93, 0.95,
      [&]
      {
        const auto cluster = MakeArray<vtkIntArray>("Cluster", this->Model->axes(), scene.Image->GetNumberOfPoints());
        this->Simulation->clusters(cluster->GetPointer(0));
        this->Cluster.Set(cluster);
      });
  }
  this->Run(DOWNLOAD, 0.95, 0.98, [&] { arrays->SetVectors(this->FetchDisplacement(scene)); });
  arrays->AddArray(this->Constraint.Get());
  arrays->SetScalars(this->Element.Get());
  arrays->AddArray(this->Cluster.Get());
  if (this->Self->PropagationTimes)
  {
    this->Run(DOWNLOAD, 0.98, 1.0, [&] { this->FetchTimes(scene, arrays); });
  }
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::vtkInternals::WriteFieldData(const Scene& scene, vtkImageData* output)
{
  vtkFieldData* fields = output->GetFieldData();
  fields->ShallowCopy(scene.Image->GetFieldData());

  const vtkIdType numberOfProbes = static_cast<vtkIdType>(this->Results.size());
  const auto addVectors = [&](const char* name, Vector3 chainmail::ProbeResult::*member)
  {
    vtkNew<vtkDoubleArray> array;
    array->SetName(name);
    array->SetNumberOfComponents(3);
    array->SetNumberOfTuples(numberOfProbes);
    for (vtkIdType p = 0; p < numberOfProbes; ++p)
    {
      double world[3];
      scene.Space.VectorToWorld((this->Results[p].*member).data(), world);
      array->SetTuple(p, world);
    }
    fields->AddArray(array);
  };
  const auto addRow = [&](vtkDataArray* array, const char* name, const std::vector<double>& row)
  {
    array->SetName(name);
    array->SetNumberOfComponents(static_cast<int>(row.size()));
    array->InsertNextTuple(row.data());
    fields->AddArray(array);
  };
  addRow(vtkNew<vtkDoubleArray>(), "Energy", { this->Statistics.energy });
  addRow(vtkNew<vtkDoubleArray>(), "MaxLinkExcess", { this->Statistics.maxLinkExcess });
  addRow(vtkNew<vtkIntArray>(), "PropagationIterationsUsed", { static_cast<double>(this->Propagation.iterations) });
  addRow(vtkNew<vtkIntArray>(), "RelaxationIterationsUsed", { static_cast<double>(this->Relaxation.iterations) });
  addRow(vtkNew<vtkDoubleArray>(), "CoarseToFineStep", { this->Relaxation.coarseStep.value_or(-1.0) });
  addRow(vtkNew<vtkIdTypeArray>(), "ActiveElements", { static_cast<double>(this->Statistics.displaced) });
  vtkNew<vtkDoubleArray> milliseconds;
  addRow(milliseconds, "Milliseconds", { this->Milliseconds.begin(), this->Milliseconds.end() });
  const char* const times[NUMBER_OF_TIMES] = { "upload", "propagate", "relax", "resample", "download" };
  for (int t = 0; t < NUMBER_OF_TIMES; ++t)
  {
    milliseconds->SetComponentName(t, times[t]);
  }

  addRow(vtkNew<vtkDoubleArray>(), "PeakDeviceMemory", { this->PeakDeviceMemory });

  vtkNew<vtkStringArray> device;
  device->SetName("DeviceName");
  device->InsertNextValue(this->Simulation->deviceName());
  fields->AddArray(device);

  // Last: field data has as many rows as its first array, and where that is none ParaView shows and sends nothing.
  addVectors("ProbeReached", &chainmail::ProbeResult::reached);
  addVectors("ProbeForce", &chainmail::ProbeResult::force);
}

//------------------------------------------------------------------------------
vtkStandardNewMacro(vtkChainMailDeformation);

//------------------------------------------------------------------------------
vtkChainMailDeformation::vtkChainMailDeformation()
  : TissueThreshold(vtkMath::Nan())
  , BackgroundValue(vtkMath::Nan())
  , Controller(vtkMultiProcessController::GetGlobalController())
  , Internals(new vtkInternals(this))
{
  this->SetNumberOfInputPorts(4);
  this->SetNumberOfOutputPorts(2);
  this->SetInputArrayToProcess(0, IMAGE, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, vtkDataSetAttributes::SCALARS);
}

//------------------------------------------------------------------------------
vtkChainMailDeformation::~vtkChainMailDeformation() = default;

//------------------------------------------------------------------------------
void vtkChainMailDeformation::SetProbesConnection(vtkAlgorithmOutput* producer)
{
  this->SetInputConnection(PROBES, producer);
}

void vtkChainMailDeformation::AddProbesConnection(vtkAlgorithmOutput* producer)
{
  this->AddInputConnection(PROBES, producer);
}

void vtkChainMailDeformation::SetCutsConnection(vtkAlgorithmOutput* producer)
{
  this->SetInputConnection(CUTS, producer);
}

void vtkChainMailDeformation::AddCutsConnection(vtkAlgorithmOutput* producer)
{
  this->AddInputConnection(CUTS, producer);
}

void vtkChainMailDeformation::SetCarvesConnection(vtkAlgorithmOutput* producer)
{
  this->SetInputConnection(CARVES, producer);
}

void vtkChainMailDeformation::AddCarvesConnection(vtkAlgorithmOutput* producer)
{
  this->AddInputConnection(CARVES, producer);
}

//------------------------------------------------------------------------------
vtkImageData* vtkChainMailDeformation::GetModelOutput()
{
  return vtkImageData::SafeDownCast(this->GetOutputDataObject(1));
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::SetController(vtkMultiProcessController* controller)
{
  if (this->Controller != controller)
  {
    this->Controller = controller;
    this->Modified();
  }
}

vtkMultiProcessController* vtkChainMailDeformation::GetController()
{
  return this->Controller;
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::SetMaterialFunction(vtkPiecewiseFunction* function)
{
  if (this->MaterialFunction != function)
  {
    this->MaterialFunction = function;
    this->Modified();
  }
}

vtkPiecewiseFunction* vtkChainMailDeformation::GetMaterialFunction()
{
  return this->MaterialFunction;
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::Reset()
{
  if (this->Mode == MODE_INTERACTIVE)
  {
    this->Internals->ResetRequested = true;
    this->Internals->WantsUpdate = this->Internals->Interacting;
    this->Modified();
  }
}

//------------------------------------------------------------------------------
bool vtkChainMailDeformation::GetNeedsUpdate()
{
  const bool needed = this->Mode == MODE_INTERACTIVE && this->Internals->WantsUpdate;
  // Of several processes perhaps one alone is asked. It would go on alone, and wait for the others without end.
  if (needed && !this->Internals->ComputedInParallel)
  {
    this->Modified();
  }
  return needed;
}

//------------------------------------------------------------------------------
// NaN differs from itself: vtkSetMacro would take every call for a change.
void vtkChainMailDeformation::SetTissueThreshold(double threshold)
{
  if (this->TissueThreshold != threshold && !(std::isnan(this->TissueThreshold) && std::isnan(threshold)))
  {
    this->TissueThreshold = threshold;
    this->Modified();
  }
}

void vtkChainMailDeformation::SetBackgroundValue(double value)
{
  if (this->BackgroundValue != value && !(std::isnan(this->BackgroundValue) && std::isnan(value)))
  {
    this->BackgroundValue = value;
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::FitMaterial(
  const double range[2], double& tissueThreshold, vtkPiecewiseFunction* function)
{
  vtkChainMailDeformation::GetPresetMaterial(MATERIAL_FUNCTION, range, tissueThreshold, function);
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::GetPresetMaterial(
  int preset, const double range[2], double& tissueThreshold, vtkPiecewiseFunction* function)
{
  using Nodes = std::vector<std::array<double, 2>>; // scalar, constraint

  Nodes nodes;
  if (preset == MATERIAL_CT || (preset == MATERIAL_FUNCTION && range[0] < -200.0))
  {
    // Hounsfield units: skin and fat about -100, muscle and organs about 50, spongy bone from 200. Blood with contrast
    // agent reaches 500, so only compact bone is certain to be rigid.
    tissueThreshold = -300.0;
    nodes = Nodes{ { -300.0, 0.3 }, { -100.0, 0.35 }, { 0.0, 0.25 }, { 50.0, 0.2 }, { 150.0, 0.15 }, { 300.0, 0.08 },
      { 600.0, 0.0 } };
  }
  else
  {
    const bool valid = range[0] <= range[1] && std::isfinite(range[1] - range[0]); // not where nothing is finite
    const double low = valid ? range[0] : 0.0;
    const double width = valid ? range[1] - range[0] : 0.0;
    // Shares of the range. T1-weighted MR: tendon is dark, muscle grey, fat bright. Else brighter is taken as stiffer.
    nodes = preset == MATERIAL_MR ? Nodes{ { 0.1, 0.15 }, { 0.3, 0.2 }, { 0.6, 0.3 }, { 1.0, 0.35 } }
                                  : Nodes{ { 0.1, 0.3 }, { 0.4, 0.2 }, { 1.0, 0.05 } };
    for (auto& node : nodes)
    {
      node[0] = low + node[0] * width;
    }
    tissueThreshold = low + 0.1 * width;
  }
  if (function)
  {
    function->RemoveAllPoints();
    function->ClampingOn();
    for (const auto& node : nodes)
    {
      function->AddPoint(node[0], node[1]);
    }
  }
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::AddLabelArray(const char* name)
{
  if (name && *name && !this->HasLabelArray(name))
  {
    this->LabelArrays.emplace_back(name);
    this->Modified();
  }
}

void vtkChainMailDeformation::RemoveLabelArray(const char* name)
{
  if (this->HasLabelArray(name))
  {
    this->LabelArrays.erase(std::find(this->LabelArrays.begin(), this->LabelArrays.end(), name));
    this->Modified();
  }
}

void vtkChainMailDeformation::ClearLabelArrays()
{
  if (!this->LabelArrays.empty())
  {
    this->LabelArrays.clear();
    this->Modified();
  }
}

int vtkChainMailDeformation::GetNumberOfLabelArrays() const
{
  return static_cast<int>(this->LabelArrays.size());
}

const char* vtkChainMailDeformation::GetLabelArray(int index) const
{
  return index >= 0 && index < this->GetNumberOfLabelArrays() ? this->LabelArrays[index].c_str() : nullptr;
}

bool vtkChainMailDeformation::HasLabelArray(const char* name) const
{
  return name && std::find(this->LabelArrays.begin(), this->LabelArrays.end(), name) != this->LabelArrays.end();
}

//------------------------------------------------------------------------------
vtkStringArray* vtkChainMailDeformation::GetAvailableDevices()
{
  this->AvailableDevices = vtkSmartPointer<vtkStringArray>::New();
  try
  {
    for (const chainmail::DeviceInfo& device : chainmail::listDevices())
    {
      this->AvailableDevices->InsertNextValue(device.name);
    }
  }
  catch (const std::exception& error)
  {
    vtkErrorMacro(<< error.what());
  }
  return this->AvailableDevices;
}

//------------------------------------------------------------------------------
vtkMTimeType vtkChainMailDeformation::GetMTime()
{
  const vtkMTimeType own = this->Superclass::GetMTime();
  return this->MaterialFunction ? std::max(own, this->MaterialFunction->GetMTime()) : own;
}

//------------------------------------------------------------------------------
int vtkChainMailDeformation::FillInputPortInformation(int port, vtkInformation* info)
{
  const char* const types[] = { "vtkImageData", "vtkPointSet", "vtkPolyData", "vtkPolyData" };
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), types[port]);
  // Else the executive would run the filter once for every block, with one simulation for all. Of several images in one
  // input the user is told.
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  if (port != IMAGE)
  {
    info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
    info->Set(vtkAlgorithm::INPUT_IS_REPEATABLE(), 1);
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailDeformation::RequestInformation(
  vtkInformation* vtkNotUsed(request), vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  vtkInformation* input = inputVector[IMAGE]->GetInformationObject(0);
  int extent[6] = { 0, -1, 0, -1, 0, -1 };
  if (input->Has(Pipeline::WHOLE_EXTENT())) // not of a composite dataset
  {
    input->Get(Pipeline::WHOLE_EXTENT(), extent);
  }
  vtkInformation* deformed = outputVector->GetInformationObject(0);
  vtkInformation* model = outputVector->GetInformationObject(1);
  model->Set(Pipeline::WHOLE_EXTENT(), extent, 6);
  vtkDataObject::SetPointDataActiveScalarInfo(model, VTK_UNSIGNED_CHAR, 1); // Element

  // No more than fits: the update will say that it does not, and nobody is to ask for extents beyond all memory.
  chainmail::Index3 size;
  for (int a = 0; a < 3; ++a)
  {
    size[a] = extent[2 * a + 1] - extent[2 * a] + 1;
  }
  const int padding = vtkChainMailSampling::FittingPadding(size, this->OutputPadding);
  for (int a = 0; a < 3; ++a)
  {
    extent[2 * a] -= size[a] > 1 ? padding : 0;
    extent[2 * a + 1] += size[a] > 1 ? padding : 0;
  }
  deformed->Set(Pipeline::WHOLE_EXTENT(), extent, 6);

  // Whatever changes with time changes the outputs: the scan, or a probe while the scan does not.
  std::set<double> steps;
  double range[2] = { std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity() };
  for (int port = 0; port < this->GetNumberOfInputPorts(); ++port)
  {
    for (int n = 0; n < inputVector[port]->GetNumberOfInformationObjects(); ++n)
    {
      vtkInformation* info = inputVector[port]->GetInformationObject(n);
      if (info->Has(Pipeline::TIME_STEPS()))
      {
        const double* first = info->Get(Pipeline::TIME_STEPS());
        steps.insert(first, first + info->Length(Pipeline::TIME_STEPS()));
      }
      if (info->Has(Pipeline::TIME_RANGE()))
      {
        range[0] = std::min(range[0], info->Get(Pipeline::TIME_RANGE())[0]);
        range[1] = std::max(range[1], info->Get(Pipeline::TIME_RANGE())[1]);
      }
    }
  }
  if (!steps.empty())
  {
    range[0] = std::min(range[0], *steps.begin());
    range[1] = std::max(range[1], *steps.rbegin());
  }

  for (vtkInformation* output : { deformed, model })
  {
    output->Remove(Pipeline::TIME_STEPS());
    output->Remove(Pipeline::TIME_RANGE());
    if (!steps.empty())
    {
      const std::vector<double> sorted(steps.begin(), steps.end());
      output->Set(Pipeline::TIME_STEPS(), sorted.data(), static_cast<int>(sorted.size()));
    }
    if (range[0] <= range[1])
    {
      output->Set(Pipeline::TIME_RANGE(), range, 2);
    }
    // The executive turns the number of a piece into the extent to deliver.
    output->Set(vtkAlgorithm::CAN_PRODUCE_SUB_EXTENT(), 1);
    // An update that failed leaves what was asked of it, which the executive would combine with what is asked of this
    // image: extents that it may not have.
    output->Remove(Pipeline::COMBINED_UPDATE_EXTENT());
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailDeformation::RequestUpdateExtent(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  // A wave can come from anywhere: every piece needs all of all inputs.
  for (int port = 0; port < this->GetNumberOfInputPorts(); ++port)
  {
    for (int n = 0; n < inputVector[port]->GetNumberOfInformationObjects(); ++n)
    {
      vtkInformation* input = inputVector[port]->GetInformationObject(n);
      if (input->Has(Pipeline::WHOLE_EXTENT()))
      {
        int extent[6];
        input->Get(Pipeline::WHOLE_EXTENT(), extent);
        input->Set(Pipeline::UPDATE_EXTENT(), extent, 6);
      }
      input->Set(Pipeline::UPDATE_PIECE_NUMBER(), 0);
      input->Set(Pipeline::UPDATE_NUMBER_OF_PIECES(), 1);
      input->Set(Pipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
    }
  }

  // Both outputs are made together, and the executive takes both for that piece then.
  vtkInformation* asked = outputVector->GetInformationObject(std::max(0, request->Get(Pipeline::FROM_OUTPUT_PORT())));
  for (int port = 0; port < this->GetNumberOfOutputPorts(); ++port)
  {
    vtkInformation* output = outputVector->GetInformationObject(port);
    if (output != asked)
    {
      output->CopyEntry(asked, Pipeline::UPDATE_PIECE_NUMBER());
      output->CopyEntry(asked, Pipeline::UPDATE_NUMBER_OF_PIECES());
      output->CopyEntry(asked, Pipeline::UPDATE_NUMBER_OF_GHOST_LEVELS());
    }
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailDeformation::RequestData(
  vtkInformation* vtkNotUsed(request), vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  vtkInternals& internals = *this->Internals;
  vtkInformation* asked = outputVector->GetInformationObject(0);
  const int pieces = asked->Get(Pipeline::UPDATE_NUMBER_OF_PIECES());

  // The processes of a parallel server ask for a piece each, all at once. Whoever asks otherwise, a writer that streams
  // say, is alone.
  const bool parallel = this->Controller && pieces > 1 && this->Controller->GetNumberOfProcesses() == pieces &&
                        this->Controller->GetLocalProcessId() == asked->Get(Pipeline::UPDATE_PIECE_NUMBER());
  const Exchange exchange(parallel ? this->Controller.Get() : nullptr);

  const bool wasPart = internals.ComputedInParallel;
  internals.ComputedInParallel = parallel;
  const Inputs mine = vtkChainMail::CollectInputs(inputVector);
  if (!exchange.All(internals.IsUnchanged(inputVector, mine) && wasPart == parallel && !internals.Last.Stopped))
  {
    const Inputs inputs = exchange.Gather(mine);
    internals.Last = exchange.IsRoot() ? internals.Compute(inputs) : Outcome();
    exchange.Share(internals.Last);
    internals.WantsUpdate = internals.Last.NeedsUpdate;
    internals.Interacting = internals.Last.Interacting;
    internals.ResetRequested = internals.ResetRequested && !internals.Last.Error.empty();
    // Printed once, heard by all who listen.
    if (!internals.Last.Error.empty() && (exchange.IsRoot() || this->HasObserver(vtkCommand::ErrorEvent)))
    {
      vtkErrorMacro(<< internals.Last.Error);
    }
  }

  for (int port = 0; port < this->GetNumberOfOutputPorts(); ++port)
  {
    vtkInformation* info = outputVector->GetInformationObject(port);
    std::array<int, 6> extent;
    info->Get(Pipeline::UPDATE_EXTENT(), extent.data());
    if (pieces <= 1)
    {
      info->Get(Pipeline::WHOLE_EXTENT(), extent.data());
    }
    const auto piece = exchange.Deliver(internals.Shown[port], extent);
    vtkImageData* output = vtkImageData::GetData(info);
    output->CopyStructure(piece);
    output->GetPointData()->ShallowCopy(piece->GetPointData());
    output->GetCellData()->ShallowCopy(piece->GetCellData());
    output->GetFieldData()->ShallowCopy(piece->GetFieldData());
  }
  // Not SetErrorCode(), which would make this update out of date.
  this->ErrorCode = internals.Last.Error.empty() ? vtkErrorCode::NoError : vtkErrorCode::UserError;
  // An update that failed shows the last good result, or the image as it is. A pipeline that fails instead leaves views
  // without anything to draw, also after the mistake was mended, and reports it over and over.
  return 1;
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  const char* const presets[] = { "Function", "CT", "MR" };
  os << indent << "MaterialPreset: " << presets[this->MaterialPreset] << "\n";
  os << indent << "MaterialFunction: ";
  if (this->MaterialFunction)
  {
    os << "\n";
    this->MaterialFunction->PrintSelf(os, indent.GetNextIndent());
  }
  else
  {
    os << "(none)\n";
  }
  os << indent << "ConstraintArray: " << (this->ConstraintArray.empty() ? "(none)" : this->ConstraintArray) << "\n";
  os << indent << "TissueThreshold: " << this->TissueThreshold << "\n";
  os << indent << "AnchorRigid: " << (this->AnchorRigid ? "On" : "Off") << "\n";
  os << indent << "AnchoredFaces:";
  for (int face : this->AnchoredFaces)
  {
    os << " " << face;
  }
  os << "\n";
  os << indent << "Mode: " << (this->Mode == MODE_FROM_REST ? "FromRest" : "Interactive") << "\n";
  os << indent << "PropagationMethod: " << (this->PropagationMethod == PROPAGATION_ENVELOPE ? "Envelope" : "Timestamp")
     << "\n";
  os << indent << "PropagationIterations: " << this->PropagationIterations << "\n";
  os << indent << "ConflictPolicy: " << (this->ConflictPolicy == CONFLICT_LIMIT ? "Limit" : "Latest") << "\n";
  os << indent << "PropagationTimes: " << (this->PropagationTimes ? "On" : "Off") << "\n";
  const char* const settings[] = { "Custom", "Interactive", "Balanced", "Accurate" };
  os << indent << "RelaxationPreset: " << settings[this->RelaxationPreset] << "\n";
  os << indent << "CoarseToFine: " << (this->CoarseToFine ? "On" : "Off") << "\n";
  os << indent << "RelaxationMethod: " << (this->RelaxationMethod == RELAXATION_PROJECTED ? "Projected" : "Paper")
     << "\n";
  os << indent << "ElasticRecovery: " << this->ElasticRecovery << "\n";
  os << indent << "RelaxationIterations: " << this->RelaxationIterations << "\n";
  os << indent << "RelaxationTolerance: " << this->RelaxationTolerance << "\n";
  os << indent << "ModelReduction: " << this->ModelReduction << "\n";
  os << indent << "Interpolation: " << (this->Interpolation == INTERPOLATION_LINEAR ? "Linear" : "Nearest") << "\n";
  os << indent << "LabelArrays:";
  for (const std::string& name : this->LabelArrays)
  {
    os << " " << name;
  }
  os << "\n";
  os << indent << "BackgroundValue: " << this->BackgroundValue << "\n";
  os << indent << "OutputPadding: " << this->OutputPadding << "\n";
  os << indent << "Device: " << (this->Device.empty() ? "(best)" : this->Device) << "\n";
  os << indent << "BlockSize: " << this->BlockSize[0] << " " << this->BlockSize[1] << " " << this->BlockSize[2] << "\n";
}
