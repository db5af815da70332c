// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_assembly.hpp"

#include <algorithm>

#include "mpm_solver/contact/contact_frame.hpp"

namespace gabion::mpm {

template <int dim>
void add_remembered(const PointSearch<dim>& search, std::int32_t owner,
                    Vector<dim> RememberedContact<dim>::*force, double share,
                    std::span<double> field) {
  std::vector<double> w;
  for (const ContactCandidate<dim>& c : search.candidates()) {
    if (!c.memory) continue;
    w.resize(c.num_values);
    for (const RememberedContact<dim>& memory : *c.memory) {
      if (memory.owner != owner) continue;
      search.surface_weights(c, memory.normal, w.data());
      search.scatter(c, w.data(), share * memory.*force, field);
    }
  }
}

// The law in the step under way: with the pore water and the speed along the surface.
template <int dim>
ContactLaw FacetAssembly<dim>::law_now(const Point& contact) const {
  ContactLaw law = parts_.points.law_of(contact, contact.part);
  parts_.laws.add_water(parts_.points.candidate(contact), contact.owner, contact.radius,
                        contact.feature.normal, law);
  if (law.weakening.fall > 0 && law.time > 0)
    law.speed = tangential<dim>(contact.relative, contact.feature.normal).norm() / law.time;
  return law;
}

// Change of the gap with the displacement of a node. @param value  of the candidate's
template <int dim>
Vector<dim> FacetAssembly<dim>::gap_slope(const Point& contact, std::int32_t value) const {
  return parts_.points.weights_of(contact)[value] * contact.feature.normal;
}

// Minus the change of the traction with the path along the surface, as far as its speed changes the
// friction.
template <int dim>
Matrix<dim> FacetAssembly<dim>::slope_by_speed(const Point& contact) const {
  const Vector<dim>& n = contact.feature.normal;
  const Vector<dim> path = tangential<dim>(contact.relative, n);
  const Vector<dim> pull = tangential<dim>(contact.slip, n);
  const double time = parts_.points.law_of(contact, contact.part).time;
  if (!(path.norm() > 0) || !(time > 0)) return Matrix<dim>::Zero();
  return contact.traction.by_speed / time * pull.normalized() * path.normalized().transpose();
}

template <int dim>
void FacetAssembly<dim>::add_stiffness(const Point& contact, const Matrix<dim>& slope,
                                       BlockMatrix<dim>& K) const {
  const Candidate& c = parts_.points.candidate(contact);
  const Vector<dim>& n = contact.feature.normal;
  const double* w = parts_.points.weights_of(contact);
  const auto nodes = parts_.search.nodes_of(c);
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
      const Vector<dim> other = gap_slope(parts_.points.all()[contact.others[l]], j);
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
void FacetAssembly<dim>::add_forces(std::span<const double> du, std::span<double> r,
                                    BlockMatrix<dim>* K) {
  Matrix<dim> slope;
  parts_.points.find(du);
  auto& contacts = parts_.points.all();
  for (std::int32_t owner = 0; owner < parts_.surface.num_members(); ++owner) {
    for (const std::int32_t k : parts_.points.of(owner)) {
      Point& contact = contacts[k];
      const Candidate& c = parts_.points.candidate(contact);
      Vector<dim> gap = contact.frame.transpose() * contact.slip;
      gap[0] = -contact.depth;
      const ContactLaw law = law_now(contact);
      contact.traction = law.template traction<dim>(gap, K ? &slope : nullptr);
      contact.force = contact.area * (contact.frame * contact.traction.t);
      parts_.search.scatter(c, parts_.points.weights_of(contact), force_weight_ * contact.force, r);
      if (K) add_stiffness(contact, slope, *K);
    }
    if (force_weight_ != 1) add_old_forces(owner, 1 - force_weight_, r);
  }
}

template <int dim>
void FacetAssembly<dim>::add_step_force_change(std::span<double> f) const {
  const auto& contacts = parts_.points.all();
  for (std::int32_t owner = 0; owner < parts_.surface.num_members(); ++owner) {
    for (const std::int32_t k : parts_.points.of(owner)) {
      const Point& contact = contacts[k];
      parts_.search.scatter(parts_.points.candidate(contact), parts_.points.weights_of(contact),
                            contact.force, f);
    }
    add_old_forces(owner, -1, f);
  }
}

template <int dim>
void FacetAssembly<dim>::add_old_forces(std::int32_t owner, double share,
                                        std::span<double> field) const {
  add_remembered(parts_.search, owner, &RememberedContact<dim>::force, share, field);
}

template <int dim>
double FacetAssembly<dim>::work_on_soil(std::span<const double>) const {
  const auto& contacts = parts_.points.all();
  double sum = 0;
  for (std::size_t owner = 0; owner < parts_.num_members(); ++owner) {
    double work = 0;
    for (const std::int32_t k : parts_.points.of(owner)) {
      work += contacts[k].motion.dot(contacts[k].force);
    }
    sum += work;
  }
  return sum;
}

template <int dim>
void FacetAssembly<dim>::mark_touched(std::span<char> nodes, std::size_t member) const {
  const auto& contacts = parts_.points.all();
  for (const std::int32_t index : parts_.points.of(member)) {
    for (const std::int32_t node : parts_.search.nodes_of(parts_.points.candidate(contacts[index])))
      nodes[node] = 1;
  }
}

template void add_remembered<2>(const PointSearch<2>&, std::int32_t,
                                Vector<2> RememberedContact<2>::*, double, std::span<double>);
template void add_remembered<3>(const PointSearch<3>&, std::int32_t,
                                Vector<3> RememberedContact<3>::*, double, std::span<double>);
template class FacetAssembly<2>;
template class FacetAssembly<3>;

}  // namespace gabion::mpm
