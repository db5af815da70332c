// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/noise_damping.hpp"

#include <cmath>

#include "mpm_solver/grid/transfer.hpp"

namespace gabion::mpm {

namespace {

// r -= S R r.
template <int dim>
void subtract_seen(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
                   const GridNodes<dim>& nodes, std::vector<Vector<dim>>& r) {
  const double weightless = weightless_mass(nodes);
  std::vector<double> seen = point_forces<dim>(points, weights, nodes, r);
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const double m = nodes.m[k / dim];
    seen[k] *= m > weightless ? 1 / m : 0;
  }
  std::int32_t active[max_group_nodes<dim>];
  for (const CellGroup& group : weights.groups) {
    nodes.list_active(weights.nodes_of(group), active);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const double* N = weights.N_of(e);
      const std::uint8_t* local = weights.local_of(e);
      for (int i = 0; i < weights.num_nodes(e); ++i) {
        const double* seen_i = seen.data() + std::ptrdiff_t{active[local[i]]} * dim;
        r[weights.point[e]] -= N[i] * Eigen::Map<const Vector<dim>>(seen_i);
      }
    }
  }
}

}  // namespace

double damped_share(double damping, double crossings) {
  return 1 - std::pow(1 - damping, crossings);
}

template <int dim>
void damp_noise(const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                std::span<const double> share, MaterialPoints<dim>& points) {
  std::vector<Vector<dim>> noise = points.v;
  subtract_seen(points, weights, nodes, noise);
  for (std::int32_t p = 0; p < points.size(); ++p) noise[p] *= share[p];
  subtract_seen(points, weights, nodes, noise);
  for (std::int32_t p = 0; p < points.size(); ++p) points.v[p] -= noise[p];
}

template void damp_noise<2>(const PointWeights<2>&, const GridNodes<2>&, std::span<const double>,
                            MaterialPoints<2>&);
template void damp_noise<3>(const PointWeights<3>&, const GridNodes<3>&, std::span<const double>,
                            MaterialPoints<3>&);

}  // namespace gabion::mpm
