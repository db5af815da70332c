// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/soil_state.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <type_traits>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"
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
  if (settings.tpic) add_gradients(points);
  const Phase& phase = settings.phases.front();
  const Vector<dim> gravity = phase.gravity_ramp.at(0) * settings.gravity;
  // Free of stress, so gravity is the acceleration at the start; the walls take their part of it.
  if (phase.dynamic) std::fill(points.a.begin(), points.a.end(), gravity);
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    if (!settings.initial_stress[b]) continue;
    set_initial_stress<dim>(
        model.comm, *settings.initial_stress[b],
        {.body = settings.bodies[b], .number = static_cast<std::int32_t>(b), .gravity = gravity},
        points);
  }
  log::info("{} material points in {} {}", total, settings.bodies.size(),
            settings.bodies.size() == 1 ? "body" : "bodies");
  return points;
}

// The material point nearest to each probe; -1 on the ranks that do not own it.
template <int dim>
std::vector<std::int32_t> find_probe_points(const SoilModel<dim>& model,
                                            const MaterialPoints<dim>& points) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<std::int32_t> probe_points;
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
          probe_points.size(), probe.name, least, model.cell_size);
    }
    const double id = distance == least ? static_cast<double>(points.id[nearest]) : infinity;
    const bool owner = nearest >= 0 && id == -max_over_ranks(model.comm, -id);
    probe_points.push_back(owner ? nearest : -1);
  }
  return probe_points;
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
  visitor.reals(name, values);
}
void visit_field(StateVisitor& visitor, const std::string& name,
                 std::vector<std::int32_t>& values) {
  visitor.integers(name, values);
}
template <class Tensor>
void visit_field(StateVisitor& visitor, const std::string& name, std::vector<Tensor>& values) {
  visitor.reals(name, flat(values));
}
template <int dim>
void visit_field(StateVisitor& visitor, const std::string& name,
                 std::vector<MaterialState<dim>>& history) {
  for_each_history_field<dim>(
      [&]<class Value>(const char* field, Value MaterialState<dim>::*member) {
        std::vector<Value> values;
        for (const auto& state : history) values.push_back(state.*member);
        visit_field(visitor, name + "." + field, values);
        for (std::size_t p = 0; p < history.size(); ++p) history[p].*member = values[p];
      });
}

// What is laid follows from the settings, but points that have left the grid are gone.
template <int dim>
void visit_points(StateVisitor& visitor, MaterialPoints<dim>& points) {
  std::vector<std::int64_t> id = points.id;
  visitor.list("points.id", id);
  std::vector<std::int32_t> gone;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    if (!std::binary_search(id.begin(), id.end(), points.id[p])) gone.push_back(p);
  }
  if (!gone.empty()) remove_points<dim>(gone, points);
  require(id == points.id, "saved state: its material points are those of other ranks or bodies");
  for_each_field<dim>([&]<class Value>(const char* name,
                                       std::vector<Value> MaterialPoints<dim>::*field,
                                       FieldKind kind) {
    if constexpr (!std::is_same_v<Value, std::int64_t>) {
      if (kind == FieldKind::moves) {
        visit_field(visitor, std::string("points.") + name, points.*field);
      }
    }
  });
}

void require_below(const char* what, std::int32_t first, std::span<const std::int32_t> indices,
                   std::int32_t end) {
  for (const std::int32_t index : indices) {
    require(index >= first && index < end, "saved state: {}: found {}, allowed: {} to {}", what,
            index, first, end - 1);
  }
}

}  // namespace

template <int dim>
SoilState<dim>::SoilState(const SoilModel<dim>& model)
    : points(lay_all_points(model)),
      surfaces(model.comm, model.settings.interfaces, model.settings.rigid_walls),
      ledger(model.comm),
      control(model.settings.step_control),
      gauges(model.comm, model.settings.gauges, model.cell_size),
      wall_forces(model.wall_groups.size(), Vector<dim>::Zero()),
      rigid_wall_forces(model.settings.rigid_walls.size() * wall_values<dim>, 0.0),
      probe_points(find_probe_points(model, points)),
      removed_masses(model.exit_sides.size(), 0.0) {
  locate_points(model, points);
  ledger.start(points);
}

// Which sides the points leave by.
template <int dim>
void SoilState<dim>::count_exits(std::span<const std::int32_t> outside, const Start& start,
                                 const SoilModel<dim>& model) {
  const auto& known = model.exit_sides;
  std::vector<double> masses(known.size(), 0.0);
  for (const std::int32_t p : outside) {
    const auto sides = model.exits.sides(start.x[p], start.cell[p], points.x[p]);
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

template <int dim>
void SoilState<dim>::remove(std::span<const std::int32_t> outside, const Start& start,
                            const SoilModel<dim>& model) {
  auto count = static_cast<std::int32_t>(outside.size());
  sum_over_ranks(model.comm, std::span<std::int32_t>(&count, 1));
  if (count == 0) return;
  require(model.lets_out, "mpm_solver: a point left the grid unseen");
  count_exits(outside, start, model);
  std::string lost;
  for (std::size_t k = 0; k < probe_points.size(); ++k) {
    if (std::binary_search(outside.begin(), outside.end(), probe_points[k])) {
      lost = fmt::format("material point {} of probe \"{}\" has left the background grid",
                         points.id[probe_points[k]], model.settings.probes[k].name);
    }
    probe_points[k] -= static_cast<std::int32_t>(
        std::lower_bound(outside.begin(), outside.end(), probe_points[k]) - outside.begin());
  }
  std::vector<Vector<dim>> inertia(1, Vector<dim>::Zero());
  for (const std::int32_t p : outside) inertia[0] += points.m[p] * points.a[p];
  sum_over_ranks<dim>(model.comm, std::span<Vector<dim>>(inertia));
  remove_points(outside, points);
  ledger.remove(points, inertia[0]);
  if (removed_points == 0 && model.settings.outside == Outside::remove) {
    log::warn("material points leave the background grid and are removed");
  }
  removed_points += count;
  lost = first_text(model.comm, lost);
  require(lost.empty(), lost);
  require(ledger.totals().mass > 0, "all material points have left the background grid");
}

template <int dim>
void SoilState<dim>::visit(StateVisitor& visitor) {
  visit_points(visitor, points);
  surfaces.visit_state(visitor);
  ledger.visit_state(visitor);
  visitor.reals("wall_forces", flat(wall_forces));
  visitor.reals("rigid_wall_forces", rigid_wall_forces);
  visitor.integers("probe_points", std::span<std::int32_t>(probe_points));
  visitor.integer("removed_points", removed_points);
  visitor.reals("removed_masses", removed_masses);
  visitor.flag("nearly_linear", nearly_linear);
  visitor.real("contact_rate", contact_rate);
  pause.visit_state(visitor);
  control.visit_state(visitor);
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
void SoilState<dim>::load(const State& state, std::int32_t num_cells) {
  StateReader reader(state);
  visit(reader);
  require_below("cell of a material point", 0, points.cell, num_cells);
  require_below("material point of a probe", -1, probe_points, points.size());
}

template struct SoilState<2>;
template struct SoilState<3>;

}  // namespace gabion::mpm
