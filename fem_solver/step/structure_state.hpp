// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/mechanics/petsc/krylov_pause.hpp"
#include "common/mechanics/petsc/linear_method.hpp"
#include "common/run/state.hpp"

namespace gabion::fem {

/// Motion of the nodes that this rank holds, num_nodes x dim each.
struct StructureMotion {
  std::vector<double> u;  ///< displacement [m]
  std::vector<double> v;  ///< velocity [m/s]
  std::vector<double> a;  ///< acceleration [m/s^2]
  bool is_still() const;  ///< v and a of the held nodes are zero in every bit
};

/// Forces on the held nodes that do not follow from their motion, num_nodes x dim each; empty:
/// none.
struct ExternalForces {
  std::vector<double> end;   ///< of loads and interfaces at the end of the step [N]
  std::vector<double> step;  ///< of interfaces that give the mean force of the step [N]
  bool operator==(const ExternalForces&) const = default;
};

/// History of the cells of this rank, see CellIntegrals; null: no cell has any. Never changed once
/// it is part of a state.
using CellHistory = std::shared_ptr<const std::vector<double>>;

/// State for which a tangent matrix was assembled.
struct TangentPoint {
  std::vector<double> u;      ///< displacement [m]
  double dt = 0;              ///< [s]
  bool with_inertia = false;  ///< the mass matrix is part of it
  CellHistory history;        ///< accepted at the start of that step, compared by address
  bool operator==(const TangentPoint&) const = default;
};

/// Histories of cells in a saved state.
struct HistoryRows {
  std::vector<std::int64_t> cells;  ///< numbers in the whole mesh
  std::int64_t width = 0;           ///< values of a cell
  std::vector<double> values;       ///< cells x width
};

/// The widest crack of a cell in any accepted state so far.
struct WidestCrack {
  double width = 0;                  ///< [m]
  double time = 0;                   ///< [s]
  std::array<double, 3> place = {};  ///< centre of the cell, before loading [m]
};

/// Everything that the next step depends on. Numbers and flags are the same on all ranks.
struct StructureState {
  double time = 0;  ///< [s]
  StructureMotion motion;
  std::vector<double> f_ext;   ///< loads and interface forces, num_nodes x dim [N]
  std::vector<double> f_step;  ///< mean interface forces of the last step, num_nodes x dim [N]
  std::vector<double> f_int;   ///< internal forces, of damping too, num_nodes x dim [N]
  /// Forces of the supports on the structure at the instant that the last step balanced,
  /// num_nodes x dim [N].
  std::vector<double> reactions;
  bool balanced = false;      ///< the motion solves the equations under f_ext and f_step
  double elastic_energy = 0;  ///< [J]
  double plastic_work = 0;    ///< of the cells since the virgin state [J]
  double brake_work = 0;      ///< that brakes of lines took since time 0 [J]
  double damping_work = 0;    ///< that damping took since time 0 [J]
  double failed_energy = 0;   ///< elastic, of cells as they failed, since time 0 [J]
  double damage_work = 0;     ///< that cracks and crushing took since the virgin state [J]
  WidestCrack widest_crack;
  CellHistory history;
  double external_work = 0;  ///< of loads, interface forces and reactions since time 0 [J]
  /// State for which the tangent matrix in use was assembled; it is part of the accepted state,
  /// because modified Newton gives other last bits with another matrix.
  std::optional<TangentPoint> tangent;
  std::optional<SolutionMethod> rescue;  ///< LinearSolver::rescue() of that matrix
  KrylovPause pause;                     ///< LinearSolver::pause() after the last step

  /// Save or load.
  /// @param nodes  whose the values of nodal_vectors() are, by number in the whole mesh
  void visit_state(StateVisitor& visitor, std::vector<std::int64_t>& nodes);
  /// Save or load what only a structure with history has.
  /// @param rows  of the history by cell, with the cells' numbers in the whole mesh
  void visit_history(StateVisitor& visitor, HistoryRows& rows);
  /// Save or load what only a structure that cracks has.
  void visit_damage(StateVisitor& visitor);
  /// Save or load what only a structure has whose cells may fail.
  void visit_failure(StateVisitor& visitor);
  /// Save or load what only a damped structure has.
  void visit_damping(StateVisitor& visitor);
  /// Name and values.
  std::vector<std::pair<std::string, std::vector<double>*>> nodal_vectors();
};

/// The reference configuration at time 0, at rest under these loads. @param f_ext  num_nodes x dim
StructureState reference_state(const std::vector<double>& f_ext, CellHistory history);

}  // namespace gabion::fem
