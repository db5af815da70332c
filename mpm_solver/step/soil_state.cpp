// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/soil_state.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "mpm_solver/boulders/soil_inside.hpp"
#include "mpm_solver/checks/varying_values.hpp"
#include "mpm_solver/points/flat.hpp"

namespace gabion::mpm {

namespace {

// Components of force and moment.
template <int dim>
constexpr std::size_t wall_values = dim == 2 ? 3 : 6;

template <int dim>
MaterialPoints<dim> lay_all_points(const SoilModel<dim>& model) {
  const MpmSettings<dim>& settings = model.settings;
  MaterialPoints<dim> points;
  std::int64_t total = 0;
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    total += lay_points<dim>(
        settings.layouts[b], settings.bodies[b].material.density,
        {.first_id = total, .part = rank_of(model.comm), .num_parts = num_ranks(model.comm)},
        points);
  }
  for_each_field<dim>([&](const char*, auto field) { (points.*field).shrink_to_fit(); });
  add_water<dim>(settings.bodies, points);
  if (settings.tpic) add_gradients(points);
  if (model.remembers_internal) add_internal(points);
  add_variables<dim>(settings.bodies, points);
  add_parameters<dim>(settings.varying, points);
  PointLaws<dim> laws(settings.varying);
  if (model.stressed) laws.follow(points);
  const Phase& phase = settings.phases.front();
  const Vector<dim> gravity = phase.gravity_ramp.at(0) * settings.gravity;
  // The points are free of stress, so gravity is the acceleration at the start; the walls take
  // their part of it.
  if (phase.dynamic) std::fill(points.a.begin(), points.a.end(), gravity);
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    // Under steady seepage it needs the pressure of the water, which the nodes find.
    if (!settings.initial_stress[b] || settings.initial_stress[b]->steady_seepage) continue;
    set_initial_stress<dim>(model.comm, *settings.initial_stress[b],
                            {.body = settings.bodies[b],
                             .number = static_cast<std::int32_t>(b),
                             .gravity = gravity,
                             .laws = laws.of_points()},
                            points);
  }
  log::info("{} material points in {} {}", total, settings.bodies.size(),
            settings.bodies.size() == 1 ? "body" : "bodies");
  log_varying(settings, points, model.comm);
  return points;
}

// The material point nearest to each probe; of several equally near the one with the least id.
template <int dim>
std::vector<std::int64_t> find_probe_points(const SoilModel<dim>& model,
                                            const MaterialPoints<dim>& points) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<std::int64_t> ids;
  for (const auto& probe : model.settings.probes) {
    std::int32_t nearest = -1;
    double distance = infinity;
    for (std::int32_t p = 0; p < points.size(); ++p) {
      const double d = (points.x[p] - probe.point).norm();
      if (d < distance) {
        distance = d;
        nearest = p;
      }
    }
    const double least = -max_over_ranks(model.comm, -distance);
    if (least > model.cell_size) {
      log::warn(
          "mpm.json: at /probes/{}/point: the material point nearest to probe \"{}\" is {:.3g} m "
          "away, more than a cell of the grid ({:.3g} m)",
          ids.size(), probe.name, least, model.cell_size);
    }
    const bool is_nearest = nearest >= 0 && distance == least;
    const double id = is_nearest ? static_cast<double>(points.id[nearest]) : infinity;
    ids.push_back(static_cast<std::int64_t>(-max_over_ranks(model.comm, -id)));
  }
  return ids;
}

template <int dim>
void locate_points(const SoilModel<dim>& model, MaterialPoints<dim>& points) {
  const auto outside = find_cells(model.grid, points);
  std::string own;
  if (!outside.empty()) {
    const std::int32_t p = outside.front();
    const auto& starts = points.body_starts;
    const auto next = std::upper_bound(starts.begin(), starts.end(), p);
    const Vector<dim>& x = points.x[p];
    own = fmt::format(
        "{}/{}: found material point {} at ({}), which lies outside the background grid, allowed: "
        "all of the body inside the grid",
        model.settings.bodies_where, next - starts.begin() - 1, points.id[p],
        fmt::join(x.data(), x.data() + dim, ", "));
  }
  const std::string text = first_text(model.comm, own);
  require<ConfigError>(text.empty(), text);
}

void visit_field(StateVisitor& visitor, const std::string& name, std::vector<double>& values) {
  visitor.list(name, values);
}
void visit_field(StateVisitor& visitor, const std::string& name,
                 std::vector<std::int64_t>& values) {
  visitor.list(name, values);
}
void visit_field(StateVisitor& visitor, const std::string& name,
                 std::vector<std::int32_t>& values) {
  std::vector<std::int64_t> wide(values.begin(), values.end());
  visitor.list(name, wide);
  values.assign(wide.begin(), wide.end());
}
template <class Tensor>
void visit_field(StateVisitor& visitor, const std::string& name, std::vector<Tensor>& values) {
  constexpr std::size_t size = Tensor::SizeAtCompileTime;
  const auto before = flat(values);
  std::vector<double> numbers(before.begin(), before.end());
  visitor.list(name, numbers);
  require(numbers.size() % size == 0,
          "saved state: \"{}\" has {} values, allowed: {} for each point", name, numbers.size(),
          size);
  values.resize(numbers.size() / size);
  std::copy(numbers.begin(), numbers.end(), flat(values).begin());
}
template <int dim>
void visit_field(StateVisitor& visitor, const std::string& name,
                 std::vector<MaterialState<dim>>& history) {
  for_each_history_field<dim>(
      [&]<class Value>(const char* field, Value MaterialState<dim>::*member) {
        std::vector<Value> values;
        for (const auto& state : history) values.push_back(state.*member);
        visit_field(visitor, name + "." + field, values);
        history.resize(values.size());
        for (std::size_t p = 0; p < history.size(); ++p) history[p].*member = values[p];
      });
}

template <class Index>
void require_below(const char* what, Index first, std::span<const Index> indices, Index end) {
  for (const Index index : indices) {
    require(index >= first && index < end, "saved state: {}: found {}, allowed: {} to {}", what,
            index, first, end - 1);
  }
}

template <int dim>
void visit_points(StateVisitor& visitor, MaterialPoints<dim>& points) {
  for_each_field<dim>([&](const char* name, auto field) {
    visit_field(visitor, std::string("points.") + name, points.*field);
  });
}

// Check the properties of the state on which a step relies.
template <int dim>
void check_points(const MaterialPoints<dim>& points, std::int32_t num_cells) {
  const std::size_t count = points.id.size();
  for_each_field<dim>(
      [&]<class Value>(const char* name, std::vector<Value> MaterialPoints<dim>::*field) {
        const std::size_t size = (points.*field).size();
        const bool optional = name == std::string("half_length") || name == std::string("grad_v") ||
                              name == std::string("grad_a") || name == std::string("water") ||
                              name == std::string("internal") || name == std::string("variables") ||
                              name == std::string("parameters");
        require(size == count || (optional && size == 0),
                "saved state: points.{}: found {} values for {} points", name, size, count);
      });
  require_below<std::int64_t>("points.id", 0, points.id, points.body_ids.back());
  require_below<std::int32_t>("points.cell", 0, points.cell, num_cells);
}

}  // namespace

template <int dim>
SoilState<dim>::SoilState(const SoilModel<dim>& model)
    : points(lay_all_points(model)),
      surfaces(model.comm, model.settings.interfaces, model.settings.rigid_walls, model.cell_size),
      boulders(boulder_scene<dim>(model.settings, model.grid)),
      ledger(model.comm),
      control(model.settings.step_control),
      gauges(model.comm, model.settings.gauges, model.cell_size),
      wall_forces(model.wall_groups.size(), Vector<dim>::Zero()),
      rigid_wall_forces(model.settings.rigid_walls.size() * wall_values<dim>, 0.0),
      ranks(model.comm, model.grid),
      removed_masses(model.exit_sides.size(), 0.0) {
  if (model.settings.body_groups.any()) {
    surfaces.add_groups(model.settings.body_groups, model.grid.num_nodes_total());
  }
  has_water = std::ranges::any_of(model.settings.bodies,
                                  [](const Body<dim>& body) { return body.water.has_value(); });
  has_rain = model.settings.rain.has_value();
  locate_points(model, points);
  remove_soil_inside(model.comm, model.settings.boulders, model.settings.rigid_walls, points);
  ranks.divide(points, surfaces);
  probe_ids = find_probe_points(model, points);
  probe_ends.assign(probe_ids.size(), std::numeric_limits<double>::infinity());
  ledger.start(points);
}

// Count the points by the sides through which they leave.
template <int dim>
void SoilState<dim>::count_exits(std::span<const std::int32_t> outside, const Step& step,
                                 const SoilModel<dim>& model) {
  const auto& known = model.exit_sides;
  std::vector<double> masses(known.size(), 0.0);
  for (const std::int32_t p : outside) {
    const auto sides = model.exits.sides(step.x[p], step.cell[p], points.x[p]);
    const auto side = std::find_first_of(known.begin(), known.end(), sides.begin(), sides.end());
    if (side != known.end()) masses[static_cast<std::size_t>(side - known.begin())] += points.m[p];
  }
  sum_over_ranks(model.comm, std::span<double>(masses));
  for (std::size_t k = 0; k < known.size(); ++k) {
    if (masses[k] > 0 && removed_masses[k] == 0) {
      log::info("soil begins to leave the background grid through side \"{}\"", known[k]);
    }
    removed_masses[k] += masses[k];
  }
}

// End the probes whose point is among these.
template <int dim>
void SoilState<dim>::end_probes(std::span<const std::int32_t> outside, double time,
                                const SoilModel<dim>& model) {
  std::vector<std::int32_t> ends(probe_ids.size(), 0);
  for (std::size_t k = 0; k < probe_ids.size(); ++k) {
    const std::int32_t p = find_point(points, probe_ids[k]);
    ends[k] = p >= 0 && std::binary_search(outside.begin(), outside.end(), p);
  }
  sum_over_ranks(model.comm, std::span<std::int32_t>(ends));
  for (std::size_t k = 0; k < ends.size(); ++k) {
    if (ends[k] == 0) continue;
    probe_ends[k] = time;
    log::warn(
        "{:.6g} s: material point {} of probe \"{}\" has left the background grid; its "
        "columns are empty from now on",
        time, probe_ids[k], model.settings.probes[k].name);
  }
}

template <int dim>
void SoilState<dim>::remove(std::span<const std::int32_t> outside, const Step& step,
                            const SoilModel<dim>& model) {
  auto count = static_cast<std::int32_t>(outside.size());
  sum_over_ranks(model.comm, std::span<std::int32_t>(&count, 1));
  if (count == 0) return;
  require(model.lets_out, "mpm_solver: a point left the grid unseen");
  count_exits(outside, step, model);
  end_probes(outside, step.time, model);
  std::vector<Vector<dim>> inertia(1, Vector<dim>::Zero());
  std::vector<std::int64_t> ids;
  for (const std::int32_t p : outside) {
    inertia[0] += points.m[p] * points.a[p];
    ids.push_back(points.id[p]);
  }
  inertia[0] -= surfaces.step_force_on(ids);  // the scheme does not ask for it again
  sum_over_ranks<dim>(model.comm, std::span<Vector<dim>>(inertia));
  remove_points(outside, points);
  ledger.remove(points, inertia[0]);
  if (removed_points == 0 && model.settings.outside == Outside::remove) {
    log::warn("material points leave the background grid and are removed");
  }
  removed_points += count;
  if (!is_empty()) return;
  soil_end = step.time;
  surfaces.drop_all();
  ledger.set_contact_energy(surfaces.energy());
  log::warn("{:.6g} s: all soil has left the background grid; the run continues without it",
            step.time);
}

template <int dim>
void SoilState<dim>::visit(StateVisitor& visitor) {
  visit_points(visitor, points);
  ranks.visit_state(visitor);
  surfaces.visit_state(visitor);
  boulders.visit_state(visitor);
  ledger.visit_state(visitor);
  visitor.reals("wall_forces", flat(wall_forces));
  visitor.reals("rigid_wall_forces", rigid_wall_forces);
  visitor.integers("probe_ids", std::span<std::int64_t>(probe_ids));
  visitor.reals("probe_ends", probe_ends);
  visitor.real("soil_end", soil_end);
  visitor.integer("removed_points", removed_points);
  visitor.reals("removed_masses", removed_masses);
  if (has_water) visitor.real("water_out", water_out);
  if (has_rain) {
    visitor.real("rain_in", rain_in);
    visitor.real("rain_run_off", rain_run_off);
  }
  visitor.flag("nearly_linear", nearly_linear);
  visitor.real("contact_rate", contact_rate);
  pause.visit_state(visitor);
  control.visit_state(visitor);
  strength.visit_state(visitor);
  gauges.visit_state(visitor);
}

template <int dim>
State SoilState<dim>::save() {
  State state;
  StateWriter writer(state);
  visit(writer);
  return state;
}

template <int dim>
void SoilState<dim>::take(StateVisitor& visitor, const SoilModel<dim>& model) {
  // Points of this rank, and on one rank those that have left; soil inside boulders was never
  // there.
  const auto own_points = [&] {
    return static_cast<double>(points.size() + (rank_of(model.comm) == 0 ? removed_points : 0));
  };
  double counts[] = {own_points(), 0};
  together(model.comm, [&] {
    visit(visitor);
    check_points(points, model.grid.num_cells());
    require(points.internal.size() == (model.remembers_internal ? points.id.size() : 0),
            "saved state: points.internal: found {} values for {} points and laws {} internal "
            "variables",
            points.internal.size(), points.id.size(),
            model.remembers_internal ? "with" : "without");
    require(points.parameters.size() == (model.varies ? points.id.size() : 0),
            "saved state: points.parameters: found {} values for {} points and bodies {} constants "
            "that vary",
            points.parameters.size(), points.id.size(), model.varies ? "with" : "without");
    require(
        points.variables.size() == (model.remembers_variables ? points.id.size() : 0),
        "saved state: points.variables: found {} values for {} points and bodies {} the law umat",
        points.variables.size(), points.id.size(), model.remembers_variables ? "with" : "without");
    require_below<std::int64_t>("probe_ids", 0, probe_ids, points.body_ids.back());
    order_points(0, points);
    require(std::ranges::adjacent_find(points.id) == points.id.end(),
            "saved state: points.id: found an id twice");
  });
  counts[1] = own_points();
  sum_over_ranks(model.comm, std::span<double>(counts));
  require(counts[1] == counts[0],
          "saved state: found {} material points, those that left included, allowed: {}", counts[1],
          counts[0]);
}

template <int dim>
void SoilState<dim>::load(const State& state, const SoilModel<dim>& model) {
  StateReader reader(state);
  take(reader, model);
  const int parts = ranks.partition().num_parts();
  require(parts == num_ranks(model.comm),
          "saved state: found a partition for {} ranks, allowed: {}", parts, num_ranks(model.comm));
}

template <int dim>
void SoilState<dim>::join(const State& first, std::span<const State> own,
                          const SoilModel<dim>& model) {
  StateJoiner joiner(first, own);
  take(joiner, model);
  ranks.divide(points, surfaces);
}

template struct SoilState<2>;
template struct SoilState<3>;

}  // namespace gabion::mpm
