// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/contact_points.hpp"

#include <algorithm>

#include "mpm_solver/contact/contact_depths.hpp"
#include "mpm_solver/contact/contact_frame.hpp"

namespace gabion::mpm {

template <int dim>
void ContactPoints<dim>::clear() {
  points_.clear();
  opened_.clear();
  w_.clear();
  order();
}

template <int dim>
void ContactPoints<dim>::find(std::span<const double> du) {
  points_.clear();
  opened_.clear();
  w_.clear();
  search_.find(du, [&](std::int32_t candidate, std::span<const SurfaceFeature<dim>> features) {
    add(candidate, features);
  });
  order();
}

template <int dim>
void ContactPoints<dim>::find_opened() {
  search_.find_opened([this](std::int32_t k, std::span<const SurfaceFeature<dim>> features) {
    const Candidate& c = search_.candidates()[k];
    if (features.empty()) return;
    search_.motions_of_nodes(c, motions_);
    for (const auto& feature : features) {
      Point point = point_at(c, feature);
      point.candidate = k;
      if (point.gap >= 0) opened_.push_back(point);
    }
  });
}

// Slip of a contact: since it began; of a new one since its displacement path met the surface.
template <int dim>
void ContactPoints<dim>::set_slip(const Candidate& c, Point& contact) const {
  const Vector<dim>& n = contact.feature.normal;
  const Vector<dim> path = tangential<dim>(contact.relative, n);
  if (const auto* memory = going_on(c.memory, n)) {
    const Vector<dim> slip = memory->tangential();
    const Vector<dim> turned = tangential<dim>(slip, n);
    const double size = turned.norm();
    contact.slip = path;
    contact.old_part = memory->part;
    if (size > 0) contact.old_slip = turned * (slip.norm() / size);
    return;
  }
  const double closing = -n.dot(contact.relative);
  const double gap_before = contact.gap + closing;
  if (gap_before > 0) {
    contact.slip_share = -contact.gap / closing;
    contact.slip_share_slope = -gap_before / (closing * closing);
  }
  contact.slip = contact.slip_share * path;
}

// Add the contact points of one candidate.
template <int dim>
void ContactPoints<dim>::add(std::int32_t candidate,
                             std::span<const SurfaceFeature<dim>> features) {
  const Candidate& c = search_.candidates()[candidate];
  if (!features.empty()) search_.motions_of_nodes(c, motions_);
  const std::size_t first = points_.size();
  for (const auto& feature : features) {
    Point contact = point_at(c, feature);
    contact.candidate = candidate;
    if (contact.gap >= 0) {
      w_.resize(contact.first_weight);
      if (c.reaches_far) opened_.push_back(contact);
      continue;
    }
    points_.push_back(contact);
  }
  share_in_corners(c, first);
}

template <int dim>
ContactPoint<dim> ContactPoints<dim>::point_at(const Candidate& c,
                                               const SurfaceFeature<dim>& feature) {
  const Vector<dim>& n = feature.normal;
  Point contact;
  contact.owner = surface_.owner(feature.simplex);
  contact.feature = feature;
  contact.radius = c.radius(n);
  contact.area = c.volume / (2 * contact.radius);
  contact.first_weight = static_cast<std::int32_t>(w_.size());
  w_.resize(w_.size() + c.num_values);
  double* w = w_.data() + contact.first_weight;
  search_.surface_weights(c, n, w);
  for (std::int32_t k = 0; k < c.num_values; ++k) contact.motion += w[k] * motions_[k];
  if (const auto* memory = going_on(c.memory, n))
    contact.initial_penetration = memory->initial_penetration();
  contact.gap = feature.distance - contact.radius + n.dot(contact.motion - c.motion) -
                contact.initial_penetration;
  contact.relative = contact.motion - surface_.motion_at(feature);
  set_slip(c, contact);
  contact.frame = frame_of<dim>(n);
  return contact;
}

// Members that meet in a corner with the point in it, or that face each other with the point
// between them, push independently.
template <int dim>
void ContactPoints<dim>::share_in_corners(const Candidate& c, std::size_t first) {
  if (surface_.num_members() == 1 || points_.size() <= first + 1)
    return share_depths(laws_, c, first, points_);
  const auto surface = search_.view_of(c);
  const auto apart = [&](const Point& a, const Point& b) {
    return are_in_corner<dim>(surface, a.feature.simplex, b.feature.simplex);
  };
  std::vector<std::vector<Point>> groups;
  for (std::size_t k = first; k < points_.size(); ++k) {
    const auto group = std::ranges::find_if(groups, [&](const auto& contacts) {
      return std::ranges::none_of(contacts, [&](const Point& t) { return apart(t, points_[k]); });
    });
    if (group == groups.end()) {
      groups.push_back({points_[k]});
    } else {
      group->push_back(points_[k]);
    }
  }
  if (groups.size() <= 1) return share_depths(laws_, c, first, points_);
  points_.resize(first);
  for (const auto& contacts : groups) {
    const std::size_t begin = points_.size();
    points_.insert(points_.end(), contacts.begin(), contacts.end());
    share_depths(laws_, c, begin, points_);
  }
}

// Sort the points by their members, those of a member as they were found.
template <int dim>
void ContactPoints<dim>::order() {
  const auto num_members = static_cast<std::size_t>(surface_.num_members());
  first_of_.assign(num_members + 1, 0);
  for (const Point& contact : points_) ++first_of_[contact.owner + 1];
  for (std::size_t m = 0; m < num_members; ++m) first_of_[m + 1] += first_of_[m];
  by_owner_.resize(points_.size());
  std::vector<std::int32_t> next(first_of_.begin(), first_of_.end() - 1);
  for (std::size_t k = 0; k < points_.size(); ++k) {
    by_owner_[next[points_[k].owner]++] = static_cast<std::int32_t>(k);
  }
}

template class ContactPoints<2>;
template class ContactPoints<3>;

}  // namespace gabion::mpm
