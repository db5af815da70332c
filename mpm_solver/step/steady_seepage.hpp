// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

#include "mpm_solver/step/equilibrium.hpp"
#include "mpm_solver/step/seepage_borders.hpp"
#include "mpm_solver/stress/seepage_forces.hpp"

namespace gabion::mpm {

/// Balance of water of the active nodes while the skeleton does not move. Unknowns and rows are
/// those of SeepageBalance, with displacements and forces held at zero. Refers to its parts; valid
/// for one step.
template <int dim>
class RigidSeepage final : public NewtonProblem<dim + 1> {
 public:
  static constexpr int block_size = dim + 1;

  RigidSeepage(const Equilibrium<dim>& equilibrium, SeepageForces<dim>& water,
               const DrainedNodes& drained, double unit_volume);

  const SharedNodes& shared() const override { return equilibrium_.shared(); }
  Evaluation evaluate(std::span<const double> x, std::span<double> r,
                      BlockMatrix<block_size>* K) override;
  double increment_scale() const override { return equilibrium_.increment_scale(); }
  std::string describe_node(std::size_t i) const override { return equilibrium_.describe_node(i); }

  /// Heads of the nodes in the last evaluation, as of SeepageForces::Trial [Pa].
  const std::vector<double>& heads() const { return q_; }
  /// Volume that leaves through drained nodes, the surface and sides in the last evaluation [m^3].
  /// @note Collective.
  double leaving() const;

 private:
  void constrain(BlockMatrix<block_size>& K) const;

  const Equilibrium<dim>& equilibrium_;
  SeepageForces<dim>& water_;
  double unit_volume_;           // scale of the volumes of a node [m^3]
  double scale_;                 // M / h [Pa/m]
  std::vector<double> q_start_;  // of each node [Pa]
  std::vector<char> held_;  // by node: 1 where it has no water of its own, 2 where it is drained
  std::vector<double> q_, still_;
};

/// Add to the pressures of all water that drains [Pa].
template <int dim>
void change_pressures(const std::vector<Body<dim>>& bodies, double by, MaterialPoints<dim>& points);

/// Heads of nodes of the grid, as of SeepageForces::Trial [Pa].
using HeadsOfNodes = std::unordered_map<std::int32_t, double>;
/// Head at a place by the linear functions of its cell, of nodes that have one alone [Pa].
template <int dim>
double head_at(const BoxGrid<dim>& box, const HeadsOfNodes& heads, const Vector<dim>& x);

}  // namespace gabion::mpm
