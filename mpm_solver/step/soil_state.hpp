// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/mechanics/petsc/krylov_pause.hpp"
#include "mpm_solver/boulders/boulders.hpp"
#include "mpm_solver/contact/surfaces.hpp"
#include "mpm_solver/gauges/gauges.hpp"
#include "mpm_solver/ranks/point_ranks.hpp"
#include "mpm_solver/step/ledger.hpp"
#include "mpm_solver/step/soil_model.hpp"
#include "mpm_solver/step/strength_search.hpp"
#include "mpm_solver/step_sizes/step_control.hpp"

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
  /// Load the state from the states of another number of ranks, see Solver::join_states.
  void join(const State& first, std::span<const State> own, const SoilModel<dim>& model);

  /// A step that was just taken: where the points were at its start, and when it ends.
  struct Step {
    std::span<const Vector<dim>> x;      ///< [m]
    std::span<const std::int32_t> cell;  ///< of the grid
    double time = 0;                     ///< at its end [s]
  };
  /// Take the points out that are outside the grid. After the last one surfaces act no more.
  /// @param outside  ascending, of this rank
  /// @param step     its start is not read where the model lets none out
  /// @throws Error  there are some and the model does not allow it
  /// @note Collective.
  void remove(std::span<const std::int32_t> outside, const Step& step, const SoilModel<dim>& model);
  /// Whether all points of all ranks have left.
  bool is_empty() const { return ledger.totals().mass == 0; }

  MaterialPoints<dim> points;
  Surfaces<dim> surfaces;
  Boulders<dim> boulders;
  Ledger<dim> ledger;
  StepControl control;
  StrengthSearch strength;
  Gauges<dim> gauges;
  std::vector<Vector<dim>> wall_forces;   ///< on SoilModel::wall_groups [N]
  std::vector<double> rigid_wall_forces;  ///< Surfaces::forces_on_walls
  PointRanks<dim> ranks;
  std::vector<std::int64_t> probe_ids;  ///< of the material point of each probe
  std::vector<double> probe_ends;  ///< when the point of each probe left [s]; infinite: it is here
  double soil_end = std::numeric_limits<double>::infinity();  ///< when the last point left [s]
  std::int64_t removed_points = 0;                            ///< of all ranks
  std::vector<double> removed_masses;  ///< through SoilModel::exit_sides [kg]
  bool has_water = false;              ///< a body has pore water, on whichever rank
  double water_out = 0;  ///< volume, free of pressure, of the pore water that left [m^3]
  bool has_rain = false;
  /// Volumes of the rain that the soil took, which water_out does not include, and that it did not
  /// take [m^3].
  double rain_in = 0, rain_run_off = 0;
  bool nearly_linear = false;  ///< the last step's first solution took one Newton iteration at most
  double contact_rate = 0;     ///< of the last explicit step, see StableStep [1/s^2]
  KrylovPause pause;           ///< LinearSolver::pause() after the last step

 private:
  void count_exits(std::span<const std::int32_t> outside, const Step& step,
                   const SoilModel<dim>& model);
  void end_probes(std::span<const std::int32_t> outside, double time, const SoilModel<dim>& model);
  void visit(StateVisitor& visitor);
  void take(StateVisitor& visitor, const SoilModel<dim>& model);
};

}  // namespace gabion::mpm
