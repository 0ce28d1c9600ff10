// Pulls the middle of a soft block by half a millimetre and checks that it came along.

#include <Device.h>
#include <Simulation.h>

#include <cmath>
#include <exception>
#include <iostream>

int main()
{
  try
  {
    chainmail::Grid grid;
    grid.size = { 9, 9, 9 };
    const std::vector<short> scan(grid.voxels(), 100);
    chainmail::ArrayView scalars;
    scalars.data = scan.data();
    scalars.type = chainmail::ArrayView::Type::Int16;
    chainmail::Material material;
    material.constraint = [](double) { return 0.25; };

    auto model = std::make_shared<const chainmail::Model>(grid, scalars, material, chainmail::Anchors());
    chainmail::Simulation simulation(model, chainmail::Settings());
    chainmail::Probe probe;
    probe.position = { 4.0, 4.0, 4.0 };
    probe.displacement = { 0.5, 0.0, 0.0 };
    simulation.pull({ probe });

    std::vector<float> displacement(3 * grid.voxels());
    simulation.displacements(displacement.data());
    // A link may stretch by 0.25 mm, so the neighbour of the held voxel follows by 0.5 - 0.25 mm. Both are exact in
    // binary; 1e-6 leaves room for a device that computes in fractions of the spacing.
    const float held = displacement[3 * grid.at(4, 4, 4)];
    const float neighbour = displacement[3 * grid.at(5, 4, 4)];
    std::cout << "held " << held << " mm, its neighbour " << neighbour << " mm, on " << simulation.deviceName() << '\n';
    return std::abs(held - 0.5f) < 1e-6f && std::abs(neighbour - 0.25f) < 1e-6f ? 0 : 1;
  }
  catch (const std::exception& error)
  {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
