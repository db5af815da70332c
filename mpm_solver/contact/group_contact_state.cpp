// SPDX-License-Identifier: BSD-3-Clause
// Results of a contact between groups of bodies, and its accepted state.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/contact/group_contact.hpp"
#include "mpm_solver/points/flat.hpp"

namespace gabion::mpm {

namespace {

// Groups and pairs of a run, for its saved state.
Json fact_of(const BodyGroups& groups) {
  Json pairs = Json::array();
  for (const GroupPair& pair : groups.pairs) pairs.push_back({pair.first, pair.second});
  return {{"names", groups.names}, {"of_body", groups.of_body}, {"pairs", pairs}};
}

}  // namespace

template <int dim>
void GroupContact<dim>::begin_substeps() {
  has_substeps_ = true;
  normal_work_ = tangential_work_ = 0;
  std::ranges::fill(resultants_, Vector<dim>::Zero());
}

template <int dim>
void GroupContact<dim>::add_substep(std::span<const double> move, double share) {
  const auto at = [&](std::int32_t i) {
    return Eigen::Map<const Vector<dim>>(move.data() + std::ptrdiff_t{i} * dim);
  };
  for (const ContactNode& contact : contacts_) {
    const Vector<dim> path = at(contact.node.second) - at(contact.node.first);
    const Vector<dim>& n = contact.node.n;
    const double normal = n.dot(contact.force) * n.dot(path);
    normal_work_ -= normal;
    tangential_work_ -= contact.force.dot(path) - normal;
    resultants_[contact.node.pair] += share * contact.force;
  }
}

template <int dim>
void GroupContact<dim>::add_stiffness_sums(std::span<double> sums) const {
  for (const ContactNode& contact : contacts_) {
    if (contact.gap >= 0) continue;
    const ContactLaw law = law_of(contact);
    const double tangential = law.mode == ContactMode::contact ? law.tangential_penalty : 0;
    const double k = contact.node.area * std::max(-2 * law.penalty * contact.gap, tangential);
    sums[contact.node.first] += 2 * k;
    sums[contact.node.second] += 2 * k;
  }
}

template <int dim>
double GroupContact<dim>::work_on_soil(std::span<const double>) const {
  double work = 0;
  for (const ContactNode& contact : contacts_) work += contact.force.dot(contact.path);
  return work;
}

template <int dim>
ContactCounts GroupContact<dim>::counts(std::size_t pair) const {
  ContactCounts counts;
  for (const ContactNode& contact : contacts_) {
    if (contact.node.pair != static_cast<std::int32_t>(pair) || contact.gap >= 0) continue;
    ++counts.closed;
    counts.sliding += contact.traction.sliding ? 1 : 0;
    counts.penetration = std::max(counts.penetration, -contact.gap);
  }
  return counts;
}

template <int dim>
double GroupContact<dim>::approach_step(double dt, double margin) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const ContactNode& contact : contacts_) {
    const double closing = -contact.node.n.dot(contact.path);
    if (contact.gap <= 0 || !(closing > 0)) continue;
    smallest = std::min(smallest, dt * (contact.gap + margin) / closing);
  }
  return smallest;
}

// A substep has its forces where the bodies would be at its end without them. As contact opens
// these are the forces of springs that are pressed more than at any time in the substep, and they
// give more energy than the springs lose. The sum of that excess over all substeps is taken from
// what the springs still store.
template <int dim>
void GroupContact<dim>::pay_back(Springs& springs) const {
  const double before = energy_.stored - stored_slip_;
  std::array<double, 4> sums = {normal_work_ - (springs.normal - before), springs.normal,
                                tangential_work_ - (springs.tangential - stored_slip_),
                                springs.tangential};
  sum_over_ranks(comm_, std::span<double>(sums));
  const auto left = [](double taken, double stored) {
    return taken < 0 && stored > 0 ? std::max(0.0, 1 + taken / stored) : 1.0;
  };
  const double gaps = left(sums[0], sums[1]), slips = left(sums[2], sums[3]);
  if (gaps == 1 && slips == 1) return;
  for (std::size_t k = 0; k < springs.nodes.size(); ++k) {
    RememberedNode<dim>& node = springs.nodes[k];
    node.stored = gaps * springs.pressed[k] + slips * (node.stored - springs.pressed[k]);
    node.gap *= std::cbrt(gaps);
    node.slip *= std::sqrt(slips);
  }
  springs.normal *= gaps;
  springs.tangential *= slips;
}

template <int dim>
void GroupContact<dim>::accept() {
  Springs springs;
  double work = 0, slid = 0;
  for (const ContactNode& contact : contacts_) {
    if (contact.gap >= 0) continue;
    const ContactLaw law = law_of(contact);
    const Vector<dim>& n = contact.node.n;
    RememberedNode<dim> memory{.place = contact.node.place,
                               .pair = contact.node.pair,
                               .force = contact.force,
                               .gap = contact.gap,
                               .area = contact.node.area,
                               .moved = contact.middle_way.norm()};
    if (law.mode == ContactMode::contact) {
      const Vector<dim> pull = contact.force - n.dot(contact.force) * n;
      memory.slip = -pull / (contact.node.area * law.tangential_penalty);
      slid -= pull.dot(contact.slip - memory.slip);
      memory.stored = 0.5 * contact.node.area * law.tangential_penalty * memory.slip.squaredNorm();
      springs.tangential += memory.stored;
    }
    const double pressed = contact.node.area * law.stored(-contact.gap);
    memory.stored += pressed;
    springs.normal += pressed;
    springs.pressed.push_back(pressed);
    work -= contact.force.dot(contact.path);
    springs.nodes.push_back(memory);
  }
  if (has_substeps_) {
    pay_back(springs);
    work = normal_work_ + tangential_work_;
    slid = tangential_work_ - (springs.tangential - stored_slip_);
  }
  if (!has_substeps_) {
    std::ranges::fill(resultants_, Vector<dim>::Zero());
    for (const ContactNode& contact : contacts_) resultants_[contact.node.pair] += contact.force;
  }
  accepted_ = resultants_;
  sum_over_ranks<dim>(comm_, std::span(accepted_));
  energy_.add_step(work, springs.normal + springs.tangential, slid);
  stored_slip_ = springs.tangential;
  own_.replace(std::move(springs.nodes));
}

template <int dim>
bool GroupContact<dim>::drop(std::size_t, bool dropped) {
  contacts_.clear();
  left_.clear();
  if (!dropped) return true;
  own_.replace({});
  std::ranges::fill(accepted_, Vector<dim>::Zero());
  energy_.loss += energy_.stored;
  energy_.stored = stored_slip_ = 0;
  return true;
}

template <int dim>
void GroupContact<dim>::visit_state(StateVisitor& visitor, const std::string& prefix) {
  const Json own = fact_of(groups_);
  Json found = own;
  visitor.fact(prefix + "groups", found);
  require(found == own, "saved state: found the contact groups {}, allowed: those of this run, {}",
          found.dump(), own.dump());
  own_.visit_state(visitor, prefix, num_places_, static_cast<std::int32_t>(groups_.pairs.size()));
  visitor.reals(prefix + "forces", flat(accepted_));
  const std::pair<const char*, double*> energies[] = {{"stored", &energy_.stored},
                                                      {"friction", &energy_.friction},
                                                      {"loss", &energy_.loss},
                                                      {"stored_slip", &stored_slip_}};
  for (const auto& [name, value] : energies) visitor.share(prefix + name, *value);
}

template class GroupContact<2>;
template class GroupContact<3>;

}  // namespace gabion::mpm
