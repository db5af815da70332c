// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/noise_damping.hpp"

#include <cmath>

#include "mpm_solver/grid/transfer.hpp"
#include "mpm_solver/points/flat.hpp"

namespace gabion::mpm {

namespace {

// r -= S R r.
template <int dim>
void subtract_seen(const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                   std::span<const double> m, double weightless, std::vector<Vector<dim>>& r) {
  std::vector<Vector<dim>> seen(nodes.m.size(), Vector<dim>::Zero());
  std::int32_t active[max_group_nodes<dim>];
  for (const CellGroup& group : weights.groups) {
    nodes.list_active(weights.nodes_of(group), active);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      const double* N = weights.N_of(e);
      const std::uint8_t* local = weights.local_of(e);
      for (int i = 0; i < weights.num_nodes(e); ++i) seen[active[local[i]]] += N[i] * m[p] * r[p];
    }
  }
  nodes.shared.sum(flat(seen), dim);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    seen[i] *= nodes.m[i] > weightless ? 1 / nodes.m[i] : 0;
  }
  for (const CellGroup& group : weights.groups) {
    nodes.list_active(weights.nodes_of(group), active);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      const double* N = weights.N_of(e);
      const std::uint8_t* local = weights.local_of(e);
      for (int i = 0; i < weights.num_nodes(e); ++i) r[p] -= N[i] * seen[active[local[i]]];
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
  const double weightless = weightless_mass(nodes);
  std::vector<Vector<dim>> noise = points.v;
  subtract_seen<dim>(weights, nodes, points.m, weightless, noise);
  for (std::int32_t p = 0; p < points.size(); ++p) noise[p] *= share[p];
  subtract_seen<dim>(weights, nodes, points.m, weightless, noise);
  for (std::int32_t p = 0; p < points.size(); ++p) points.v[p] -= noise[p];
}

template void damp_noise<2>(const PointWeights<2>&, const GridNodes<2>&, std::span<const double>,
                            MaterialPoints<2>&);
template void damp_noise<3>(const PointWeights<3>&, const GridNodes<3>&, std::span<const double>,
                            MaterialPoints<3>&);

}  // namespace gabion::mpm
