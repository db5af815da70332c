// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/matrix_solver.hpp"

#include <cmath>
#include <set>
#include <string_view>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion::fem {

namespace {

/// Unknowns of the wet surfaces, ascending.
template <int dim>
std::vector<int> wet_unknowns(const MatrixSettings<dim>& s, const MatrixStructure<dim>& structure) {
  std::set<int> result;
  for (const auto& interface : s.interfaces) {
    for (const auto node : structure.mesh.group_nodes(interface.groups.front(), interface.where)) {
      for (int c = 0; c < dim; ++c) {
        const int unknown = structure.unknown_of[static_cast<std::size_t>(node) * dim + c];
        if (unknown >= 0) result.insert(unknown);
      }
    }
  }
  return {result.begin(), result.end()};
}

template <int dim>
Coordinates make_coordinates(const MatrixSettings<dim>& s, const MatrixStructure<dim>& structure) {
  if (!s.modes) return Coordinates(structure.model);
  try {
    return Coordinates(structure.model, wet_unknowns(s, structure), *s.modes);
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}/modes: {}", s.where, error.what()));
  }
}

template <int dim>
LinearStep make_step(const MatrixSettings<dim>& s, const Coordinates& coordinates) {
  try {
    return LinearStep(coordinates.model(), s.time_integration, s.dynamic);
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}: {}", s.where, error.what()));
  }
}

std::string bytes_of(const SparseMatrix& A) {
  return {reinterpret_cast<const char*>(A.valuePtr()), sizeof(double) * A.nonZeros()};
}

}  // namespace

template <int dim>
MatrixSolver<dim>::MatrixSolver(MPI_Comm comm, const Scene& scene, MatrixSettings<dim> settings,
                                const std::string& output_folder)
    : settings_(std::move(settings)),
      structure_(read_matrix_structure(scene, settings_)),
      wet_surfaces_(structure_.mesh, settings_.interfaces),
      coordinates_(make_coordinates(settings_, structure_)),
      wet_components_(wet_components()),
      load_(coordinates_.forces(structure_.load)),
      step_(make_step(settings_, coordinates_)),
      report_(settings_, structure_, coordinates_, rank_of(comm) == 0 ? output_folder : ""),
      state_(initial_state()),
      u_nodes_(structure_.unknown_of.size(), 0.0) {}

template <int dim>
LinearState MatrixSolver<dim>::initial_state() const {
  if (settings_.initial_equilibrium) return step_.equilibrium(load_);
  Eigen::VectorXd v = Eigen::VectorXd::Zero(structure_.model.size());
  for (int i = 0; i < v.size(); ++i) {
    const int c = structure_.model.unknowns[i].direction - 1;
    if (c < dim) v[i] = settings_.initial_velocity[c];
  }
  return step_.state_of(Eigen::VectorXd::Zero(coordinates_.model().size()),
                        coordinates_.velocity(v), load_);
}

template <int dim>
std::vector<typename MatrixSolver<dim>::WetComponent> MatrixSolver<dim>::wet_components() const {
  const std::vector<int> wet = wet_unknowns(settings_, structure_);
  std::vector<WetComponent> result;
  for (std::size_t dof = 0; dof < structure_.unknown_of.size(); ++dof) {
    const int unknown = structure_.unknown_of[dof];
    if (!std::binary_search(wet.begin(), wet.end(), unknown)) continue;
    result.push_back({dof, coordinates_.of_unknown(unknown)});
  }
  return result;
}

template <int dim>
LinearForces MatrixSolver<dim>::forces(const InterfaceValues& received) const {
  LinearForces f = {.end = load_, .step = Eigen::VectorXd::Zero(load_.size())};
  const ExternalForces nodal = wet_surfaces_.nodal_forces(received);
  if (nodal.end.empty()) return f;
  for (const auto& wet : wet_components_) {
    f.end[wet.coordinate] += nodal.end[wet.dof];
    f.step[wet.coordinate] += nodal.step[wet.dof];
  }
  return f;
}

template <int dim>
void MatrixSolver<dim>::set_motion(Eigen::VectorXd u, Eigen::VectorXd v) {
  require(u.size() == load_.size() && v.size() == u.size(),
          "initial motion: found {} and {} values, expected {}", u.size(), v.size(), load_.size());
  reject_step();
  state_ = step_.state_of(std::move(u), std::move(v), load_);
}

template <int dim>
InterfaceValues MatrixSolver<dim>::start_displacements() const {
  std::vector<double> u(structure_.unknown_of.size(), 0.0);
  for (const auto& wet : wet_components_) u[wet.dof] = state_.u[wet.coordinate];
  return wet_surfaces_.displacements(u);
}

template <int dim>
StepReport MatrixSolver<dim>::solve_step(const StepRequest& request,
                                         const InterfaceValues& received, InterfaceValues& sent) {
  require(request.dt > 0, "step {}: found dt {}, allowed: dt > 0", request.step, request.dt);
  require(std::abs(request.time - state_.time) <= 1e-6 * request.dt,
          "step {}: asked to start at {} s, but the accepted state is that of {} s", request.step,
          request.time, state_.time);
  trial_.reset();
  Trial trial{.f = forces(received), .u = {}};
  const std::int64_t skipped = step_.skipped(), factorised = step_.factorisations();
  trial.u = step_.solve(state_, trial.f, request.dt);
  for (const auto& wet : wet_components_) u_nodes_[wet.dof] = trial.u[wet.coordinate];
  sent = wet_surfaces_.displacements(u_nodes_);
  trial_ = std::move(trial);
  StepReport report;
  report.newton_iterations = step_.skipped() > skipped ? 0 : 1;
  report.details = {{"skipped", step_.skipped() - skipped},
                    {"matrix_assemblies", step_.factorisations() - factorised}};
  return report;
}

template <int dim>
AcceptReport MatrixSolver<dim>::accept_step(const StepRequest& request, bool solved) {
  if (solved) {
    require(trial_.has_value(), "step {}: accepted without a solution", request.step);
    state_ = step_.after(state_, std::move(trial_->f), std::move(trial_->u), request.dt);
  }
  state_.time = request.time + request.dt;
  reject_step();
  return {.probes = probes(), .at_rest = state_.balanced && state_.is_still()};
}

template <int dim>
void MatrixSolver<dim>::reject_step() {
  trial_.reset();
  step_.forget();
}

template <int dim>
void MatrixSolver<dim>::write_output(double) {
  std::vector<double> f(structure_.unknown_of.size(), 0.0);
  for (std::size_t i = 0; i < f.size(); ++i) {
    if (structure_.unknown_of[i] >= 0) f[i] = structure_.load[structure_.unknown_of[i]];
  }
  for (const auto& wet : wet_components_) {
    f[wet.dof] +=
        state_.f.end[wet.coordinate] - load_[wet.coordinate] + state_.f.step[wet.coordinate];
  }
  report_.write_frame(state_, f);
}

template <int dim>
std::string MatrixSolver<dim>::fingerprint() const {
  const LinearModel& model = coordinates_.model();
  return hash_text(bytes_of(model.K) + bytes_of(model.M) + bytes_of(model.C));
}

template <int dim>
void MatrixSolver<dim>::visit_state(StateVisitor& visitor) {
  const Json own = fingerprint();
  Json saved = own;
  visitor.fact("matrices", saved);
  require<ConfigError>(saved == own, "{}: found other matrices than those of the saved state",
                       settings_.where);
  state_.visit_state(visitor);
}

template <int dim>
State MatrixSolver<dim>::save_state() {
  State state;
  StateWriter writer(state);
  visit_state(writer);
  return state;
}

template <int dim>
void MatrixSolver<dim>::load_state(const State& state) {
  reject_step();
  StateReader reader(state);
  visit_state(reader);
}

template class MatrixSolver<2>;
template class MatrixSolver<3>;

}  // namespace gabion::fem
