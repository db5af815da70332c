// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/rigid_links.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "fem_solver/stress/beam_cells.hpp"

namespace gabion::fem {

namespace {

/// Forces of an arm on its node, the place and the rotation node, in the order of its unknowns.
template <int dim, class S>
struct ArmForces {
  std::array<S, 3 * dim> f;
  S energy;
};

/// (R - 1) d without cancellation where R is near 1, and R d.
template <class S>
std::pair<std::array<S, 2>, std::array<S, 2>> turned(const Vector<2>& d, const S& angle) {
  using std::cos, std::sin;
  const S half = S(0.5) * angle, s = sin(half), c = cos(half);
  const S less = S(-2.0) * s * s, sine = S(2.0) * s * c;  // cos - 1, sin
  const std::array<S, 2> moved = {less * S(d[0]) - sine * S(d[1]), sine * S(d[0]) + less * S(d[1])};
  return {moved, {S(d[0]) + moved[0], S(d[1]) + moved[1]}};
}
template <class S>
std::pair<Triple<S>, Triple<S>> turned(const Vector<3>& d, const Turn<S>& q) {
  const Triple<S> x = {S(d[0]), S(d[1]), S(d[2])};
  const Triple<S> t = S(2.0) * cross(q.v, x);
  const Triple<S> moved = q.w * t + cross(q.v, t);
  return {moved, x + moved};
}

/// Rotation of the node of the beams, an angle in the plane.
/// @param history  accepted, of the beam that ends there
template <class S>
auto rotation_of(const RigidLink<2>& link, std::span<const double> u, std::span<const double>,
                 double length) {
  return S(1 / length) * unknown<S>(u[static_cast<std::size_t>(link.rotation) * 2], 4);
}
template <class S>
Turn<S> rotation_of(const RigidLink<3>& link, std::span<const double> u,
                    std::span<const double> history, double length) {
  const double* q = &history[4 * static_cast<std::size_t>(link.end)];
  const double* before = &history[8 + 3 * static_cast<std::size_t>(link.end)];
  Triple<S> angle;
  for (int c = 0; c < 3; ++c) {
    const double w = u[static_cast<std::size_t>(link.rotation) * 3 + c];
    angle[c] = S(1 / length) * unknown<S>(w - before[c], 6 + c);
  }
  return turn_by(angle) * Turn<S>{S(1 + q[0]), {S(q[1]), S(q[2]), S(q[3])}};
}

template <class S>
void set_moment(const std::array<S, 2>& arm, const std::array<S, 2>& force, double length,
                std::array<S, 6>& f) {
  f[4] = S(-1 / length) * (arm[0] * force[1] - arm[1] * force[0]);
  f[5] = S(0.0);
}
template <class S>
void set_moment(const Triple<S>& arm, const Triple<S>& force, double length, std::array<S, 9>& f) {
  const Triple<S> moment = cross(arm, force);
  for (int c = 0; c < 3; ++c) f[6 + c] = S(-1 / length) * moment[c];
}

template <class S, int dim>
ArmForces<dim, S> arm_forces(const RigidLink<dim>& link, const typename RigidLink<dim>::Arm& arm,
                             std::span<const double> u, std::span<const double> history,
                             double length) {
  const auto [moved, reach] = turned<S>(arm.reach, rotation_of<S>(link, u, history, length));
  std::array<S, dim> force;
  ArmForces<dim, S> result;
  result.energy = 0.0;
  for (int c = 0; c < dim; ++c) {
    const S of_node = unknown<S>(u[static_cast<std::size_t>(arm.node) * dim + c], c);
    const S of_place = unknown<S>(u[static_cast<std::size_t>(link.place) * dim + c], dim + c);
    const S gap = of_node - of_place - moved[c];
    force[c] = S(link.stiffness) * gap;
    result.energy = result.energy + S(0.5) * force[c] * gap;
    result.f[c] = force[c];
    result.f[dim + c] = -force[c];
  }
  set_moment(reach, force, length, result.f);
  return result;
}

}  // namespace

template <int dim>
RigidLinks<dim>::RigidLinks(std::vector<RigidLink<dim>> links, double length)
    : links_(std::move(links)), length_(length) {
  for (const auto& link : links_) num_arms_ += link.arms.size();
}

template <int dim>
std::vector<std::int32_t> RigidLinks<dim>::nodes() const {
  std::vector<std::int32_t> nodes;
  for (const auto& link : links_) {
    for (const auto& arm : link.arms) {
      nodes.insert(nodes.end(), {arm.node, link.place, link.rotation});
    }
  }
  return nodes;
}

template <int dim>
double RigidLinks<dim>::add_internal(std::span<const double> u, std::span<double> f_int,
                                     BlockMatrix<dim>* K, std::int32_t first,
                                     std::span<const std::span<const double>> histories) const {
  constexpr int n = 3 * dim;
  double energy = 0;
  for (std::size_t l = 0; l < links_.size(); ++l) {
    const RigidLink<dim>& link = links_[l];
    const auto history = dim == 3 ? histories[l] : std::span<const double>();
    for (const auto& arm : link.arms) {
      const auto now = arm_forces<double, dim>(link, arm, u, history, length_);
      energy += now.energy;
      const std::array<std::int32_t, 3> nodes = {arm.node, link.place, link.rotation};
      for (int i = 0; i < n; ++i) {
        f_int[static_cast<std::size_t>(nodes[i / dim]) * dim + i % dim] += now.f[i];
      }
      if (K) {
        const auto slopes = arm_forces<Dual<n>, dim>(link, arm, u, history, length_);
        std::array<double, static_cast<std::size_t>(n) * n> K_arm;
        for (int i = 0; i < n; ++i) {
          std::ranges::copy(slopes.f[i].slope, K_arm.begin() + i * n);
        }
        K->add_cell(first, K_arm.data());
      }
      ++first;
    }
  }
  return energy;
}

template class RigidLinks<2>;
template class RigidLinks<3>;

}  // namespace gabion::fem
