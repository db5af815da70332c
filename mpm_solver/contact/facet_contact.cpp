// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gabion::mpm {

namespace {

template <int dim>
Matrix<dim> frame_of(const Vector<dim>& n) {
  Matrix<dim> frame;
  frame.col(0) = n;
  if constexpr (dim == 2) {
    frame.col(1) << -n[1], n[0];
  } else {
    frame.col(1) = n.unitOrthogonal();
    frame.col(2) = n.cross(frame.col(1));
  }
  return frame;
}

template <int dim>
Vector<dim> tangential(const Vector<dim>& v, const Vector<dim>& n) {
  return v - n.dot(v) * n;
}

}  // namespace

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
                 .time = soil_ ? share_ * soil_->dt : 0};
  const double k = method.resting_factor;
  if (c.took_weight && k * k * M > 4 * c.weight * method.penalty_factor) {
    law.penalty = k * k * M / (4 * c.weight) * M / (h * h);
    law.linear_from = 2 * h * c.weight / (k * M);
  }
  return law;
}

template <int dim>
const typename FacetContact<dim>::Memory* FacetContact<dim>::remembered(const Candidate& c,
                                                                        const Vector<dim>& n,
                                                                        std::int32_t owner) const {
  if (!c.memory) return nullptr;
  const Memory* best = nullptr;
  double largest = same_normal;
  for (const Memory& memory : *c.memory) {
    if (owner != any_owner && memory.owner != owner) continue;
    if (memory.normal.dot(n) <= largest) continue;
    largest = memory.normal.dot(n);
    best = &memory;
  }
  return best;
}

template <int dim>
double FacetContact<dim>::most_begun(const Candidate& c) {
  double most = 0;
  if (!c.memory) return most;
  for (const Memory& memory : *c.memory) most = std::max(most, memory.begun());
  return most;
}

// A touch that goes on has slipped since it began; a new one since the way met the surface.
template <int dim>
void FacetContact<dim>::set_slip(const Candidate& c, Touch& touch) const {
  const Vector<dim>& n = touch.feature.normal;
  const Vector<dim> way = tangential<dim>(touch.relative, n);
  if (const Memory* memory = remembered(c, n)) {
    const Vector<dim> slip = memory->tangential();
    const Vector<dim> turned = tangential<dim>(slip, n);
    const double size = turned.norm();
    touch.slip = way;
    touch.old_part = memory->part;
    if (size > 0) touch.old_slip = turned * (slip.norm() / size);
    return;
  }
  const double closing = -n.dot(touch.relative);
  const double gap_before = touch.gap + closing;
  if (gap_before > 0) {
    touch.slip_share = -touch.gap / closing;
    touch.slip_share_slope = -gap_before / (closing * closing);
  }
  touch.slip = touch.slip_share * way;
}

// The old slip in springs of the present stiffness. Those that became softer keep it, those that
// became stiffer keep its force: either way they hold no more energy than before.
template <int dim>
void FacetContact<dim>::follow_part(Touch& touch) {
  if (touch.part <= touch.old_part) {
    touch.slip += touch.old_slip;
    return;
  }
  const double kept = touch.old_part / touch.part;
  touch.slip += kept * touch.old_slip;
  touch.slip_part_slope = -kept / touch.part * touch.old_slip;
}

// The functions of the point where its ball, as the step began, has its surface in the direction
// -n.
template <int dim>
void FacetContact<dim>::surface_weights(const Candidate& c, const Vector<dim>& n, double* w) const {
  Vector<dim> d = c.offset - radius(c, n) * n;
  const double* N = N_.data() + c.first_value;
  if (c.surface) {
    d -= c.surface->at(n, -n.dot(d), w);
    N = w;
  }
  for (std::int32_t k = 0; k < c.num_values; ++k) w[k] = N[k] + grad_N_[c.first_value + k].dot(d);
}

template <int dim>
typename FacetContact<dim>::Touch FacetContact<dim>::touch_at(const Candidate& c,
                                                              const SurfaceFeature<dim>& feature,
                                                              std::span<const double> du) {
  const Vector<dim>& n = feature.normal;
  Touch touch;
  touch.owner = owner_[feature.simplex];
  touch.feature = feature;
  touch.radius = radius(c, n);
  touch.area = c.volume / (2 * touch.radius);
  touch.first_weight = static_cast<std::int32_t>(w_.size());
  w_.resize(w_.size() + c.num_values);
  double* w = w_.data() + touch.first_weight;
  surface_weights(c, n, w);
  for (std::int32_t k = 0; k < c.num_values; ++k) {
    const std::ptrdiff_t node = nodes_[c.first_value + k];
    touch.motion += w[k] * Eigen::Map<const Vector<dim>>(du.data() + node * dim);
  }
  if (const Memory* memory = remembered(c, n)) touch.begun = memory->begun();
  touch.gap = feature.distance - touch.radius + n.dot(touch.motion - c.motion) - touch.begun;
  touch.relative = touch.motion - surface_motion(feature);
  set_slip(c, touch);
  touch.frame = frame_of<dim>(n);
  return touch;
}

// Along the normal of a touch, after the step: the gap stays what it was. Where a rigid ball opens,
// it goes back to its point as far as it does not touch.
template <int dim>
double FacetContact<dim>::offset_after(const Touch& touch) const {
  const Candidate& c = candidates_[touch.candidate];
  const Vector<dim>& n = touch.feature.normal;
  const double offset = n.dot(c.offset + touch.motion - c.motion);
  if (c.deforms) return offset + (c.shape * (n + c.H.transpose() * n)).norm() - touch.radius;
  if (touch.gap < 0) return std::max(offset, -touch.radius);
  return std::max(offset - touch.gap - touch.begun, 0.0);
}

// Members that meet in a corner with the point in it, or that face each other with the point
// between them, push each for itself.
template <int dim>
void FacetContact<dim>::share_in_corners(const Candidate& c, std::size_t first) {
  if (members_.size() == 1 || touches_.size() <= first + 1) return share_depths(c, first);
  const auto surface = surface_of(c, end_);
  const auto apart = [&](const Touch& a, const Touch& b) {
    return are_in_corner<dim>(surface, a.feature.simplex, b.feature.simplex);
  };
  std::vector<std::vector<Touch>> groups;
  for (std::size_t k = first; k < touches_.size(); ++k) {
    const auto group = std::ranges::find_if(groups, [&](const auto& touches) {
      return std::ranges::none_of(touches, [&](const Touch& t) { return apart(t, touches_[k]); });
    });
    if (group == groups.end()) {
      groups.push_back({touches_[k]});
    } else {
      group->push_back(touches_[k]);
    }
  }
  if (groups.size() <= 1) return share_depths(c, first);
  touches_.resize(first);
  for (const auto& touches : groups) {
    const std::size_t begin = touches_.size();
    touches_.insert(touches_.end(), touches.begin(), touches.end());
    share_depths(c, begin);
  }
}

// Depths of the touches of one point. Where several push, the traction of all is penalty g(|u|) u,
// of which each has its part: penalty g lambda_k, u = sum_k lambda_k n_k the shortest way out. The
// tangential stiffness of all is that of one, too: parts lambda_k delta_k / |u|^2 add up to 1.
template <int dim>
void FacetContact<dim>::share_depths(const Candidate& c, std::size_t first) {
  if (touches_.size() == first) return;
  if (touches_.size() == first + 1) {
    Touch& touch = touches_.back();
    const double depth = -touch.gap;
    const ContactLaw law = law_of(c, touch.owner, 1);
    const double reduced = law.reduced(depth);
    touch.depth = std::sqrt(depth * reduced);
    const bool is_linear = depth > law.linear_from;
    touch.stored_depth = is_linear ? std::cbrt(law.storing(depth) * depth * depth) : depth;
    touch.num_others = 1;
    touch.others[0] = static_cast<std::int32_t>(first);
    touch.shares[0] = (reduced + law.reduced_slope(depth) * depth) / (2 * touch.depth);
    follow_part(touch);
    return;
  }
  std::vector<Vector<dim>> normals;
  std::vector<double> deltas;
  for (std::size_t k = first; k < touches_.size(); ++k) {
    normals.push_back(touches_[k].feature.normal);
    deltas.push_back(-touches_[k].gap);
  }
  const WayOut<dim> out = way_out<dim>(normals, deltas);
  for (int k = 0; k < out.size; ++k) {
    Touch touch = touches_[first + out.planes[k]];  // planes ascend
    const ContactLaw law = law_of(c, touch.owner, 1);
    const double reduced = law.reduced(out.length), slope = law.reduced_slope(out.length);
    touch.depth = std::sqrt(out.depths[k] * reduced);
    touch.stored_depth = std::cbrt(law.storing(out.length) * out.depths[k] * -touch.gap);
    touch.num_others = out.size;
    const double square = out.length * out.length;
    touch.part = out.depths[k] * -touch.gap / square;
    for (int l = 0; l < out.size; ++l) {
      touch.part_slopes[l] = (out.inverse(k, l) * -touch.gap + (k == l ? out.depths[k] : 0) -
                              2 * touch.part * out.depths[l]) /
                             square;
      touch.others[l] = static_cast<std::int32_t>(first) + l;
      touch.shares[l] =
          (reduced * out.inverse(k, l) + slope * out.depths[k] * out.depths[l] / out.length) /
          (2 * touch.depth);
    }
    follow_part(touch);
    touches_[first + k] = touch;
  }
  touches_.resize(first + out.size);
}

template <int dim>
void FacetContact<dim>::scatter(const Candidate& c, const double* w, const Vector<dim>& f,
                                std::span<double> field) const {
  for (std::int32_t k = 0; k < c.num_values; ++k) {
    const std::ptrdiff_t node = nodes_[c.first_value + k];
    Eigen::Map<Vector<dim>>(field.data() + node * dim) += w[k] * f;
  }
}

// Change of the gap with the displacement of a node. @param value  of the candidate's
template <int dim>
Vector<dim> FacetContact<dim>::gap_slope(const Touch& touch, std::int32_t value) const {
  return weights_of(touch)[value] * touch.feature.normal;
}

template <int dim>
void FacetContact<dim>::add_stiffness(const Touch& touch, const Matrix<dim>& slope,
                                      BlockMatrix<dim>& K) const {
  const Candidate& c = candidates_[touch.candidate];
  const Vector<dim>& n = touch.feature.normal;
  const double* w = weights_of(touch);
  const std::int32_t* nodes = nodes_.data() + c.first_value;
  const double scale = force_weight_ * touch.area;
  const Vector<dim> by_depth = scale * (touch.frame * slope.col(0));
  const Matrix<dim> by_slip = scale * (touch.frame * slope * touch.frame.transpose()) *
                              (Matrix<dim>::Identity() - n * n.transpose());
  const Vector<dim> by_part =
      force_weight_ / touch.part * (touch.traction.elastic * tangential<dim>(touch.force, n)) -
      by_slip * touch.slip_part_slope;
  const Vector<dim> by_begin = touch.slip_share_slope * (by_slip * touch.relative);
  for (std::int32_t j = 0; j < c.num_values; ++j) {
    Vector<dim> depth_slope = Vector<dim>::Zero(), part_slope = Vector<dim>::Zero();
    for (int l = 0; l < touch.num_others; ++l) {
      const Vector<dim> other = gap_slope(touches_[touch.others[l]], j);
      depth_slope += touch.shares[l] * other;
      part_slope += touch.part_slopes[l] * other;
    }
    const Matrix<dim> column =
        touch.slip_share * w[j] * by_slip + by_depth * depth_slope.transpose() +
        by_part * part_slope.transpose() + by_begin * gap_slope(touch, j).transpose();
    for (std::int32_t i = 0; i < c.num_values; ++i) {
      K.add_block(nodes[i], nodes[j], w[i] * column);
    }
  }
}

template <int dim>
void FacetContact<dim>::add_forces(std::span<const double> du, std::span<double> r,
                                   BlockMatrix<dim>* K) {
  touches_.clear();
  opened_.clear();
  w_.clear();
  Matrix<dim> slope;
  find_touches(du);
  order_touches();
  for (std::int32_t owner = 0; owner < std::ssize(members_); ++owner) {
    for (const std::int32_t k : touches_of(owner)) {
      Touch& touch = touches_[k];
      const Candidate& c = candidates_[touch.candidate];
      Vector<dim> gap = touch.frame.transpose() * touch.slip;
      gap[0] = -touch.depth;
      touch.traction =
          law_of(c, owner, touch.part).template traction<dim>(gap, K ? &slope : nullptr);
      touch.force = touch.area * (touch.frame * touch.traction.t);
      scatter(c, weights_of(touch), force_weight_ * touch.force, r);
      if (K) add_stiffness(touch, slope, *K);
    }
    if (force_weight_ != 1) add_old_forces(owner, 1 - force_weight_, r);
  }
}

template <int dim>
void FacetContact<dim>::add_step_force_change(std::span<double> f) const {
  for (std::int32_t owner = 0; owner < std::ssize(members_); ++owner) {
    for (const std::int32_t k : touches_of(owner)) {
      const Touch& touch = touches_[k];
      scatter(candidates_[touch.candidate], weights_of(touch), touch.force, f);
    }
    add_old_forces(owner, -1, f);
  }
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
