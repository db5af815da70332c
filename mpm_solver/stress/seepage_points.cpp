// SPDX-License-Identifier: BSD-3-Clause
// What points do at the pressure of their water, and what they get of a solution.
#include <cmath>

#include "mpm_solver/points/retention.hpp"
#include "mpm_solver/stress/seepage_group.hpp"

namespace gabion::mpm {

// What the water of a point does at its pressure. Mobility and held_slope are left to fill_pores().
template <int dim>
void SeepageForces<dim>::bear(const PoreWater& water, Work& point) {
  const double K_w = water.bulk_modulus;
  point.density = retention_at(water, point.p_n).filled;
  if (!gives_way(water)) {
    point.borne = point.p;
    point.borne_n = point.p_n;
    const double strain = (point.p - point.p_n) / K_w;
    point.borne_slope = point.kappa = 1;
    point.kappa_by_p = 0;
    point.change = std::expm1(strain);
    point.grown = std::exp(strain);
    return;
  }
  const Retention now = retention_at(water, point.p);
  point.borne = now.borne;
  point.borne_n = retention_at(water, point.p_n).borne;
  point.borne_slope = now.borne_slope;
  point.kappa = now.mobility;
  point.kappa_by_p = now.mobility_slope / now.mobility;
  point.grown = now.filled / point.density;
  point.change = (now.filled - point.density) / point.density;
  point.held_slope = now.filled_slope;
}

// Give the trial state of a point its pressure.
// @returns energy that its water got, by volume free of stress [J/m^3]
template <int dim>
double SeepageForces<dim>::give_water(std::int32_t body, std::int32_t e) {
  const PoreWater& water = *parts_.bodies[body].water;
  TrialPoints<dim>& trial = parts_.trial;
  const double borne = gives_way(water) ? retention_at(water, p_[e]).borne : p_[e];
  trial.pore_tau[e] = J_[e] * borne;
  trial.tau[e].template head<3>().array() -= trial.pore_tau[e];
  const std::int32_t p = parts_.weights.point[e];
  const double before = water.at(parts_.points.water[p], parts_.points.J[p]).energy;
  const double after = water.at(water.content_at(p_[e], J_[e]), J_[e]).energy;
  trial.energy[e] += after;
  return after - before;
}

template <int dim>
double SeepageForces<dim>::finish() {
  parts_.trial.pore_tau.resize(parts_.trial.tau.size(), 0.0);
  double gained = 0;
  for (const std::int32_t g : groups_) {
    const CellGroup& group = parts_.weights.groups[g];
    for (std::int32_t e = group.first; e < group.last; ++e) {
      gained += parts_.weights.volume[e] * give_water(group.body, e);
    }
  }
  return gained;
}

template <int dim>
double SeepageForces<dim>::finish(std::span<const double> du) {
  double lost = 0;
  for (std::size_t k = 0; k < f_.size(); ++k) lost -= 0.5 * f_[k] * du[k];
  lost += 0.5 * pool_work(du);
  parts_.trial.pore_tau.resize(parts_.trial.tau.size(), 0.0);
  std::array<double, max_group_nodes<dim> * dim> moves;
  for (const std::int32_t g : groups_) {
    const CellGroup& group = parts_.weights.groups[g];
    const PoreWater& water = *parts_.bodies[group.body].water;
    const bool limited = gives_way(water);
    parts_.nodes.gather(parts_.weights.nodes_of(group), du, moves.data());
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = parts_.weights.point[e];
      lost -= 0.5 * parts_.weights.volume[e] * parts_.points.J[p] *
              (limited ? retention_at(water, p_n_[e]).borne : p_n_[e]) *
              displacement_gradient<dim>(parts_.weights, e, moves.data()).trace();
      lost -= parts_.weights.volume[e] * give_water(group.body, e);
    }
  }
  return lost;
}

template <int dim>
void SeepageForces<dim>::store(MaterialPoints<dim>& points) const {
  for (const std::int32_t g : groups_) {
    const CellGroup& group = parts_.weights.groups[g];
    const PoreWater& water = *parts_.bodies[group.body].water;
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = parts_.weights.point[e];
      const double content = water.content_at(p_[e], J_[e]);
      points.m[p] += water.density * points.V0[p] * (content - points.water[p]);
      points.water[p] = content;
    }
  }
}

template void SeepageForces<2>::bear(const PoreWater&, Work&);
template void SeepageForces<3>::bear(const PoreWater&, Work&);
template double SeepageForces<2>::finish();
template double SeepageForces<3>::finish();
template double SeepageForces<2>::finish(std::span<const double>);
template double SeepageForces<3>::finish(std::span<const double>);
template void SeepageForces<2>::store(MaterialPoints<2>&) const;
template void SeepageForces<3>::store(MaterialPoints<3>&) const;

}  // namespace gabion::mpm
