// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/fem_solver.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include "common/base/require.hpp"
#include "common/mechanics/petsc/numbered_values.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "fem_solver/report/failure_log.hpp"
#include "fem_solver/report/widest_crack.hpp"

namespace gabion::fem {

namespace {

/// What to try where statics find no equilibrium.
template <int dim>
std::string advice_on_statics(const FemSettings<dim>& settings) {
  std::string advice = "let loads grow from 0 by \"table\", over several steps";
  if (!settings.rotation_nodes.empty()) {
    advice += "; beams turn freely at supports without \"rotations\"";
  }
  if (!settings.membranes.empty()) {
    advice +=
        "; a membrane without tension has no stiffness across: give it a \"prestress\" and hold "
        "its rim, or run in dynamics";
  }
  return advice;
}

}  // namespace

template <int dim>
FemSolver<dim>::FemSolver(MPI_Comm comm, FemSettings<dim> settings,
                          const std::string& output_folder)
    : settings_(std::move(settings)),
      wet_surfaces_(settings_.mesh, settings_.interfaces, settings_.ranks),
      beam_surfaces_(settings_),
      changing_(settings_, wet_surfaces_),
      step_(settings_, comm),
      report_(settings_, step_, output_folder),
      state_(step_.initial_state()),
      period_check_(settings_) {}

template <int dim>
void FemSolver<dim>::set_motion(std::vector<double> u, std::vector<double> v) {
  require(u.size() == settings_.mesh.nodes.size() * dim && v.size() == u.size(),
          "initial motion: found {} and {} values, expected {} nodes x {}", u.size(), v.size(),
          settings_.mesh.nodes.size(), dim);
  step_.forget_iterates();
  trial_.reset();
  state_ = step_.state_of(std::move(u), std::move(v));
}

template <int dim>
std::vector<InterfaceMesh> FemSolver<dim>::interfaces() const {
  std::vector<InterfaceMesh> meshes = wet_surfaces_.meshes();
  meshes.insert(meshes.end(), beam_surfaces_.meshes().begin(), beam_surfaces_.meshes().end());
  return meshes;
}

template <int dim>
void FemSolver<dim>::set_force_kinds(const ForceKinds& kinds) {
  ForceKinds of_facets;
  for (const auto& [name, kind] : kinds) {
    if (beam_surfaces_.has(name)) {
      beam_surfaces_.set_force_kind(name, kind);
    } else {
      of_facets[name] = kind;
    }
  }
  wet_surfaces_.set_force_kinds(of_facets);
}

/// Rotations of the nodes of beams.
template <int dim>
std::vector<Matrix<dim>> FemSolver<dim>::turns_of(const StructureState& state) const {
  const std::span<const double> history =
      state.history ? std::span<const double>(*state.history) : std::span<const double>();
  return beam_turns<dim>(settings_, step_.equilibrium().cells(), state.motion.u, history);
}

/// Arms of forces around beams are those that the accepted motion leads to in the middle of the
/// step, so that they are known before it is solved.
template <int dim>
ExternalForces FemSolver<dim>::interface_forces(const InterfaceValues& received, double dt) const {
  if (settings_.beam_surfaces.empty() || received.empty()) {
    return wet_surfaces_.nodal_forces(received);
  }
  InterfaceValues of_facets = received;
  for (const InterfaceMesh& mesh : beam_surfaces_.meshes()) of_facets.erase(mesh.name);
  ExternalForces forces = wet_surfaces_.nodal_forces(of_facets);
  std::vector<Matrix<dim>> turns = turns_of(state_);
  turn_on<dim>(settings_, state_.motion.v, 0.5 * dt, turns);
  beam_surfaces_.add_forces(received, turns, forces);
  return forces;
}

template <int dim>
InterfaceValues FemSolver<dim>::interface_displacements(const StructureState& state) const {
  InterfaceValues sent = wet_surfaces_.displacements(state.motion.u);
  changing_.hold(sent);
  if (settings_.beam_surfaces.empty()) return sent;
  beam_surfaces_.add_displacements(state.motion.u, turns_of(state), sent);
  return sent;
}

template <int dim>
StepReport FemSolver<dim>::solve_step(const StepRequest& request, const InterfaceValues& received,
                                      InterfaceValues& sent) {
  require(request.dt > 0, "step {}: found dt {}, allowed: dt > 0", request.step, request.dt);
  require(std::abs(request.time - state_.time) <= 1e-6 * request.dt,
          "step {}: asked to start at {} s, but the accepted state is that of {} s", request.step,
          request.time, state_.time);
  trial_.reset();
  state_.time = request.time;
  StructureState trial;
  StepReport report;
  try {
    report = step_.solve(state_, interface_forces(received, request.dt), request.dt, trial);
  } catch (const ConvergenceError& error) {
    if (settings_.dynamic) throw;
    throw failures_.judge(request, error, advice_on_statics(settings_));
  }
  sent = interface_displacements(trial);
  trial_ = std::move(trial);
  return report;
}

template <int dim>
AcceptReport FemSolver<dim>::accept_step(const StepRequest& request, bool solved) {
  if (solved) {
    require(trial_.has_value(), "step {}: accepted without a solution", request.step);
    step_.complete(state_, request.dt, *trial_);
    period_check_.look_at(step_, *trial_, request.dt);
    const WidestCrack earlier = state_.widest_crack;
    state_ = std::move(*trial_);
    state_.widest_crack = earlier;
    log_failures<dim>(settings_, changing_, step_.fail_cells(request.dt, state_), state_.time,
                      warned_of_wet_failure_);
    if (changing_.any() && state_.history) {
      changing_.accept(lost_shares_of_cells(step_.equilibrium().cells(), *state_.history),
                       state_.motion.u);
    }
    const Equilibrium<dim>& equilibrium = step_.equilibrium();
    const bool small_strain = std::ranges::any_of(settings_.materials, [](const auto& material) {
      return std::holds_alternative<LinearElastic<dim>>(material.law);
    });
    if (equilibrium.cracks()) {
      state_.widest_crack =
          wider_crack(settings_, equilibrium.cells(), state_, request.time + request.dt, earlier);
    }
    if (small_strain) {
      const double angle = equilibrium.cells().largest_rotation(state_.motion.u);
      rotation_.look(equilibrium.shared().largest(angle), "structure");
    }
  }
  state_.time = request.time + request.dt;
  trial_.reset();
  step_.forget_iterates();
  AcceptReport report{.probes = probes(), .at_rest = step_.at_rest(state_)};
  if (step_.equilibrium().may_fail()) report.details["failed_cells"] = num_failed();
  return report;
}

/// Number of cells and lines of all ranks that failed.
template <int dim>
std::int64_t FemSolver<dim>::num_failed() const {
  const Equilibrium<dim>& equilibrium = step_.equilibrium();
  const auto own = count_failed(equilibrium.cells(), *state_.history);
  return static_cast<std::int64_t>(equilibrium.shared().total(static_cast<double>(own)));
}

template <int dim>
void FemSolver<dim>::reject_step() {
  trial_.reset();
  step_.forget_iterates();
}

template <int dim>
Json FemSolver<dim>::summary() const {
  Json summary = report_.summary();
  if (step_.equilibrium().cracks()) {
    summary["widest_crack"] = describe(state_.widest_crack, dim);
  }
  if (step_.equilibrium().may_fail()) {
    summary["failed_cells"] = num_failed();
    summary["failed_energy"] = state_.failed_energy;
  }
  return summary;
}

/// Name of TangentPoint::history, saved by cell as the history itself.
constexpr const char* tangent_history = "tangent.history";

template <int dim>
State FemSolver<dim>::save_state() {
  const MeshRanks& ranks = settings_.ranks;
  StructureState own = state_;
  for (const auto& [name, values] : own.nodal_vectors()) {
    *values = ranks.owned(std::move(*values), dim);
  }
  auto nodes = ranks.owned_nodes(settings_.mesh.num_nodes_total());
  State state;
  StateWriter writer(state);
  own.visit_state(writer, nodes);
  if (step_.equilibrium().damped()) own.visit_damping(writer);
  if (step_.equilibrium().cracks()) own.visit_damage(writer);
  if (step_.equilibrium().may_fail()) own.visit_failure(writer);
  if (changing_.any()) changing_.visit_state(writer);
  if (own.history) {
    const CellIntegrals<dim>& cells = step_.equilibrium().cells();
    HistoryRows rows{.cells = ranks.own_elements(settings_.mesh),
                     .width = static_cast<std::int64_t>(cells.history_width()),
                     .values = cells.history_rows(*own.history)};
    own.visit_history(writer, rows);
    if (own.tangent) {
      auto of_tangent = cells.history_rows(*own.tangent->history);
      writer.list(tangent_history, of_tangent);
    }
  }
  return state;
}

template <int dim>
void FemSolver<dim>::load_state(const State& state) {
  join_states(state, {&state, 1});
}

template <int dim>
void FemSolver<dim>::join_states(const State& first, std::span<const State> own) {
  reject_step();
  const Mesh<dim>& mesh = settings_.mesh;
  const MeshRanks& ranks = settings_.ranks;
  StructureState loaded;
  HistoryRows history;
  std::vector<double> of_tangent;
  std::vector<std::int64_t> nodes;
  together(ranks.comm(), [&] {
    StateJoiner joiner(first, own);
    loaded.visit_state(joiner, nodes);
    if (step_.equilibrium().damped()) loaded.visit_damping(joiner);
    if (step_.equilibrium().cracks()) loaded.visit_damage(joiner);
    if (step_.equilibrium().may_fail()) loaded.visit_failure(joiner);
    if (changing_.any()) changing_.visit_state(joiner);
    if (state_.history) loaded.visit_history(joiner, history);
    if (state_.history && loaded.tangent) joiner.list(tangent_history, of_tangent);
    for (const auto& [name, values] : loaded.nodal_vectors()) {
      require(values->size() == nodes.size() * dim,
              "saved state: \"{}\" has {} values for {} nodes, allowed: {} a node", name,
              values->size(), nodes.size(), dim);
    }
  });
  const NumberedValues holders(ranks.alone() ? MPI_COMM_SELF : ranks.comm(), nodes,
                               ranks.held_nodes(mesh), ranks.num_nodes_of_all(mesh),
                               "saved state: nodes");
  for (const auto& [name, values] : loaded.nodal_vectors()) *values = holders.send(*values, dim);
  if (state_.history) {
    loaded.history = history_of(history, history.values);
    if (loaded.tangent) loaded.tangent->history = history_of(history, of_tangent);
  }
  state_ = std::move(loaded);
  if (changing_.any() && state_.history) {
    changing_.load(lost_shares_of_cells(step_.equilibrium().cells(), *state_.history));
  }
}

/// Send rows of the saved cells to the ranks that have the cells here.
template <int dim>
CellHistory FemSolver<dim>::history_of(const HistoryRows& saved,
                                       const std::vector<double>& values) const {
  const MeshRanks& ranks = settings_.ranks;
  const CellIntegrals<dim>& cells = step_.equilibrium().cells();
  const auto width = static_cast<std::int64_t>(cells.history_width());
  together(ranks.comm(), [&] {
    require(saved.width == width && values.size() == saved.cells.size() * width,
            "saved state: \"history\" has {} values for {} cells, allowed: {} a cell",
            values.size(), saved.cells.size(), width);
  });
  std::vector<std::int32_t> wanted;
  for (const std::int64_t c : ranks.own_elements(settings_.mesh)) {
    wanted.push_back(static_cast<std::int32_t>(c));
  }
  const Mesh<dim>& mesh = settings_.mesh;
  const NumberedValues holders(ranks.alone() ? MPI_COMM_SELF : ranks.comm(), saved.cells, wanted,
                               ranks.num_cells_of_all(mesh) + ranks.num_lines_of_all(mesh),
                               "saved state: cells");
  const std::vector<double> rows = holders.send(values, static_cast<int>(width));
  return std::make_shared<const std::vector<double>>(cells.history_of_rows(rows));
}

template class FemSolver<2>;
template class FemSolver<3>;

}  // namespace gabion::fem
