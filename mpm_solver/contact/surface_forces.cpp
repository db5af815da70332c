// SPDX-License-Identifier: BSD-3-Clause
// Forces on surfaces: of the soil, and of pools.
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/contact/pool_forces.hpp"
#include "mpm_solver/contact/surfaces.hpp"

namespace gabion::mpm {

template <int dim>
void Surfaces<dim>::place(std::size_t surface, std::span<const double> displacement) {
  contact_of(surface).set_displacement(displacement, member_of(surface));
  if (!pools_.empty()) displaced_[surface].assign(displacement.begin(), displacement.end());
}

// Forces of pools on a surface; empty: none press on it, or not on this rank.
template <int dim>
std::vector<double> Surfaces<dim>::pool_forces_on(std::size_t surface) const {
  if (pools_.empty() || dropped_[surface] != 0 || rank_of(comm_) != 0) return {};
  return pool_forces<dim>(pools_, settings(surface).surface, displaced_[surface]);
}

template <int dim>
InterfaceValues Surfaces<dim>::forces_on_structure() const {
  InterfaceValues forces;
  for (std::size_t k = 0; k < interfaces_.size(); ++k) {
    auto values = contact_of(k).results().forces_on_structure(member_of(k));
    const std::vector<double> of_pools = pool_forces_on(k);
    for (std::size_t i = 0; i < of_pools.size(); ++i) values[i] += of_pools[i];
    sum_over_ranks(comm_, std::span<double>(values));
    forces[interfaces_[k].name] = std::move(values);
  }
  return forces;
}

template <int dim>
std::vector<double> Surfaces<dim>::forces_on_walls() const {
  std::vector<double> values;
  for (std::size_t k = interfaces_.size(); k < size(); ++k) {
    ContactResultant<dim> sum = contact_of(k).results().resultant(member_of(k));
    const std::vector<double> of_pools = pool_forces_on(k);
    const auto& vertices = settings(k).surface.vertices;
    for (std::size_t i = 0; i < of_pools.size(); i += dim) {
      const Vector<dim> moved = Eigen::Map<const Vector<dim>>(displaced_[k].data() + i);
      sum.add(vertices[i / dim] + moved, Eigen::Map<const Vector<dim>>(of_pools.data() + i));
    }
    auto [force, moment] = sum;
    ContactResultant<dim> at_place;
    at_place.add(walls_[k - interfaces_.size()].moment_about, force);
    moment -= at_place.moment;
    values.insert(values.end(), force.data(), force.data() + force.size());
    values.insert(values.end(), moment.data(), moment.data() + moment.size());
  }
  sum_over_ranks(comm_, std::span<double>(values));
  return values;
}

template void Surfaces<2>::place(std::size_t, std::span<const double>);
template InterfaceValues Surfaces<2>::forces_on_structure() const;
template std::vector<double> Surfaces<2>::forces_on_walls() const;
template void Surfaces<3>::place(std::size_t, std::span<const double>);
template InterfaceValues Surfaces<3>::forces_on_structure() const;
template std::vector<double> Surfaces<3>::forces_on_walls() const;

}  // namespace gabion::mpm
