// SPDX-License-Identifier: BSD-3-Clause
// The free surface, where pore water leaves the soil, or comes in from a pool.
#include <algorithm>
#include <cmath>

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
      if (outlet.outside == 0) {
        outlet.rain =
            std::max(0.0, at.n.dot(-step_.rain)) * surface_area<dim>(parts_.points, at) * step_.dt;
        double p_start = outlet.at_rest;
        const std::int32_t* active = parts_.nodes.of_groups.data() + group.first_node;
        for (int i = 0; i < weights.num_nodes(e); ++i) {
          p_start += outlet.w[i] * q_start_[active[weights.local_of(e)[i]]];
        }
        outlet.full = outlet.drained * p_start > -outlet.rain;
      }
      outlets_.push_back(outlet);
    }
  }
}

// Whether the flow through an outlet follows the pressure. Air does not press water into the soil,
// and soil takes rain only until it is full, with the pressure of air there.
// @param volume  that by the difference of the pressures; of what leaves [m^3]
template <int dim>
bool SeepageForces<dim>::follows_pressure(const Outlet& outlet, double& volume) {
  if (outlet.outside != 0) {
    outflow_ += volume;
    leaving_ += std::max(0.0, volume);
    inflow_work_ -= volume * outlet.outside;
    return true;
  }
  const bool follows = hold_ || outlet.rain > 0 ? outlet.full : volume > 0;
  if (!follows) volume = -outlet.rain;
  outflow_ += std::max(0.0, volume);
  leaving_ += std::max(0.0, volume);
  const double taken = std::max(0.0, -volume);
  rain_in_ += taken;
  rain_run_off_ += outlet.rain - taken;
  return follows;
}

template <int dim>
bool SeepageForces<dim>::update_outlets() {
  if (step_.rain.isZero(0) && !hold_) return false;
  bool changed = false;
  for (Outlet& outlet : outlets_) {
    if (outlet.outside != 0 || !(hold_ || outlet.rain > 0)) continue;
    const bool full = outlet.at_pressure > -outlet.rain;
    changed = changed || full != outlet.full;
    outlet.full = full;
  }
  return parts_.nodes.shared.largest(changed ? 1 : 0) > 0;
}

// Add the outlets of a group: volumes, and their terms in K_pp (`with_stiffness`).
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
    double volume = outlet->at_pressure = outlet->drained * p;
    const bool follows = follows_pressure(*outlet, volume);
    outlet->follows = follows;
    if (with_stiffness) outlet->in_K = follows;
    if (!follows && volume == 0) continue;
    for (int i = 0; i < num; ++i) {
      const double of_node = outlet->drained * outlet->w[i];
      r_[work.active[local[i]]] += follows ? of_node * p : outlet->w[i] * volume;
      left_[work.active[local[i]]] += follows ? of_node * p : outlet->w[i] * volume;
      if (!with_stiffness || !follows) continue;
      double* row = &work.K[(static_cast<std::size_t>(local[i]) * block_size + dim) * rows];
      for (int k = 0; k < num; ++k) row[local[k] * block_size + dim] -= of_node * outlet->w[k];
    }
  }
}

template <int dim>
std::vector<OutletChange> SeepageForces<dim>::take_outlet_changes() {
  std::vector<OutletChange> changes;
  for (Outlet& outlet : outlets_) {
    if (outlet.follows == outlet.in_K) continue;
    outlet.in_K = outlet.follows;
    changes.push_back(
        {outlet.entry, outlet.w.data(), outlet.follows ? outlet.drained : -outlet.drained});
  }
  return changes;
}

template std::vector<OutletChange> SeepageForces<2>::take_outlet_changes();
template std::vector<OutletChange> SeepageForces<3>::take_outlet_changes();
template void SeepageForces<2>::open(const BackgroundGrid<2>&, std::span<const OuterPoint<2>>);
template void SeepageForces<3>::open(const BackgroundGrid<3>&, std::span<const OuterPoint<3>>);
template bool SeepageForces<2>::update_outlets();
template bool SeepageForces<3>::update_outlets();
template void SeepageForces<2>::add_outflow(const CellGroup&, Group&, bool);
template void SeepageForces<3>::add_outflow(const CellGroup&, Group&, bool);

}  // namespace gabion::mpm
