// SPDX-License-Identifier: BSD-3-Clause
// Cuts and carves that meet no tissue are warned about, by name and once; so are those that come back to where they
// were in Interactive mode, as Undo makes them, and bring back no tissue.

#include "FilterTest.h"

#include "vtkAppendPolyData.h"
#include "vtkSphereSource.h"

using namespace FilterTest;

namespace
{

vtkSmartPointer<vtkPolyData> Knife(double x)
{
  return MakeBlade({ { { { x, -2.0, -2.0 } }, { { x, 12.0, -2.0 } }, { { x, 12.0, 12.0 } }, { { x, -2.0, 12.0 } } } });
}

vtkSmartPointer<vtkPolyData> Ball(double x)
{
  vtkNew<vtkSphereSource> ball;
  ball->SetCenter(x, 4.0, 4.0);
  ball->SetRadius(1.75);
  ball->Update();
  return ball->GetOutput();
}

/// Tissue from x = 0 to 15.
struct Bench
{
  vtkSmartPointer<vtkImageData> Image = MakeImage({ { 0, 15, 0, 8, 0, 8 } });
  vtkNew<vtkChainMailDeformation> Filter;
  EventLog Log{ this->Filter };

  explicit Bench(int mode)
  {
    this->Image->GetPointData()->GetScalars()->Fill(50.0);
    this->Filter->SetMode(mode);
    this->Filter->SetInputData(this->Image);
    this->Filter->SetTissueThreshold(10.0);
    this->Filter->SetMaterialFunction(ConstantMaterial(0.3));
  }

  std::string Update(Checks& check)
  {
    this->Filter->Modified();
    this->Filter->Update();
    check.Equal(this->Log.TakeErrors(), std::string(), "no error");
    return this->Log.TakeWarnings();
  }

  double Tissue()
  {
    vtkDataArray* element = this->Filter->GetModelOutput()->GetPointData()->GetArray("Element");
    double count = 0.0;
    for (vtkIdType v = 0; v < element->GetNumberOfTuples(); ++v)
    {
      count += element->GetTuple1(v);
    }
    return count;
  }
};

const double air = 30.0;

}

int TestChainMailSurfaces(int, char*[])
{
  Checks check;
  const std::string nothing;
  const std::string met = "met no tissue";
  const std::string back = "back where it was before";

  for (const int mode : { vtkChainMailDeformation::MODE_FROM_REST, vtkChainMailDeformation::MODE_INTERACTIVE })
  {
    for (const int port : { 2, 3 })
    {
      const std::string portName = port == 2 ? "Cuts" : "Carves";
      const auto surface = [&](double x) { return port == 2 ? Knife(x) : Ball(x); };
      const std::string where =
        (mode == vtkChainMailDeformation::MODE_FROM_REST ? "from rest, " : "interactive, ") + portName + ": ";
      Bench bench(mode);
      const auto put = [&](int input, double x)
      {
        if (input < bench.Filter->GetNumberOfInputConnections(port))
        {
          bench.Filter->RemoveInputConnection(port, input);
        }
        // The second of two stays the second.
        bench.Filter->AddInputDataObject(port, surface(x));
        return bench.Update(check);
      };

      bench.Filter->AddInputDataObject(port, surface(4.5));
      check.Equal(bench.Update(check), nothing, where + "in tissue");
      // Alone of two, the second one misses.
      const std::string first = put(1, air);
      check.Contains(first, portName + " input 1", where + "the one that misses is named");
      check.Contains(first, met, where + "what is wrong");
      check.Equal(bench.Update(check), nothing, where + "once");
      for (double x = air; x < air + 3.0; x += 0.75)
      {
        check.Equal(put(1, x + 0.25), nothing, where + "once while it moves through air");
      }
      bench.Filter->SetInputDataObject(1, MakeProbes({ { { { 8.0, 4.0, 4.0 } }, { { 0.25, 0.0, 0.0 } } } }));
      check.Equal(bench.Update(check), nothing, where + "once while others move");
      check.Equal(put(1, 10.5), nothing, where + "where it meets tissue again");
      check.Contains(put(1, air + 5.0), portName + " input 1", where + "after it met tissue, it misses anew");
      check.Equal(put(1, air + 6.0), nothing, where + "once");
      // A surface that is gone does not speak for what is connected next.
      bench.Filter->RemoveInputConnection(port, 1);
      check.Equal(bench.Update(check), nothing, where + "disconnected");
      check.Contains(put(1, air + 7.0), portName + " input 1", where + "another one misses");
      // Nothing to cut with is no miss.
      bench.Filter->RemoveInputConnection(port, 1);
      bench.Filter->AddInputDataObject(port, vtkNew<vtkPolyData>());
      check.Equal(bench.Update(check), nothing, where + "an empty one");
    }
  }

  // Another surface at once at the place of one that misses: it has other triangles.
  {
    Bench bench(vtkChainMailDeformation::MODE_FROM_REST);
    bench.Filter->AddInputDataObject(2, Knife(air));
    check.Contains(bench.Update(check), met, "the first one misses");
    bench.Filter->SetInputDataObject(2, Ball(air));
    check.Contains(bench.Update(check), met, "so does the one that takes its place");
    check.Equal(bench.Update(check), nothing, "once");
  }

  // Polygons that cross themselves.
  {
    Bench bench(vtkChainMailDeformation::MODE_FROM_REST);
    vtkNew<vtkAppendPolyData> polygons;
    polygons->AddInputData(Knife(4.5));
    polygons->AddInputData(
      MakeBlade({ { { { 8.5, 1.0, 1.0 } }, { { 8.5, 7.0, 7.0 } }, { { 8.5, 7.0, 1.0 } }, { { 8.5, 1.0, 7.0 } } } }));
    polygons->Update();
    bench.Filter->SetInputDataObject(2, polygons->GetOutput());
    check.Contains(bench.Update(check), "Cuts input 0: polygon 1 crosses itself", "a bow tie");
    check.Equal(bench.Update(check), nothing, "a bow tie: once");
    // No polygon that is merely not convex, or not flat, does.
    const auto fine =
      MakeBlade({ { { { 4.5, 1.0, 1.0 } }, { { 4.7, 7.0, 1.0 } }, { { 4.5, 3.0, 3.0 } }, { { 4.3, 1.0, 7.0 } } } });
    bench.Filter->SetInputDataObject(2, fine);
    bench.Filter->Modified();
    check.Equal(bench.Update(check), nothing, "a dart");
  }

  // Undo.
  for (const int port : { 2, 3 })
  {
    const std::string portName = port == 2 ? "Cuts" : "Carves";
    const auto surface = [&](double x) { return port == 2 ? Knife(x) : Ball(x); };
    Bench bench(vtkChainMailDeformation::MODE_INTERACTIVE);
    const auto put = [&](double x)
    {
      bench.Filter->SetInputDataObject(port, surface(x));
      return bench.Update(check);
    };
    check.Equal(put(4.5), nothing, portName + " at once");
    check.Equal(put(10.5), nothing, portName + " moved");
    const double tissue = bench.Tissue();
    const std::string warning = put(4.5);
    check.Contains(warning, portName + " input 0", portName + " back: named");
    check.Contains(warning, back, portName + " back: what is odd");
    check.Contains(warning, "Reset", portName + " back: what to do");
    check.That(warning.find(met) == std::string::npos, portName + " back: it is no miss");
    check.Equal(bench.Tissue(), tissue, portName + " back: what is gone stays gone");
    check.Equal(put(10.5), nothing, portName + " back: once");
    check.Equal(put(4.5), nothing, portName + " back: once");
    check.Equal(put(7.5), nothing, portName + " elsewhere");

    // After Reset() it starts anew; what was there then was at that place.
    bench.Filter->Reset();
    check.Equal(bench.Update(check), nothing, portName + " reset");
    check.Equal(bench.Tissue(), 16.0 * 9.0 * 9.0, portName + " reset: all tissue is back");
    check.Equal(put(10.5), nothing, portName + " reset: places from before do not count");
    check.Contains(put(7.5), back, portName + " reset: back to where it was at rest");

    // From rest a surface may go where it likes.
    bench.Filter->SetModeToFromRest();
    for (const double x : { 4.5, 10.5, 4.5 })
    {
      check.Equal(put(x), nothing, portName + " from rest");
    }
  }
  return check.Finish();
}
