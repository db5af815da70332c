// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/contact/dropped_contact.hpp"
#include "mpm_solver/contact/facet_contact.hpp"
#include "mpm_solver/contact/group_contact.hpp"
#include "mpm_solver/contact/soil_extent.hpp"

namespace gabion::mpm {

namespace {

// A rim that is nearer to a surface than this share of the cell size meets it.
constexpr double seam_share = 0.02;

template <int dim>
bool any_by_facets(const Contacts<dim>& contacts) {
  return std::ranges::any_of(contacts, [](const auto& contact) {
    return dynamic_cast<const FacetContact<dim>*>(contact.get()) != nullptr;
  });
}

}  // namespace

template <int dim>
Surfaces<dim>::Surfaces(MPI_Comm comm, const std::vector<ContactSettings<dim>>& interfaces,
                        const std::vector<RigidWallSettings<dim>>& walls, double cell_size)
    : comm_(comm), interfaces_(interfaces), walls_(walls) {
  const std::size_t count = interfaces_.size() + walls_.size();
  std::vector<std::size_t> by_facets;
  std::vector<PlacedSurface<dim>> at_start;
  for (std::size_t k = 0; k < count; ++k) {
    if (!std::holds_alternative<FacetSettings>(settings(k).method)) continue;
    if (k >= interfaces_.size() && walls_[k - interfaces_.size()].is_boulder) continue;
    by_facets.push_back(k);
    at_start.push_back(placed(k));
  }
  std::vector<std::size_t> first(count);  // of the surfaces of the same contact
  std::iota(first.begin(), first.end(), 0);
  const auto joint = joint_surfaces<dim>(at_start, seam_share * cell_size);
  for (std::size_t k = 0; k < joint.size(); ++k) first[by_facets[k]] = by_facets[joint[k]];
  for (std::size_t k = 0; k < count; ++k) {
    if (first[k] != k) {
      places_.push_back({places_[first[k]].contact, 0});
      for (std::size_t j = first[k]; j < k; ++j) places_[k].member += first[j] == first[k] ? 1 : 0;
      continue;
    }
    places_.push_back({contacts_.size(), 0});
    std::vector<const ContactSettings<dim>*> members;
    for (std::size_t j = k; j < count; ++j) {
      if (first[j] == k) members.push_back(&settings(j));
    }
    contacts_.push_back(members.size() > 1 ? make_joint_contact(members)
                                           : make_contact(settings(k)));
  }
  touching_.assign(places_.size(), 0);
  dropped_.assign(places_.size(), 0);
  displaced_.resize(places_.size());
}

template <int dim>
void Surfaces<dim>::add_groups(const BodyGroups& groups, std::int32_t num_places) {
  auto contact = std::make_unique<GroupContact<dim>>(groups, num_places);
  groups_ = &groups;
  between_groups_ = contact.get();
  contacts_.push_back(std::move(contact));
}

template <int dim>
std::vector<Vector<dim>> Surfaces<dim>::forces_between_groups() const {
  return between_groups_ != nullptr ? between_groups_->forces() : std::vector<Vector<dim>>();
}

template <int dim>
PlacedSurface<dim> Surfaces<dim>::placed(std::size_t surface) const {
  const ContactSurface<dim>& mesh = settings(surface).surface;
  PlacedSurface<dim> result{.simplices = simplices(mesh), .vertices = mesh.vertices};
  if (surface < interfaces_.size()) return result;
  const auto& motion = walls_[surface - interfaces_.size()].motion;
  const auto moved = motion.displacement(mesh.vertices, 0);
  for (std::size_t v = 0; v < result.vertices.size(); ++v) {
    result.vertices[v] += Eigen::Map<const Vector<dim>>(moved.data() + v * dim);
  }
  return result;
}

template <int dim>
void Surfaces<dim>::drop(std::size_t surface) {
  const auto [contact, member] = places_[surface];
  dropped_[surface] = 1;
  if (contacts_[contact]->drop(member, true)) return;
  const ContactEnergy energy = contacts_[contact]->state().energy();
  contacts_[contact] = std::make_unique<DroppedContact<dim>>(settings(surface), energy);
}

template <int dim>
void Surfaces<dim>::take_back(std::size_t surface) {
  const auto [contact, member] = places_[surface];
  dropped_[surface] = 0;
  if (contacts_[contact]->drop(member, false)) return;
  contacts_[contact] = make_contact(settings(surface));
}

template <int dim>
void Surfaces<dim>::drop_all() {
  for (std::size_t k = 0; k < places_.size(); ++k) {
    if (dropped_[k] == 0) drop(k);
  }
  if (between_groups_ != nullptr) between_groups_->drop(0, true);
  std::fill(touching_.begin(), touching_.end(), 0);
  symmetric_ = true;
}

template <int dim>
void Surfaces<dim>::keep_walls(std::span<const std::string> names) {
  for (std::size_t k = 0; k < walls_.size(); ++k) {
    const std::size_t surface = interfaces_.size() + k;
    const bool named = std::find(names.begin(), names.end(), walls_[k].name) != names.end();
    if (named || walls_[k].is_boulder || dropped_[surface] != 0) continue;
    drop(surface);
    log::info("rigid wall \"{}\" is dropped", walls_[k].name);
  }
}

template <int dim>
std::vector<InterfaceMesh> Surfaces<dim>::interface_meshes() const {
  std::vector<InterfaceMesh> meshes;
  for (const auto& settings : interfaces_) meshes.push_back(interface_mesh(settings));
  return meshes;
}

template <int dim>
const ContactSettings<dim>& Surfaces<dim>::settings(std::size_t surface) const {
  const bool wall = surface >= interfaces_.size();
  return wall ? walls_[surface - interfaces_.size()].boundary : interfaces_[surface];
}

template <int dim>
std::span<const Vector<dim>> Surfaces<dim>::accepted_vertices(std::size_t surface) const {
  return contact_of(surface).state().accepted_vertices(member_of(surface));
}

template <int dim>
bool Surfaces<dim>::asks_for_cells() const {
  return std::any_of(contacts_.begin(), contacts_.end(),
                     [](const auto& contact) { return contact->asks_for_cells(); });
}

template <int dim>
std::vector<std::int32_t> Surfaces<dim>::find_nodes(const SoilSurface<dim>& soil) {
  std::vector<std::int32_t> nodes;
  for (const auto& contact : contacts_) {
    const std::vector<std::int32_t> own = contact->find_nodes(soil);
    nodes.insert(nodes.end(), own.begin(), own.end());
  }
  return nodes;
}

template <int dim>
void Surfaces<dim>::begin_step(const SoilSurface<dim>& soil) {
  std::vector<std::int32_t> touching;
  SoilSurface<dim> shared = soil;
  if (any_by_facets<dim>(contacts_)) shared.extent = std::make_shared<SoilExtent<dim>>(soil);
  for (const auto& contact : contacts_) contact->begin_step(shared);
  for (std::size_t k = 0; k < size(); ++k) {
    touching.push_back(contact_of(k).can_touch(member_of(k)) ? 1 : 0);
  }
  sum_over_ranks(comm_, std::span<std::int32_t>(touching));
  symmetric_ = true;
  for (std::size_t k = 0; k < size(); ++k) {
    touching_[k] = touching[k] > 0;
    symmetric_ &= !touching_[k] || contact_of(k).assembly().symmetric();
  }
  if (between_groups_ != nullptr) {
    symmetric_ &= max_over_ranks(comm_, between_groups_->symmetric() ? 0 : 1) == 0;
  }
}

template <int dim>
bool Surfaces<dim>::may_touch_interface() const {
  const auto end = touching_.begin() + std::ssize(interfaces_);
  return std::find_if(touching_.begin(), end, [](char touches) { return touches != 0; }) != end;
}

template <int dim>
void Surfaces<dim>::mark_touched(std::span<char> nodes) const {
  for (std::size_t k = 0; k < interfaces_.size(); ++k) {
    contact_of(k).assembly().mark_touched(nodes, member_of(k));
  }
}

template <int dim>
void Surfaces<dim>::receive(const InterfaceValues& displacements) {
  for (std::size_t k = 0; k < interfaces_.size(); ++k) {
    const auto found = displacements.find(interfaces_[k].name);
    if (found != displacements.end()) {
      place(k, found->second);
    } else {
      place(k, std::vector<double>(interfaces_[k].surface.vertices.size() * dim));
    }
  }
}

template <int dim>
void Surfaces<dim>::move_walls(double time) {
  for (std::size_t k = 0; k < walls_.size(); ++k) {
    const auto& wall = walls_[k];
    if (wall.is_boulder) continue;
    const std::size_t surface = interfaces_.size() + k;
    place(surface, wall.motion.displacement(wall.boundary.surface.vertices, time));
  }
}

template <int dim>
void Surfaces<dim>::move_wall(std::size_t wall, std::span<const double> displacement) {
  place(interfaces_.size() + wall, displacement);
}

template <int dim>
bool Surfaces<dim>::look_ahead() const {
  for (std::size_t k = 0; k < size(); ++k) {
    if (std::isfinite(contact_of(k).allowed_motion(member_of(k)))) return true;
  }
  return false;
}

template <int dim>
void Surfaces<dim>::refuse_misses(double largest) const {
  for (std::size_t k = 0; k < size(); ++k) {
    const double allowed = contact_of(k).allowed_motion(member_of(k));
    if (max_over_ranks(comm_, largest > allowed ? 1 : 0) == 0) continue;
    throw ConvergenceError(
        fmt::format("soil and \"{}\" move too far in one step for the search of contacts",
                    settings(k).name),
        "contact");
  }
}

template <int dim>
ContactCounts Surfaces<dim>::counts(std::size_t surface) const {
  ContactCounts counts = contact_of(surface).results().counts(member_of(surface));
  std::int32_t sums[] = {counts.closed, counts.sliding};
  sum_over_ranks(comm_, std::span<std::int32_t>(sums));
  counts.closed = sums[0];
  counts.sliding = sums[1];
  counts.penetration = max_over_ranks(comm_, counts.penetration);
  return counts;
}

template <int dim>
void Surfaces<dim>::report(StepReport& report) const {
  report.interface_active = false;
  ContactCounts all;
  for (std::size_t k = 0; k < interfaces_.size(); ++k) {
    const ContactCounts own = counts(k);
    const bool in_water = !pools_.empty() && dropped_[k] == 0;
    report.interface_active |= touching_[k] || own.closed > 0 || in_water;
    all.closed += own.closed;
    all.sliding += own.sliding;
    all.penetration = std::max(all.penetration, own.penetration);
  }
  const auto add = [&](const std::string& prefix, const ContactCounts& counts) {
    report.details[prefix + "closed_points"] = counts.closed;
    report.details[prefix + "sliding_points"] = counts.sliding;
    report.details[prefix + "max_penetration"] = counts.penetration;
  };
  if (!interfaces_.empty()) add("", all);
  for (std::size_t k = 0; k < walls_.size(); ++k) {
    add(walls_[k].name + ".", counts(interfaces_.size() + k));
  }
  for (std::size_t k = 0; groups_ != nullptr && k < groups_->pairs.size(); ++k) {
    add("contact." + groups_->text_of(k) + ".", between_groups_->counts(k));
  }
}

template <int dim>
double Surfaces<dim>::approach_step(double step, double margin) const {
  double dt = std::numeric_limits<double>::infinity();
  for (const auto& contact : contacts_) dt = std::min(dt, contact->approach_step(step, margin));
  return -max_over_ranks(comm_, -dt);
}

template <int dim>
ContactEnergy Surfaces<dim>::energy() const {
  double sums[3] = {};
  for (const auto& contact : contacts_) {
    const ContactEnergy own = contact->state().energy();
    sums[0] += own.stored;
    sums[1] += own.friction;
    sums[2] += own.loss;
  }
  sum_over_ranks(comm_, std::span<double>(sums));
  return {.stored = sums[0], .friction = sums[1], .loss = sums[2]};
}

template <int dim>
Vector<dim> Surfaces<dim>::step_force_on(std::span<const std::int64_t> ids) const {
  Vector<dim> sum = Vector<dim>::Zero();
  for (const auto& contact : contacts_) sum += contact->assembly().step_force_on(ids);
  return sum;
}

template <int dim>
ContactFields<dim> Surfaces<dim>::fields(std::size_t surface, const MaterialPoints<dim>& points,
                                         double reach) const {
  ContactFields<dim> fields = contact_of(surface).state().fields(points, reach, member_of(surface));
  sum_over_ranks<dim>(comm_, std::span(fields.force));
  sum_over_ranks<dim>(comm_, std::span(fields.slip));
  sum_over_ranks(comm_, std::span(fields.area));
  max_over_ranks(comm_, std::span(fields.status));
  for (double& gap : fields.gap) gap = -gap;
  max_over_ranks(comm_, std::span(fields.gap));
  for (double& gap : fields.gap) gap = -gap;
  return fields;
}

template <int dim>
void Surfaces<dim>::begin_at_rest(const SoilAtRest<dim>& rest) {
  for (const auto& contact : contacts_) contact->state().begin_at_rest(rest);
}

template <int dim>
void Surfaces<dim>::accept() {
  for (const auto& contact : contacts_) contact->accept();
}

template <int dim>
void Surfaces<dim>::give(std::span<const std::int64_t> ids, Packet& packet) {
  for (const auto& contact : contacts_) contact->state().give(ids, packet);
}

template <int dim>
void Surfaces<dim>::take(Packet& packet) {
  for (const auto& contact : contacts_) contact->state().take(packet);
}

template <int dim>
void Surfaces<dim>::visit_state(StateVisitor& visitor) {
  std::vector<std::int32_t> dropped = dropped_;
  visitor.integers("dropped_surfaces", std::span<std::int32_t>(dropped));
  for (std::size_t k = 0; k < places_.size(); ++k) {
    if (dropped[k] != 0 && dropped_[k] == 0) drop(k);
    if (dropped[k] == 0 && dropped_[k] != 0) take_back(k);
  }
  bool has_groups = groups_ != nullptr;
  visitor.flag("contact_groups", has_groups);
  require(has_groups == (groups_ != nullptr),
          "saved state: found a run {} contact_groups, allowed: the groups of this run",
          has_groups ? "with" : "without");
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    contacts_[k]->state().visit_state(visitor, fmt::format("boundary_{}.", k));
  }
}

template class Surfaces<2>;
template class Surfaces<3>;

}  // namespace gabion::mpm
