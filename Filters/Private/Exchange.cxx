// SPDX-License-Identifier: BSD-3-Clause
#include "Exchange.h"

#include "Arrays.h"
#include "ImageParts.h"
#include "Steps.h"

#include "Error.h"

#include "vtkCellData.h"
#include "vtkCharArray.h"
#include "vtkCommunicator.h"
#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkExtentTranslator.h"
#include "vtkFieldData.h"
#include "vtkMatrix3x3.h"
#include "vtkMultiProcessController.h"
#include "vtkMultiProcessStream.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkTable.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <numeric>
#include <tuple>

namespace vtkChainMail
{

namespace
{

constexpr int root = Exchange::Root;

constexpr std::size_t page = 4096;                    // [bytes] of a sparse array
constexpr std::size_t portion = std::size_t(1) << 22; // [bytes] of a message

// For messages that find no other memory.
alignas(16) char buffer[portion];

// Messages between two processes arrive in the order in which they were sent, so the tags only help debugging.
enum Tags
{
  ARRAYS = 7101,
  BYTES,
  REQUESTS
};

/// Whether an array is sent as a block of memory. Bits, strings and variants have other storage and are sent as a table
/// with one column.
bool IsRaw(vtkAbstractArray* array)
{
  return vtkDataArray::SafeDownCast(array) && array->GetDataType() != VTK_BIT;
}

/// The numbers of all processes one after the other, on one of them.
template <typename T>
std::vector<T> GatherOn(int process, vtkMultiProcessController* controller, const std::vector<T>& mine)
{
  if (!controller)
  {
    return mine;
  }
  std::vector<T> all(mine.size() * static_cast<std::size_t>(controller->GetNumberOfProcesses()));
  controller->Gather(mine.data(), all.data(), static_cast<vtkIdType>(mine.size()), process);
  return all;
}

/// Runs a step in which other processes take part, and sets `problem` to why it fails, unless an earlier one failed.
template <typename F> void TryExchange(std::string& problem, F&& step)
{
  std::string why;
  try
  {
    step();
  }
  catch (const chainmail::InputError& error)
  {
    why = error.what();
  }
  catch (const std::bad_alloc&)
  {
    why = "There is not enough main memory for this image. Crop it or resample it to fewer voxels.";
  }
  problem = problem.empty() ? why : problem;
}

/// The same for a step of this process alone, which is left out after an earlier one failed.
template <typename F> void Try(std::string& problem, F&& step)
{
  if (problem.empty())
  {
    TryExchange(problem, step);
  }
}

}

namespace
{

/// Whether parts of an image can be read voxel by voxel: all its arrays are numbers in memory, one for each voxel, and
/// no voxel is a copy that may be outdated.
bool IsPlain(vtkImageData* image)
{
  bool is = !image->GetPointGhostArray() && !image->GetCellGhostArray();
  vtkPointData* arrays = image->GetPointData();
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    vtkAbstractArray* array = arrays->GetAbstractArray(a);
    is = is && IsRaw(array) && array->HasStandardMemoryLayout() &&
         array->GetNumberOfTuples() == image->GetNumberOfPoints();
  }
  return is && arrays->GetNumberOfArrays() > 0;
}

/// The hash of what all parts of an image have in common.
Fingerprint KindOf(vtkImageData* image)
{
  Fingerprint h = FingerprintOf(image->GetOrigin(), 3 * sizeof(double));
  h = FingerprintOf(image->GetSpacing(), 3 * sizeof(double), h);
  h = FingerprintOf(image->GetDirectionMatrix()->GetData(), 9 * sizeof(double), h);
  const std::string types = ListTypes(image);
  return FingerprintOf(types.data(), types.size(), h);
}

struct Part
{
  bool IsPlain = false;
  Fingerprint Kind = 0;
  Extent Voxels{ { 0, -1, 0, -1, 0, -1 } };
};

/// What each process provides of an image that stays spread. Nothing where it has to be assembled: where a part is not
/// plain or parts differ, where the root has none, and where parts share more voxels than the planes between pieces.
std::vector<Extent> OwnedOf(const std::vector<Part>& parts, const Extent& whole)
{
  std::vector<Extent> owned;
  vtkIdType voxels = 0;
  std::vector<Extent> missing{ whole };
  for (const Part& part : parts)
  {
    Extent own = part.Voxels;
    for (int a = 0; a < 3 && !IsEmpty(part.Voxels); ++a)
    {
      own[2 * a] += own[2 * a] > whole[2 * a] ? 1 : 0; // this plane belongs to the piece before
    }
    owned.push_back(own);
    if (IsEmpty(part.Voxels))
    {
      continue;
    }
    if (!part.IsPlain || part.Kind != parts.front().Kind || !Contains(whole, part.Voxels) || IsEmpty(own))
    {
      return {};
    }
    voxels += VoxelsOf(own);
    missing = Without(missing, own);
  }
  const bool isExact = missing.empty() && voxels == VoxelsOf(whole);
  return isExact && !IsEmpty(owned.front()) ? owned : std::vector<Extent>();
}

/// The pieces of an image, as VTK divides it.
std::vector<Extent> PiecesOf(const Extent& whole, int count)
{
  vtkNew<vtkExtentTranslator> translator;
  std::vector<Extent> pieces(static_cast<std::size_t>(count));
  for (int p = 0; p < count; ++p)
  {
    Extent source = whole;
    translator->PieceToExtentThreadSafe(
      p, count, 0, source.data(), pieces[p].data(), vtkExtentTranslator::BLOCK_MODE, 0);
  }
  return pieces;
}

}

void Exchange::Wanted::Write(vtkMultiProcessStream& stream) const
{
  stream << static_cast<int>(this->Numbers.size());
  std::for_each(this->Numbers.begin(), this->Numbers.end(), [&](int n) { stream << n; });
  stream << this->Image;
}

void Exchange::Wanted::Read(vtkMultiProcessStream& stream)
{
  int count;
  stream >> count;
  this->Numbers.resize(count);
  std::for_each(this->Numbers.begin(), this->Numbers.end(), [&](int& n) { stream >> n; });
  stream >> this->Image;
}

Exchange::Exchange(vtkMultiProcessController* controller)
  : Controller(controller && controller->GetNumberOfProcesses() > 1 ? controller : nullptr)
{
}

bool Exchange::IsRoot() const
{
  return !this->Controller || this->Controller->GetLocalProcessId() == root;
}

bool Exchange::All(bool mine) const
{
  int all = mine;
  if (this->Controller)
  {
    const int one = mine;
    this->Controller->AllReduce(&one, &all, 1, vtkCommunicator::MIN_OP);
  }
  return all != 0;
}

Inputs Exchange::Gather(Inputs& mine, bool isKnown, vtkImageData* known, Holding& holding) const
{
  if (!this->Controller)
  {
    holding = Holding();
    return mine;
  }
  // Each process first sends a list of what it has, so nothing is sent that the root already has.
  vtkMultiProcessStream about;
  about << mine.Problem << static_cast<int>(mine.Leaves.size());
  for (const InputDataset& leaf : mine.Leaves)
  {
    about << leaf.Port << leaf.Input << leaf.Block << leaf.BlockName << leaf.GetFingerprint();
  }
  const bool hasImage = mine.Image && mine.Image->GetNumberOfPoints() > 0;
  about << hasImage;
  if (hasImage)
  {
    about << IsPlain(mine.Image) << KindOf(mine.Image);
    for (const int e : ExtentOf(mine.Image))
    {
      about << e;
    }
  }
  std::vector<vtkMultiProcessStream> abouts;
  this->Controller->Gather(about, abouts, root);

  Inputs all;
  std::vector<Wanted> wanted(this->Controller->GetNumberOfProcesses());
  vtkMultiProcessStream wishes;
  if (this->IsRoot())
  {
    wanted = Choose(mine, isKnown, abouts, all.Problem, holding);
    wishes << (!isKnown && holding.IsSpread() && Contains(ExtentOf(mine.Image), mine.WholeExtent));
    std::for_each(wanted.begin(), wanted.end(), [&](const Wanted& one) { one.Write(wishes); });
    wishes << static_cast<int>(holding.Owned.size());
    for (const Extent& owned : holding.Owned)
    {
      std::for_each(owned.begin(), owned.end(), [&](int e) { wishes << e; });
    }
  }
  this->Controller->Broadcast(wishes, root);
  bool isDivided;
  wishes >> isDivided;
  if (this->IsRoot())
  {
    this->Receive(mine, wanted, all);
    if (isKnown)
    {
      all.Image = known;
    }
  }
  else
  {
    std::for_each(wanted.begin(), wanted.end(), [&](Wanted& one) { one.Read(wishes); });
    int owners = 0;
    wishes >> owners;
    holding.Whole = mine.WholeExtent;
    holding.Owned.resize(owners);
    for (Extent& owned : holding.Owned)
    {
      std::for_each(owned.begin(), owned.end(), [&](int& e) { wishes >> e; });
    }
    this->Send(mine, wanted[this->Controller->GetLocalProcessId()]);
  }
  if (isDivided)
  {
    this->Divide(mine, all.Problem);
  }
  return all;
}

void Exchange::Divide(Inputs& mine, std::string& problem) const
{
  if (!this->IsRoot())
  {
    mine.Image = nullptr;
    TryExchange(problem, [&] { mine.Image = this->ReceiveImage(root); });
    return;
  }
  const std::vector<Extent> pieces = PiecesOf(mine.WholeExtent, this->GetSize());
  const auto cut = [&](int p)
  {
    auto part = vtkSmartPointer<vtkImageData>::New();
    Try(problem, [&] { part = Cut(mine.Image, pieces[static_cast<std::size_t>(p)]); });
    return part;
  };
  for (int p = 1; p < this->GetSize(); ++p)
  {
    this->Send(cut(p), p);
  }
  mine.Image = cut(root);
}

std::vector<Exchange::Wanted> Exchange::Choose(
  const Inputs& mine, bool isKnown, std::vector<vtkMultiProcessStream>& abouts, std::string& problem, Holding& holding)
{
  const bool hasAll =
    isKnown || (mine.Image && mine.Image->GetNumberOfPoints() > 0 && Contains(ExtentOf(mine.Image), mine.WholeExtent));
  std::vector<std::tuple<int, int, int, Fingerprint>> known;
  std::vector<Wanted> wanted(abouts.size());
  std::vector<Part> parts;
  for (int p = 0; p < static_cast<int>(abouts.size()); ++p)
  {
    std::string problemThere;
    int count;
    abouts[p] >> problemThere >> count;
    problem = problem.empty() ? problemThere : problem;
    for (int n = 0; n < count; ++n)
    {
      InputDataset leaf;
      Fingerprint fingerprint;
      abouts[p] >> leaf.Port >> leaf.Input >> leaf.Block >> leaf.BlockName >> fingerprint;
      leaf.Process = p;
      // Equal data on the same process are two datasets. Equal data on two processes are one dataset, which both have.
      const auto key = std::make_tuple(leaf.Port, leaf.Input, leaf.Block, fingerprint);
      if (p == root || std::find(known.begin(), known.end(), key) == known.end())
      {
        known.push_back(key);
        wanted[p].Numbers.push_back(n);
        wanted[p].Leaves.push_back(leaf);
      }
    }
    bool hasImage;
    abouts[p] >> hasImage;
    wanted[p].Image = hasImage && !hasAll;
    Part part;
    if (hasImage)
    {
      abouts[p] >> part.IsPlain >> part.Kind;
      std::for_each(part.Voxels.begin(), part.Voxels.end(), [&](int& e) { abouts[p] >> e; });
    }
    parts.push_back(part);
  }
  if (!isKnown)
  {
    holding.Whole = mine.WholeExtent;
    const bool isOnRoot =
      hasAll && std::all_of(parts.begin() + 1, parts.end(), [](const Part& part) { return IsEmpty(part.Voxels); });
    const bool isDivided = isOnRoot && mine.IsReleased;
    if (isDivided)
    {
      const std::vector<Extent> pieces = PiecesOf(mine.WholeExtent, static_cast<int>(parts.size()));
      for (std::size_t p = 0; p < parts.size(); ++p)
      {
        parts[p] = { parts.front().IsPlain, parts.front().Kind, pieces[p] };
      }
    }
    holding.Owned = hasAll && !isDivided ? std::vector<Extent>() : OwnedOf(parts, mine.WholeExtent);
  }
  for (Wanted& one : wanted)
  {
    one.Image = one.Image && !holding.IsSpread();
  }
  return wanted;
}

void Exchange::Send(const Inputs& mine, const Wanted& wanted) const
{
  for (const int n : wanted.Numbers)
  {
    this->Send(mine.Leaves[n].Data, root);
  }
  if (wanted.Image)
  {
    this->Send(mine.Image, root);
  }
}

void Exchange::Receive(const Inputs& mine, const std::vector<Wanted>& wanted, Inputs& all) const
{
  all.WholeExtent = mine.WholeExtent;
  Assembly image(mine.WholeExtent);
  bool isAssembled = false;
  for (int p = 0; p < static_cast<int>(wanted.size()); ++p)
  {
    for (std::size_t n = 0; n < wanted[p].Numbers.size(); ++n)
    {
      InputDataset leaf = wanted[p].Leaves[n];
      if (p == root)
      {
        leaf.Data = mine.Leaves[wanted[p].Numbers[n]].Data;
      }
      else
      {
        TryExchange(all.Problem, [&] { leaf.Data = this->ReceiveSurface(p); });
      }
      all.Leaves.push_back(leaf);
    }
    if (wanted[p].Image)
    {
      vtkSmartPointer<vtkImageData> part = mine.Image;
      if (p != root)
      {
        TryExchange(all.Problem, [&] { part = this->ReceiveImage(p); });
      }
      isAssembled = true;
      Try(all.Problem, [&] { image.Add(part); });
    }
  }
  std::stable_sort(all.Leaves.begin(), all.Leaves.end(),
    [](const InputDataset& a, const InputDataset& b)
    { return std::tie(a.Port, a.Input, a.Block) < std::tie(b.Port, b.Input, b.Block); });

  all.Image = mine.Image;
  if (isAssembled)
  {
    Try(all.Problem, [&] { all.Image = image.End(); });
  }
}

void Exchange::Agree(Outcome& outcome) const
{
  if (!this->Controller)
  {
    return;
  }
  vtkMultiProcessStream stream;
  stream << outcome.Error << outcome.Stopped << outcome.NeedsUpdate << outcome.Interacting;
  std::vector<vtkMultiProcessStream> all;
  this->Controller->Gather(stream, all, root);
  Outcome agreed;
  const std::string elsewhere = FailedElsewhere().what();
  for (std::size_t p = all.size(); p-- > 0;)
  {
    Outcome one;
    all[p] >> one.Error >> one.Stopped >> one.NeedsUpdate >> one.Interacting;
    if (p == root || one.Stopped || !one.Error.empty())
    {
      // A process that could not go on because of another one has less to say than that one.
      const bool isEcho = one.Error == elsewhere && !(agreed.Error.empty() && !agreed.Stopped);
      const bool isFine = (!one.Stopped && one.Error.empty()) || isEcho;
      const std::string where = p == root ? "" : "Process " + std::to_string(p) + ": ";
      agreed.Error = isFine ? agreed.Error : one.Error.empty() ? one.Error : where + one.Error;
      agreed.Stopped = isFine ? agreed.Stopped : one.Stopped;
      agreed.NeedsUpdate = one.NeedsUpdate;
      agreed.Interacting = one.Interacting;
    }
  }
  vtkMultiProcessStream result;
  result << agreed.Error << agreed.Stopped << agreed.NeedsUpdate << agreed.Interacting;
  this->Controller->Broadcast(result, root);
  result >> outcome.Error >> outcome.Stopped >> outcome.NeedsUpdate >> outcome.Interacting;
}

int Exchange::GetRank() const
{
  return this->Controller ? this->Controller->GetLocalProcessId() : root;
}

std::vector<int> Exchange::ToAll(const std::vector<int>& mine) const
{
  if (!this->Controller)
  {
    return mine;
  }
  std::vector<int> all(mine.size() * static_cast<std::size_t>(this->GetSize()));
  this->Controller->AllGather(mine.data(), all.data(), static_cast<vtkIdType>(mine.size()));
  return all;
}

void Exchange::Request(int process, const Command& command) const
{
  this->Controller->Send(command.data(), static_cast<vtkIdType>(command.size()), process, REQUESTS);
}

Exchange::Command Exchange::ReceiveRequest() const
{
  Command command;
  this->Controller->Receive(command.data(), static_cast<vtkIdType>(command.size()), root, REQUESTS);
  return command;
}

void Exchange::EndRequests() const
{
  for (int p = 1; p < this->GetSize(); ++p)
  {
    this->Request(p, { { END } });
  }
}

int Exchange::GetSize() const
{
  return this->Controller ? this->Controller->GetNumberOfProcesses() : 1;
}

std::vector<int> Exchange::ToRoot(const std::vector<int>& mine) const
{
  return GatherOn(root, this->Controller, mine);
}

std::vector<vtkTypeInt64> Exchange::ToRoot(const std::vector<vtkTypeInt64>& mine) const
{
  return GatherOn(root, this->Controller, mine);
}

void Exchange::FromRoot(vtkMultiProcessStream& stream) const
{
  if (this->Controller)
  {
    this->Controller->Broadcast(stream, root);
  }
}

vtkTypeUInt64 Exchange::FromRoot(vtkTypeUInt64 number) const
{
  vtkMultiProcessStream stream;
  stream << number;
  this->FromRoot(stream);
  stream >> number;
  return number;
}

std::vector<vtkSmartPointer<vtkDataArray>> Exchange::FromRoot(std::vector<vtkSmartPointer<vtkDataArray>> arrays) const
{
  const auto count = static_cast<std::size_t>(this->FromRoot(static_cast<vtkTypeUInt64>(arrays.size())));
  arrays.resize(count);
  for (vtkSmartPointer<vtkDataArray>& array : arrays)
  {
    const auto type =
      static_cast<int>(this->FromRoot(static_cast<vtkTypeUInt64>(array ? array->GetDataType() : VTK_VOID)));
    if (type != VTK_VOID && this->Controller)
    {
      if (!this->IsRoot())
      {
        array.TakeReference(vtkDataArray::CreateDataArray(type));
      }
      this->Controller->Broadcast(array, root);
    }
  }
  return arrays;
}

void Exchange::FromRoot(vtkFieldData* fields) const
{
  for (int p = 1; this->IsRoot() && p < this->GetSize(); ++p)
  {
    vtkNew<vtkImageData> image;
    image->GetFieldData()->ShallowCopy(fields);
    this->Send(image, p);
  }
  if (!this->IsRoot())
  {
    fields->ShallowCopy(this->ReceiveImage(root)->GetFieldData());
  }
}

void Exchange::SendBlock(const char* memory, std::size_t bytes, int to) const
{
  for (std::size_t first = 0; first < bytes; first += portion)
  {
    this->Controller->Send(memory + first, static_cast<vtkIdType>(std::min(portion, bytes - first)), to, BYTES);
  }
}

void Exchange::ReceiveBlock(char* memory, std::size_t bytes, int from) const
{
  for (std::size_t first = 0; first < bytes; first += portion)
  {
    this->Controller->Receive(
      memory ? memory + first : buffer, static_cast<vtkIdType>(std::min(portion, bytes - first)), from, BYTES);
  }
}

void Exchange::Send(const std::vector<char>& bytes, int to) const
{
  const auto size = static_cast<vtkIdType>(bytes.size());
  this->Controller->Send(&size, 1, to, BYTES);
  this->SendBlock(bytes.data(), bytes.size(), to);
}

std::vector<char> Exchange::Receive(int from) const
{
  vtkIdType size = 0;
  this->Controller->Receive(&size, 1, from, BYTES);
  std::vector<char> bytes;
  try
  {
    bytes.resize(static_cast<std::size_t>(size));
  }
  catch (const std::bad_alloc&)
  {
    this->ReceiveBlock(nullptr, static_cast<std::size_t>(size), from);
    throw;
  }
  this->ReceiveBlock(bytes.data(), bytes.size(), from);
  return bytes;
}

void Exchange::Send(vtkPolyData* data, int to) const
{
  vtkNew<vtkCharArray> bytes;
  vtkCommunicator::MarshalDataObject(data, bytes);
  this->Send(std::vector<char>(bytes->GetPointer(0), bytes->GetPointer(0) + bytes->GetNumberOfTuples()), to);
}

vtkSmartPointer<vtkPolyData> Exchange::ReceiveSurface(int from) const
{
  std::vector<char> memory = this->Receive(from);
  vtkNew<vtkCharArray> bytes;
  bytes->SetArray(memory.data(), static_cast<vtkIdType>(memory.size()), 1);
  return vtkPolyData::SafeDownCast(vtkCommunicator::UnMarshalDataObject(bytes));
}

// Runs of pages that are not 0: each is the number of its first page and its bytes. The last one has no bytes.
void Exchange::SendSparse(const char* values, std::size_t bytes, int to) const
{
  const auto isZero = [&](std::size_t at)
  {
    const char* const end = values + std::min(at + page, bytes);
    return std::find_if(values + at, end, [](char value) { return value != 0; }) == end;
  };
  for (std::size_t first = 0, end = 0; first < bytes; first = end)
  {
    end = std::min(first + page, bytes);
    if (isZero(first))
    {
      continue;
    }
    while (end < bytes && end - first + page <= portion && !isZero(end))
    {
      end = std::min(end + page, bytes);
    }
    const vtkIdType run[2] = { static_cast<vtkIdType>(first), static_cast<vtkIdType>(end - first) };
    this->Controller->Send(run, 2, to, BYTES);
    this->SendBlock(values + first, end - first, to);
  }
  const vtkIdType last[2] = { 0, 0 };
  this->Controller->Send(last, 2, to, BYTES);
}

void Exchange::ReceiveSparse(char* zeros, int from) const
{
  for (;;)
  {
    vtkIdType run[2] = { 0, 0 };
    this->Controller->Receive(run, 2, from, BYTES);
    if (run[1] == 0)
    {
      return;
    }
    this->ReceiveBlock(zeros ? zeros + run[0] : nullptr, static_cast<std::size_t>(run[1]), from);
  }
}

vtkSmartPointer<vtkImageData> Exchange::Deliver(vtkImageData* whole, const Extent& extent) const
{
  if (!this->Controller)
  {
    return Cut(whole, extent);
  }
  const int processes = this->Controller->GetNumberOfProcesses();
  std::vector<int> extents(6 * static_cast<std::size_t>(processes));
  this->Controller->Gather(extent.data(), extents.data(), 6, root);
  if (!this->IsRoot())
  {
    return this->ReceiveImage(root);
  }
  vtkSmartPointer<vtkImageData> own;
  for (int p = 0; p < processes; ++p)
  {
    Extent extentThere;
    std::copy_n(extents.begin() + 6 * p, 6, extentThere.begin());
    auto part = vtkSmartPointer<vtkImageData>::New();
    std::string problem;
    Try(problem, [&] { part = Cut(whole, extentThere); });
    if (p == root)
    {
      own = part;
    }
    else
    {
      this->Send(part, p);
    }
  }
  return own;
}

vtkSmartPointer<vtkImageData> Exchange::Assemble(vtkImageData* part, const Extent& whole, std::string& problem) const
{
  if (!this->Controller)
  {
    return part;
  }
  const bool hasAll = part->GetNumberOfPoints() > 0 && Contains(ExtentOf(part), whole);
  if (this->All(hasAll))
  {
    return part;
  }
  vtkSmartPointer<vtkImageData> all = part;
  if (this->IsRoot())
  {
    Assembly image(whole);
    bool isAssembled = false;
    for (int p = 0; p < this->Controller->GetNumberOfProcesses(); ++p)
    {
      vtkSmartPointer<vtkImageData> one = part;
      if (p != root)
      {
        TryExchange(problem, [&] { one = this->ReceiveImage(p); });
      }
      if (!hasAll && one->GetNumberOfPoints() > 0)
      {
        isAssembled = true;
        Try(problem, [&] { image.Add(one); });
      }
    }
    if (isAssembled)
    {
      Try(problem, [&] { all = image.End(); });
    }
  }
  else
  {
    this->Send(part, root);
  }
  vtkMultiProcessStream stream;
  stream << problem;
  this->Controller->Broadcast(stream, root);
  stream >> problem;
  return problem.empty() ? this->Deliver(all, whole) : all;
}

void Exchange::Send(vtkImageData* image, int to) const
{
  vtkMultiProcessStream about;
  WriteGeometry(about, image);
  std::vector<vtkAbstractArray*> arrays;
  const std::array<vtkFieldData*, 3> groups = { { image->GetPointData(), image->GetCellData(),
    image->GetFieldData() } };
  for (vtkFieldData* group : groups)
  {
    about << group->GetNumberOfArrays();
    for (int a = 0; a < group->GetNumberOfArrays(); ++a)
    {
      vtkAbstractArray* array = group->GetAbstractArray(a);
      about << (IsRaw(array) ? array->GetDataType() : VTK_VOID);
      about << std::string(array->GetName() ? array->GetName() : "");
      about << static_cast<vtkTypeInt64>(array->GetNumberOfTuples()) << array->GetNumberOfComponents();
      for (int c = 0; c < array->GetNumberOfComponents(); ++c)
      {
        about << std::string(array->GetComponentName(c) ? array->GetComponentName(c) : "");
      }
      arrays.push_back(array);
    }
  }
  for (vtkDataSetAttributes* group : { static_cast<vtkDataSetAttributes*>(image->GetPointData()),
         static_cast<vtkDataSetAttributes*>(image->GetCellData()) })
  {
    int active[vtkDataSetAttributes::NUM_ATTRIBUTES];
    group->GetAttributeIndices(active);
    for (const int a : active)
    {
      about << a;
    }
  }
  this->Controller->Send(about, to, ARRAYS);
  for (vtkAbstractArray* array : arrays)
  {
    if (IsRaw(array))
    {
      const vtkSmartPointer<vtkDataArray> values = Interleaved(vtkDataArray::SafeDownCast(array));
      this->SendBlock(static_cast<const char*>(values->GetVoidPointer(0)),
        BytesOfVoxel(values) * static_cast<std::size_t>(values->GetNumberOfTuples()), to);
    }
    else
    {
      vtkNew<vtkTable> table;
      table->GetRowData()->AddArray(array);
      this->Controller->Send(table, to, ARRAYS);
    }
  }
}

vtkSmartPointer<vtkImageData> Exchange::ReceiveImage(int from) const
{
  vtkMultiProcessStream about;
  this->Controller->Receive(about, from, ARRAYS);
  auto image = vtkSmartPointer<vtkImageData>::New();
  Steps steps;
  ReadGeometry(about, image);
  const std::array<vtkFieldData*, 3> groups = { { image->GetPointData(), image->GetCellData(),
    image->GetFieldData() } };
  for (vtkFieldData* group : groups)
  {
    int count;
    about >> count;
    for (int a = 0; a < count; ++a)
    {
      int type;
      std::string nameOfArray;
      vtkTypeInt64 tuples;
      int components;
      about >> type >> nameOfArray >> tuples >> components;
      vtkSmartPointer<vtkAbstractArray> array;
      if (type == VTK_VOID)
      {
        vtkNew<vtkTable> table;
        this->Controller->Receive(table, from, ARRAYS);
        array = table->GetRowData()->GetAbstractArray(0);
      }
      else
      {
        const auto values = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
        values->SetNumberOfComponents(components);
        if (!nameOfArray.empty())
        {
          values->SetName(nameOfArray.c_str());
        }
        steps.Run([&] { Allocate(values, tuples); });
        const std::size_t bytes = BytesOfVoxel(values) * static_cast<std::size_t>(tuples);
        this->ReceiveBlock(steps.HaveFailed() ? nullptr : static_cast<char*>(values->GetVoidPointer(0)), bytes, from);
        array = values;
      }
      for (int c = 0; c < components; ++c)
      {
        std::string name;
        about >> name;
        if (!name.empty())
        {
          array->SetComponentName(c, name.c_str());
        }
      }
      group->AddArray(array);
    }
  }
  for (vtkDataSetAttributes* group : { static_cast<vtkDataSetAttributes*>(image->GetPointData()),
         static_cast<vtkDataSetAttributes*>(image->GetCellData()) })
  {
    for (int attribute = 0; attribute < vtkDataSetAttributes::NUM_ATTRIBUTES; ++attribute)
    {
      int a;
      about >> a;
      if (a >= 0)
      {
        group->SetActiveAttribute(a, attribute);
      }
    }
  }
  steps.End();
  return image;
}

}
