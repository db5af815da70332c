// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gabion::mpm {

namespace {

// Shares of the diameter of the largest point: edge of the lattice's cubes, how far around them
// their lists go, by how much a surface may move before its lists are made anew.
constexpr double cube_share = 1;
constexpr double reach_share = 1.4;
constexpr double slack_share = 0.1;
constexpr double far_cube_share = 2;
constexpr double far_reach_share = 3;

// Kept lists go as far as those that would be made now, to between these shares: points grow.
constexpr double fewest_share = 0.8;
constexpr double most_share = 1.5;

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

template <int dim>
void FacetSearch<dim>::add_member(std::size_t num_simplices) {
  Member& member = members_.emplace_back();
  member.first = static_cast<std::int32_t>(bounds_.size());
  member.count = static_cast<std::int32_t>(num_simplices);
  bounds_.resize(bounds_.size() + num_simplices);
}

template <int dim>
void FacetSearch<dim>::find_bounds(Member& member) {
  const auto found = bounds_of<dim>(simplices_.subspan(member.first, member.count), vertices_);
  std::copy(found.begin(), found.end(), bounds_.begin() + member.first);
  member.size = 0;
  for (const auto& bounds : found) member.size = std::max(member.size, 2 * bounds.radius);
  member.bounds_known = true;
}

// A bounding sphere goes no farther beyond the simplex than its corners are apart.
template <int dim>
void FacetSearch<dim>::find_box(Member& member) const {
  double widest = 0;
  for (const Simplex<dim>& simplex : simplices_.subspan(member.first, member.count)) {
    Eigen::AlignedBox<double, dim> box;
    for (const std::int32_t v : simplex) box.extend(vertices_[v]);
    widest = std::max(widest, box.sizes().squaredNorm());
    member.box.extend(box);
  }
  const Vector<dim> beyond = Vector<dim>::Constant(std::sqrt(widest));
  member.box = {member.box.min() - beyond, member.box.max() + beyond};
}

template <int dim>
Eigen::AlignedBox<double, dim> FacetSearch<dim>::box() {
  Eigen::AlignedBox<double, dim> box;
  for (Member& member : members_) {
    if (member.dropped || member.count == 0) continue;
    if (member.box.isEmpty()) find_box(member);
    box.extend(member.box);
  }
  return box;
}

template <int dim>
void FacetSearch<dim>::begin_step(std::span<const Simplex<dim>> simplices,
                                  std::span<const Vector<dim>> vertices, double diameter) {
  simplices_ = simplices;
  vertices_ = vertices;
  const double reach = reach_share * diameter;
  if (!(fewest_share * reach <= reach_ && reach_ <= most_share * reach)) {
    reach_ = reach;
    for (Member& member : members_) member.has_lattice = false;
  }
}

template <int dim>
void FacetSearch<dim>::make_ready() {
  size_ = 0;
  for (Member& member : members_) {
    if (!member.bounds_known) find_bounds(member);
    size_ = std::max(size_, member.size);
    if (member.dropped || (member.has_lattice && !member.lattice.is_stale())) continue;
    const double unit = reach_ / reach_share, slack = slack_share * unit;
    const auto surface = surface_of(member);
    member.lattice =
        FacetLattice<dim>(surface, {.cube = cube_share * unit, .reach = reach_, .slack = slack});
    member.far = FacetLattice<dim>(surface, {.cube = far_cube_share * unit,
                                             .reach = far_reach_share * unit,
                                             .slack = slack,
                                             .with_lists = false});
    member.has_lattice = true;
  }
}

template <int dim>
void FacetSearch<dim>::add_motion(std::size_t member, double path) {
  if (path == 0) return;
  members_[member].bounds_known = false;
  members_[member].box.setEmpty();
  members_[member].lattice.add_motion(path);
  members_[member].far.add_motion(path);
}

template <int dim>
void FacetSearch<dim>::forget() {
  for (Member& member : members_) {
    member.bounds_known = member.has_lattice = false;
    member.box.setEmpty();
  }
}

template <int dim>
std::span<const std::int32_t> FacetSearch<dim>::near(std::size_t member, const Vector<dim>& x,
                                                     double distance,
                                                     std::vector<std::int32_t>& room) const {
  const Member& own = members_[member];
  if (own.dropped) return {};
  return own.lattice.near(surface_of(own), x, distance, room);
}

template <int dim>
std::span<const std::int32_t> FacetSearch<dim>::near(const Vector<dim>& x, double distance,
                                                     std::vector<std::int32_t>& room) const {
  if (members_.size() == 1) return near(0, x, distance, room);
  room.clear();
  for (std::size_t m = 0; m < members_.size(); ++m) {
    const auto of_member = near(m, x, distance, of_member_);
    room.insert(room.end(), of_member.begin(), of_member.end());
  }
  return room;
}

template <int dim>
double FacetSearch<dim>::at_least(std::size_t member, const Vector<dim>& middle,
                                  const Vector<dim>& half) const {
  const Member& own = members_[member];
  return own.dropped ? infinity : own.lattice.at_least(surface_of(own), middle, half);
}

template <int dim>
double FacetSearch<dim>::at_least(const Vector<dim>& middle, const Vector<dim>& half) const {
  double least = infinity;
  for (std::size_t m = 0; m < members_.size(); ++m) {
    least = std::min(least, at_least(m, middle, half));
  }
  return least;
}

template <int dim>
double FacetSearch<dim>::far_at_least(const Vector<dim>& middle, const Vector<dim>& half) const {
  double least = infinity;
  for (const Member& member : members_) {
    if (member.dropped) continue;
    least = std::min(least, member.far.at_least(surface_of(member), middle, half));
  }
  return least;
}

template class FacetSearch<2>;
template class FacetSearch<3>;

}  // namespace gabion::mpm
