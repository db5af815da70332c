// SPDX-License-Identifier: BSD-3-Clause
// Stiffness of a group from pore water that drains.
#include <algorithm>
#include <cmath>

#include "mpm_solver/stress/seepage_group.hpp"

namespace gabion::mpm {

// Add the terms of one point. Those by the pressure and the volume of a group are left to
// add_group_stiffness.
template <int dim>
void SeepageForces<dim>::add_point_stiffness(const CellGroup& group, const Work& point,
                                             Group& work) const {
  const auto& weights = parts_.weights;
  const PoreWater& water = *parts_.bodies[group.body].water;
  const double kappa = point.kappa, Vj = point.V * point.j;
  const double p = work.excess(point, step_.averages);
  const double storage = point.held_slope + point.V * tau_st_[group.body];
  const double by_volume = step_.averages ? 0 : point.density * Vj * point.grown;
  const int num = weights.num_nodes(point.entry), rows = group.num_nodes * block_size;
  const std::uint8_t* local = weights.local_of(point.entry);
  const double* N = weights.N_of(point.entry);
  for (int i = 0; i < num; ++i) {
    const Vector<dim>& g_i = point.g[i];
    const double g_w = g_i.dot(point.w);
    for (int k = 0; k < num; ++k) {
      const Vector<dim>& g_k = point.g[k];
      const double gg = kappa * g_i.dot(g_k), gw_k = g_k.dot(point.w);
      double* block = &work.K[static_cast<std::size_t>(local[i]) * block_size * rows +
                              static_cast<std::size_t>(local[k]) * block_size];
      double* volumes = block + static_cast<std::ptrdiff_t>(dim) * rows;
      for (int d = 0; d < dim; ++d) {
        for (int c = 0; c < dim; ++c) {
          block[d * rows + c] -= Vj * p * (g_i[d] * g_k[c] - g_k[d] * g_i[c]);
        }
        for (int c = 0; c < dim && !p_pool_.empty(); ++c) {
          block[d * rows + c] += Vj * N[i] * point.p_pool_slope[d] * g_k[c];
        }
        if (!step_.averages) block[d * rows + dim] -= Vj * point.borne_slope * N[k] * g_i[d];
        volumes[d] += step_.dt * Vj * (g_w * g_k[d] - gw_k * g_i[d] + gg * point.grad_p[d]) -
                      by_volume * N[i] * g_k[d];
      }
      volumes[dim] -= storage * N[i] * N[k] + step_.dt * Vj * gg;
      if (point.kappa_by_p != 0) volumes[dim] += step_.dt * Vj * g_w * point.kappa_by_p * N[k];
    }
  }
  if (water.kozeny_carman) add_mobility_stiffness(group, point, work);
}

// Add the change of the mobility with the volume (under F-bar that of the group).
template <int dim>
void SeepageForces<dim>::add_mobility_stiffness(const CellGroup& group, const Work& point,
                                                Group& work) const {
  const auto& weights = parts_.weights;
  const int num = weights.num_nodes(point.entry), rows = group.num_nodes * block_size;
  const std::uint8_t* local = weights.local_of(point.entry);
  for (int i = 0; i < num; ++i) {
    const double changed =
        step_.dt * point.V * point.j * point.g[i].dot(point.w) * point.kappa_slope;
    double* row = &work.K[(static_cast<std::size_t>(local[i]) * block_size + dim) * rows];
    for (int k = 0; k < (step_.averages ? group.num_nodes : num); ++k) {
      const Vector<dim> slope = step_.averages ? work.change[k] / work.Vj : point.g[k];
      double* block = row + (step_.averages ? k : local[k]) * block_size;
      for (int d = 0; d < dim; ++d) block[d] += changed * slope[d];
    }
  }
}

// Add the common terms of the points of a group: K_up, K_pu under F-bar and the mean pressure of
// the stabilisation.
template <int dim>
void SeepageForces<dim>::add_group_stiffness(const CellGroup& group, Group& work) const {
  const int n = group.num_nodes, rows = n * block_size;
  const double tau = tau_st_[group.body] * work.V, tie = tie_of_nodes(group) * work.V;
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      double* block = &work.K[static_cast<std::size_t>(i) * block_size * rows +
                              static_cast<std::size_t>(k) * block_size];
      double* volumes = block + static_cast<std::ptrdiff_t>(dim) * rows;
      volumes[dim] += tau * work.N[i] * work.N[k] - tie * ((i == k ? 1 : 0) - 1.0 / n);
      if (!step_.averages) continue;
      const double share = work.density * work.N[i] + work.compressed[i] / work.V;
      for (int d = 0; d < dim; ++d) {
        block[d * rows + dim] -= work.change[i][d] * work.borne_N[k];
        volumes[d] -= share * work.change[k][d];
      }
    }
  }
}

template <int dim>
void SeepageForces<dim>::add_stiffness(const CellGroup& group, Group& work) const {
  const std::size_t rows = static_cast<std::size_t>(group.num_nodes) * block_size;
  const auto& weights = parts_.weights;
  work.K.assign(rows * rows, 0.0);
  std::fill_n(work.compressed.begin(), group.num_nodes, 0.0);
  for (const Work& point : work.points) {
    add_point_stiffness(group, point, work);
    const double by_change = point.density * point.V * point.change;
    for (int i = 0; i < weights.num_nodes(point.entry); ++i) {
      work.compressed[weights.local_of(point.entry)[i]] += by_change * weights.N_of(point.entry)[i];
    }
  }
  add_group_stiffness(group, work);
}

template void SeepageForces<2>::add_stiffness(const CellGroup&, Group&) const;
template void SeepageForces<3>::add_stiffness(const CellGroup&, Group&) const;

}  // namespace gabion::mpm
