// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_contact.hpp"

#include <algorithm>
#include <cmath>

#include "mpm_solver/contact/contact_frame.hpp"
#include "mpm_solver/contact/shortest_exit.hpp"

namespace gabion::mpm {

template <int dim>
ContactLaw FacetContact<dim>::law_of(const Candidate& c, std::int32_t owner, double part) const {
  const Member& member = members_[owner];
  const FacetSettings& method = member.method;
  const double M = c.modulus, h = cell_size_;
  ContactLaw law{.mode = member.mode,
                 .friction = member.friction,
                 .penalty = method.penalty_factor * M / (h * h),
                 .tangential_penalty = part * method.tangential_factor * M / h,
                 .normal = NormalLaw::quadratic,
                 .drag = member.drag,
                 .time = search_.soil() ? surface_.share() * search_.soil()->dt : 0,
                 .weakening = member.weakening};
  const double k = method.resting_factor;
  if (c.took_weight && k * k * M > 4 * c.weight * method.penalty_factor) {
    law.penalty = k * k * M / (4 * c.weight) * M / (h * h);
    law.linear_from = 2 * h * c.weight / (k * M);
  }
  return law;
}

template <int dim>
double FacetContact<dim>::pore_pressure_at(const ContactPoint& contact) const {
  const std::optional<SoilSurface<dim>>& soil = search_.soil();
  if (!soil || soil->pore_pressures.empty() || members_[contact.owner].drained) return 0;
  const double below = contact.radius * contact.feature.normal.dot(soil->water_weight);
  return std::max(0.0, candidate(contact).pore_pressure - below);
}

template <int dim>
ContactLaw FacetContact<dim>::law_now(const ContactPoint& contact) const {
  ContactLaw law = law_of(candidate(contact), contact.owner, contact.part);
  law.pore_pressure = pore_pressure_at(contact);
  if (law.weakening.fall > 0 && law.time > 0)
    law.speed = tangential<dim>(contact.relative, contact.feature.normal).norm() / law.time;
  return law;
}

// A contact that goes on has slipped since it began; a new one since its path met the surface.
template <int dim>
void FacetContact<dim>::set_slip(const Candidate& c, ContactPoint& contact) const {
  const Vector<dim>& n = contact.feature.normal;
  const Vector<dim> path = tangential<dim>(contact.relative, n);
  if (const Remembered* memory = going_on(c.memory, n)) {
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

// The old slip in springs of the present stiffness. Those that became softer keep it, those that
// became stiffer keep its force: either way they hold no more energy than before.
template <int dim>
void FacetContact<dim>::follow_part(ContactPoint& contact) {
  if (contact.part <= contact.old_part) {
    contact.slip += contact.old_slip;
    return;
  }
  const double kept = contact.old_part / contact.part;
  contact.slip += kept * contact.old_slip;
  contact.slip_part_slope = -kept / contact.part * contact.old_slip;
}

// Those of one candidate.
template <int dim>
void FacetContact<dim>::add_contacts(std::int32_t candidate,
                                     std::span<const SurfaceFeature<dim>> features,
                                     std::span<const double> du) {
  const Candidate& c = search_.candidates()[candidate];
  const std::size_t first = contacts_.size();
  for (const auto& feature : features) {
    ContactPoint contact = contact_at(c, feature, du);
    contact.candidate = candidate;
    if (contact.gap >= 0) {
      w_.resize(contact.first_weight);
      if (c.reaches_far) opened_.push_back(contact);
      continue;
    }
    contacts_.push_back(contact);
  }
  share_in_corners(c, first);
}

template <int dim>
typename FacetContact<dim>::ContactPoint FacetContact<dim>::contact_at(
    const Candidate& c, const SurfaceFeature<dim>& feature, std::span<const double> du) {
  const Vector<dim>& n = feature.normal;
  ContactPoint contact;
  contact.owner = surface_.owner(feature.simplex);
  contact.feature = feature;
  contact.radius = c.radius(n);
  contact.area = c.volume / (2 * contact.radius);
  contact.first_weight = static_cast<std::int32_t>(w_.size());
  w_.resize(w_.size() + c.num_values);
  double* w = w_.data() + contact.first_weight;
  const auto nodes = search_.nodes_of(c);
  search_.surface_weights(c, n, w);
  for (std::int32_t k = 0; k < c.num_values; ++k) {
    const std::ptrdiff_t node = nodes[k];
    contact.motion += w[k] * Eigen::Map<const Vector<dim>>(du.data() + node * dim);
  }
  if (const Remembered* memory = going_on(c.memory, n))
    contact.initial_penetration = memory->initial_penetration();
  contact.gap = feature.distance - contact.radius + n.dot(contact.motion - c.motion) -
                contact.initial_penetration;
  contact.relative = contact.motion - surface_.motion_at(feature);
  set_slip(c, contact);
  contact.frame = frame_of<dim>(n);
  return contact;
}

// Along the normal of a contact, after the step: the gap stays what it was. Where a rigid sphere
// opens, it goes back to its point as far as it does not touch.
template <int dim>
double FacetContact<dim>::offset_after(const ContactPoint& contact) const {
  const Candidate& c = candidate(contact);
  const Vector<dim>& n = contact.feature.normal;
  const double offset = n.dot(c.offset + contact.motion - c.motion);
  if (c.deforms) return offset + (c.shape * (n + c.H.transpose() * n)).norm() - contact.radius;
  if (contact.gap < 0) return std::max(offset, -contact.radius);
  return std::max(offset - contact.gap - contact.initial_penetration, 0.0);
}

// Members that meet in a corner with the point in it, or that face each other with the point
// between them, push each for itself.
template <int dim>
void FacetContact<dim>::share_in_corners(const Candidate& c, std::size_t first) {
  if (members_.size() == 1 || contacts_.size() <= first + 1) return share_depths(c, first);
  const auto surface = search_.view_of(c);
  const auto apart = [&](const ContactPoint& a, const ContactPoint& b) {
    return are_in_corner<dim>(surface, a.feature.simplex, b.feature.simplex);
  };
  std::vector<std::vector<ContactPoint>> groups;
  for (std::size_t k = first; k < contacts_.size(); ++k) {
    const auto group = std::ranges::find_if(groups, [&](const auto& contacts) {
      return std::ranges::none_of(contacts,
                                  [&](const ContactPoint& t) { return apart(t, contacts_[k]); });
    });
    if (group == groups.end()) {
      groups.push_back({contacts_[k]});
    } else {
      group->push_back(contacts_[k]);
    }
  }
  if (groups.size() <= 1) return share_depths(c, first);
  contacts_.resize(first);
  for (const auto& contacts : groups) {
    const std::size_t begin = contacts_.size();
    contacts_.insert(contacts_.end(), contacts.begin(), contacts.end());
    share_depths(c, begin);
  }
}

// Depths of the contact points of one material point. Where several push, the traction of all is
// penalty g(|u|) u, of which each has its part: penalty g lambda_k, u = sum_k lambda_k n_k the
// shortest displacement out. The tangential stiffness of all is that of one, too: parts lambda_k
// delta_k / |u|^2 add up to 1.
template <int dim>
void FacetContact<dim>::share_depths(const Candidate& c, std::size_t first) {
  if (contacts_.size() == first) return;
  if (contacts_.size() == first + 1) {
    ContactPoint& contact = contacts_.back();
    const double depth = -contact.gap;
    const ContactLaw law = law_of(c, contact.owner, 1);
    const double reduced = law.reduced(depth);
    contact.depth = std::sqrt(depth * reduced);
    const bool is_linear = depth > law.linear_from;
    contact.stored_depth = is_linear ? std::cbrt(law.storing(depth) * depth * depth) : depth;
    contact.num_others = 1;
    contact.others[0] = static_cast<std::int32_t>(first);
    contact.shares[0] = (reduced + law.reduced_slope(depth) * depth) / (2 * contact.depth);
    follow_part(contact);
    return;
  }
  std::vector<Vector<dim>> normals;
  std::vector<double> deltas;
  for (std::size_t k = first; k < contacts_.size(); ++k) {
    normals.push_back(contacts_[k].feature.normal);
    deltas.push_back(-contacts_[k].gap);
  }
  const ShortestExit<dim> out = shortest_exit<dim>(normals, deltas);
  for (int k = 0; k < out.size; ++k) {
    ContactPoint contact = contacts_[first + out.planes[k]];  // planes ascend
    const ContactLaw law = law_of(c, contact.owner, 1);
    const double reduced = law.reduced(out.length), slope = law.reduced_slope(out.length);
    contact.depth = std::sqrt(out.depths[k] * reduced);
    contact.stored_depth = std::cbrt(law.storing(out.length) * out.depths[k] * -contact.gap);
    contact.num_others = out.size;
    const double square = out.length * out.length;
    contact.part = out.depths[k] * -contact.gap / square;
    for (int l = 0; l < out.size; ++l) {
      contact.part_slopes[l] = (out.inverse(k, l) * -contact.gap + (k == l ? out.depths[k] : 0) -
                                2 * contact.part * out.depths[l]) /
                               square;
      contact.others[l] = static_cast<std::int32_t>(first) + l;
      contact.shares[l] =
          (reduced * out.inverse(k, l) + slope * out.depths[k] * out.depths[l] / out.length) /
          (2 * contact.depth);
    }
    follow_part(contact);
    contacts_[first + k] = contact;
  }
  contacts_.resize(first + out.size);
}

// Change of the gap with the displacement of a node. @param value  of the candidate's
template <int dim>
Vector<dim> FacetContact<dim>::gap_slope(const ContactPoint& contact, std::int32_t value) const {
  return weights_of(contact)[value] * contact.feature.normal;
}

// Minus the change of the traction with the path along the surface, as far as its speed changes the
// friction.
template <int dim>
Matrix<dim> FacetContact<dim>::slope_by_speed(const ContactPoint& contact) const {
  const Vector<dim>& n = contact.feature.normal;
  const Vector<dim> path = tangential<dim>(contact.relative, n);
  const Vector<dim> pull = tangential<dim>(contact.slip, n);
  const double time = law_of(candidate(contact), contact.owner, contact.part).time;
  if (!(path.norm() > 0) || !(time > 0)) return Matrix<dim>::Zero();
  return contact.traction.by_speed / time * pull.normalized() * path.normalized().transpose();
}

template <int dim>
void FacetContact<dim>::add_stiffness(const ContactPoint& contact, const Matrix<dim>& slope,
                                      BlockMatrix<dim>& K) const {
  const Candidate& c = candidate(contact);
  const Vector<dim>& n = contact.feature.normal;
  const double* w = weights_of(contact);
  const auto nodes = search_.nodes_of(c);
  const double scale = force_weight_ * contact.area;
  const Vector<dim> by_depth = scale * (contact.frame * slope.col(0));
  const Matrix<dim> by_slip = scale * (contact.frame * slope * contact.frame.transpose()) *
                              (Matrix<dim>::Identity() - n * n.transpose());
  const Vector<dim> by_part = force_weight_ / contact.part *
                                  (contact.traction.elastic * tangential<dim>(contact.force, n)) -
                              by_slip * contact.slip_part_slope;
  const bool weakens = contact.traction.by_speed != 0;
  Matrix<dim> by_speed = Matrix<dim>::Zero();
  if (weakens) by_speed = scale * slope_by_speed(contact);
  const Vector<dim> by_begin = contact.slip_share_slope * (by_slip * contact.relative);
  for (std::int32_t j = 0; j < c.num_values; ++j) {
    Vector<dim> depth_slope = Vector<dim>::Zero(), part_slope = Vector<dim>::Zero();
    for (int l = 0; l < contact.num_others; ++l) {
      const Vector<dim> other = gap_slope(contacts_[contact.others[l]], j);
      depth_slope += contact.shares[l] * other;
      part_slope += contact.part_slopes[l] * other;
    }
    Matrix<dim> column = contact.slip_share * w[j] * by_slip + by_depth * depth_slope.transpose() +
                         by_part * part_slope.transpose() +
                         by_begin * gap_slope(contact, j).transpose();
    if (weakens) column += w[j] * by_speed;
    for (std::int32_t i = 0; i < c.num_values; ++i) {
      K.add_block(nodes[i], nodes[j], w[i] * column);
    }
  }
}

template <int dim>
void FacetContact<dim>::add_forces(std::span<const double> du, std::span<double> r,
                                   BlockMatrix<dim>* K) {
  contacts_.clear();
  opened_.clear();
  w_.clear();
  Matrix<dim> slope;
  search_.find(du, [&](std::int32_t candidate, std::span<const SurfaceFeature<dim>> features) {
    add_contacts(candidate, features, du);
  });
  order_contacts();
  for (std::int32_t owner = 0; owner < std::ssize(members_); ++owner) {
    for (const std::int32_t k : contacts_of(owner)) {
      ContactPoint& contact = contacts_[k];
      const Candidate& c = candidate(contact);
      Vector<dim> gap = contact.frame.transpose() * contact.slip;
      gap[0] = -contact.depth;
      const ContactLaw law = law_now(contact);
      contact.traction = law.template traction<dim>(gap, K ? &slope : nullptr);
      contact.force = contact.area * (contact.frame * contact.traction.t);
      search_.scatter(c, weights_of(contact), force_weight_ * contact.force, r);
      if (K) add_stiffness(contact, slope, *K);
    }
    if (force_weight_ != 1) add_old_forces(owner, 1 - force_weight_, r);
  }
}

template <int dim>
void FacetContact<dim>::add_step_force_change(std::span<double> f) const {
  for (std::int32_t owner = 0; owner < std::ssize(members_); ++owner) {
    for (const std::int32_t k : contacts_of(owner)) {
      const ContactPoint& contact = contacts_[k];
      search_.scatter(candidate(contact), weights_of(contact), contact.force, f);
    }
    add_old_forces(owner, -1, f);
  }
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
