// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/mpm_solver.hpp"

#include <algorithm>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "mpm_solver/checks/cut_cells.hpp"
#include "mpm_solver/checks/overlaps.hpp"
#include "mpm_solver/checks/soil_at_rest.hpp"
#include "mpm_solver/contact/facet_contact.hpp"
#include "mpm_solver/contact/start_check.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
std::vector<StartSurface<dim>> surfaces_of(const SoilModel<dim>& model) {
  return surfaces_at_start(model.settings.interfaces, model.settings.rigid_walls);
}

}  // namespace

template <int dim>
MpmSolver<dim>::MpmSolver(MPI_Comm comm, MpmSettings<dim> settings,
                          const std::string& output_folder)
    : model_(comm, std::move(settings)),
      state_(model_),
      step_(model_, state_, times_),
      report_(model_, output_folder),
      thin_walls_(surfaces_of(model_), step_.soil().shared_pairs(), model_.cell_size) {
  report_.log_start(state_, step_.soil().weights());
  log_soil_at_rest(model_.settings, model_.cell_size);
  check_overlaps(model_.comm, model_.settings, state_.points);
  const auto surfaces = surfaces_of(model_);
  check_start<dim>(model_.comm, surfaces, state_.points, model_.cell_size,
                   bounding_box(model_.grid));
  for (const auto& text :
       thin_walls_.at_start(model_.comm, surfaces, state_.points, model_.settings.body_groups)) {
    log::warn("{}", text);
  }
  for (const auto& text :
       cut_cells_texts(model_.comm, model_.settings, surfaces, model_.grid, state_.points)) {
    log::warn("{}", text);
  }
  step_.check_initial_stress();
  model_.settings.layouts.clear();  // the points are laid and at rest
}

template <int dim>
StepReport MpmSolver<dim>::solve_step(const StepRequest& request, const InterfaceValues& received,
                                      InterfaceValues& sent) {
  StepReport report;
  try {
    if (request.iteration == 0) step_.begin(request);
    report = step_.solve(request, received);
  } catch (const ConvergenceError& error) {
    step_.note_failure(error, request.dt);
    if (step_.phase().dynamic) throw;
    throw failures_.judge(request, error,
                          "let the load grow over several steps, weight by \"gravity_ramp\"");
  }
  sent = state_.surfaces.forces_on_structure();
  state_.boulders.add_forces(sent);
  return report;
}

template <int dim>
AcceptReport MpmSolver<dim>::accept_step(const StepRequest& request, bool solved) {
  AcceptReport report = step_.accept(request, solved);
  for (const auto& text :
       thin_walls_.after_step(model_.comm, state_.surfaces, request.time + request.dt,
                              state_.points, model_.settings.body_groups)) {
    log::warn("{}", text);
  }
  report.probes = probes();
  report_.look_at_memory(state_, step_);
  return report;
}

template <int dim>
void MpmSolver<dim>::write_output(double time) {
  const ScopedTimer timer(times_, "output");
  step_.release();
  report_.write_frame(time, state_);
}

template <int dim>
bool MpmSolver<dim>::takes_facets() const {
  return model_.settings.boulders.empty() &&
         std::ranges::all_of(model_.settings.interfaces, [](const auto& interface) {
           return std::holds_alternative<FacetSettings>(interface.method);
         });
}

template <int dim>
void MpmSolver<dim>::set_facets(const InterfaceFacets& facets) {
  step_.forget();
  for (const auto& [name, own] : facets) {
    const auto found =
        std::ranges::find(model_.settings.interfaces, name, &ContactSettings<dim>::name);
    require(found != model_.settings.interfaces.end(),
            "mpm_solver: found other facets of \"{}\", allowed: of its interfaces", name);
    ContactSurface<dim>& surface = found->surface;
    const auto width = static_cast<std::size_t>(num_nodes(surface.facet_type));
    require(own.size() % width == 0,
            "interface \"{}\": found {} vertices of other facets, allowed: {} a facet", name,
            own.size(), width);
    const auto end = static_cast<std::int64_t>(surface.vertices.size());
    for (const std::int64_t vertex : own) {
      require(vertex >= 0 && vertex < end,
              "interface \"{}\": other facets name vertex {}, allowed: 0 to {}", name, vertex,
              end - 1);
    }
    first_.try_emplace(name, surface.facets.begin(), surface.facets.end());
    surface.facets.assign(own.begin(), own.end());
    mpm::set_facets<dim>(state_.surfaces.contacts(), name, surface.facets);
    other_[name] = own;
  }
  step_.renew_surfaces();
  thin_walls_ = ThinWalls<dim>(surfaces_of(model_), step_.soil().shared_pairs(), model_.cell_size);
}

/// A state has the facets of the interfaces that got others.
template <int dim>
void MpmSolver<dim>::set_facets_as(const State& state) {
  InterfaceFacets facets = first_;
  for (const auto& interface : model_.settings.interfaces) {
    const auto saved = state.facts.find("facets." + interface.name);
    if (saved == state.facts.end()) continue;
    require(saved->is_array() && std::ranges::all_of(*saved, &Json::is_number_integer),
            "saved state: \"facets.{}\": found {}, allowed: a list of vertices", interface.name,
            saved->type_name());
    facets[interface.name] = saved->template get<std::vector<std::int64_t>>();
  }
  if (!facets.empty()) set_facets(facets);
}

template <int dim>
State MpmSolver<dim>::save_state() {
  step_.release();
  State state = state_.save();
  for (const auto& [name, facets] : other_) state.facts["facets." + name] = facets;
  return state;
}

template <int dim>
void MpmSolver<dim>::load_state(const State& state) {
  step_.forget();
  set_facets_as(state);
  state_.load(state, model_);
}

template <int dim>
void MpmSolver<dim>::join_states(const State& first, std::span<const State> own) {
  step_.forget();
  set_facets_as(first);
  state_.join(first, own, model_);
}

template <int dim>
void MpmSolver<dim>::set_motion(std::vector<Vector<dim>> v, std::vector<Vector<dim>> a) {
  MaterialPoints<dim>& points = state_.points;
  require(v.size() == points.v.size() && a.size() == points.a.size(),
          "mpm_solver: found {} velocities and {} accelerations for {} points", v.size(), a.size(),
          points.size());
  points.v = std::move(v);
  points.a = std::move(a);
  state_.ledger.start(points);
}

template class MpmSolver<2>;
template class MpmSolver<3>;

}  // namespace gabion::mpm
