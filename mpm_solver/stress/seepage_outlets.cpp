// SPDX-License-Identifier: BSD-3-Clause
// The free surface, where pore water leaves the soil, or comes in from a pool.
#include <algorithm>

#include "mpm_solver/grid/surface_values.hpp"
#include "mpm_solver/stress/seepage_group.hpp"

namespace gabion::mpm {

namespace {

// Mobility of the surface over that of the soil, by a cell: the pressure goes to zero 1 / 50 of a
// cell outside of the surface.
constexpr double surface_mobility = 50;

}  // namespace

template <int dim>
void SeepageForces<dim>::open(const BackgroundGrid<dim>& grid,
                              std::span<const OuterPoint<dim>> surface) {
  outlets_.clear();
  const auto& weights = parts_.weights;
  std::vector<std::int32_t> number(parts_.points.size(), -1);
  for (std::size_t k = 0; k < surface.size(); ++k) {
    number[surface[k].point] = static_cast<std::int32_t>(k);
  }
  const double h = step_.cell_size;
  for (const std::int32_t g : groups_) {
    const CellGroup& group = weights.groups[g];
    const PoreWater& water = *parts_.bodies[group.body].water;
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      if (number[p] < 0) continue;
      const OuterPoint<dim>& at = surface[number[p]];
      Outlet outlet{.entry = e};
      const Vector<dim> place =
          parts_.points.x[p] +
          SurfaceValues<dim>(grid, parts_.points, p).at(-at.n, at.R, outlet.w.data());
      outlet.at_rest = at_rest(group.body, place);
      outlet.outside = step_.pools.template pressure<dim>(place);
      const double kappa = water.mobility() * water.mobility_ratio(parts_.points.J[p]);
      outlet.drained = surface_mobility * at.area / h * kappa * step_.dt;
      outlets_.push_back(outlet);
    }
  }
}

// Outlets of a group: volumes, and what they add to K_pp (`with_stiffness`).
template <int dim>
void SeepageForces<dim>::add_outflow(const CellGroup& group, Group& work, bool with_stiffness) {
  const auto& weights = parts_.weights;
  auto outlet = std::ranges::lower_bound(outlets_, group.first, {}, &Outlet::entry);
  for (; outlet != outlets_.end() && outlet->entry < group.last; ++outlet) {
    const int num = weights.num_nodes(outlet->entry), rows = group.num_nodes * block_size;
    const std::uint8_t* local = weights.local_of(outlet->entry);
    double p = outlet->at_rest;
    for (int i = 0; i < num; ++i) p += outlet->w[i] * work.q[local[i]];
    p -= outlet->outside;
    if (!(p > 0) && outlet->outside == 0) continue;  // air does not press water into the soil
    outflow_ += outlet->drained * p;
    inflow_work_ -= outlet->drained * p * outlet->outside;
    for (int i = 0; i < num; ++i) {
      const double of_node = outlet->drained * outlet->w[i];
      r_[work.active[local[i]]] += of_node * p;
      if (!with_stiffness) continue;
      double* row = &work.K[(static_cast<std::size_t>(local[i]) * block_size + dim) * rows];
      for (int k = 0; k < num; ++k) row[local[k] * block_size + dim] -= of_node * outlet->w[k];
    }
  }
}

template void SeepageForces<2>::open(const BackgroundGrid<2>&, std::span<const OuterPoint<2>>);
template void SeepageForces<3>::open(const BackgroundGrid<3>&, std::span<const OuterPoint<3>>);
template void SeepageForces<2>::add_outflow(const CellGroup&, Group&, bool);
template void SeepageForces<3>::add_outflow(const CellGroup&, Group&, bool);

}  // namespace gabion::mpm
