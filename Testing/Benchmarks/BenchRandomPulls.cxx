// B15: pulls at random places of the scans, in random directions, of random length and radius, every third beside a
// cut. Nobody tuned the presets for them. Of each preset: what an update of the filter takes, and how far the tissue
// then is from the optimum. Of coarse to fine: what it takes before its first sweep on the finest grid.

#include "../Unit/Random.h"
#include "Scans.h"

namespace
{

/// Tissue that moves less than this is a speck in air.
constexpr double fewElements = 1000.0;

/// The value below which a share of the values is.
double quantile(std::vector<double> values, double share)
{
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size()))) - 1];
}

std::map<std::string, double> spread(const std::string& what, const std::vector<double>& values)
{
  return { { what + ", median", bench::median(values) }, { what + ", nine of ten", quantile(values, 0.9) },
    { what + ", worst", quantile(values, 1.0) } };
}

/// A scan with the material that the filter takes for it, and a pull in it.
class Pull
{
public:
  Pull(const bench::Session& session, const std::string& name)
    : scan_(bench::readScan(name))
  {
    this->filter_->SetInputData(this->scan_);
    this->filter_->SetDevice(session.device().c_str());
    this->filter_->Update(1);
    this->isElement_ = this->filter_->GetModelOutput()->GetPointData()->GetArray("Element");
  }

  vtkChainMailDeformation* filter() { return this->filter_; }

  /// Draws another one, until it moves more than a speck.
  void draw(Random& random, bool cut)
  {
    this->filter_->SetRelaxationPresetToFast();
    for (int attempt = 0; attempt < 100; ++attempt)
    {
      this->drawOnce(random, cut);
      this->run();
      if (this->field("DisplacedElements") > fewElements)
      {
        return;
      }
    }
    throw std::runtime_error("no pull in this scan moves tissue");
  }

  void rest()
  {
    this->filter_->SetInputDataObject(1, FilterTest::MakeProbes({}));
    this->filter_->Update();
  }

  void run()
  {
    this->filter_->SetInputDataObject(1, FilterTest::MakeProbes({ this->probe_ }));
    this->filter_->Update();
  }

  double field(const char* name, int component = 0)
  {
    return FilterTest::Field(this->filter_->GetOutput(), name, component);
  }

  double relaxMilliseconds() { return this->field("Milliseconds", FilterTest::RELAX); }

  void requireSound()
  {
    const double* spacing = this->scan_->GetSpacing();
    const double voxels = bench::length(this->probe_.Displacement.data()) / *std::min_element(spacing, spacing + 3);
    const double excess = this->field("MaxLinkExcess");
    if (this->filter_->GetOutput()->GetFieldData()->GetAbstractArray("Error"))
    {
      throw std::runtime_error("an update failed");
    }
    if (!std::isfinite(this->field("Energy")) || !(excess <= bench::roundingOf(voxels)))
    {
      throw std::runtime_error("the state must not be reported: link excess " + std::to_string(excess));
    }
  }

private:
  static FilterTest::Vector direction(Random& random)
  {
    FilterTest::Vector d;
    do
    {
      d = { random(-1.0, 1.0), random(-1.0, 1.0), random(-1.0, 1.0) };
    } while (bench::length(d.data()) > 1.0 || bench::length(d.data()) < 0.1);
    const double length = bench::length(d.data());
    return { d[0] / length, d[1] / length, d[2] / length };
  }

  vtkIdType elementAwayFromFaces(Random& random)
  {
    const int* size = this->scan_->GetDimensions();
    for (int attempt = 0; attempt < 100000; ++attempt)
    {
      int at[3];
      for (int a = 0; a < 3; ++a)
      {
        at[a] = this->scan_->GetExtent()[2 * a] + static_cast<int>(size[a] * random(0.1, 0.9));
      }
      const vtkIdType voxel = this->scan_->ComputePointId(at);
      if (this->isElement_->GetTuple1(voxel) != 0.0)
      {
        return voxel;
      }
    }
    throw std::runtime_error("there is hardly any tissue in this scan");
  }

  void drawOnce(Random& random, bool cut)
  {
    double bounds[6];
    this->scan_->GetBounds(bounds);
    const double shortest = std::min({ bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4] });
    this->scan_->GetPoint(this->elementAwayFromFaces(random), this->probe_.Position.data());
    this->probe_.Radius = shortest * random(0.02, 0.08);
    const FilterTest::Vector way = direction(random);
    const double far = shortest * random(0.03, 0.15);
    for (int a = 0; a < 3; ++a)
    {
      this->probe_.Displacement[a] = far * way[a];
    }
    // A square blade beside the probe, parallel to the pull, so that the cut opens.
    const FilterTest::Vector other = direction(random);
    const FilterTest::Vector aside{ way[1] * other[2] - way[2] * other[1], way[2] * other[0] - way[0] * other[2],
      way[0] * other[1] - way[1] * other[0] };
    std::array<FilterTest::Vector, 4> corners;
    for (int n = 0; n < 4; ++n)
    {
      for (int a = 0; a < 3; ++a)
      {
        corners[n][a] = this->probe_.Position[a] + 1.5 * this->probe_.Radius * aside[a] +
                        0.2 * shortest * ((n == 1 || n == 2 ? 1.0 : -1.0) * way[a] + (n > 1 ? 1.0 : -1.0) * other[a]);
      }
    }
    this->filter_->SetInputDataObject(2, cut ? FilterTest::MakeBlade(corners) : vtkSmartPointer<vtkPolyData>::New());
  }

  vtkSmartPointer<vtkImageData> scan_;
  vtkNew<vtkChainMailDeformation> filter_;
  vtkSmartPointer<vtkDataArray> isElement_; // of each voxel whether it is tissue
  FilterTest::Probe probe_;
};

/// Milliseconds before the first sweep on the finest grid, over those of such a sweep.
double sweepsBeforeTheFirst(Pull& pull)
{
  vtkChainMailDeformation* filter = pull.filter();
  filter->SetRelaxationPresetToCustom();
  filter->SetCoarseToFine(true);
  filter->SetRelaxationTolerance(0.0);
  filter->SetRelaxationError(0.0);
  const auto relax = [&](int sweeps)
  {
    filter->SetRelaxationIterations(sweeps);
    pull.rest();
    pull.run();
    return pull.relaxMilliseconds();
  };
  relax(1);
  const double one = relax(1);
  const double sweep = (relax(17) - one) / 16.0; // so few leave no room for a correction, and no group moves in them
  return (one - sweep) / sweep;
}

constexpr struct
{
  const char* name;
  int preset;
  bool rotations;
} rows[] = { { "Fast", vtkChainMailDeformation::RELAXATION_FAST, false },
  { "Balanced", vtkChainMailDeformation::RELAXATION_BALANCED, false },
  { "Accurate", vtkChainMailDeformation::RELAXATION_ACCURATE, false },
  { "Balanced with rotations", vtkChainMailDeformation::RELAXATION_BALANCED, true } };

/// What was measured, a value for each pull.
struct Measured
{
  std::array<std::vector<double>, std::size(rows)> milliseconds;
  std::array<std::vector<double>, std::size(rows)> figure; ///< see report()
  std::vector<double> before;                              ///< sweepsBeforeTheFirst()

  void add(const Measured& more)
  {
    const auto append = [](std::vector<double>& to, const std::vector<double>& from)
    { to.insert(to.end(), from.begin(), from.end()); };
    for (std::size_t r = 0; r < std::size(rows); ++r)
    {
      append(this->milliseconds[r], more.milliseconds[r]);
      append(this->figure[r], more.figure[r]);
    }
    append(this->before, more.before);
  }

  void report(bench::Session& session, const std::string& scene) const
  {
    for (std::size_t r = 0; r < std::size(rows); ++r)
    {
      session.report({ scene, rows[r].name, this->milliseconds[r],
        spread(
          rows[r].rotations ? "times one without" : "distance from the optimum [% of the pull]", this->figure[r]) });
    }
    session.report({ scene, "coarse to fine", {}, spread("sweeps' time before the first one", this->before) });
  }
};

Measured randomPulls(bench::Session& session, const std::string& name, int count)
{
  Random random(session.seed());
  Pull pull(session, name);
  vtkChainMailDeformation* filter = pull.filter();
  Measured measured;
  for (int n = 0; n < count; ++n)
  {
    filter->SetRotations(false);
    pull.draw(random, n % 3 == 2);
    std::vector<std::vector<float>> states;
    for (std::size_t r = 0; r < std::size(rows); ++r)
    {
      filter->SetRelaxationPreset(rows[r].preset);
      filter->SetRotations(rows[r].rotations);
      bench::Task task;
      task.prepare = [&] { pull.rest(); };
      task.run = [&] { pull.run(); };
      task.check = [&] { pull.requireSound(); };
      session.once(task); // kernels are compiled and memory is touched
      measured.milliseconds[r].push_back(session.once(task));
      states.push_back(bench::displacementsOf(filter));
    }
    filter->SetRotations(false);
    measured.before.push_back(sweepsBeforeTheFirst(pull));
    // The optimum, with as many corrections as help.
    filter->SetRelaxationIterations(session.small() ? 200 : 1000);
    filter->SetRelaxationTolerance(1e-7);
    filter->SetRelaxationError(1e-6);
    pull.rest();
    pull.run();
    const std::vector<float> optimum = bench::displacementsOf(filter);
    for (std::size_t r = 0; r < std::size(rows); ++r)
    {
      measured.figure[r].push_back(rows[r].rotations ? measured.milliseconds[r].back() / measured.milliseconds[1].back()
                                                     : 100.0 * bench::distance(states[r], optimum));
    }
  }
  measured.report(session, name);
  return measured;
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B15", "random pulls",
    [](bench::Session& session)
    {
      vtkChainMailDeformation::SetGlobalProbeWarnings(false); // some probes pull further than tissue stretches
      std::vector<const char*> scans{ "abdomen_ct", "heart_cta", "head_mr", "head_vhf_ct", "chest_lidc_ct" };
      scans.resize(session.small() ? 1 : scans.size());
      Measured all;
      for (const char* scan : scans)
      {
        all.add(randomPulls(session, scan, session.small() ? 1 : 6));
      }
      all.report(session, "all scans");
    });
}
