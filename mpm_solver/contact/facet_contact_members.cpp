// SPDX-License-Identifier: BSD-3-Clause
// The surfaces of a contact by facets, and what the touches of each come to.
#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm_solver/contact/facet_contact.hpp"

namespace gabion::mpm {

template <int dim>
FacetContact<dim>::FacetContact(const std::vector<const ContactSettings<dim>*>& members) {
  for (const auto* settings : members) add_member(*settings);
  target_ = end_ = start_;
  rim_ = rim_vertices<dim>(simplices_, start_.size());
  neighbours_ = neighbours_of<dim>(simplices_);
  order_touches();
}

template <int dim>
void FacetContact<dim>::add_member(const ContactSettings<dim>& settings) {
  Member& member = members_.emplace_back();
  member.mode = settings.mode;
  member.friction = settings.friction;
  member.drag = settings.drag;
  member.method = std::get<FacetSettings>(settings.method);
  member.surface = settings.surface;
  member.first_vertex = static_cast<std::int32_t>(start_.size());
  member.num_vertices = static_cast<std::int32_t>(settings.surface.vertices.size());
  member.first_simplex = static_cast<std::int32_t>(simplices_.size());
  start_.insert(start_.end(), settings.surface.vertices.begin(), settings.surface.vertices.end());
  for (Simplex<dim> simplex : simplices(settings.surface)) {
    for (std::int32_t& vertex : simplex) vertex += member.first_vertex;
    simplices_.push_back(simplex);
  }
  member.num_simplices = static_cast<std::int32_t>(simplices_.size()) - member.first_simplex;
  search_.add_member(static_cast<std::size_t>(member.num_simplices));
  owner_.resize(simplices_.size(), static_cast<std::int32_t>(members_.size()) - 1);
}

template <int dim>
void FacetContact<dim>::set_displacement(std::span<const double> displacement, std::size_t member) {
  Member& moved = members_[member];
  for (std::int32_t k = 0; k < moved.num_vertices; ++k) {
    const std::int32_t v = moved.first_vertex + k;
    end_[v] = moved.surface.vertices[k] +
              Eigen::Map<const Vector<dim>>(displacement.data() + std::ptrdiff_t{k} * dim);
    target_[v] = end_[v];
  }
  find_motion(moved);
  share_ = 1;
}

template <int dim>
void FacetContact<dim>::find_motion(Member& member) {
  member.motion = 0;
  for (std::int32_t k = 0; k < member.num_vertices && !member.dropped; ++k) {
    const std::int32_t v = member.first_vertex + k;
    member.motion = std::max(member.motion, (end_[v] - start_[v]).norm());
  }
  surface_motion_ = 0;
  for (const Member& other : members_) surface_motion_ = std::max(surface_motion_, other.motion);
}

// A ball that touched nothing else goes back to its point.
template <int dim>
bool FacetContact<dim>::drop(std::size_t member, bool dropped) {
  Member& own = members_[member];
  own.dropped = dropped;
  search_.drop(member, dropped);
  own.may_touch = false;
  own.substeps = {};
  if (!dropped) return true;
  own.energy.loss += own.energy.stored;
  own.energy.stored = own.stored_slip = 0;
  own.marks.clear();
  own.last_motion = 0;
  for (auto entry = memory_.begin(); entry != memory_.end();) {
    auto& [id, touches] = *entry;
    const auto forgotten = std::erase_if(touches, [member](const Memory& memory) {
      return memory.owner == static_cast<std::int32_t>(member);
    });
    if (forgotten > 0 && touches.empty()) offset_.erase(id);
    entry = touches.empty() ? memory_.erase(entry) : std::next(entry);
  }
  return true;
}

// Touches in the order in which their members stand, those of a member as they were found.
template <int dim>
void FacetContact<dim>::order_touches() {
  first_of_.assign(members_.size() + 1, 0);
  for (const Touch& touch : touches_) ++first_of_[touch.owner + 1];
  for (std::size_t m = 0; m < members_.size(); ++m) first_of_[m + 1] += first_of_[m];
  by_owner_.resize(touches_.size());
  std::vector<std::int32_t> next(first_of_.begin(), first_of_.end() - 1);
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    by_owner_[next[touches_[k].owner]++] = static_cast<std::int32_t>(k);
  }
}

template <int dim>
void FacetContact<dim>::add_vertex_forces(const Touch& touch, double share,
                                          std::span<double> forces) const {
  const Simplex<dim>& simplex = simplices_[touch.feature.simplex];
  for (int k = 0; k < dim; ++k) {
    Eigen::Map<Vector<dim>>(forces.data() + std::ptrdiff_t{simplex[k]} * dim) -=
        share * touch.feature.weights[k] * touch.force;
  }
}

template <int dim>
std::vector<double> FacetContact<dim>::forces_on_structure(std::size_t member) const {
  std::vector<double> forces = substep_forces_;
  if (!has_substeps_) {
    forces.assign(start_.size() * dim, 0.0);
    for (const std::int32_t k : touches_of(member)) add_vertex_forces(touches_[k], 1, forces);
  }
  const Member& own = members_[member];
  const auto first = forces.begin() + std::ptrdiff_t{own.first_vertex} * dim;
  return {first, first + std::ptrdiff_t{own.num_vertices} * dim};
}

template <int dim>
typename Contact<dim>::Resultant FacetContact<dim>::resultant(std::size_t member) const {
  if (has_substeps_) return members_[member].substeps.resultant;
  typename Contact<dim>::Resultant sum;
  for (const std::int32_t k : touches_of(member)) {
    sum.add(touches_[k].feature.x, -touches_[k].force);
  }
  return sum;
}

template <int dim>
double FacetContact<dim>::work_on_soil(std::span<const double>) const {
  double sum = 0;
  for (std::size_t owner = 0; owner < members_.size(); ++owner) {
    double work = 0;
    for (const std::int32_t k : touches_of(owner)) {
      work += touches_[k].motion.dot(touches_[k].force);
    }
    sum += work;
  }
  return sum;
}

template <int dim>
ContactCounts FacetContact<dim>::counts(std::size_t member) const {
  ContactCounts result;
  for (const std::int32_t k : touches_of(member)) {
    const Touch& touch = touches_[k];
    ++result.closed;
    result.sliding += touch.traction.sliding;
    result.penetration = std::max(result.penetration, -touch.gap - touch.begun);
  }
  if (has_substeps_) result.closed = std::max(result.closed, members_[member].substeps.closed);
  return result;
}

template <int dim>
ContactEnergy FacetContact<dim>::energy() const {
  ContactEnergy sum;
  for (const Member& member : members_) {
    sum.stored += member.energy.stored;
    sum.friction += member.energy.friction;
    sum.loss += member.energy.loss;
  }
  return sum;
}

template <int dim>
Vector<dim> FacetContact<dim>::surface_motion(const SurfaceFeature<dim>& feature) const {
  Vector<dim> motion = Vector<dim>::Zero();
  if (surface_motion_ == 0) return motion;
  for (int k = 0; k < dim; ++k) {
    const std::int32_t v = simplices_[feature.simplex][k];
    motion += feature.weights[k] * (end_[v] - start_[v]);
  }
  return motion;
}

// The motion of a point in the last add_forces [m].
template <int dim>
Vector<dim> FacetContact<dim>::motion_of(std::int32_t entry, const CellGroup& group) const {
  Vector<dim> motion = Vector<dim>::Zero();
  if (du_.empty()) return motion;
  const PointWeights<dim>& weights = soil_->weights;
  const double* N = weights.N_of(entry);
  const std::uint8_t* local = weights.local_of(entry);
  const std::int32_t first = weights.nodes_of(group).first;
  for (int i = 0; i < weights.num_nodes(entry); ++i) {
    const std::ptrdiff_t node = soil_->nodes.of_groups[first + local[i]];
    motion += N[i] * Eigen::Map<const Vector<dim>>(du_.data() + node * dim);
  }
  return motion;
}

// A point that touched nothing and is far away, or slow, cannot ask for the smallest step.
template <int dim>
double FacetContact<dim>::approach_step(double dt, double margin) const {
  double result = std::numeric_limits<double>::infinity();
  for (const WatchedGroup& watched : watched_groups_) {
    const CellGroup& group = soil_->weights.groups[watched.group];
    for (std::int32_t k = watched.first; k < watched.last; ++k) {
      const Watched& point = watched_[k];
      const Vector<dim> motion = motion_of(point.entry, group);
      if (point.candidate < 0) {
        const double closing = motion.norm() + surface_motion_;  // or less
        const double nearest = search_.far_at_least(point.x, Vector<dim>::Zero());
        const double gap = std::max(nearest - closing - point.reach, 0.0);
        if (dt * (gap + margin) > 1.001 * result * closing) continue;
      }
      const Candidate c =
          point.candidate < 0 ? candidate_of(point, group) : candidates_[point.candidate];
      const Facing facing = facing_of(c);
      if (facing.simplices.empty()) continue;
      for (const Near& near : facing.near) {
        const Vector<dim>& n = near.place.normal;
        const double closing = n.dot(surface_motion(near.place) - motion);
        const double gap = near.distance - closing - radius(c, n);
        if (closing > 0) result = std::min(result, dt * (std::max(gap, 0.0) + margin) / closing);
      }
    }
  }
  return result;
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
