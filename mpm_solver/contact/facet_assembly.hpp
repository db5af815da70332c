// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/contact/contact_assembly.hpp"
#include "mpm_solver/contact/facet_parts.hpp"

namespace gabion::mpm {

/// Add a share of a remembered force of each contact between the candidates and a member, at its
/// place at the start of the step.
template <int dim>
void add_remembered(const PointSearch<dim>& search, std::int32_t owner,
                    Vector<dim> RememberedContact<dim>::*force, double share,
                    std::span<double> field);

/// Forces of a contact by facets at its contact points, and their stiffness.
template <int dim>
class FacetAssembly final : public ContactAssembly<dim> {
 public:
  explicit FacetAssembly(FacetParts<dim>& parts) : parts_(parts) {}

  /// @param force_weight  of NewmarkBossak::step_force_weight
  void begin_step(double force_weight) { force_weight_ = force_weight; }

  bool symmetric() const override { return false; }
  /// Nothing: the nodes of a point are those of its group already.
  void append_cells(std::vector<std::int32_t>&, std::vector<std::int32_t>&) const override {}
  void add_forces(std::span<const double> du, std::span<double> r, BlockMatrix<dim>* K) override;
  void mark_touched(std::span<char> nodes, std::size_t member = 0) const override;
  double work_on_soil(std::span<const double> du) const override;
  bool is_step_force() const override { return true; }
  void add_step_force_change(std::span<double> f) const override;
  Vector<dim> step_force_on(std::span<const std::int64_t> ids) const override {
    return parts_.memory.force_on(ids, parts_.num_members());
  }

 private:
  using Candidate = ContactCandidate<dim>;
  using Point = ContactPoint<dim>;

  ContactLaw law_now(const Point& contact) const;
  Vector<dim> gap_slope(const Point& contact, std::int32_t value) const;
  Matrix<dim> slope_by_speed(const Point& contact) const;
  void add_stiffness(const Point& contact, const Matrix<dim>& slope, BlockMatrix<dim>& K) const;
  void add_old_forces(std::int32_t owner, double share, std::span<double> field) const;

  FacetParts<dim>& parts_;
  double force_weight_ = 1;
};

}  // namespace gabion::mpm
