// SPDX-License-Identifier: BSD-3-Clause
#include "structure.hpp"

#include <cmath>

namespace dealii_structure {

namespace {

/// The parts of a state that are numbers, by name.
template <class State>
auto parts_of(State& state) {
  return std::array{std::pair{"u", &state.u}, std::pair{"v", &state.v}, std::pair{"a", &state.a},
                    std::pair{"forces_end", &state.forces.end},
                    std::pair{"forces_mean", &state.forces.mean}};
}

void copy(const gabion::State& from, const std::string& name, Vector& to) {
  const auto found = from.reals.find(name);
  if (found == from.reals.end() || found->second.size() != to.size()) {
    throw gabion::Error("the saved state has no \"" + name + "\" of " + std::to_string(to.size()) +
                        " values");
  }
  std::copy(found->second.begin(), found->second.end(), to.begin());
}

}  // namespace

template <int dim>
Structure<dim>::Structure(const Settings& settings)
    : settings_(settings), solid_(settings), stepper_(settings, solid_) {
  for (const auto& each : settings.interfaces) surfaces_.emplace_back(settings, each, solid_);
  for (const auto& each : settings.probes) probed_.push_back(solid_.interpolation(each));
  accepted_ = stepper_.initial_state();
  trial_ = accepted_;
}

template <int dim>
std::vector<gabion::InterfaceMesh> Structure<dim>::interfaces() const {
  std::vector<gabion::InterfaceMesh> all;
  for (const auto& surface : surfaces_) all.push_back(surface.mesh());
  return all;
}

template <int dim>
void Structure<dim>::set_force_kinds(const gabion::ForceKinds& kinds) {
  force_kinds_ = kinds;
}

template <int dim>
gabion::InterfaceValues Structure<dim>::start_displacements() const {
  gabion::InterfaceValues start;
  for (const auto& surface : surfaces_) {
    start[surface.mesh().name] = surface.displacement(accepted_.u);
  }
  return start;
}

template <int dim>
gabion::StepReport Structure<dim>::solve_step(const gabion::StepRequest& request,
                                              const gabion::InterfaceValues& received,
                                              gabion::InterfaceValues& sent) {
  const Vector zero(solid_.num_dofs());
  WetForces forces{zero, zero};
  for (const auto& surface : surfaces_) {
    const auto values = received.find(surface.mesh().name);
    if (values == received.end()) continue;  // no contact
    const auto kind = force_kinds_.find(surface.mesh().name);
    const bool mean = kind != force_kinds_.end() && kind->second == gabion::ForceKind::step_mean;
    surface.add_forces(values->second, mean ? forces.mean : forces.end);
  }
  gabion::StepReport report;
  report.newton_iterations = stepper_.solve(accepted_, forces, request.dt, trial_);
  for (const auto& surface : surfaces_) {
    sent[surface.mesh().name] = surface.displacement(trial_.u);
  }
  ++solves_;
  newton_iterations_ += report.newton_iterations;
  return report;
}

template <int dim>
gabion::AcceptReport Structure<dim>::accept_step(const gabion::StepRequest& request, bool solved) {
  if (solved) {
    stepper_.complete(accepted_, request.dt, trial_);
    accepted_ = trial_;
  }
  gabion::AcceptReport report;
  report.probes = probes();
  report.at_rest = accepted_.balanced && accepted_.v.all_zero() && accepted_.a.all_zero();
  return report;
}

template <int dim>
void Structure<dim>::write_output(double time) {
  if (frames_) frames_->write(time, solid_, accepted_.u, accepted_.v);
}

template <int dim>
std::vector<std::string> Structure<dim>::probe_names() const {
  std::vector<std::string> names;
  for (const auto& probe : settings_.probes) {
    for (int i = 0; i < dim; ++i) names.push_back(probe.name + ".u" + "xyz"[i]);
  }
  return names;
}

template <int dim>
std::vector<double> Structure<dim>::probes() const {
  std::vector<double> values;
  for (const auto& probe : probed_) {
    for (int i = 0; i < dim; ++i) {
      double sum = 0;
      for (std::size_t a = 0; a < probe.weights.size(); ++a) {
        sum += probe.weights[a] * accepted_.u[probe.dofs[i][a]];
      }
      values.push_back(sum);
    }
  }
  return values;
}

template <int dim>
gabion::State Structure<dim>::save_state() {
  gabion::State state;
  for (const auto& [name, part] : parts_of(accepted_)) {
    state.reals[name].assign(part->begin(), part->end());
  }
  state.facts["model"] = settings_.model;
  state.facts["balanced"] = accepted_.balanced;
  if (accepted_.tangent) {
    state.reals["tangent_u"].assign(accepted_.tangent->u.begin(), accepted_.tangent->u.end());
    state.reals["tangent_dt"] = {accepted_.tangent->dt};
  }
  return state;
}

template <int dim>
void Structure<dim>::load_state(const gabion::State& state) {
  if (state.facts.at("model") != settings_.model) {
    throw gabion::ConfigError("the saved state is of other settings than structure.json: found " +
                              state.facts.at("model").dump() +
                              ", allowed: " + settings_.model.dump());
  }
  for (auto& [name, part] : parts_of(accepted_)) copy(state, name, *part);
  accepted_.balanced = state.facts.at("balanced");
  accepted_.tangent.reset();
  if (const auto dt = state.reals.find("tangent_dt"); dt != state.reals.end()) {
    TangentPoint point{accepted_.u, dt->second.at(0)};
    copy(state, "tangent_u", point.u);
    accepted_.tangent = std::make_shared<TangentPoint>(std::move(point));
  }
  trial_ = accepted_;
}

template <int dim>
gabion::Json Structure<dim>::summary() const {
  return {{"cells", solid_.mesh().n_active_cells()},
          {"unknowns", solid_.num_dofs()},
          {"hanging_or_held", solid_.constraints().n_constraints()},
          {"solves", solves_},
          {"newton_iterations", newton_iterations_},
          {"factorisations", stepper_.num_factorisations()}};
}

template class Structure<2>;
template class Structure<3>;

}  // namespace dealii_structure
