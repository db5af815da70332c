// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/json.hpp"
#include "common/run/state.hpp"

namespace gabion {

/// Instant at which the interface forces that a solver sends act.
enum class ForceKind {
  end_of_step,  ///< the forces at its end
  step_mean     ///< the mean force, constant over the step: its work is F . du, its impulse dt F
};
/// Interface name -> kind of the forces that act there; those not named are `end_of_step`.
using ForceKinds = std::map<std::string, ForceKind>;

/// The surface of a solver through which it is coupled, in its reference configuration.
struct InterfaceMesh {
  std::string name;  ///< name of the interface, such as "wall"; equal in both solvers
  int dim = 0;       ///< 2 or 3
  std::vector<double> coordinates;  ///< [m], num_vertices x dim, row-major
  int vertices_per_facet = 0;       ///< 2 (segments), 3 or 4; 0 for bare points
  std::vector<std::int64_t>
      facets;  ///< num_facets x vertices_per_facet; normals point out of the structure
  ForceKind force_kind = ForceKind::end_of_step;  ///< kind of the forces that are sent, if any
  std::int64_t num_vertices() const { return static_cast<std::int64_t>(coordinates.size()) / dim; }
};

/// Interface name -> values at its vertices, num_vertices x dim, row-major.
/// Displacement [m] is total, measured from the reference configuration.
/// Force [N] is the nodal force that the soil exerts on the structure (2D: per metre of thickness).
using InterfaceValues = std::map<std::string, std::vector<double>>;

/// One solution of one step: from the accepted state at `time` to `time + dt`.
struct StepRequest {
  std::int64_t step = 0;  ///< 1, 2, 3, ...
  int iteration = 0;      ///< coupling iteration, 0 = first solution of this step
  double time = 0;        ///< [s] of the accepted state
  double dt = 0;          ///< [s]
};

/// Report of a solver on one solution.
struct StepReport {
  int newton_iterations = 0;
  std::int64_t linear_iterations = 0;
  /// False when the interface values cannot change this solution, whatever they are
  /// (no soil near the structure): the coupler then needs one pass only.
  bool interface_active = true;
  Json details = Json::object();  ///< numbers for the log, by name
};

/// Report of a solver on an accepted step.
struct AcceptReport {
  std::vector<double> probes;  ///< values in the order of probe_names()
  bool at_rest = false;  ///< nothing moves and the load is balanced: the next step without new load
                         ///< may be skipped
  double proposed_dt = 0;         ///< [s], 0 = no opinion
  Json details = Json::object();  ///< numbers of the accepted step for the log, by name
};

/// A time-stepping solver as seen from outside. A step is a function of the accepted state:
/// repeating `solve_step` with the same request gives the same bits, so that iterating, cutting dt
/// and restarting need no special cases.
class Solver {
 public:
  virtual ~Solver() = default;

  virtual std::vector<InterfaceMesh> interfaces() const = 0;
  virtual std::vector<std::string> probe_names() const = 0;

  /// Whether this solver has set_force_kinds(). A solver without it takes all forces that it
  /// receives as those at the end of the step.
  virtual bool takes_force_kinds() const { return false; }
  /// Say which forces it will receive, between two steps, before the first one of a run. They are
  /// no part of the state.
  /// @throws Error  an interface that it does not have
  virtual void set_force_kinds(const ForceKinds&) {
    throw Error("this solver takes forces as those of the end of the step");
  }

  /// Solve from the accepted state. `received` holds the values given to this solver at the end of
  /// the step; `sent` is filled with what it answers. An empty `received` means free interfaces.
  /// @throws ConvergenceError  the accepted state is untouched; try a smaller dt
  virtual StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                                InterfaceValues& sent) = 0;

  /// Make the last solution the accepted state. When the coupler skipped this solver in this step
  /// (`solved` false), only time advances.
  virtual AcceptReport accept_step(const StepRequest& request, bool solved) = 0;

  /// Forget the last solution.
  virtual void reject_step() = 0;

  /// Write the accepted state to disk. Called at time 0 too.
  virtual void write_output(double time) = 0;

  /// Values of the probes in the accepted state.
  virtual std::vector<double> probes() const = 0;

  /// Whether this solver has save_state() and load_state().
  virtual bool keeps_state() const { return false; }

  /// Everything of the accepted state that later steps depend on, and nothing else.
  /// @note  Solvers on several ranks: the part of this rank.
  virtual State save_state() { throw Error("this solver does not save its state"); }

  /// Like save_state(), but solvers that can write the state to a file do so: State::file is `path`
  /// then.
  /// @param path  of a file that is not there, in a folder that is
  virtual State save_state_to(const std::string&) { return save_state(); }

  /// Go on from a state that a solver with the same settings saved: every later step gives the bits
  /// that it would have given there. Forgets the last solution.
  /// @throws Error  the state is not one of this solver
  virtual void load_state(const State&) { throw Error("this solver does not load a state"); }

  /// Whether this solver has join_states().
  virtual bool joins_states() const { return false; }

  /// Go on from what another number of ranks saved: every later step gives the same values but for
  /// rounding.
  /// @param first  of the first rank of the other run; its lists may be missing
  /// @param own    states of the other run that this rank has; each of them one rank has
  /// @note  Collective.
  virtual void join_states(const State& /*first*/, std::span<const State> /*own*/) {
    throw Error("this solver does not join the states of other ranks");
  }

  /// Methods that ran ("linear_solver", ...), counts, and wall seconds by phase, for summary.json.
  virtual Json summary() const = 0;

  /// [s] wall time that the last call kept the solver busy, by its own clock. Empty for a solver of
  /// this process, which is busy as long as the call lasts.
  virtual std::optional<double> last_busy_seconds() const { return std::nullopt; }
};

}  // namespace gabion
