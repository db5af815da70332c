// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/end_of_step.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "mpm_solver/step/largest_part.hpp"

namespace gabion::mpm {

namespace {

// Share of the mass that may be stray points, whose error does not decide the step.
constexpr double stray_share = 0.01;

}  // namespace

template <int dim>
NodalMotion<dim> nodal_motion(const Equilibrium<dim>& equilibrium, std::span<const double> du) {
  const auto& parts = equilibrium.parts();
  const NewmarkBossak& scheme = parts.scheme;
  const std::size_t n = parts.nodes.grid_node.size();
  const auto& m = equilibrium.inertia_mass();
  const auto& v = equilibrium.start_velocity();
  const auto& a = equilibrium.start_acceleration();
  std::vector<double> jump = equilibrium.step_force_change();  // of acceleration
  if (parts.with_inertia && !jump.empty()) {
    for (std::size_t k = 0; k < jump.size(); ++k) jump[k] /= m[k / dim];
    parts.walls.project(jump);
  }
  NodalMotion<dim> motion;
  motion.du.resize(n);
  motion.v_new.assign(n, Vector<dim>::Zero());
  motion.a_new.assign(n, Vector<dim>::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    for (int d = 0; d < dim; ++d) {
      const std::size_t k = i * dim + d;
      motion.du[i][d] = du[k];
      if (!parts.with_inertia) continue;
      motion.a_new[i][d] = scheme.acceleration(du[k], v[k], a[k], parts.dt);
      motion.v_new[i][d] = scheme.velocity(motion.a_new[i][d], v[k], a[k], parts.dt);
      if (jump.empty()) continue;
      motion.v_new[i][d] += parts.dt * scheme.step_force_velocity() * jump[k];
      motion.a_new[i][d] -= scheme.step_force_acceleration() * jump[k];
    }
  }
  return motion;
}

template <int dim>
StepError step_error(const Equilibrium<dim>& equilibrium, const NodalMotion<dim>& motion,
                     std::span<const char> touched) {
  const auto& m = equilibrium.inertia_mass();
  const auto& a = equilibrium.start_acceleration();
  const SharedNodes& shared = equilibrium.shared();
  double sums[4] = {};
  auto& [mass, free_mass, squared_jump, squared_speed] = sums;
  std::vector<MassValue> free;
  for (std::size_t i = 0; i < m.size(); ++i) {
    if (!shared.owns(static_cast<std::int32_t>(i))) continue;
    mass += m[i];
    squared_speed += m[i] * motion.v_new[i].squaredNorm();
    const Eigen::Map<const Vector<dim>> a_i(&a[i * dim]);
    const double squared = (motion.a_new[i] - a_i).squaredNorm();
    if (touched[i] != 0) {
      squared_jump += m[i] * squared;
    } else {
      free.push_back({squared, m[i]});
      free_mass += m[i];
    }
  }
  shared.total(sums);
  const double left_out = std::min(stray_share * mass, free_mass);
  squared_jump += sum_without_largest(shared, std::move(free), left_out);
  const auto& parts = equilibrium.parts();
  const double factor = std::abs(1.0 / 6 - parts.scheme.beta) * parts.dt * parts.dt;
  return {factor * std::sqrt(squared_jump / (mass - left_out)), std::sqrt(squared_speed / mass)};
}

template NodalMotion<2> nodal_motion<2>(const Equilibrium<2>&, std::span<const double>);
template NodalMotion<3> nodal_motion<3>(const Equilibrium<3>&, std::span<const double>);
template StepError step_error<2>(const Equilibrium<2>&, const NodalMotion<2>&,
                                 std::span<const char>);
template StepError step_error<3>(const Equilibrium<3>&, const NodalMotion<3>&,
                                 std::span<const char>);

}  // namespace gabion::mpm
