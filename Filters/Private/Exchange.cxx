// SPDX-License-Identifier: BSD-3-Clause
#include "Exchange.h"

#include "Error.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkFieldData.h"
#include "vtkMatrix3x3.h"
#include "vtkMultiProcessController.h"
#include "vtkMultiProcessStream.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkTable.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <tuple>

namespace vtkChainMail
{

namespace
{

constexpr int root = 0;

// Messages from one process to another come in the order in which they were sent; the tags are for whoever looks at
// them.
enum Tags
{
  LEAVES = 7101,
  ARRAYS
};

using Extent = std::array<int, 6>;

bool IsEmpty(const Extent& e)
{
  return e[0] > e[1] || e[2] > e[3] || e[4] > e[5];
}

bool Contains(const Extent& outer, const Extent& inner)
{
  return inner[0] >= outer[0] && inner[1] <= outer[1] && inner[2] >= outer[2] && inner[3] <= outer[3] &&
         inner[4] >= outer[4] && inner[5] <= outer[5];
}

Extent ExtentOf(vtkImageData* image)
{
  Extent extent{ { 0, -1, 0, -1, 0, -1 } };
  if (image)
  {
    image->GetExtent(extent.data());
  }
  return extent;
}

/// Sent as memory; bits, strings and variants, which are not laid out so, as a table with one column.
bool IsRaw(vtkAbstractArray* array)
{
  return vtkDataArray::SafeDownCast(array) && array->GetDataType() != VTK_BIT;
}

/// The same places in the same world.
bool HasSameGrid(vtkImageData* a, vtkImageData* b)
{
  return std::equal(a->GetOrigin(), a->GetOrigin() + 3, b->GetOrigin()) &&
         std::equal(a->GetSpacing(), a->GetSpacing() + 3, b->GetSpacing()) &&
         std::equal(a->GetDirectionMatrix()->GetData(), a->GetDirectionMatrix()->GetData() + 9,
           b->GetDirectionMatrix()->GetData());
}

/// Puts parts of an image together. Where they overlap they hold the same, but for voxels that one marks as ghosts, of
/// which it may hold an old copy.
vtkSmartPointer<vtkImageData> PutTogether(const std::vector<vtkSmartPointer<vtkImageData>>& parts, const Extent& whole)
{
  vtkImageData* first = parts.front();
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetOrigin(first->GetOrigin());
  image->SetSpacing(first->GetSpacing());
  image->SetDirectionMatrix(first->GetDirectionMatrix());
  image->SetExtent(whole[0], whole[1], whole[2], whole[3], whole[4], whole[5]);
  image->GetFieldData()->ShallowCopy(first->GetFieldData());
  const vtkIdType voxels = image->GetNumberOfPoints();
  vtkPointData* arrays = image->GetPointData();
  arrays->CopyAllOn();
  arrays->CopyAllocate(first->GetPointData(), voxels);
  arrays->SetNumberOfTuples(voxels);

  enum : unsigned char
  {
    Missing,
    Ghost,
    Own
  };
  std::vector<unsigned char> known(voxels, Missing);
  for (vtkImageData* part : parts)
  {
    if (!HasSameGrid(part, first))
    {
      throw chainmail::InputError("The parts of the image that the processes have differ in origin, spacing or "
                                  "direction, so they are no parts of one image. Give one image.");
    }
    for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
    {
      const char* name = arrays->GetArrayName(a);
      vtkAbstractArray* from = part->GetPointData()->GetAbstractArray(name);
      if (!from || from->GetDataType() != arrays->GetAbstractArray(a)->GetDataType() ||
          from->GetNumberOfComponents() != arrays->GetAbstractArray(a)->GetNumberOfComponents())
      {
        throw chainmail::InputError("The point array \"" + std::string(name ? name : "") +
                                    "\" is not the same in all parts of the image that the processes have. Give all "
                                    "parts the same arrays.");
      }
    }
    vtkUnsignedCharArray* ghosts = part->GetPointGhostArray();
    const Extent e = ExtentOf(part);
    vtkIdType from = 0;
    for (int k = e[4]; k <= e[5]; ++k)
    {
      for (int j = e[2]; j <= e[3]; ++j)
      {
        for (int i = e[0]; i <= e[1]; ++i, ++from)
        {
          if (i < whole[0] || i > whole[1] || j < whole[2] || j > whole[3] || k < whole[4] || k > whole[5])
          {
            continue;
          }
          int at[3] = { i, j, k };
          const vtkIdType to = image->ComputePointId(at);
          const bool ghost = ghosts && (ghosts->GetValue(from) & vtkDataSetAttributes::DUPLICATEPOINT);
          if (known[to] < (ghost ? Ghost : Own))
          {
            known[to] = ghost ? Ghost : Own;
            for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
            {
              arrays->GetAbstractArray(a)->SetTuple(
                to, from, part->GetPointData()->GetAbstractArray(arrays->GetArrayName(a)));
            }
          }
        }
      }
    }
  }
  if (const auto missing = std::count(known.begin(), known.end(), Missing))
  {
    throw chainmail::InputError("The parts of the image that the processes have leave out " + std::to_string(missing) +
                                " of its " + std::to_string(voxels) + " voxels. Give the whole image.");
  }
  // In the whole image no voxel is the copy of another process's.
  if (vtkUnsignedCharArray* ghosts = image->GetPointGhostArray())
  {
    for (vtkIdType v = 0; v < voxels; ++v)
    {
      ghosts->SetValue(v, ghosts->GetValue(v) & ~vtkDataSetAttributes::DUPLICATEPOINT);
    }
  }
  return image;
}

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

Inputs Exchange::Gather(const Inputs& mine) const
{
  if (!this->Controller)
  {
    return mine;
  }
  const int processes = this->Controller->GetNumberOfProcesses();

  // First what there is, so that nothing travels that the root has already.
  vtkMultiProcessStream about;
  about << mine.Problem << static_cast<int>(mine.Leaves.size());
  for (const Leaf& leaf : mine.Leaves)
  {
    about << leaf.Port << leaf.Input << leaf.Block << leaf.GetFingerprint();
  }
  const bool hasImage = mine.Image && mine.Image->GetNumberOfPoints() > 0;
  about << hasImage;
  std::vector<vtkMultiProcessStream> abouts;
  this->Controller->Gather(about, abouts, root);

  Inputs all;
  vtkMultiProcessStream wanted; // of each process: the numbers of leaves, and whether its part of the image
  std::vector<std::vector<Leaf>> leavesFrom(processes);
  std::vector<bool> imageFrom(processes, false);
  if (this->IsRoot())
  {
    all.WholeExtent = mine.WholeExtent;
    const bool needsParts = !hasImage || !Contains(ExtentOf(mine.Image), mine.WholeExtent);
    std::vector<std::tuple<int, int, int, Fingerprint>> known;
    for (int p = 0; p < processes; ++p)
    {
      std::string problem;
      int count;
      abouts[p] >> problem >> count;
      all.Problem = all.Problem.empty() ? problem : all.Problem;
      std::vector<int> numbers;
      for (int n = 0; n < count; ++n)
      {
        Leaf leaf;
        Fingerprint fingerprint;
        abouts[p] >> leaf.Port >> leaf.Input >> leaf.Block >> fingerprint;
        leaf.Process = p;
        // Alike on the same process are two datasets; alike on two processes they are one that both have.
        const auto key = std::make_tuple(leaf.Port, leaf.Input, leaf.Block, fingerprint);
        if (p == root || std::find(known.begin(), known.end(), key) == known.end())
        {
          known.push_back(key);
          numbers.push_back(n);
          leavesFrom[p].push_back(leaf);
        }
      }
      bool has;
      abouts[p] >> has;
      imageFrom[p] = has && needsParts;
      wanted << static_cast<int>(numbers.size());
      for (const int n : numbers)
      {
        wanted << n;
      }
      wanted << static_cast<bool>(imageFrom[p]);
    }
  }
  this->Controller->Broadcast(wanted, root);

  for (int p = 0; p < processes; ++p)
  {
    int count;
    wanted >> count;
    std::vector<int> numbers(count);
    for (int& n : numbers)
    {
      wanted >> n;
    }
    bool image;
    wanted >> image;
    if (p != root && p == this->Controller->GetLocalProcessId())
    {
      for (const int n : numbers)
      {
        this->Controller->Send(mine.Leaves[n].Data, root, LEAVES);
      }
      if (image)
      {
        this->Send(mine.Image, root);
      }
    }
    else if (p == root && this->IsRoot())
    {
      for (std::size_t n = 0; n < numbers.size(); ++n)
      {
        leavesFrom[p][n].Data = mine.Leaves[numbers[n]].Data;
      }
    }
  }
  if (!this->IsRoot())
  {
    return all;
  }

  std::vector<vtkSmartPointer<vtkImageData>> parts;
  for (int p = 0; p < processes; ++p)
  {
    for (Leaf& leaf : leavesFrom[p])
    {
      if (p != root)
      {
        leaf.Data = vtkSmartPointer<vtkPolyData>::New();
        this->Controller->Receive(leaf.Data, p, LEAVES);
      }
      all.Leaves.push_back(leaf);
    }
    if (imageFrom[p])
    {
      parts.push_back(p == root ? mine.Image : this->Receive(p));
    }
  }
  std::stable_sort(all.Leaves.begin(), all.Leaves.end(),
    [](const Leaf& a, const Leaf& b)
    { return std::tie(a.Port, a.Input, a.Block) < std::tie(b.Port, b.Input, b.Block); });

  all.Image = mine.Image;
  if (!parts.empty() && all.Problem.empty())
  {
    try
    {
      all.Image = PutTogether(parts, mine.WholeExtent);
    }
    catch (const chainmail::InputError& error)
    {
      all.Problem = error.what();
    }
  }
  return all;
}

void Exchange::Share(Outcome& outcome) const
{
  if (!this->Controller)
  {
    return;
  }
  vtkMultiProcessStream stream;
  stream << outcome.Error << outcome.Stopped << outcome.NeedsUpdate << outcome.Interacting;
  this->Controller->Broadcast(stream, root);
  stream >> outcome.Error >> outcome.Stopped >> outcome.NeedsUpdate >> outcome.Interacting;
}

vtkSmartPointer<vtkImageData> Exchange::Deliver(vtkImageData* whole, const Extent& extent) const
{
  const auto cut = [whole](const Extent& part)
  {
    auto image = vtkSmartPointer<vtkImageData>::New();
    image->ShallowCopy(whole);
    if (IsEmpty(part))
    {
      image->Initialize();
      image->SetExtent(const_cast<int*>(part.data()));
      image->GetFieldData()->ShallowCopy(whole->GetFieldData());
    }
    else if (!Contains(part, ExtentOf(whole)))
    {
      image->GetPointData()->CopyAllOn();
      image->GetCellData()->CopyAllOn();
      image->Crop(part.data());
    }
    return image;
  };
  if (!this->Controller)
  {
    return cut(extent);
  }
  const int processes = this->Controller->GetNumberOfProcesses();
  std::vector<int> extents(6 * static_cast<std::size_t>(processes));
  this->Controller->Gather(extent.data(), extents.data(), 6, root);
  if (!this->IsRoot())
  {
    return this->Receive(root);
  }
  vtkSmartPointer<vtkImageData> own;
  for (int p = 0; p < processes; ++p)
  {
    Extent part;
    std::copy_n(extents.begin() + 6 * p, 6, part.begin());
    if (p == root)
    {
      own = cut(part);
    }
    else
    {
      this->Send(cut(part), p);
    }
  }
  return own;
}

void Exchange::Send(vtkImageData* image, int to) const
{
  // The name and components of an array travel with its memory, its type and place do not.
  vtkMultiProcessStream about;
  for (const int e : ExtentOf(image))
  {
    about << e;
  }
  for (int a = 0; a < 3; ++a)
  {
    about << image->GetOrigin()[a] << image->GetSpacing()[a];
  }
  for (int n = 0; n < 9; ++n)
  {
    about << image->GetDirectionMatrix()->GetData()[n];
  }
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
      about << array->GetNumberOfComponents();
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
      this->Controller->Send(vtkDataArray::SafeDownCast(array), to, ARRAYS);
    }
    else
    {
      vtkNew<vtkTable> table;
      table->GetRowData()->AddArray(array);
      this->Controller->Send(table, to, ARRAYS);
    }
  }
}

vtkSmartPointer<vtkImageData> Exchange::Receive(int from) const
{
  vtkMultiProcessStream about;
  this->Controller->Receive(about, from, ARRAYS);
  auto image = vtkSmartPointer<vtkImageData>::New();
  Extent extent;
  double origin[3];
  double spacing[3];
  double direction[9];
  for (int& e : extent)
  {
    about >> e;
  }
  for (int a = 0; a < 3; ++a)
  {
    about >> origin[a] >> spacing[a];
  }
  for (double& d : direction)
  {
    about >> d;
  }
  image->SetExtent(extent.data());
  image->SetOrigin(origin);
  image->SetSpacing(spacing);
  image->SetDirectionMatrix(direction);

  const std::array<vtkFieldData*, 3> groups = { { image->GetPointData(), image->GetCellData(),
    image->GetFieldData() } };
  for (vtkFieldData* group : groups)
  {
    int count;
    about >> count;
    for (int a = 0; a < count; ++a)
    {
      int type;
      int components;
      about >> type >> components;
      vtkSmartPointer<vtkAbstractArray> array;
      if (type == VTK_VOID)
      {
        vtkNew<vtkTable> table;
        this->Controller->Receive(table, from, ARRAYS);
        array = table->GetRowData()->GetAbstractArray(0);
      }
      else
      {
        array.TakeReference(vtkDataArray::CreateDataArray(type));
        this->Controller->Receive(vtkDataArray::SafeDownCast(array), from, ARRAYS);
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
  return image;
}

}
