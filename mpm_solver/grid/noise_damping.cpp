// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/noise_damping.hpp"

#include <cmath>

#include "mpm_solver/grid/group_vectors.hpp"
#include "mpm_solver/grid/transfer.hpp"

namespace gabion::mpm {

namespace {

// R r, num_nodes x dim.
template <int dim>
std::vector<double> mean_at_nodes(const MaterialPoints<dim>& points,
                                  const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                                  std::span<const Vector<dim>> r) {
  const double weightless = weightless_mass(nodes);
  std::vector<double> mean = point_forces<dim>(points, weights, nodes, r);
  for (std::size_t k = 0; k < mean.size(); ++k) {
    const double m = nodes.m[k / dim];
    mean[k] *= m > weightless ? 1 / m : 0;
  }
  return mean;
}

// Kirchhoff stresses of the points beyond the pressure of pools [Pa].
template <int dim>
std::vector<Symmetric<dim>> stresses_in_pools(const MaterialPoints<dim>& points,
                                              std::span<const double> pool_pressures) {
  std::vector<Symmetric<dim>> tau = points.tau;
  for (std::size_t p = 0; p < tau.size(); ++p) {
    tau[p].template head<3>().array() += points.J[p] * pool_pressures[p];
  }
  return tau;
}

// damp_noise() by the stresses tau of the points. @tparam n  see EntryValues
template <int dim, int n>
void damp(const PointWeights<dim>& weights, const GridNodes<dim>& nodes, const NoiseDamping& rate,
          std::span<const Symmetric<dim>> tau, MaterialPoints<dim>& points) {
  const std::vector<double> v = mean_at_nodes<dim>(points, weights, nodes, points.v);
  std::vector<Vector<dim>> noise(points.v.size());
  GroupVectors<dim, n> mean;
  for (const CellGroup& group : weights.groups) {
    mean.gather(nodes, weights.nodes_of(group), v);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      const double c2 = tau[p].norm() * points.V0[p] / points.m[p];
      const double grad2 =
          mean.squared_gradient(weights, weights.constant_gradient ? group.first : e);
      noise[p] = rate.share(c2, grad2) * (points.v[p] - mean.at_point(weights, e));
    }
  }
  const std::vector<double> seen = mean_at_nodes<dim>(points, weights, nodes, noise);
  for (const CellGroup& group : weights.groups) {
    mean.gather(nodes, weights.nodes_of(group), seen);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      points.v[p] -= noise[p] - mean.at_point(weights, e);
    }
  }
}

}  // namespace

double NoiseDamping::share(double c2, double grad2) const {
  if (c2 == 0) return 0;
  const double h2 = cell_size * cell_size;
  const double flow2 = c2 * inertial_number_of_flow * inertial_number_of_flow;
  const double slow_down = flow2 / (flow2 + h2 * grad2);
  return -std::expm1(-damping * dt / cell_size * std::sqrt(c2) * slow_down);
}

template <int dim>
void damp_noise(const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                const NoiseDamping& rate, MaterialPoints<dim>& points) {
  std::vector<Symmetric<dim>> in_pools;
  if (!rate.pool_pressures.empty()) in_pools = stresses_in_pools(points, rate.pool_pressures);
  const std::span<const Symmetric<dim>> tau = in_pools.empty() ? points.tau : in_pools;
  with_num_nodes(weights, [&]<int n>() { damp<dim, n>(weights, nodes, rate, tau, points); });
}

template void damp_noise<2>(const PointWeights<2>&, const GridNodes<2>&, const NoiseDamping&,
                            MaterialPoints<2>&);
template void damp_noise<3>(const PointWeights<3>&, const GridNodes<3>&, const NoiseDamping&,
                            MaterialPoints<3>&);

}  // namespace gabion::mpm
