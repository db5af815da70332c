// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

template <int dim>
Surfaces<dim>::Surfaces(const std::vector<ContactSettings<dim>>& interfaces,
                        const std::vector<RigidWallSettings<dim>>& walls)
    : interfaces_(interfaces), walls_(walls) {
  for (const auto& settings : interfaces_) contacts_.push_back(make_contact(settings));
  for (const auto& wall : walls_) contacts_.push_back(make_contact(wall.boundary));
}

template <int dim>
std::vector<InterfaceMesh> Surfaces<dim>::interface_meshes() const {
  std::vector<InterfaceMesh> meshes;
  for (const auto& settings : interfaces_) meshes.push_back(interface_mesh(settings));
  return meshes;
}

template <int dim>
void Surfaces<dim>::begin_step(const SoilSurface<dim>& soil) {
  for (const auto& contact : contacts_) contact->begin_step(soil);
}

template <int dim>
bool Surfaces<dim>::symmetric() const {
  return std::all_of(contacts_.begin(), contacts_.end(),
                     [](const auto& contact) { return contact->symmetric(); });
}

template <int dim>
void Surfaces<dim>::receive(const InterfaceValues& displacements) {
  for (std::size_t k = 0; k < interfaces_.size(); ++k) {
    const auto found = displacements.find(interfaces_[k].name);
    if (found != displacements.end()) {
      contacts_[k]->set_displacement(found->second);
    } else {
      contacts_[k]->set_displacement(
          std::vector<double>(interfaces_[k].surface.vertices.size() * dim));
    }
  }
}

template <int dim>
void Surfaces<dim>::move_walls(double time) {
  for (std::size_t k = 0; k < walls_.size(); ++k) {
    const auto& wall = walls_[k];
    contacts_[interfaces_.size() + k]->set_displacement(
        wall.motion.displacement(wall.boundary.surface.vertices, time));
  }
}

template <int dim>
InterfaceValues Surfaces<dim>::forces_on_structure() const {
  InterfaceValues forces;
  for (std::size_t k = 0; k < interfaces_.size(); ++k) {
    forces[interfaces_[k].name] = contacts_[k]->forces_on_structure();
  }
  return forces;
}

template <int dim>
void Surfaces<dim>::report(StepReport& report) const {
  report.interface_active = false;
  ContactCounts all;
  for (std::size_t k = 0; k < interfaces_.size(); ++k) {
    report.interface_active |= contacts_[k]->can_touch();
    const ContactCounts counts = contacts_[k]->counts();
    all.closed += counts.closed;
    all.sliding += counts.sliding;
    all.penetration = std::max(all.penetration, counts.penetration);
  }
  const auto add = [&](const std::string& prefix, const ContactCounts& counts) {
    report.details[prefix + "closed_points"] = counts.closed;
    report.details[prefix + "sliding_points"] = counts.sliding;
    report.details[prefix + "max_penetration"] = counts.penetration;
  };
  if (!interfaces_.empty()) add("", all);
  for (std::size_t k = 0; k < walls_.size(); ++k) {
    add(walls_[k].name + ".", contacts_[interfaces_.size() + k]->counts());
  }
}

template <int dim>
std::vector<double> Surfaces<dim>::forces_on_walls(MPI_Comm comm) const {
  std::vector<double> values;
  for (std::size_t k = interfaces_.size(); k < contacts_.size(); ++k) {
    const auto [force, moment] = contacts_[k]->resultant();
    values.insert(values.end(), force.data(), force.data() + force.size());
    values.insert(values.end(), moment.data(), moment.data() + moment.size());
  }
  sum_over_ranks(comm, std::span<double>(values));  // the first rank has the contact
  return values;
}

template <int dim>
double Surfaces<dim>::approach_step(MPI_Comm comm, double step, double margin) const {
  double dt = std::numeric_limits<double>::infinity();
  if (rank_of(comm) == 0) {  // the first rank has the contact
    for (const auto& contact : contacts_) dt = std::min(dt, contact->approach_step(step, margin));
  }
  return -max_over_ranks(comm, -dt);
}

template <int dim>
void Surfaces<dim>::accept() {
  for (const auto& contact : contacts_) contact->accept();
}

template <int dim>
void Surfaces<dim>::visit_state(StateVisitor& visitor) {
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    contacts_[k]->visit_state(visitor, fmt::format("boundary_{}.", k));
  }
}

template class Surfaces<2>;
template class Surfaces<3>;

}  // namespace gabion::mpm
