#include "MassSpring.h"

#include "Programs.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace baseline
{

namespace
{

/// A node at the centre of six cubes' corners of the kind that has diagonals: 6 edges and 12 diagonals of faces.
constexpr int valence = 18;

/// Two thirds of what is stable: the stiffest mode has omega^2 = 12 (6 along each axis, neighbours against it).
constexpr float timeStep = 0.4f;

}

class MassSpring::Impl
{
public:
  Impl(const std::string& device, const std::array<int, 3>& nodes)
    : context_(chainmail::Context::of(device))
    , nodes_(nodes)
    , count_(static_cast<std::size_t>(nodes[0]) * nodes[1] * nodes[2])
  {
    this->findSprings();
    std::vector<cl_int> neighbour(valence * this->count_);
    std::vector<cl_float> rest(neighbour.size(), 1.0f);
    std::vector<int> used(this->count_, 0);
    for (std::size_t n = 0; n < neighbour.size(); ++n)
    {
      neighbour[n] = static_cast<cl_int>(n % this->count_);
    }
    for (const auto& [a, b] : this->springs_)
    {
      const float length = this->distance(this->rest(a), this->rest(b));
      for (const auto& [from, to] : { std::pair(a, b), std::pair(b, a) })
      {
        const std::size_t entry = this->count_ * used[from]++ + from;
        neighbour[entry] = static_cast<cl_int>(to);
        rest[entry] = length;
      }
    }
    this->neighbour_ = this->context_->upload(neighbour, "springs");
    this->restLength_ = this->context_->upload(rest, "springs");
    for (cl::Buffer& place : this->place_)
    {
      place = this->context_->allocate(sizeof(cl_float4) * this->count_, "nodes");
    }
    this->held_ = this->context_->allocate(this->count_, "nodes");
    this->kernel_ =
      cl::Kernel(buildProgram(*this->context_, "massspring.cl", " -DVALENCE=" + std::to_string(valence)), "integrate");
    this->reset();
  }

  std::size_t tetrahedra() const { return this->tetrahedra_; }
  std::size_t springs() const { return this->springs_.size(); }

  void reset()
  {
    std::vector<cl_float4> places;
    for (std::size_t n = 0; n < this->count_; ++n)
    {
      const Place p = this->rest(n);
      places.push_back({ { p[0], p[1], p[2], 0.0f } });
    }
    for (const cl::Buffer& place : this->place_)
    {
      this->context_->write(place, 0, places);
    }
    this->context_->write(this->held_, 0, std::vector<cl_uchar>(this->count_, 0));
  }

  void hold(const std::vector<std::size_t>& nodes, const Place& displacement)
  {
    for (const std::size_t n : nodes)
    {
      const Place p = this->rest(n);
      const std::vector<cl_float4> place{
        { { p[0] + displacement[0], p[1] + displacement[1], p[2] + displacement[2], 0.0f } }
      };
      for (const cl::Buffer& buffer : this->place_)
      {
        this->context_->write(buffer, sizeof(cl_float4) * n, place);
      }
      this->context_->write(this->held_, n, std::vector<cl_uchar>{ 1 });
    }
  }

  void step(int steps, float damping)
  {
    constexpr std::size_t group = 64;
    for (int n = 0; n < steps; ++n)
    {
      int argument = 0;
      this->kernel_.setArg(argument++, static_cast<cl_uint>(this->count_));
      this->kernel_.setArg(argument++, timeStep * timeStep);
      this->kernel_.setArg(argument++, 1.0f - damping);
      this->kernel_.setArg(argument++, this->held_);
      this->kernel_.setArg(argument++, this->neighbour_);
      this->kernel_.setArg(argument++, this->restLength_);
      this->kernel_.setArg(argument++, this->place_[0]);
      this->kernel_.setArg(argument++, this->place_[1]);
      this->context_->launch(this->kernel_, (this->count_ + group - 1) / group, group);
      std::swap(this->place_[0], this->place_[1]);
    }
    this->context_->queue().finish();
  }

  std::vector<Place> displacements() const
  {
    const std::vector<cl_float4> places = this->read(0);
    std::vector<Place> u(this->count_);
    for (std::size_t n = 0; n < this->count_; ++n)
    {
      const Place p = this->rest(n);
      u[n] = { places[n].s[0] - p[0], places[n].s[1] - p[1], places[n].s[2] - p[2] };
    }
    return u;
  }

  /// The velocity is that between two steps; the springs' energy is the mean of before and after it.
  double energy() const
  {
    const std::vector<cl_float4> now = this->read(0);
    const std::vector<cl_float4> before = this->read(1);
    double sum = 0.0;
    for (std::size_t n = 0; n < this->count_; ++n)
    {
      for (int a = 0; a < 3; ++a)
      {
        const double velocity = (now[n].s[a] - before[n].s[a]) / timeStep;
        sum += 0.5 * velocity * velocity;
      }
    }
    const auto place = [](const std::vector<cl_float4>& places, std::size_t n) {
      return Place{ places[n].s[0], places[n].s[1], places[n].s[2] };
    };
    for (const auto& [a, b] : this->springs_)
    {
      const double length = this->distance(this->rest(a), this->rest(b));
      for (const std::vector<cl_float4>* places : { &now, &before })
      {
        const double stretch = this->distance(place(*places, a), place(*places, b)) - length;
        sum += 0.25 * stretch * stretch;
      }
    }
    return sum;
  }

private:
  /// Five tetrahedra a cube: one on four corners that are no neighbours, and one at each of the other corners. Cubes
  /// take turns with the corners, so that diagonals of faces meet.
  void findSprings()
  {
    std::set<std::pair<std::size_t, std::size_t>> edges;
    const auto cube = [&](int i, int j, int k)
    {
      const auto corner = [&](int bits)
      {
        return static_cast<std::size_t>(i + (bits & 1)) +
               this->nodes_[0] * (static_cast<std::size_t>(j + (bits >> 1 & 1)) +
                                   this->nodes_[1] * static_cast<std::size_t>(k + (bits >> 2)));
      };
      const int turn = (i + j + k) % 2 == 0 ? 0 : 7; // mirrors a corner
      const auto tetrahedron = [&](const std::array<int, 4>& corners)
      {
        ++this->tetrahedra_;
        for (int a = 0; a < 4; ++a)
        {
          for (int b = 0; b < a; ++b)
          {
            edges.insert(std::minmax({ corner(corners[a] ^ turn), corner(corners[b] ^ turn) }));
          }
        }
      };
      tetrahedron({ 0, 3, 5, 6 });
      for (const int at : { 1, 2, 4, 7 })
      {
        tetrahedron({ at, at ^ 1, at ^ 2, at ^ 4 });
      }
    };
    for (int k = 0; k + 1 < this->nodes_[2]; ++k)
    {
      for (int j = 0; j + 1 < this->nodes_[1]; ++j)
      {
        for (int i = 0; i + 1 < this->nodes_[0]; ++i)
        {
          cube(i, j, k);
        }
      }
    }
    this->springs_.assign(edges.begin(), edges.end());
  }

  Place rest(std::size_t node) const
  {
    const std::size_t nx = this->nodes_[0];
    const std::size_t ny = this->nodes_[1];
    return { float(node % nx), float(node / nx % ny), float(node / (nx * ny)) };
  }

  static float distance(const Place& a, const Place& b)
  {
    return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
  }

  std::vector<cl_float4> read(int which) const
  {
    std::vector<cl_float4> places(this->count_);
    this->context_->read(this->place_[which], places);
    return places;
  }

  std::shared_ptr<chainmail::Context> context_;
  std::array<int, 3> nodes_;
  std::size_t count_;
  std::size_t tetrahedra_ = 0;
  std::vector<std::pair<std::size_t, std::size_t>> springs_;
  cl::Buffer neighbour_;
  cl::Buffer restLength_;
  cl::Buffer held_;
  cl::Buffer place_[2]; ///< now, and one step ago
  cl::Kernel kernel_;
};

MassSpring::MassSpring(const std::string& device, const std::array<int, 3>& nodes)
  : impl_(chainmail::translated([&] { return std::make_unique<Impl>(device, nodes); }))
{
}

MassSpring::~MassSpring() = default;

std::size_t MassSpring::tetrahedra() const
{
  return this->impl_->tetrahedra();
}

std::size_t MassSpring::springs() const
{
  return this->impl_->springs();
}

void MassSpring::reset()
{
  chainmail::translated([&] { this->impl_->reset(); });
}

void MassSpring::hold(const std::vector<std::size_t>& nodes, const Place& displacement)
{
  chainmail::translated([&] { this->impl_->hold(nodes, displacement); });
}

void MassSpring::step(int steps, float damping)
{
  chainmail::translated([&] { this->impl_->step(steps, damping); });
}

std::vector<MassSpring::Place> MassSpring::displacements() const
{
  return chainmail::translated([&] { return this->impl_->displacements(); });
}

double MassSpring::energy() const
{
  return chainmail::translated([&] { return this->impl_->energy(); });
}

}
