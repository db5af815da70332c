// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/tensor.hpp"
#include "fem_solver/fem_config.hpp"
#include "fem_solver/stress/nodal_parts.hpp"

namespace gabion::fem {

/// Node of a mesh at this position, by its number in the whole.
/// @throws ConfigError  no node within 1e-6 of the mesh's extent; names the nearest one
/// @note Collective.
template <int dim>
std::int32_t node_at(const Mesh<dim>& mesh, const MeshRanks& ranks, const Vector<dim>& point,
                     const std::string& where);

/// Consistent nodal parts of a unit density: integral of N_a over the facets, num_nodes.
template <int dim>
std::vector<double> facet_weights(const Mesh<dim>& mesh, std::span<const std::int32_t> facets);

/// Masses and springs at the nodes that this rank owns.
/// @throws ConfigError  missing group, no node at a point
/// @note Collective.
template <int dim>
NodalParts<dim> nodal_parts(const FemSettings<dim>& settings);

/// C += the dashpots of the nodes that this rank owns.
/// @throws ConfigError  missing group, no node at a point
/// @note Collective.
template <int dim>
void add_dashpots(const FemSettings<dim>& settings, BlockMatrix<dim>& C);

/// Supports, prescribed displacements and loads of a structure, at the nodes that this rank holds.
template <int dim>
class BoundaryConditions {
 public:
  /// @throws ConfigError  missing group (with those that exist), a component constrained by both a
  ///                      support and a prescribed displacement, or by two prescribed ones
  /// @note Collective.
  explicit BoundaryConditions(const FemSettings<dim>& settings);

  /// Nodes with at least one constrained component, ascending, and the projectors onto their free
  /// directions.
  std::span<const std::int32_t> constrained_nodes() const { return nodes_; }
  std::span<const Matrix<dim>> projectors() const { return projectors_; }
  /// Constrained degrees of freedom, node * dim + component, ascending.
  std::span<const std::int32_t> constrained_dofs() const { return dofs_; }

  /// Displacement of the constrained degrees of freedom, in their order [m].
  std::vector<double> displacements(double time) const;

  /// Add the point loads and tractions at `time` to f, num_nodes x dim [N].
  void add_loads(double time, std::span<double> f) const;

  /// Whether loads and prescribed displacements never change again from `time` on.
  bool constant_after(double time) const;

 private:
  struct Load {
    std::vector<std::int32_t> nodes;
    std::vector<Vector<dim>> forces;  // [N] at factor 1
    TimeFunction factor;
  };
  struct Constraint {
    std::int32_t node;
    int component, function;
  };
  static void add_constraint(std::vector<int>& owner, const Constraint& constraint,
                             const MeshRanks& ranks, const std::string& where);
  std::vector<int> find_owners(const FemSettings<dim>& settings);
  void collect_constraints(const std::vector<int>& owner);
  void collect_loads(const FemSettings<dim>& settings);

  std::vector<std::int32_t> nodes_;
  std::vector<Matrix<dim>> projectors_;
  std::vector<std::int32_t> dofs_;
  std::vector<int> dof_functions_;  // of each constrained dof, -1 = fixed
  std::vector<TimeFunction> functions_;
  std::vector<Load> loads_;
};

}  // namespace gabion::fem
