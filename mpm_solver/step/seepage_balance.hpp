// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "mpm_solver/step/equilibrium.hpp"
#include "mpm_solver/step/seepage_borders.hpp"
#include "mpm_solver/stress/seepage_forces.hpp"

namespace gabion::mpm {

/// Balance of momentum and of water of the active nodes at the end of a step. Unknowns and rows of
/// a node: its displacement, and psi = (q - q_start) h / M; forces, and volumes of water times
/// M / h, with the cell size h and the modulus M of P waves. So unknowns are lengths and rows
/// forces. Refers to its parts; valid for one step.
template <int dim>
class SeepageBalance final : public NewtonProblem<dim + 1> {
 public:
  static constexpr int block_size = dim + 1;

  /// @param K_uu  matrix with the pattern of `equilibrium`, for its part
  SeepageBalance(Equilibrium<dim>& equilibrium, SeepageForces<dim>& water, BlockMatrix<dim>& K_uu,
                 const DrainedNodes& drained);

  const SharedNodes& shared() const override { return equilibrium_.shared(); }
  Evaluation evaluate(std::span<const double> x, std::span<double> r,
                      BlockMatrix<block_size>* K) override;
  bool regularise(double share) override { return equilibrium_.regularise(share); }
  bool support(bool on) override { return equilibrium_.support(on); }
  double increment_scale() const override { return equilibrium_.increment_scale(); }
  std::string describe_node(std::size_t i) const override { return equilibrium_.describe_node(i); }
  std::string describe_worst_point(std::span<const double> x) const override;

  /// Unknowns of a guess with this displacement and the accepted pressures, num_nodes x (dim + 1).
  std::vector<double> guess(std::span<const double> du) const;
  /// The displacement in x, num_nodes x dim [m].
  std::vector<double> displacement(std::span<const double> x) const;
  /// Volume of water that leaves through drained nodes and the free surface in the state of the
  /// last evaluation [m^3].
  double outflow() const { return outflow_ + water_.outflow(); }
  /// Work of the pressure beyond drained nodes on the water that comes in there, less that of what
  /// leaves, in the state of the last evaluation, of the nodes of this rank [J].
  double drained_work() const { return drained_work_; }

 private:
  void add_equilibrium(BlockMatrix<block_size>& K) const;
  void constrain(BlockMatrix<block_size>& K) const;

  Equilibrium<dim>& equilibrium_;
  SeepageForces<dim>& water_;
  BlockMatrix<dim>& K_uu_;
  double scale_;                 // M / h [Pa/m]
  std::vector<double> q_start_;  // of each node [Pa]
  std::vector<char> held_;  // by node: 1 where it has no water of its own, 2 where it is drained
  std::vector<double> p_drained_;  // pressure of drained nodes, else 0 [Pa]
  std::vector<double> q_, r_u_;
  double outflow_ = 0, drained_work_ = 0;
};

}  // namespace gabion::mpm
