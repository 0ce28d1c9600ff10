// SPDX-License-Identifier: BSD-3-Clause
// Propagation on real scans, through the filter: the displacement of every voxel against formula (P*), with distances
// by Dijkstra's algorithm in double precision that shares no code with the engine; for one probe and for five, whatever
// the size of the blocks and the order of the probes. Scans are looked for in the folder CHAINMAIL_VOLUMES.

#include "FilterTest.h"

#include "vtkFloatArray.h"
#include "vtkMetaImageReader.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <queue>
#include <random>
#include <utility>

using namespace FilterTest;

namespace
{

/// The tissue of a scan as a graph: D of every voxel, negative for air.
struct Tissue
{
  int Size[3];
  double Spacing[3];
  double Origin[3];
  std::vector<float> D;

  vtkIdType Count() const { return static_cast<vtkIdType>(this->D.size()); }
  void IndexOf(vtkIdType voxel, int index[3]) const
  {
    index[0] = static_cast<int>(voxel % this->Size[0]);
    index[1] = static_cast<int>(voxel / this->Size[0] % this->Size[1]);
    index[2] = static_cast<int>(voxel / this->Size[0] / this->Size[1]);
  }
  bool OnFace(vtkIdType voxel) const
  {
    int index[3];
    this->IndexOf(voxel, index);
    return index[0] == 0 || index[1] == 0 || index[2] == 0 || index[0] == this->Size[0] - 1 ||
           index[1] == this->Size[1] - 1 || index[2] == this->Size[2] - 1;
  }

  /// All voxels nearer to `source` than `reach`, with their distances in fractions of the spacing: the same on all
  /// axes.
  std::vector<std::pair<vtkIdType, double>> Around(vtkIdType source, double reach) const
  {
    std::vector<std::pair<vtkIdType, double>> found;
    std::vector<bool> done(this->D.size(), false);
    std::priority_queue<std::pair<double, vtkIdType>, std::vector<std::pair<double, vtkIdType>>, std::greater<>> front;
    front.emplace(0.0, source);
    const vtkIdType steps[3] = { 1, this->Size[0], static_cast<vtkIdType>(this->Size[0]) * this->Size[1] };
    while (!front.empty())
    {
      const auto [distance, voxel] = front.top();
      front.pop();
      if (done[voxel])
      {
        continue;
      }
      done[voxel] = true;
      found.emplace_back(voxel, distance);
      int index[3];
      this->IndexOf(voxel, index);
      for (int d = 0; d < 6; ++d)
      {
        const int a = d / 2;
        if (index[a] == (d % 2 ? this->Size[a] - 1 : 0))
        {
          continue;
        }
        const vtkIdType next = voxel + (d % 2 ? steps[a] : -steps[a]);
        if (this->D[next] < 0.0f || done[next])
        {
          continue;
        }
        const double there = distance + 0.5 * (static_cast<double>(this->D[voxel]) + this->D[next]);
        if (there < reach)
        {
          front.emplace(there, next);
        }
      }
    }
    return found;
  }
};

struct Pull
{
  vtkIdType Voxel;
  double Displacement[3]; // fractions of the spacing, below `longest`
};

constexpr double longest = 2.0;

/// Soft places that neither held tissue nor one another can disturb.
std::vector<Pull> FindPulls(const Tissue& tissue, int number)
{
  std::mt19937 random(20);
  std::vector<Pull> pulls;
  for (int attempt = 0; attempt < 5000 && static_cast<int>(pulls.size()) < number; ++attempt)
  {
    const vtkIdType voxel = static_cast<vtkIdType>(random() % static_cast<unsigned long>(tissue.Count()));
    if (tissue.D[voxel] < 0.1f)
    {
      continue;
    }
    bool free = true;
    for (const auto& [near, distance] : tissue.Around(voxel, 2.0 * longest))
    {
      free = free && !(tissue.OnFace(near) && distance < longest);
      for (const Pull& other : pulls)
      {
        free = free && near != other.Voxel;
      }
    }
    if (free)
    {
      const double sign = pulls.size() % 2 ? -1.0 : 1.0;
      pulls.push_back({ voxel, { sign * (longest - 0.1), -0.6 * sign, 0.2 + 0.3 * pulls.size() } });
    }
  }
  return pulls;
}

vtkSmartPointer<vtkPolyData> Probes(const Tissue& tissue, const std::vector<Pull>& pulls)
{
  auto probes = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkDoubleArray> displacements;
  displacements->SetName("Displacement");
  displacements->SetNumberOfComponents(3);
  for (const Pull& pull : pulls)
  {
    int index[3];
    tissue.IndexOf(pull.Voxel, index);
    double place[3];
    double displacement[3];
    for (int a = 0; a < 3; ++a)
    {
      place[a] = tissue.Origin[a] + index[a] * tissue.Spacing[a];
      displacement[a] = pull.Displacement[a] * tissue.Spacing[a];
    }
    points->InsertNextPoint(place);
    displacements->InsertNextTuple(displacement);
  }
  probes->SetPoints(points);
  probes->GetPointData()->AddArray(displacements);
  return probes;
}

const float* Displacements(vtkChainMailDeformation* filter)
{
  return vtkFloatArray::SafeDownCast(filter->GetModelOutput()->GetPointData()->GetArray("Displacement"))->GetPointer(0);
}

void TestScan(Checks& check, const std::string& file, const std::string& name)
{
  vtkNew<vtkMetaImageReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkImageData* image = reader->GetOutput();
  vtkDataArray* scalars = image->GetPointData()->GetScalars();

  Tissue tissue;
  image->GetDimensions(tissue.Size);
  image->GetSpacing(tissue.Spacing);
  image->GetOrigin(tissue.Origin);
  tissue.D.resize(static_cast<std::size_t>(image->GetNumberOfPoints()));
  double threshold = 0.0;
  vtkNew<vtkPiecewiseFunction> function;
  vtkChainMailDeformation::FitMaterial(scalars->GetRange(), threshold, function);
  for (vtkIdType v = 0; v < tissue.Count(); ++v)
  {
    const double scalar = scalars->GetTuple1(v);
    tissue.D[v] = scalar < threshold ? -1.0f : static_cast<float>(function->GetValue(scalar));
  }
  const std::vector<Pull> pulls = FindPulls(tissue, 5);
  check.Equal(pulls.size(), std::size_t(5), name + ": places to pull at");
  if (pulls.size() < 5)
  {
    return;
  }

  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);
  filter->SetInputData(image);
  filter->SetRelaxationIterations(0);
  for (const std::size_t number : { std::size_t(1), std::size_t(5) })
  {
    const std::string what = name + ", " + std::to_string(number) + " probes";
    const std::vector<Pull> some(pulls.begin(), pulls.begin() + static_cast<long>(number));
    filter->SetInputDataObject(1, Probes(tissue, some));
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), what + ": errors");

    // (P*); elements further away than the displacement keep their places.
    constexpr double infinity = std::numeric_limits<double>::infinity();
    std::vector<std::array<double, 3>> lower(tissue.D.size(), { -infinity, -infinity, -infinity });
    std::vector<std::array<double, 3>> upper(tissue.D.size(), { infinity, infinity, infinity });
    for (const Pull& pull : some)
    {
      for (const auto& [voxel, distance] : tissue.Around(pull.Voxel, longest))
      {
        for (int a = 0; a < 3; ++a)
        {
          lower[voxel][a] = std::max(lower[voxel][a], pull.Displacement[a] - distance);
          upper[voxel][a] = std::min(upper[voxel][a], pull.Displacement[a] + distance);
        }
      }
    }
    const float* found = Displacements(filter);
    double error = 0.0;
    vtkIdType moved = 0;
    for (vtkIdType v = 0; v < tissue.Count(); ++v)
    {
      bool moves = false;
      for (int a = 0; a < 3; ++a)
      {
        const double expected = std::min(std::max(0.0, lower[v][a]), upper[v][a]);
        error = std::max(error, std::fabs(found[3 * v + a] / tissue.Spacing[a] - expected));
        moves = moves || expected != 0.0;
      }
      moved += moves;
    }
    std::cout << what << ": " << moved << " elements move, largest error " << error << " of the spacing\n";
    // float32 sums of some tens of links of up to 0.35 around displacements of 2.
    check.Near(error, 0.0, 1e-4, what + ": error");
    check.That(moved > 200 * static_cast<vtkIdType>(number), what + ": a wave worth the name");
    check.Near(
      filter->GetOutput()->GetFieldData()->GetArray("MaxLinkExcess")->GetTuple1(0), 0.0, 1e-5, what + ": links");

    const std::vector<float> first(found, found + 3 * tissue.Count());
    const auto sameBits = [&](const std::string& how)
    {
      filter->Update();
      check.That(std::memcmp(first.data(), Displacements(filter), sizeof(float) * first.size()) == 0, what + how);
    };
    const int blocks[3][3] = { { 4, 4, 4 }, { 16, 8, 4 }, { 64, 2, 16 } };
    for (const auto& block : blocks)
    {
      filter->SetBlockSize(block[0], block[1], block[2]);
      sameBits(": the same bits in other blocks");
    }
    filter->SetBlockSize(0, 0, 0);
    filter->SetInputDataObject(1, Probes(tissue, std::vector<Pull>(some.rbegin(), some.rend())));
    sameBits(": the same bits in the other order");
  }

  // What users wait for: two probes and the default relaxation. Reported, not asserted: machines differ.
  filter->SetRelaxationIterations(40);
  filter->SetInputDataObject(1, Probes(tissue, { pulls[0], pulls[1] }));
  filter->Update();
  vtkDataArray* milliseconds = filter->GetOutput()->GetFieldData()->GetArray("Milliseconds");
  std::cout << name << ", 2 probes, "
            << filter->GetOutput()->GetFieldData()->GetArray("RelaxationIterationsUsed")->GetTuple1(0) << " sweeps:";
  for (int c = 0; c < milliseconds->GetNumberOfComponents(); ++c)
  {
    std::cout << " " << milliseconds->GetComponentName(c) << " " << milliseconds->GetComponent(0, c) << " ms";
  }
  std::cout << std::endl;
  check.Near(
    filter->GetOutput()->GetFieldData()->GetArray("MaxLinkExcess")->GetTuple1(0), 0.0, 1e-5, name + ": relaxed");
}

}

int TestChainMailScans(int, char*[])
{
  const char* folder = std::getenv("CHAINMAIL_VOLUMES");
  Checks check;
  bool any = false;
  for (const char* name : { "heart_cta", "abdomen_ct", "head_mr" })
  {
    const std::string file = std::string(folder ? folder : ".") + "/" + name + ".mhd";
    if (std::ifstream(file).good())
    {
      any = true;
      TestScan(check, file, name);
    }
    else
    {
      std::cout << name << " is not there, so it is not tested\n";
    }
  }
  if (!any)
  {
    std::cout << "Skipped: no scan found; name their folder in CHAINMAIL_VOLUMES.\n";
    return 125; // VTK_SKIP_RETURN_CODE of vtkTesting.h
  }
  return check.Finish();
}
