// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/report/soil_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/log.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/report/water_output.hpp"

namespace gabion::mpm {

namespace {

// Value for a point that has left and for a body without points.
constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

template <int dim>
void append_removed_names(const std::vector<std::string>& sides, std::vector<std::string>& names) {
  names.insert(names.end(), {"removed_points", "removed_mass", "removed_kinetic_energy",
                             "removed_elastic_energy"});
  for (int d = 0; d < dim; ++d) names.push_back(fmt::format("removed_momentum_{}", "xyz"[d]));
  for (const auto& side : sides) names.push_back(fmt::format("removed.{}.mass", side));
}

template <int dim>
Json removed_masses(const SoilModel<dim>& model, const SoilState<dim>& state) {
  Json masses = Json::object();
  for (std::size_t k = 0; k < model.exit_sides.size(); ++k) {
    masses[model.exit_sides[k]] = state.removed_masses[k];
  }
  return masses;
}

/// Add the times at which soil and probes left the grid, if they did.
template <int dim>
void append_ends(const SoilModel<dim>& model, const SoilState<dim>& state, Json& summary) {
  if (std::isfinite(state.soil_end)) summary["soil_left_at"] = state.soil_end;
  for (std::size_t k = 0; k < state.probe_ends.size(); ++k) {
    if (!std::isfinite(state.probe_ends[k])) continue;
    summary["probes_left_at"][model.settings.probes[k].name] = state.probe_ends[k];
  }
}

// Share of the points that repeated solutions evaluated; 0: there were none. @note Collective.
double repeated_share(MPI_Comm comm, const SubstepCounts& counts) {
  double points[] = {static_cast<double>(counts.evaluated_points),
                     static_cast<double>(counts.repeated_points)};
  sum_over_ranks(comm, std::span<double>(points));
  return points[1] > 0 ? points[0] / points[1] : 0;
}

void log_explicit(const SubstepCounts& counts, double share) {
  log::info("explicit: {} substeps in {} solutions", counts.substeps, counts.solutions);
  if (counts.repeated == 0) return;
  log::info(
      "explicit: {} repeated solutions evaluated {:.3g} % of the points, those in reach of the "
      "interfaces; {} of them all points",
      counts.repeated, 100 * share, counts.repeated_whole);
}

Json explicit_json(const SubstepCounts& counts, double share) {
  Json json = {{"solutions", counts.solutions},         {"substeps", counts.substeps},
               {"most_in_a_step", counts.largest},      {"smallest_substep", counts.smallest},
               {"repeated_solutions", counts.repeated}, {"repeated_whole", counts.repeated_whole},
               {"repeated_point_share", share}};
  if (counts.pressure_iterations > 0) json["pressure_iterations"] = counts.pressure_iterations;
  return json;
}

}  // namespace

template <int dim>
SoilReport<dim>::SoilReport(const SoilModel<dim>& model, const std::string& output_folder)
    : model_(model),
      output_(model.comm, output_folder, model.settings.bodies,
              [&model](const auto& points) { return water_fields(model.settings.bodies, points); }),
      contact_output_(model, output_folder) {}

template <int dim>
void SoilReport<dim>::write_frame(double time, const SoilState<dim>& state) {
  output_.write(time, state.points);
  contact_output_.write(time, state);
}

template <int dim>
void SoilReport<dim>::log_start(const SoilState<dim>& state,
                                const PointWeights<dim>& weights) const {
  const LockingCure& locking = model_.settings.locking;
  log::info("F-bar against volumetric locking: {} ({})", locking.average_volumes ? "on" : "off",
            locking.reason);
  const double damping = model_.settings.noise_damping;
  log::info("noise of the points' velocities: {}",
            damping == 0
                ? "not damped"
                : fmt::format("damped by exp(-{:g}) while sqrt(stress / density) crosses a cell, "
                              "where soil does not flow",
                              damping));
  log_water(model_);
  log::info("stresses summed over {}", quadrature_name(model_.settings.quadrature));
  log::info(
      "background grid: {} cells, {} nodes, mean size {:.4g} m; elastic wave speed {:.4g} m/s",
      model_.grid.num_cells(), model_.grid.num_nodes_total(), model_.cell_size, model_.wave_speed);
  std::vector<double> counts = {static_cast<double>(state.points.size()),
                                static_cast<double>(weights.N.size())};
  sum_over_ranks(model_.comm, std::span<double>(counts));
  log::info("basis: {}, {:.3g} nodes a point", basis_name(model_.grid.basis),
            counts[1] / counts[0]);
}

template <int dim>
std::vector<std::string> SoilReport<dim>::probe_names() const {
  static constexpr const char* axes[] = {"x", "y", "z"};
  const MpmSettings<dim>& settings = model_.settings;
  std::vector<std::string> names = {"mass", "kinetic_energy", "elastic_energy"};
  for (int d = 0; d < dim; ++d) names.push_back(fmt::format("momentum_{}", axes[d]));
  for (const auto& body : settings.bodies) {
    names.push_back(settings.bodies.size() == 1 ? "front" : "front_" + body.name);
  }
  for (const auto& name : Ledger<dim>::names()) names.push_back(name);
  for (const auto& probe : settings.probes) {
    for (int d = 0; d < dim; ++d) names.push_back(fmt::format("{}.u{}", probe.name, axes[d]));
  }
  for (const auto& name : water_probe_names(settings)) names.push_back(name);
  for (const auto& group : model_.wall_groups) {
    for (int d = 0; d < dim; ++d) names.push_back(fmt::format("wall.{}.f{}", group, axes[d]));
  }
  for (const auto& wall : settings.rigid_walls) {
    for (int d = 0; d < dim; ++d) names.push_back(fmt::format("{}.f{}", wall.name, axes[d]));
    for (int d = dim == 2 ? 2 : 0; d < 3; ++d) {
      names.push_back(fmt::format("{}.m{}", wall.name, axes[d]));
    }
  }
  for (std::size_t k = 0; k < settings.body_groups.pairs.size(); ++k) {
    const std::string pair = settings.body_groups.text_of(k);
    for (int d = 0; d < dim; ++d) names.push_back(fmt::format("contact.{}.f{}", pair, axes[d]));
  }
  for (const auto& name : Boulders<dim>::names(boulder_scene<dim>(settings, model_.grid))) {
    names.push_back(name);
  }
  for (const auto& name : Gauges<dim>::names(settings.gauges)) names.push_back(name);
  if (any_reduces_strength(settings.phases)) {
    names.insert(names.end(), {"strength_factor", "strength_displacement"});
  }
  if (model_.lets_out) append_removed_names<dim>(model_.exit_sides, names);
  return names;
}

template <int dim>
std::vector<double> SoilReport<dim>::probes(const SoilState<dim>& state) const {
  const PointTotals<dim>& totals = state.ledger.totals();
  std::vector<double> values = {totals.mass, totals.kinetic_energy, totals.elastic_energy};
  const auto append = [&values](const auto& more) {
    values.insert(values.end(), more.begin(), more.end());
  };
  append(std::span(totals.momentum.data(), dim));
  for (const double front : totals.front) values.push_back(std::isfinite(front) ? front : no_value);
  append(state.ledger.values());
  std::vector<double> motion;
  for (const std::int64_t id : state.probe_ids) {
    const std::int32_t p = find_point(state.points, id);
    for (int d = 0; d < dim; ++d) motion.push_back(p < 0 ? 0.0 : state.points.u[p][d]);
  }
  sum_over_ranks(model_.comm, std::span<double>(motion));
  for (std::size_t k = 0; k < motion.size(); ++k) {
    if (std::isfinite(state.probe_ends[k / dim])) motion[k] = no_value;
  }
  append(motion);
  append(water_probe_values(model_, state));
  for (const auto& force : state.wall_forces) append(std::span(force.data(), dim));
  append(state.rigid_wall_forces);
  for (const auto& force : state.surfaces.forces_between_groups()) {
    append(std::span(force.data(), dim));
  }
  append(state.boulders.values());
  append(state.gauges.values(state.points));
  if (any_reduces_strength(model_.settings.phases)) {
    append(std::vector{state.strength.highest(), state.strength.displacement()});
  }
  if (model_.lets_out) {
    const PointTotals<dim>& removed = state.ledger.removed();
    append(std::vector{static_cast<double>(state.removed_points), removed.mass,
                       removed.kinetic_energy, removed.elastic_energy});
    append(std::span(removed.momentum.data(), dim));
    append(state.removed_masses);
  }
  return values;
}

template <int dim>
Json SoilReport<dim>::small_cuts(const SoilStep<dim>& step) const {
  const auto method =
      method_in(model_.settings.small_cuts, model_.grid.basis, step.phase().dynamic);
  const auto name = std::find_if(small_cut_methods.begin(), small_cut_methods.end(),
                                 [&](const auto& entry) { return entry.second == method; });
  const SmallCutCounts& counts = step.soil().small_cuts();
  Json cuts = {{"method", name->first}, {"joined_nodes", counts.joined_nodes}};
  if (step.soil().has_ghost()) {
    cuts["steps_with_ghost"] = counts.ghost_steps;
    cuts["facets"] = counts.ghost_facets;
  }
  return cuts;
}

template <int dim>
Json SoilReport<dim>::ranks(const SoilState<dim>& state, const SoilStep<dim>& step) const {
  const SharedNodes& shared = step.soil().nodes().shared;
  const double num_shared = shared.alone() ? 0 : shared.num_shared();
  const double num_neighbours = shared.alone() ? 0 : shared.num_neighbours();
  return {{"number", num_ranks(model_.comm)},
          {"largest_share", state.ranks.largest_share(state.points)},
          {"partitions", state.ranks.num_divisions()},
          {"moved_points", state.ranks.num_moved()},
          {"neighbours", static_cast<int>(max_over_ranks(model_.comm, num_neighbours))},
          {"shared_nodes", static_cast<std::int64_t>(max_over_ranks(model_.comm, num_shared))}};
}

template <int dim>
Json SoilReport<dim>::summary(const SoilState<dim>& state, const SoilStep<dim>& step,
                              const PhaseTimes& times) const {
  const MpmSettings<dim>& settings = model_.settings;
  const Json locking = {{"method", settings.locking.average_volumes ? "fbar" : "none"},
                        {"reason", settings.locking.reason}};
  std::vector<double> sums = {static_cast<double>(step.capped_domains()),
                              static_cast<double>(state.points.size())};
  sum_over_ranks(model_.comm, std::span<double>(sums));
  const auto num_points = static_cast<std::int64_t>(sums[1]);
  const LinearSolver<dim>& linear = step.implicit_steps().linear_solver();
  const NewtonCounts& newton = step.newton_counts();
  const SubstepCounts& substeps = step.explicit_steps().counts();
  const double share = repeated_share(model_.comm, substeps);
  if (any_implicit(settings.phases)) log::info("{}", newton.text());
  if (any_explicit(settings.phases)) log_explicit(substeps, share);
  Json summary = {
      {"basis", basis_name(model_.grid.basis)},
      {"quadrature", quadrature_name(settings.quadrature)},
      {"locking", locking},
      {"bodies", settings.bodies.size()},
      {"points", num_points},
      {"grid_cells", model_.grid.num_cells()},
      {"grid_nodes", model_.grid.num_nodes_total()},
      {"frame_bytes", output_.frame_bytes(num_points) + ContactOutput<dim>::frame_bytes(settings)},
      {"capped_domains", static_cast<std::int64_t>(sums[0])},
      {"phases", settings.phases.size()},
      {"initial_displacement", step.initial_displacement()},
      {"small_cuts", small_cuts(step)},
      {"removed_points", state.removed_points},
      {"removed_mass", removed_masses(model_, state)},
      {"linear_solver", linear.method_name()},
      {"factorisations", linear.factorisations()},
      {"linear_fallbacks", linear.fallbacks()},
      {"solutions", newton.solutions()},
      {"newton_iterations", newton.iterations()},
      {"newton", newton.json()},
      {"explicit", explicit_json(substeps, share)},
      {"linear_iterations", step.implicit_steps().linear_iterations()},
      {"memory", memory_.json(model_.comm)},
      {"wall_seconds", times.seconds()}};
  if (const Json water = water_summary(model_); !water.is_null()) summary["water"] = water;
  if (step.initial_discharge()) summary["initial_discharge"] = *step.initial_discharge();
  append_ends(model_, state, summary);
  if (state.strength.started()) {
    summary["strength_reduction"] = state.strength.summary();
    if (!state.strength.bracketed()) state.strength.log_result();
  }
  if (num_ranks(model_.comm) > 1) summary["ranks"] = ranks(state, step);
  return summary;
}

template class SoilReport<2>;
template class SoilReport<3>;

}  // namespace gabion::mpm
