// B6: a drag in the filter's Interactive mode on head_vhf_ct (8.9 M voxels): from the moved probe to the new output,
// without drawing it, against what the engine alone needs for the same step.

#include "Scans.h"

namespace
{

/// The same handle in the same tissue, without VTK.
class EngineDrag
{
public:
  EngineDrag(bench::Session& session, vtkImageData* scan, double threshold, double top)
    : function_(bench::softMaterial(threshold, top))
  {
    chainmail::Grid grid;
    scan->GetDimensions(grid.size.data());
    scan->GetSpacing(grid.spacing.data());
    vtkDataArray* array = scan->GetPointData()->GetScalars();
    chainmail::ArrayView scalars;
    scalars.data = array->GetVoidPointer(0);
    scalars.type =
      array->GetDataType() == VTK_SHORT ? chainmail::ArrayView::Type::Int16 : chainmail::ArrayView::Type::UInt8;
    if (array->GetDataType() != VTK_SHORT && array->GetDataType() != VTK_UNSIGNED_CHAR)
    {
      throw std::runtime_error("scans of this type are not expected here");
    }
    chainmail::Material material;
    material.tissueThreshold = threshold;
    material.constraint = [this](double scalar) { return this->function_->GetValue(scalar); };
    this->simulation_ = std::make_unique<chainmail::Simulation>(
      session.simulate(std::make_shared<const chainmail::Model>(grid, scalars, material, chainmail::Anchors())));
    for (int a = 0; a < 3; ++a)
    {
      this->probe_.position[a] = 0.5 * (grid.size[a] - 1) * grid.spacing[a];
    }
  }

  void to(double far, double radius, int sweeps, double tolerance, const FilterTest::Vector& share)
  {
    chainmail::Probe probe = this->probe_;
    const chainmail::Grid& grid = this->simulation_->model().grid();
    for (int a = 0; a < 3; ++a)
    {
      probe.position[a] += share[a] * (grid.size[a] - 1) * grid.spacing[a];
    }
    probe.displacement = { far, 0.5 * far, -0.25 * far };
    probe.radius = radius;
    this->simulation_->hold({ probe });
    this->simulation_->propagate();
    this->simulation_->relax(sweeps, tolerance);
    this->simulation_->resample({ 0, 0, 0 }, [](const std::vector<chainmail::ResampledBox>&) {});
  }

  void reset() { this->simulation_->reset(); }
  const chainmail::Simulation& simulation() const { return *this->simulation_; }

private:
  vtkSmartPointer<vtkPiecewiseFunction> function_;
  std::unique_ptr<chainmail::Simulation> simulation_;
  chainmail::Probe probe_;
};

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B6", "a drag in Interactive mode",
    [](bench::Session& session)
    {
      const std::string name = bench::scanName(session, "head_vhf_ct");
      const auto scan = bench::readScan(name);
      // Eight bits hold Hounsfield units as (HU + 1024) / 16.
      const bool bytes = scan->GetPointData()->GetScalars()->GetDataType() == VTK_UNSIGNED_CHAR;
      const double threshold = bytes ? 35.0 : -300.0;
      const double top = bytes ? 110.0 : 600.0;
      const FilterTest::Vector share{ 0.3, -0.1, -0.1 }; // a cheek
      constexpr double radius = 6.0;
      constexpr double far = 5.0;
      constexpr double before = 4.5;

      bench::Drag drag(session, scan, threshold, top);
      drag.grabAt(share, radius);
      EngineDrag engine(session, scan, threshold, top);
      const int sweeps = drag.filter()->GetRelaxationIterations();
      const double tolerance = drag.filter()->GetRelaxationTolerance();

      // The same step of the same way for both.
      std::map<std::string, double> figures;
      bench::Task viaFilter;
      viaFilter.prepare = [&]
      {
        drag.rest();
        drag.to(before);
      };
      viaFilter.run = [&] { drag.to(far); };
      viaFilter.check = [&] { drag.requireSound(false); };
      bench::Task alone;
      alone.prepare = [&]
      {
        engine.reset();
        engine.to(before, radius, sweeps, tolerance, share);
      };
      alone.run = [&] { engine.to(far, radius, sweeps, tolerance, share); };
      alone.check = [&] { bench::requireSound(engine.simulation()); };
      const auto milliseconds = session.time({ viaFilter, alone });
      const char* const names[] = { "upload [ms]", "propagate [ms]", "relax [ms]", "resample [ms]", "download [ms]" };
      for (int part = 0; part < 5; ++part)
      {
        figures[names[part]] = drag.field("Milliseconds", part);
      }
      figures["elements displaced"] = drag.field("DisplacedElements");
      figures["times the engine"] = bench::median(milliseconds[0]) / bench::median(milliseconds[1]);
      session.report({ name, "filter", milliseconds[0], figures });
      session.report({ name, "engine", milliseconds[1],
        { { "elements displaced", double(engine.simulation().measure().displaced) } } });
    });
}
