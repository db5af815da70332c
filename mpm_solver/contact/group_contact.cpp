// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/group_contact.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/base/log.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "mpm_solver/contact/contact_frame.hpp"
#include "mpm_solver/grid/group_fields.hpp"

namespace gabion::mpm {

namespace {

// A contact node takes gap and area from the points by this share for each cell that its soil has
// moved through the grid.
constexpr double renewal = 2;

// Spheres of points that overlap by more than this share of the cell size, where no contact was
// closed before, give a warning.
constexpr double notable_overlap = 0.25;

// Share of the cell size by which the spheres along a normal overlap more than any two of them do
// where the plane between them leans across a corner.
constexpr double notable_lean = 0.25;

// A new node whose gap lies below that of the closed ones around it by more than this share of the
// cell size is not of their surface.
constexpr double notable_difference = 0.05;

template <int dim>
Eigen::Map<Vector<dim>> at(std::span<double> field, std::int32_t i) {
  return Eigen::Map<Vector<dim>>(field.data() + std::ptrdiff_t{i} * dim);
}
template <int dim>
Eigen::Map<const Vector<dim>> at(std::span<const double> field, std::int32_t i) {
  return Eigen::Map<const Vector<dim>>(field.data() + std::ptrdiff_t{i} * dim);
}

// A slip turned into the plane across n, as long as before.
template <int dim>
Vector<dim> turned_slip(const Vector<dim>& slip, const Vector<dim>& n) {
  const Vector<dim> turned = tangential<dim>(slip, n);
  const double size = turned.norm();
  return size > 0 ? Vector<dim>(turned * (slip.norm() / size)) : Vector<dim>(Vector<dim>::Zero());
}

// A gap not below the gap that the node had when it was closed before, nor below the overlap of the
// nearest points. Across a re-entrant corner a slanted plane separates the points, and the spheres
// along its normal overlap by far more than the bodies do.
template <int dim>
double bounded_gap(const GroupNode<dim>& node, double before) {
  return std::max(node.gap, std::min(before, -node.overlap));
}

}  // namespace

template <int dim>
ContactLaw GroupContact<dim>::law_of(const ContactNode& contact) const {
  const GroupPair& pair = groups_.pairs[contact.node.pair];
  const double M = contact.node.modulus, h = cell_size_;
  return {.mode = pair.mode,
          .friction = pair.friction / strength_factor_,
          .penalty = pair.penalty_factor * M / (h * h),
          .tangential_penalty = pair.tangential_factor * M / h,
          .normal = NormalLaw::quadratic};
}

template <int dim>
bool GroupContact<dim>::symmetric() const {
  return std::ranges::all_of(contacts_,
                             [&](const ContactNode& t) { return !law_of(t).has_friction(); });
}

// Continue with the state of the node at the end of the step before.
template <int dim>
void GroupContact<dim>::follow(ContactNode& contact) const {
  GroupNode<dim>& node = contact.node;
  const RememberedNode<dim>* const before = memory_.find(node.place, node.pair);
  if (before == nullptr) return;
  const double share = std::min(1.0, renewal * before->moved / cell_size_);
  const double found = node.separates ? bounded_gap(node, before->gap) : before->gap;
  node.gap = before->gap + share * (found - before->gap);
  node.area = before->area + share * (node.area - before->area);
  contact.old_force = before->force;
  if (node.gap >= 0) return;
  contact.goes_on = true;
  contact.old_slip = turned_slip<dim>(before->slip, node.n);
}

// Give a new node within a closed contact the mean state of the nodes around it.
template <int dim>
void GroupContact<dim>::go_on_from_neighbours(const BackgroundGrid<dim>& grid,
                                              ContactNode& contact) const {
  GroupNode<dim>& node = contact.node;
  Vector<dim> slip = Vector<dim>::Zero();
  double area = 0, gap = 0;
  for (const std::int32_t place : places_around(grid, node.place, 1)) {
    const RememberedNode<dim>* const near = memory_.find(place, node.pair);
    if (near == nullptr) continue;
    area += near->area;
    slip += near->area * near->slip;
    gap += near->area * near->gap;
  }
  const double around = area > 0 ? gap / area : 0;
  if (node.separates) {
    const bool alike = node.gap > around - notable_difference * cell_size_;
    node.gap = bounded_gap(node, alike ? around : 0);
  } else if (node.gap == 0) {
    node.gap = around;
  }
  if (area == 0 || node.gap >= 0) return;
  contact.goes_on = true;
  contact.old_slip = turned_slip<dim>(slip / area, node.n);
}

// Energy in the springs of a node before its bodies move [J].
template <int dim>
double GroupContact<dim>::stored_at_start(const ContactNode& contact) const {
  const GroupNode<dim>& node = contact.node;
  if (node.gap >= 0) return 0;
  const ContactLaw law = law_of(contact);
  const double pressed = node.area * law.stored(-node.gap);
  if (law.mode != ContactMode::contact) return pressed;
  return pressed + 0.5 * node.area * law.tangential_penalty * contact.old_slip.squaredNorm();
}

// Limit the rise of the energy stored by some nodes since the end of the step before to the fall of
// that stored by others, nodes that are left included. So the springs of a pair never gain by a new
// gap, area or slip.
template <int dim>
void GroupContact<dim>::keep_stored_energy() {
  const std::size_t num_pairs = groups_.pairs.size();
  std::vector<double> sums(2 * num_pairs, 0.0);
  const std::span<double> lost = std::span(sums).first(num_pairs);
  const std::span<double> gained = std::span(sums).last(num_pairs);
  for (const RememberedNode<dim>& before : own_.nodes()) lost[before.pair] += before.stored;
  const auto stored_before = [&](const ContactNode& contact) {
    const RememberedNode<dim>* const before = memory_.find(contact.node.place, contact.node.pair);
    return before ? before->stored : 0.0;
  };
  for (const ContactNode& contact : contacts_) {
    const double before = stored_before(contact), now = stored_at_start(contact);
    lost[contact.node.pair] -= std::min(before, now);
    gained[contact.node.pair] += std::max(0.0, now - before);
  }
  sum_over_ranks(comm_, std::span<double>(sums));
  for (ContactNode& contact : contacts_) {
    const std::int32_t pair = contact.node.pair;
    if (gained[pair] <= lost[pair]) continue;
    const double before = stored_before(contact), now = stored_at_start(contact);
    if (now <= before) continue;
    const double share = std::max(0.0, lost[pair]) / gained[pair];
    const double left = (before + share * (now - before)) / now;
    contact.node.gap *= std::cbrt(left);
    contact.old_slip *= std::sqrt(left);
  }
}

// The warning of a node; empty: none.
template <int dim>
std::string GroupContact<dim>::text_of_overlap(const SoilSurface<dim>& soil,
                                               const ContactNode& contact) const {
  const GroupNode<dim>& node = contact.node;
  if (contact.goes_on || node.overlap <= notable_overlap * cell_size_) return {};
  const GroupPair& pair = groups_.pairs[node.pair];
  const Vector<dim> x = soil.grid.node(node.place);
  return fmt::format(
      "{}: bodies of \"{}\" and \"{}\" overlap by {:.3g} m near ({:.4g}) without contact before: "
      "they passed through each other in one step; take smaller steps",
      groups_.where, groups_.names[pair.first], groups_.names[pair.second], node.overlap,
      fmt::join(x.data(), x.data() + dim, ", "));
}

template <int dim>
std::string GroupContact<dim>::text_of_corner(const SoilSurface<dim>& soil,
                                              const GroupNode<dim>& node) const {
  const double lean = notable_lean * cell_size_;
  if (!node.separates || node.gap >= -node.overlap - lean) return {};
  const GroupPair& pair = groups_.pairs[node.pair];
  const Vector<dim> x = soil.grid.node(node.place);
  return fmt::format(
      "{}: bodies of \"{}\" and \"{}\" meet in a re-entrant corner near ({:.4g}): a node has one "
      "normal only, so that soil that slides into the corner may stop short of it or be lifted; "
      "give each face of the corner a group of its own",
      groups_.where, groups_.names[pair.first], groups_.names[pair.second],
      fmt::join(x.data(), x.data() + dim, ", "));
}

template <int dim>
void GroupContact<dim>::warn_once(const std::string& text, bool& said) const {
  if (said) return;
  const std::string first = first_text(comm_, text);
  said = !first.empty();
  if (said) log::warn("{}", first);
}

// Forces of the step before at nodes that both groups still have, but that carry no contact.
template <int dim>
void GroupContact<dim>::find_left_forces(const SoilSurface<dim>& soil,
                                         const GroupsAtNodes<dim>& at_nodes) {
  left_.clear();
  std::size_t k = 0;
  const auto key = [](const auto& node) { return std::pair(node.place, node.pair); };
  for (const RememberedNode<dim>& before : memory_.nodes()) {
    while (k < contacts_.size() && key(contacts_[k].node) < key(before)) ++k;
    if (k < contacts_.size() && key(contacts_[k].node) == key(before)) continue;
    const GroupPair& pair = groups_.pairs[before.pair];
    const std::uint32_t both = (std::uint32_t{1} << pair.first) | (std::uint32_t{1} << pair.second);
    if ((at_nodes.at(before.place) & both) != both || !at_nodes.owns(before.place)) continue;
    const auto node = [&](std::int32_t group) {
      return soil.nodes.active[at_nodes.node(before.place, group)];
    };
    left_.push_back({node(pair.first), node(pair.second), before.force});
  }
}

template <int dim>
void GroupContact<dim>::begin_step(const SoilSurface<dim>& soil) {
  comm_ = soil.comm;
  force_weight_ = soil.step_force_weight;
  cell_size_ = soil.cell_size;
  strength_factor_ = soil.strength_factor;
  has_substeps_ = false;
  contacts_.clear();
  memory_ = own_.of_all(comm_);
  const GroupsAtNodes<dim> at_nodes(comm_, groups_.of_body, soil.nodes.num_places, soil.weights);
  std::string overlap, corner;  // warnings of the first nodes that have one
  for (const GroupNode<dim>& node : find_contact_nodes(soil, groups_, at_nodes)) {
    if (corner.empty()) corner = text_of_corner(soil, node);
    ContactNode contact{.node = node};
    follow(contact);
    if (memory_.find(node.place, node.pair) == nullptr) go_on_from_neighbours(soil.grid, contact);
    contact.frame = frame_of<dim>(node.n);
    if (overlap.empty()) overlap = text_of_overlap(soil, contact);
    contacts_.push_back(contact);
  }
  warn_once(corner, said_corner_);
  warn_once(overlap, said_overlap_);
  keep_stored_energy();
  find_left_forces(soil, at_nodes);
}

template <int dim>
void GroupContact<dim>::append_cells(std::vector<std::int32_t>& offsets,
                                     std::vector<std::int32_t>& nodes) const {
  for (const ContactNode& contact : contacts_) {
    nodes.insert(nodes.end(), {contact.node.first, contact.node.second});
    offsets.push_back(static_cast<std::int32_t>(nodes.size()));
  }
}

template <int dim>
void GroupContact<dim>::move(std::span<const double> du, ContactNode& contact) const {
  const auto first = at<dim>(du, contact.node.first), second = at<dim>(du, contact.node.second);
  contact.path = second - first;
  contact.middle_way = 0.5 * (first + second);
  contact.gap = contact.node.gap + contact.node.n.dot(contact.path);
  contact.traction = {};
  contact.force.setZero();
  if (contact.gap < 0) set_slip(contact);
}

// Slip of a contact: since it began; of a new one since its displacement path met the surface.
template <int dim>
void GroupContact<dim>::set_slip(ContactNode& contact) const {
  const Vector<dim>& n = contact.node.n;
  contact.slip_share = 1;
  contact.slip_share_slope = 0;
  if (!contact.goes_on && contact.node.gap > 0) {
    const double closing = contact.node.gap - contact.gap;
    contact.slip_share = -contact.gap / closing;
    contact.slip_share_slope = -contact.node.gap / (closing * closing);
  }
  contact.slip = contact.slip_share * tangential<dim>(contact.path, n);
  if (contact.goes_on) contact.slip += contact.old_slip;
}

template <int dim>
void GroupContact<dim>::add_stiffness(const ContactNode& contact, const Matrix<dim>& slope,
                                      BlockMatrix<dim>& K) const {
  const Vector<dim>& n = contact.node.n;
  const double scale = force_weight_ * contact.node.area;
  const Vector<dim> by_gap = scale * (contact.frame * slope.col(0));
  const Matrix<dim> by_slip = scale * (contact.frame * slope * contact.frame.transpose()) *
                              (Matrix<dim>::Identity() - n * n.transpose());
  const Vector<dim> by_begin = contact.slip_share_slope * (by_slip * contact.path);
  const Matrix<dim> k = contact.slip_share * by_slip + (by_gap + by_begin) * n.transpose();
  const std::int32_t a = contact.node.first, b = contact.node.second;
  K.add_block(a, a, k);
  K.add_block(b, b, k);
  K.add_block(a, b, -k);
  K.add_block(b, a, -k);
}

template <int dim>
void GroupContact<dim>::add_forces(std::span<const double> du, std::span<double> r,
                                   BlockMatrix<dim>* K) {
  Matrix<dim> slope;
  for (ContactNode& contact : contacts_) {
    move(du, contact);
    if (contact.gap >= 0) continue;
    Vector<dim> gap = contact.frame.transpose() * contact.slip;
    gap[0] = contact.gap;
    contact.traction = law_of(contact).template traction<dim>(gap, K ? &slope : nullptr);
    contact.force = contact.node.area * (contact.frame * contact.traction.t);
    at<dim>(r, contact.node.second) += force_weight_ * contact.force;
    at<dim>(r, contact.node.first) -= force_weight_ * contact.force;
    if (K) add_stiffness(contact, slope, *K);
  }
  if (force_weight_ != 1) add_old_forces(1 - force_weight_, r);
}

template <int dim>
void GroupContact<dim>::add_old_forces(double share, std::span<double> field) const {
  const auto add = [&](std::int32_t first, std::int32_t second, const Vector<dim>& force) {
    at<dim>(field, second) += share * force;
    at<dim>(field, first) -= share * force;
  };
  for (const ContactNode& contact : contacts_)
    add(contact.node.first, contact.node.second, contact.old_force);
  for (const LeftForce& left : left_) add(left.first, left.second, left.force);
}

template <int dim>
void GroupContact<dim>::add_step_force_change(std::span<double> f) const {
  for (const ContactNode& contact : contacts_) {
    at<dim>(f, contact.node.second) += contact.force;
    at<dim>(f, contact.node.first) -= contact.force;
  }
  add_old_forces(-1, f);
}

template class GroupContact<2>;
template class GroupContact<3>;

}  // namespace gabion::mpm
