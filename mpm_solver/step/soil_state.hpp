// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/petsc/krylov_pause.hpp"
#include "mpm_solver/contact/surfaces.hpp"
#include "mpm_solver/gauges/gauges.hpp"
#include "mpm_solver/ranks/point_ranks.hpp"
#include "mpm_solver/step/ledger.hpp"
#include "mpm_solver/step/soil_model.hpp"
#include "mpm_solver/step/step_control.hpp"

namespace gabion::mpm {

/// The accepted state: everything that later steps and probes depend on.
template <int dim>
struct SoilState {
  /// The state at time 0. Refers to the model. @note Collective.
  /// @throws ConfigError  a point lies outside the grid; initial stress that the soil does not bear
  explicit SoilState(const SoilModel<dim>& model);

  State save();
  /// @throws Error  not a state of these settings and this number of ranks; on all ranks
  /// @note Collective.
  void load(const State& state, const SoilModel<dim>& model);
  /// The same from the states of another number of ranks, see Solver::join_states.
  void join(const State& first, std::span<const State> own, const SoilModel<dim>& model);

  /// Where the points were at the start of a step.
  struct Start {
    std::span<const Vector<dim>> x;      ///< [m]
    std::span<const std::int32_t> cell;  ///< of the grid
  };
  /// Take the points out that are outside the grid.
  /// @param outside  ascending, of this rank
  /// @param start    not read where the model lets none out
  /// @throws Error  there are some and the model does not allow it; a probe is lost; none is left
  /// @note Collective.
  void remove(std::span<const std::int32_t> outside, const Start& start,
              const SoilModel<dim>& model);

  MaterialPoints<dim> points;
  Surfaces<dim> surfaces;
  Ledger<dim> ledger;
  StepControl control;
  Gauges<dim> gauges;
  std::vector<Vector<dim>> wall_forces;   ///< on SoilModel::wall_groups [N]
  std::vector<double> rigid_wall_forces;  ///< Surfaces::forces_on_walls
  PointRanks<dim> ranks;
  std::vector<std::int64_t> probe_ids;  ///< of the material point of each probe
  std::int64_t removed_points = 0;      ///< of all ranks
  std::vector<double> removed_masses;   ///< through SoilModel::exit_sides [kg]
  bool nearly_linear = false;  ///< the last step's first solution took one Newton iteration at most
  double contact_rate = 0;     ///< of the last explicit step, see StableStep [1/s^2]
  KrylovPause pause;           ///< LinearSolver::pause() after the last step

 private:
  void count_exits(std::span<const std::int32_t> outside, const Start& start,
                   const SoilModel<dim>& model);
  void visit(StateVisitor& visitor);
  void take(StateVisitor& visitor, const SoilModel<dim>& model);
};

}  // namespace gabion::mpm
