// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/joint_surface.hpp"

#include <algorithm>
#include <utility>

#include "mpm_solver/points/flat.hpp"

namespace gabion::mpm {

template <int dim>
JointSurface<dim>::JointSurface(const std::vector<const ContactSettings<dim>*>& members) {
  for (const auto* settings : members) add(*settings);
  target_ = end_ = start_;
  rim_ = rim_vertices<dim>(simplices_, start_.size());
  neighbours_ = neighbours_of<dim>(simplices_);
}

template <int dim>
void JointSurface<dim>::add(const ContactSettings<dim>& settings) {
  const ContactSurface<dim>& surface = settings.surface;
  Member& member = members_.emplace_back();
  member.name = settings.name;
  member.surface = surface;
  member.first_vertex = static_cast<std::int32_t>(start_.size());
  member.num_vertices = static_cast<std::int32_t>(surface.vertices.size());
  start_.insert(start_.end(), surface.vertices.begin(), surface.vertices.end());
  cut(member);
}

// Add the simplices of a member behind those of the others.
template <int dim>
void JointSurface<dim>::cut(Member& member) {
  member.first_simplex = static_cast<std::int32_t>(simplices_.size());
  for (Simplex<dim> simplex : gabion::mpm::simplices(member.surface)) {
    for (std::int32_t& vertex : simplex) vertex += member.first_vertex;
    simplices_.push_back(simplex);
  }
  member.num_simplices = static_cast<std::int32_t>(simplices_.size()) - member.first_simplex;
  search_.add_member(static_cast<std::size_t>(member.num_simplices));
  owner_.resize(simplices_.size(), static_cast<std::int32_t>(&member - members_.data()));
}

template <int dim>
void JointSurface<dim>::set_facets(std::size_t member, std::vector<std::int32_t> facets) {
  members_[member].surface.facets = std::move(facets);
  simplices_.clear();
  owner_.clear();
  search_ = {};
  for (std::size_t m = 0; m < members_.size(); ++m) {
    cut(members_[m]);
    search_.drop(m, members_[m].dropped || members_[m].num_simplices == 0);
  }
  rim_ = rim_vertices<dim>(simplices_, start_.size());
  neighbours_ = neighbours_of<dim>(simplices_);
}

template <int dim>
void JointSurface<dim>::set_displacement(std::span<const double> displacement, std::size_t member) {
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
void JointSurface<dim>::set_share(double share) {
  share_ = share;
  if (motion_ == 0) return;  // neither do the surfaces in the whole step
  if (share == 1) {
    end_ = target_;
  } else {
    for (std::size_t v = 0; v < end_.size(); ++v) {
      end_[v] = start_[v] + share * (target_[v] - start_[v]);
    }
  }
  for (Member& member : members_) find_motion(member);
}

template <int dim>
void JointSurface<dim>::find_motion(Member& member) {
  member.motion = 0;
  for (std::int32_t k = 0; k < member.num_vertices && !member.dropped; ++k) {
    const std::int32_t v = member.first_vertex + k;
    member.motion = std::max(member.motion, (end_[v] - start_[v]).norm());
  }
  motion_ = 0;
  for (const Member& other : members_) motion_ = std::max(motion_, other.motion);
}

template <int dim>
Vector<dim> JointSurface<dim>::motion_at(const SurfaceFeature<dim>& place) const {
  Vector<dim> motion = Vector<dim>::Zero();
  if (motion_ == 0) return motion;
  for (int k = 0; k < dim; ++k) {
    const std::int32_t v = simplices_[place.simplex][k];
    motion += place.weights[k] * (end_[v] - start_[v]);
  }
  return motion;
}

template <int dim>
FacingSurface<dim> JointSurface<dim>::view(std::span<const FacingSimplex> facing,
                                           double seam) const {
  return {.simplices = simplices_,
          .start = start_,
          .end = end_,
          .facing = facing,
          .rim = rim_,
          .owner = members_.size() > 1 ? std::span<const std::int32_t>(owner_)
                                       : std::span<const std::int32_t>(),
          .motion = motion_,
          .size = search_.size(),
          .seam = seam};
}

template <int dim>
void JointSurface<dim>::accept() {
  start_ = end_;
  for (std::size_t m = 0; m < members_.size(); ++m) {
    search_.add_motion(m, members_[m].motion);
    members_[m].last_motion = members_[m].motion;
  }
}

template <int dim>
void JointSurface<dim>::drop(std::size_t member, bool dropped) {
  members_[member].dropped = dropped;
  search_.drop(member, dropped || members_[member].num_simplices == 0);
  if (dropped) members_[member].last_motion = 0;
}

template <int dim>
void JointSurface<dim>::visit_vertices(StateVisitor& visitor, const std::string& prefix) {
  visitor.reals(prefix + "vertices", flat(start_));
  search_.forget();
}

template class JointSurface<2>;
template class JointSurface<3>;

}  // namespace gabion::mpm
