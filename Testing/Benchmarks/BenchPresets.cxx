// B13: the presets Balanced and Accurate on whole scans, from rest: what an update of the filter takes, and how far the
// tissue then is from the optimum. B14: Balanced with rotations, which has another optimum.

#include "Scans.h"

namespace
{

/// A pull from rest with both presets, and with tissue that turns, in turns.
void presets(bench::Session& session, const std::string& name, bench::Drag& drag, double far)
{
  vtkChainMailDeformation* filter = drag.filter();
  filter->SetModeToFromRest();
  const struct
  {
    const char* name;
    int preset;
    bool rotations;
  } rows[] = { { "Balanced", vtkChainMailDeformation::RELAXATION_BALANCED, false },
    { "Accurate", vtkChainMailDeformation::RELAXATION_ACCURATE, false },
    { "Balanced with rotations", vtkChainMailDeformation::RELAXATION_BALANCED, true } };
  std::vector<std::vector<float>> states(std::size(rows));
  std::vector<double> relax(std::size(rows));
  std::vector<bench::Task> tasks;
  for (std::size_t n = 0; n < std::size(rows); ++n)
  {
    bench::Task task;
    task.prepare = [&, n]
    {
      filter->SetRelaxationPreset(rows[n].preset);
      filter->SetRotations(rows[n].rotations);
      drag.rest();
    };
    task.run = [&] { drag.to(far); };
    task.check = [&, n]
    {
      drag.requireSound(false);
      states[n] = bench::displacementsOf(filter);
      relax[n] = drag.field("Milliseconds", FilterTest::RELAX);
    };
    tasks.push_back(task);
  }
  const auto milliseconds = session.time(tasks);

  // The optimum: 1000 iterations, with as many corrections as help. What is left of the way to it counts for both
  // presets.
  filter->SetRotations(false);
  filter->SetRelaxationPresetToCustom();
  filter->SetCoarseToFine(true);
  filter->SetRelaxationIterations(session.small() ? 200 : 1000);
  filter->SetRelaxationTolerance(1e-7);
  filter->SetRelaxationError(1e-6);
  drag.rest();
  drag.to(far);
  const std::vector<float> optimum = bench::displacementsOf(filter);

  for (std::size_t n = 0; n < std::size(rows); ++n)
  {
    std::map<std::string, double> figures{ { "relax [ms]", relax[n] },
      { "times Balanced", bench::median(milliseconds[n]) / bench::median(milliseconds[0]) } };
    if (!rows[n].rotations)
    {
      figures["distance from the optimum [% of the pull]"] = 100.0 * bench::distance(states[n], optimum);
    }
    session.report({ name, rows[n].name, milliseconds[n], figures });
  }
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B13", "presets",
    [](bench::Session& session)
    {
      {
        const std::string name = bench::scanName(session, "heart_cta");
        bench::Drag drag(session, bench::readScan(name), -300.0, 600.0);
        // The lateral wall of the left ventricle, out towards the lung; calcium and bone are rigid.
        vtkNew<vtkPiecewiseFunction> material;
        material->AddPoint(-300.0, 0.35);
        material->AddPoint(-100.0, 0.4);
        material->AddPoint(250.0, 0.5);
        material->AddPoint(600.0, 0.5);
        material->AddPoint(1000.0, 0.0);
        drag.filter()->SetMaterialFunction(material);
        drag.grabAt({ -0.29, 0.164, -0.12 }, 12.0);
        presets(session, name, drag, session.small() ? -2.0 : -16.0);
      }
      if (!session.small())
      {
        bench::Drag drag(session, bench::readScan("head_vhf_ct"), 35.0, 110.0); // bytes, (HU + 1024) / 16
        drag.grabAt({ 0.3, -0.1, -0.1 }, 6.0);                                  // a cheek
        presets(session, "head_vhf_ct", drag, 5.0);
      }
    });
}
