// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/timer.hpp"
#include "common/run/facets.hpp"
#include "coupler/coupler_config.hpp"
#include "coupler/mapping/interface_map.hpp"
#include "coupler/step/attempt.hpp"
#include "coupler/step/side.hpp"

namespace gabion {

/// A solver, in this process or behind a proxy, and the name that coupler.json gives it.
struct NamedSolver {
  std::string name;
  Solver& solver;
};

/// The smaller one of two proposed step sizes [s]; 0 = no opinion.
inline double smaller_dt(double a, double b) {
  return a > 0 && b > 0 ? std::min(a, b) : std::max(a, b);
}

/// Soils and structures of a run, and the map between their surfaces.
///
///     soils:       x -> u = H x -> f_soil = MPM(u) -> f = H^T f_soil
///     structures:  f_given -> x_tilde = FEM(f_given)
///
/// A side that is started has to be finished before the other functions are called.
class Sides {
 public:
  /// @param participants  one for each entry of settings.participants, in any order
  /// @throws ConfigError  participants or interfaces do not fit the settings
  Sides(const CouplerSettings& settings, const std::vector<NamedSolver>& participants,
        PhaseTimes& phases);

  /// Tell each structure which forces it will receive, before the first step. Warns of structures
  /// that take mean forces as those of the end of the step.
  void tell_force_kinds();
  /// Take the displacements with which the structures begin as the accepted x, and tell the soils
  /// where their interfaces are, before the first step of a run that is no restart.
  void tell_start();
  /// Weights of the forces at the start of a step in its work, see InterfaceWork; of the soils'
  /// values, and of the structures' as they take them.
  Eigen::VectorXd soil_start_weights() const;
  Eigen::VectorXd structure_start_weights() const;

  std::vector<Side*> all();  ///< soils first
  const InterfaceMap& map() const { return *map_; }
  const Eigen::VectorXd& accepted_x() const { return accepted_x_; }
  std::vector<StepReport> soil_reports() const;
  bool all_structures_solved() const;  ///< whether all were solved in the last iteration
  /// Whether any soil may answer another force to another x.
  /// @throws Error  a force comes from soils that say they are not active
  bool contact_possible(const Attempt& now) const;

  void begin_step();
  void begin_solution();
  void start_soils(Attempt& now);
  void start_structures(Attempt& now, bool may_sleep);
  /// Take all answers, also when a solver failed: no request is open then.
  /// @param since  the side's wall time runs from here on
  /// @throws ConvergenceError  the first failure
  void finish_soils(Attempt& now, const Stopwatch& since);
  void finish_structures(Attempt& now, const Stopwatch& since);
  void solve_soils(Attempt& now);
  void solve_structures(Attempt& now, bool may_sleep);

  /// Have all sides accept, at the same time where they are other processes.
  void start_accept(const Attempt& now);
  /// @param since  the wait runs from here on
  /// @returns probes of all structures, the smallest of the proposed dt
  AcceptReport finish_structures_accept(const Attempt& now, const Stopwatch& since);
  AcceptReport finish_soils_accept(const Attempt& now, const Stopwatch& since);

  /// Whether start_next may be called.
  bool take_next_step() const;
  /// Start the soils on the next step, if they propose one of these step sizes. Call it before
  /// finish_soils_accept; the attempt may be finished as any other one.
  void start_next(Attempt& now, const DtRange& proposed);
  /// Whether all soils solve the next step; known after finish_soils_accept.
  bool solve_next() const;
  void call_off_next();
  void reject();
  /// Take the facets that the structures have after they accepted. @returns whether any changed
  bool take_facets();
  /// Tell the soils, once they accepted too, of the facets that take_facets found changed.
  void tell_facets();
  /// See InterfaceMap::accept. @pre the step was accepted
  void renew_map() { map_->accept(accepted_x_); }

  void visit_state(StateVisitor& visitor);

 private:
  int finish_all(std::vector<Side>& sides, Eigen::VectorXd& answer);
  AcceptReport finish_accept(std::vector<Side>& sides, const Eigen::VectorXd& given,
                             Stopwatch since);
  void check_changing(const std::vector<InterfaceSettings>& interfaces) const;
  void visit_surfaces(StateVisitor& visitor) const;

  std::vector<Side> soils_;
  std::vector<Side> structures_;
  std::unique_ptr<InterfaceMap> map_;
  std::map<std::string, ForceKinds> force_kinds_;  // those each participant sends or receives
  Json surfaces_ = Json::object();                 // participant -> interface -> hash of its mesh
  InterfaceFacets facets_;                         // of the interfaces that may get others
  InterfaceFacets changed_;                        // that the soils do not know yet
  Eigen::VectorXd accepted_x_;
  PhaseTimes& phases_;
};

}  // namespace gabion
