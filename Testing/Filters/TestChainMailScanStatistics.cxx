// SPDX-License-Identifier: BSD-3-Clause
// What scans are taken for: a head as MR and as CT, with all that spoils guesses from a range, of several types, in
// parts, and deformed.

#include "FilterTest.h"
#include "vtkChainMailScanStatistics.h"

#include "vtkImageData.h"

#include <limits>
#include <map>
#include <set>

using namespace FilterTest;

namespace
{

constexpr int side = 44;

enum Tissues
{
  AIR,
  FAT,
  BRAIN,
  BONE
};

/// A ball of brain in a skull in fat, with a neck that a face of the image cuts.
Tissues TissueAt(int i, int j, int k)
{
  const double x = i - 21.5;
  const double y = j - 21.5;
  const double z = k - 21.5;
  const double r = std::sqrt(x * x + y * y + z * z);
  const bool neck = k < 20 && x * x + y * y < 49.0;
  return r < 12.0 ? BRAIN : r < 14.0 ? BONE : r < 17.0 || neck ? FAT : AIR;
}

double NoiseAt(int i, int j, int k, unsigned seed)
{
  Noise noise(static_cast<unsigned>(i + side * (j + side * k)) * 3u + seed);
  noise.Next();
  return noise.Uniform() + noise.Uniform() + noise.Uniform() - 1.5;
}

/// T1-weighted: bone is as dark as air.
double MR(int i, int j, int k)
{
  const Tissues tissue = TissueAt(i, j, k);
  const double noise = NoiseAt(i, j, k, 1);
  return tissue == FAT     ? std::round(210.0 + 20.0 * noise)
         : tissue == BRAIN ? std::round(110.0 + 20.0 * noise)
                           : std::round(4.0 + 2.0 * noise);
}

double CT(int i, int j, int k)
{
  const double means[] = { -1000.0, -100.0, 35.0, 900.0 };
  return std::round(means[TissueAt(i, j, k)] + 15.0 * NoiseAt(i, j, k, 2));
}

using Value = std::function<double(int, int, int)>;

vtkSmartPointer<vtkImageData> Make(const Value& value, int type = VTK_SHORT)
{
  auto image = MakeImage({ { 0, side - 1, 0, side - 1, 0, side - 1 } }, type);
  Fill(image->GetPointData()->GetScalars(), image, value);
  return image;
}

/// The same with one voxel changed.
Value WithOne(const Value& value, double other)
{
  return [=](int i, int j, int k) { return i == 2 && j == 3 && k == 5 ? other : value(i, j, k); };
}

/// The same in a cylinder, and padding around that.
Value Padded(const Value& value, double padding)
{
  return [=](int i, int j, int k)
  { return (i - 21.5) * (i - 21.5) + (j - 21.5) * (j - 21.5) > 21.0 * 21.0 ? padding : value(i, j, k); };
}

bool IsTissueInMR(int i, int j, int k)
{
  const Tissues tissue = TissueAt(i, j, k);
  return tissue == FAT || tissue == BRAIN;
}

bool IsTissueInCT(int i, int j, int k)
{
  return TissueAt(i, j, k) != AIR;
}

struct Case
{
  std::string What;
  Value Scalars;
  int Type;
  int Kind;
  bool (*IsTissue)(int, int, int);
  bool IsDoubtful = false;
};

void TestKinds(Checks& check)
{
  const int unknown = vtkChainMailScanStatistics::KIND_UNKNOWN;
  const int isCT = vtkChainMailScanStatistics::KIND_CT;
  const auto scaled = [](const Value& value, double slope, double intercept)
  { return [=](int i, int j, int k) { return std::round(slope * value(i, j, k) + intercept); }; };
  // As beside edges that were resampled: a voxel in forty, in air, and less often the further below.
  const Value rings = [](int i, int j, int k)
  {
    const double chance = NoiseAt(i, j, k, 7) + 1.5;
    return 4.0 * MR(i, j, k) -
           (chance < 0.55 && TissueAt(i, j, k) == AIR ? 1000.0 * std::pow(NoiseAt(i, j, k, 8) / 1.5, 4) : 0.0);
  };
  const std::vector<Case> cases = {
    { "MR", MR, VTK_SHORT, unknown, IsTissueInMR },
    { "MR, 8 bits", MR, VTK_UNSIGNED_CHAR, unknown, IsTissueInMR },
    { "MR, double", MR, VTK_DOUBLE, unknown, IsTissueInMR },
    { "MR with a dead voxel at -1000", WithOne(MR, -1000.0), VTK_SHORT, unknown, IsTissueInMR },
    { "MR with a voxel at -32768", WithOne(MR, -32768.0), VTK_SHORT, unknown, IsTissueInMR },
    { "MR with a voxel five times the largest", WithOne(MR, 1250.0), VTK_SHORT, unknown, IsTissueInMR },
    { "MR with a voxel at 1e30", WithOne(MR, 1e30), VTK_FLOAT, unknown, IsTissueInMR },
    { "MR with a voxel that is no number", WithOne(MR, std::nan("")), VTK_FLOAT, unknown, IsTissueInMR },
    { "MR with rings", rings, VTK_SHORT, unknown, IsTissueInMR },
    { "MR stretched over 16 bits", scaled(MR, 230.0, -32000.0), VTK_SHORT, unknown, IsTissueInMR, true },
    { "MR with -3024 around", Padded(MR, -3024.0), VTK_SHORT, unknown, IsTissueInMR },
    { "MR with -32768 around", Padded(MR, -32768.0), VTK_SHORT, unknown, IsTissueInMR },
    { "MR with 65535 around", Padded(MR, 65535.0), VTK_UNSIGNED_SHORT, unknown, IsTissueInMR },
    { "MR with 63536 around", Padded(MR, 63536.0), VTK_INT, unknown, IsTissueInMR },
    { "CT", CT, VTK_SHORT, isCT, IsTissueInCT },
    { "CT, float", CT, VTK_FLOAT, isCT, IsTissueInCT },
    { "CT, 64 bits", CT, VTK_LONG_LONG, isCT, IsTissueInCT },
    { "CT with a voxel at 30000", WithOne(CT, 30000.0), VTK_SHORT, isCT, IsTissueInCT },
    { "CT with a voxel at -32768", WithOne(CT, -32768.0), VTK_SHORT, isCT, IsTissueInCT },
    { "CT with -3024 around", Padded(CT, -3024.0), VTK_SHORT, isCT, IsTissueInCT },
    { "CT with -2000 around", Padded(CT, -2000.0), VTK_SHORT, isCT, IsTissueInCT },
    { "CT with -1500 around", Padded(CT, -1500.0), VTK_SHORT, isCT, IsTissueInCT },
    { "CT with -32768 around", Padded(CT, -32768.0), VTK_INT, isCT, IsTissueInCT },
    { "CT with 32767 around", Padded(CT, 32767.0), VTK_SHORT, isCT, IsTissueInCT },
    { "CT from 0 on with 65535 around", Padded(scaled(CT, 1.0, 1024.0), 65535.0), VTK_UNSIGNED_SHORT, unknown,
      IsTissueInCT },
    { "CT stretched", scaled(CT, 10.0, 0.0), VTK_SHORT, unknown, IsTissueInCT, true },
    { "CT in 8 bits", [](int i, int j, int k) { return std::round(std::clamp(CT(i, j, k) / 16.0 + 64.0, 0.0, 255.0)); },
      VTK_UNSIGNED_CHAR, unknown, IsTissueInCT },
    { "CT in a window of 8 bits",
      [](int i, int j, int k) { return std::round(std::clamp((CT(i, j, k) + 200.0) * 0.6375, 0.0, 255.0)); },
      VTK_UNSIGNED_CHAR, unknown, IsTissueInCT },
    { "a mask", [](int i, int j, int k) { return TissueAt(i, j, k) == AIR ? 0.0 : 1.0; }, VTK_UNSIGNED_CHAR, unknown,
      IsTissueInCT },
    { "labels", [](int i, int j, int k) { return static_cast<double>(TissueAt(i, j, k)); }, VTK_UNSIGNED_CHAR,
      vtkChainMailScanStatistics::KIND_LABELS, IsTissueInCT },
    { "labels far apart",
      [](int i, int j, int k) {
        return std::array<double, 4>{ { 0.0, 1.0, 52.0, 117.0 } }[TissueAt(i, j, k)];
      },
      VTK_INT, vtkChainMailScanStatistics::KIND_LABELS, IsTissueInCT },
  };
  for (const Case& one : cases)
  {
    const auto image = Make(one.Scalars, one.Type);
    vtkNew<vtkChainMailScanStatistics> statistics;
    statistics->Read(image, image->GetPointData()->GetScalars());
    check.Equal(statistics->GetKind(), one.Kind, one.What + ": kind");
    check.Equal(!statistics->GetDoubt(0).empty(), one.IsDoubtful, one.What + ": doubtful");
    double threshold = 0.0;
    statistics->GetMaterial(0, threshold, nullptr);
    // Noise has an end, and the kinds of tissue are far apart: no voxel may be on the wrong side, except the one.
    int wrong = 0;
    for (int k = 0; k < side; ++k)
    {
      for (int j = 0; j < side; ++j)
      {
        for (int i = 0; i < side; ++i)
        {
          const double scalar = image->GetScalarComponentAsDouble(i, j, k, 0);
          const bool isTissue = std::isfinite(scalar) && scalar >= threshold && !statistics->IsPadding(scalar);
          const bool isPadded = one.What.find("around") != std::string::npos &&
                                Padded([](int, int, int) { return 0.0; }, 1.0)(i, j, k) != 0.0;
          wrong += isTissue != (one.IsTissue(i, j, k) && !isPadded);
        }
      }
    }
    check.That(wrong <= (one.What.find(" a voxel ") != std::string::npos ? 1 : 0),
      one.What + ": " + std::to_string(wrong) + " voxels on the wrong side of " + std::to_string(threshold));
    const double air = statistics->GetBackgroundValue();
    check.That(air < threshold && !statistics->IsPadding(air), one.What + ": air is " + std::to_string(air));
    check.Equal(statistics->IsPadding(image->GetScalarComponentAsDouble(0, 0, 0, 0)),
      one.What.find("around") != std::string::npos, one.What + ": padding");

    // In parts, each with a plane of the next, as readers give them to the processes of a server.
    for (const int parts : { 2, 3 })
    {
      vtkNew<vtkChainMailScanStatistics> merged;
      for (int n = 0; n < parts * parts; ++n)
      {
        int extent[6] = { 0, side - 1, 0, side - 1, 0, side - 1 };
        const int place[] = { n % parts, n / parts };
        for (const int a : { 0, 2 })
        {
          extent[2 * a] = place[a / 2] * (side - 1) / parts;
          extent[2 * a + 1] = (place[a / 2] + 1) * (side - 1) / parts;
        }
        const auto part = vtkSmartPointer<vtkImageData>::New();
        part->DeepCopy(image);
        part->Crop(extent);
        vtkNew<vtkChainMailScanStatistics> read;
        read->ReadPart(part, part->GetPointData()->GetScalars(), image->GetExtent());
        vtkNew<vtkChainMailScanStatistics> received;
        received->Unpack(read->Pack());
        merged->Merge(received);
      }
      const std::vector<double> whole = statistics->Pack();
      const std::vector<double> sum = merged->Pack();
      // The last of these numbers says whether all was read in one.
      check.That(
        sum.size() >= whole.size() && std::memcmp(whole.data(), sum.data(), (whole.size() - 2) * sizeof(double)) == 0,
        one.What + ": the same in " + std::to_string(parts * parts) + " parts");
    }
  }
}

/// The distinct scalars that an image has.
std::set<double> ValuesOf(vtkImageData* image)
{
  std::set<double> values;
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  for (vtkIdType n = 0; n < scalars->GetNumberOfTuples(); ++n)
  {
    values.insert(scalars->GetComponent(n, 0));
  }
  return values;
}

void TestDeformed(Checks& check)
{
  struct Scene
  {
    std::string What;
    Value Scalars;
    int Type;
  };
  // One voxel is wrong, and the pull reached 0.18 of 6 mm.
  for (const Scene& one :
    std::vector<Scene>{ { "MR", MR, VTK_SHORT }, { "MR with a dead voxel", WithOne(MR, -1000.0), VTK_SHORT },
      { "MR with a bright voxel", WithOne(MR, 1250.0), VTK_SHORT } })
  {
    vtkNew<vtkChainMailDeformation> filter;
    EventLog log(filter);
    filter->SetInputData(Make(one.Scalars, one.Type));
    filter->SetInputDataObject(1, MakeProbes({ { { { 21.0, 21.0, 38.0 } }, { { 0.0, 0.0, 1.5 } }, 1.0 } }));
    filter->Update();
    check.Equal(log.TakeErrors() + log.TakeWarnings(), std::string(), one.What + ": no message");
    check.Near(Field(filter->GetOutput(), "ProbeReached", 2), 1.5, 1e-5, one.What + ": how far the pull came");
    check.Contains(filter->GetReport(), "Taken for MR or another scan without a unit: air below ", one.What);
  }

  // Tissue that leaves shows air; padding is in no blend, and stays where nothing moved.
  for (const double padding : { -3024.0, -2000.0, -32768.0, 32767.0 })
  {
    const std::string what = "padding of " + std::to_string(padding);
    // So that tissue touches it.
    const Value scalars = [=](int i, int j, int k) { return i < 12 ? padding : CT(i, j, k); };
    const auto image = Make(scalars);
    vtkNew<vtkChainMailDeformation> filter;
    EventLog log(filter);
    filter->SetInputData(image);
    filter->Update();
    check.That(SameBits(filter->GetOutput()->GetPointData()->GetScalars(), image->GetPointData()->GetScalars()),
      what + ": nothing changes at rest");
    filter->SetInputDataObject(1, MakeProbes({ { { { 12.0, 21.0, 21.0 } }, { { 2.3, 0.4, 0.7 } }, 3.0 } }));
    filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), what + ": no error");
    const std::set<double> before = ValuesOf(image);
    std::set<double> measured = before;
    measured.erase(padding);
    int strange = 0;
    int left = 0;
    vtkDataArray* shown = filter->GetOutput()->GetPointData()->GetScalars();
    for (vtkIdType n = 0; n < shown->GetNumberOfTuples(); ++n)
    {
      const double value = shown->GetComponent(n, 0);
      const bool isIn = value >= *measured.begin() && value <= *measured.rbegin();
      strange += !isIn && value != padding;
      left += isIn && image->GetPointData()->GetScalars()->GetComponent(n, 0) > -300.0 && value < -900.0;
      // Padding that nothing came to is as it was; there is none where there was none.
      strange += value == padding && image->GetPointData()->GetScalars()->GetComponent(n, 0) != padding;
    }
    check.Equal(strange, 0, what + ": no value that no scan has");
    check.That(left > 20, what + ": where tissue left there is air");
    check.Contains(filter->GetReport(), " of the voxels are padding (", what);
  }
}

void TestLabels(Checks& check)
{
  const auto image =
    Make([](int i, int j, int k) { return TissueAt(i, j, k) == AIR ? 0.0 : 1.0 + 5 * TissueAt(i, j, k) + (i / 8) % 5; },
      VTK_UNSIGNED_CHAR);
  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);
  filter->SetInputData(image);
  filter->SetInputDataObject(1, MakeProbes({ { { { 21.0, 21.0, 37.0 } }, { { 0.3, 1.4, 2.3 } }, 2.0 } }));
  filter->Update();
  check.Equal(log.TakeErrors() + log.TakeWarnings(), std::string(), "labels: no message");
  check.Contains(filter->GetReport(), "Taken for labels: 0 is air", "labels: the report");
  check.That(SameBits(image->GetPointData()->GetScalars(), image->GetPointData()->GetScalars()), "labels: the input");
  vtkDataArray* in = image->GetPointData()->GetScalars();
  vtkDataArray* out = filter->GetOutput()->GetPointData()->GetScalars();
  vtkDataArray* element = filter->GetModelOutput()->GetPointData()->GetArray("Element");
  int changed = 0;
  int nowhere = 0;
  for (int k = 0; k < side; ++k)
  {
    for (int j = 0; j < side; ++j)
    {
      for (int i = 0; i < side; ++i)
      {
        const vtkIdType id = i + side * (j + static_cast<vtkIdType>(side) * k);
        check.That((element->GetComponent(id, 0) != 0.0) == (in->GetComponent(id, 0) != 0.0), "labels: 0 alone is air");
        if (out->GetComponent(id, 0) == in->GetComponent(id, 0))
        {
          continue;
        }
        // Nothing is more than 3 voxels away from where it was, and the nearest voxel at most one more.
        bool found = false;
        for (int n = 0; n < 9 * 9 * 9 && !found; ++n)
        {
          const int x = i + n % 9 - 4;
          const int y = j + n / 9 % 9 - 4;
          const int z = k + n / 81 - 4;
          found = std::min({ x, y, z }) >= 0 && std::max({ x, y, z }) < side &&
                  in->GetComponent(x + side * (y + static_cast<vtkIdType>(side) * z), 0) == out->GetComponent(id, 0);
        }
        ++changed;
        nowhere += !found;
      }
    }
  }
  check.That(changed > 100, "labels: some changed, " + std::to_string(changed));
  check.Equal(nowhere, 0, "labels that are nowhere near");
}

/// A preset on data that do not look so is warned about once.
void TestPresets(Checks& check)
{
  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);
  double pull = 0.0;
  const auto warnings = [&]
  {
    filter->SetInputDataObject(1, MakeProbes({ { { { 21.0, 21.0, 38.0 } }, { { 0.0, 0.0, pull += 0.1 } }, 1.0 } }));
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), "presets: no error");
    return log.TakeWarnings();
  };
  filter->SetInputData(Make(CT));
  filter->SetMaterialPresetToCT();
  check.Equal(warnings(), std::string(), "CT as CT");
  filter->SetMaterialPresetToMR();
  check.Contains(warnings(), "look like Hounsfield units", "CT as MR");
  check.Equal(warnings(), std::string(), "once");
  filter->SetRotations(true); // the model is built anew
  check.Equal(warnings(), std::string(), "once");
  filter->SetInputData(Make(MR));
  check.Equal(warnings(), std::string(), "MR as MR");
  filter->SetMaterialPresetToCT();
  check.Contains(warnings(), "do not look like Hounsfield units", "MR as CT");
  filter->SetMaterialPresetToFunction();
  check.Equal(warnings(), std::string(), "MR as what fits");
  filter->SetInputData(Make([](int i, int j, int k) { return 255.0 - MR(i, j, k); }));
  check.Contains(warnings(), "inverted", "bright air");
  filter->SetTissueThreshold(20.0);
  check.That(warnings().find("inverted") == std::string::npos, "a threshold that was given is no guess");
  check.Contains(filter->GetReport(), "Air below 20, as set. ", "the report");
}

void TestOdd(Checks& check)
{
  const auto statistics = [](vtkImageData* image)
  {
    auto read = vtkSmartPointer<vtkChainMailScanStatistics>::New();
    read->Read(image, image->GetPointData()->GetScalars());
    return read;
  };
  const double numbers[] = { 7.0, -0.3, 0.0, 1e-30, -5e9 };
  for (const double number : numbers)
  {
    const auto image = Make([&](int, int, int) { return number; }, VTK_FLOAT);
    double threshold = 0.0;
    statistics(image)->GetMaterial(0, threshold, nullptr);
    check.That(image->GetScalarComponentAsDouble(0, 0, 0, 0) >= threshold, "one number alone is tissue");
    check.Equal(statistics(image)->GetDoubt(0), std::string(), "one number alone");
  }
  const auto none = Make([](int, int, int) { return std::nan(""); }, VTK_DOUBLE);
  check.Equal(statistics(none)->GetDescription(), std::string("No voxel has a finite scalar."), "nothing but NaN");

  // A crop without air, of CT, where fat is tissue.
  const auto crop = MakeImage({ { 0, 19, 0, 19, 0, 19 } });
  Fill(crop->GetPointData()->GetScalars(), crop,
    [](int i, int j, int k)
    { return i == 3 && j == 3 ? 400.0 : (i < 8 ? -100.0 : 40.0) + std::round(10.0 * NoiseAt(i, j, k, 5)); });
  check.Equal(statistics(crop)->GetKind(), static_cast<int>(vtkChainMailScanStatistics::KIND_CT), "a crop without air");
  check.That(!statistics(crop)->GetDoubt(0).empty(), "a crop without air is doubtful");

  // A slice along each axis, and a picture of few grey values, which are no labels.
  for (int axis = 0; axis < 3; ++axis)
  {
    std::array<int, 6> extent{ { 0, 43, 0, 43, 0, 43 } };
    extent[2 * axis + 1] = 0;
    const auto slice = MakeImage(extent, VTK_UNSIGNED_CHAR);
    Fill(slice->GetPointData()->GetScalars(), slice,
      [&](int i, int j, int k)
      { return static_cast<double>(TissueAt(axis == 0 ? 21 : i, axis == 1 ? 21 : j, axis == 2 ? 21 : k)); });
    check.Equal(
      statistics(slice)->GetKind(), static_cast<int>(vtkChainMailScanStatistics::KIND_LABELS), "labels in a slice");
    Fill(slice->GetPointData()->GetScalars(), slice,
      [&](int i, int j, int k) { return std::floor(6.0 + 6.0 * std::sin((i + j + k) / 12.0)); });
    check.Equal(
      statistics(slice)->GetKind(), static_cast<int>(vtkChainMailScanStatistics::KIND_UNKNOWN), "few grey values");
    Fill(slice->GetPointData()->GetScalars(), slice,
      [&](int i, int j, int k) { return 50.0 * TissueAt(axis == 0 ? 21 : i, axis == 1 ? 21 : j, axis == 2 ? 21 : k); });
    check.Equal(statistics(slice)->GetKind(), static_cast<int>(vtkChainMailScanStatistics::KIND_UNKNOWN),
      "a phantom's four greys");
  }

  // Kept for an array until it changes, by its own time or the image's.
  const auto image = Make(MR);
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  const auto first = vtkChainMailScanStatistics::Of(image, scalars);
  check.That(first == vtkChainMailScanStatistics::Of(image, scalars), "kept");
  Fill(scalars, image, CT);
  scalars->Modified();
  check.Equal(vtkChainMailScanStatistics::Of(image, scalars)->GetKind(),
    static_cast<int>(vtkChainMailScanStatistics::KIND_CT), "read again");
}

}

int TestChainMailScanStatistics(int, char*[])
{
  Checks check;
  TestKinds(check);
  TestDeformed(check);
  TestLabels(check);
  TestPresets(check);
  TestOdd(check);
  return check.Finish();
}
