// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/phases/phases.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace gabion::mpm {

namespace {

// Times that differ by this share are one: they are sums of steps, rounded.
constexpr double same_time = 1e-9;

OutflowSide read_outflow(const ConfigReader& item, const std::string& group) {
  for (const char* key : {"motion", "drained", "inflow"}) {
    if (item.has(key)) item.fail(key, "allowed only with a wall that holds soil");
  }
  return {group, item.where("group")};
}

// Read the walls, and the sides through which soil leaves.
void read_walls(ConfigReader& in, int dim, Phase& phase) {
  phase.walls.clear();
  phase.outflows.clear();
  std::set<std::string> groups;
  for (auto& item : in.objects("walls")) {
    WallSettings wall;
    wall.group = item.text("group");
    if (!groups.insert(wall.group).second) {
      item.fail("group",
                fmt::format("found \"{}\" a second time, allowed: one wall a group", wall.group));
    }
    const std::string condition = item.choice("condition");
    if (condition == "outflow") {
      phase.outflows.push_back(read_outflow(item, wall.group));
      item.finish();
      continue;
    }
    wall.fixed = condition == "fixed";
    wall.where = item.where("group");
    wall.drained = item.boolean("drained");
    wall.inflow = item.number("inflow");
    wall.where_inflow = item.where("inflow");
    if (wall.drained && wall.inflow != 0) {
      item.fail("inflow", fmt::format("found {:g} with \"drained\", whose pressure is given, "
                                      "allowed: one of them",
                                      wall.inflow));
    }
    if (auto motion = item.optional_object("motion")) {
      wall.motion = read_wall_motion(*motion, dim);
    }
    item.finish();
    phase.walls.push_back(std::move(wall));
  }
}

LoadRamp read_load_ramp(ConfigReader in, double start) {
  LoadRamp ramp;
  ramp.start = start;
  ramp.duration = in.number("duration");
  ramp.smooth = in.choice("shape") == "smooth";
  ramp.from = in.number("from");
  ramp.to = in.number("to");
  in.finish();
  return ramp;
}

std::string analysis_name(bool dynamic) {
  return dynamic ? "dynamic" : "quasi_static";
}

Key analysis_key() {
  return key::choice(
      "analysis", {analysis_name(true), analysis_name(false)},
      "`quasi_static`: without inertia; `time_integration`, `transfer` and velocities "
      "of bodies then have no meaning.");
}

KeyTable wall_keys() {
  return {
      "wall",
      "A wall along facets of the grid; each group has one wall at most. Where walls meet, `fixed` "
      "prevails.",
      {key::text("group", "Facet group of the grid."),
       key::choice("condition", {"fixed", "slip", "outflow"},
                   "`fixed`: holds all components; `slip`: holds the normal component, in tension "
                   "too; `outflow`: holds nothing, and points that leave there are removed. `slip` "
                   "takes one mean normal per node where the group bends by less than 20 degrees."),
       key::object("motion", wall_motion_keys(), "Given motion; none: it is still.").or_none(),
       key::boolean("drained",
                    "Whether pore water drains through the wall: its pressure there is that of "
                    "water at rest below the `water_table` of the body, 0 without one. Only with "
                    "soil that has a `permeability`.")
           .or_else(false)
           .when("condition", {"fixed", "slip"}),
       key::number(
           "inflow", "m/s",
           "Volume of pore water that enters the soil through the wall, by time and by the "
           "area of the wall that soil touches; negative: that is drawn out. Only with soil "
           "that has a `permeability`, with `gimp` and in implicit steps.")
           .in(between(-1, 1))
           .or_else(0)
           .when("condition", {"fixed", "slip"})}};
}

Key walls_key(const std::string& sentence) {
  return key::objects("walls", wall_keys(), sentence);
}

KeyTable load_ramp_keys() {
  const LoadRamp defaults;
  return {"gravity_ramp",
          "Factor of gravity, from the start of the run or of the phase that names it.",
          {key::number("duration", "s", "Time from `from` to `to`.").in(positive()),
           key::choice("shape", {"linear", "smooth"}, "`smooth`: without kinks at both ends.")
               .or_else("linear"),
           key::number("from", "", "Factor at the start.").or_else(defaults.from),
           key::number("to", "", "Factor at the end and after it.").or_else(defaults.to)}};
}

Key gravity_ramp_key(const std::string& sentence) {
  return key::object("gravity_ramp", load_ramp_keys(), sentence).or_none();
}

constexpr double default_courant = 0.9;

// The schemes of Newmark's family, and substeps without a system of equations.
KeyTable scheme_keys() {
  KeyTable table = newmark_keys("bossak");
  Key& scheme = table.keys.front();
  scheme.words.push_back("explicit");
  scheme.sentence.back() = ';';
  scheme.sentence += " `explicit`: central differences, in as many substeps as stability asks for.";
  table.keys.push_back(
      key::number(
          "courant", "",
          "Largest substep by cell size over wave speed; above 1 only where that is known to be "
          "stable.")
          .in({.low = 0, .high = 2, .low_open = true, .allowed = "a number in (0, 2]"})
          .or_else(default_courant)
          .when("scheme", {"explicit"}));
  return table;
}

Key scheme_key() {
  return key::object("time_integration", scheme_keys(), "Time integration of phases with inertia.");
}

void read_scheme(ConfigReader in, Phase& phase) {
  phase.courant.reset();
  if (in.choice("scheme") == "explicit") {
    phase.courant = in.number("courant");
    in.finish();
  } else {
    phase.scheme = read_newmark_bossak(std::move(in));
  }
}

/// A key of a phase: where it is missing, the value is that of the phase before.
Key or_as_before(Key key, const std::string& words) {
  key.absence = Absence::none;
  key.computed = words;
  return key;
}

KeyTable phase_keys() {
  return {
      "phase",
      "A part of the run. Keys that it does not name are those of the run.",
      {key::number("until", "s", "End of the phase, after its start.")
           .in(positive())
           .only("in all phases but the last one, which lasts to the end"),
       key::number("dt", "s", "Largest step of the phase.").in(positive()).or_none(),
       analysis_key().or_computed("as in the run"),
       or_as_before(walls_key("All walls of this phase."), "as in the run"),
       or_as_before(key::texts("rigid_walls",
                               "Names of the rigid walls that act from this phase on; the others "
                               "are dropped for good, as a gate is opened."),
                    "those of the phase before, in the first phase all"),
       or_as_before(scheme_key(), "as in the run"),
       or_as_before(
           gravity_ramp_key("A ramp from the start of this phase; it continues in later ones."),
           "that of the phase before"),
       key::object("strength_reduction", strength_reduction_keys(),
                   "Search for the factor of safety, in a quasi-static phase.")
           .or_none()}};
}

void read_ramp(ConfigReader& in, Phase& phase) {
  if (auto ramp = in.optional_object("gravity_ramp")) {
    phase.gravity_ramp = read_load_ramp(*ramp, phase.start);
  }
}

// Replace the settings that the object of a phase names.
void read_overrides(ConfigReader& in, int dim, Phase& phase) {
  phase.dynamic = in.choice_or("analysis", analysis_name(phase.dynamic)) == analysis_name(true);
  if (in.has("walls")) read_walls(in, dim, phase);
  phase.rigid_walls.reset();
  if (in.has("rigid_walls")) phase.rigid_walls = in.texts("rigid_walls");
  if (auto scheme = in.optional_object("time_integration")) {
    read_scheme(*scheme, phase);
  }
  read_ramp(in, phase);
  phase.strength_reduction.reset();
  if (auto reduction = in.optional_object("strength_reduction")) {
    phase.strength_reduction = read_strength_reduction(*reduction);
    if (phase.dynamic) {
      in.fail("strength_reduction",
              "found in a phase with inertia, allowed: with \"analysis\": \"quasi_static\"");
    }
  }
}

void require_inertia(const ConfigReader& in, const Phase& phase) {
  if (phase.dynamic || !in.has("time_integration")) return;
  in.fail("time_integration", "has no meaning when \"analysis\" is \"quasi_static\"");
}

Phase read_base(ConfigReader& in, int dim) {
  Phase base;
  base.dynamic = in.choice("analysis") == analysis_name(true);
  read_walls(in, dim, base);
  const bool quasi_static = !base.dynamic && !in.has("phases");
  if (quasi_static) {
    require_inertia(in, base);
  } else {
    read_scheme(in.object("time_integration"), base);
  }
  read_ramp(in, base);
  return base;
}

}  // namespace

bool any_implicit(const std::vector<Phase>& phases) {
  return std::any_of(phases.begin(), phases.end(),
                     [](const Phase& phase) { return !phase.is_explicit(); });
}

bool any_explicit(const std::vector<Phase>& phases) {
  return std::any_of(phases.begin(), phases.end(),
                     [](const Phase& phase) { return phase.is_explicit(); });
}

bool any_reduces_strength(const std::vector<Phase>& phases) {
  return std::any_of(phases.begin(), phases.end(),
                     [](const Phase& phase) { return phase.strength_reduction.has_value(); });
}

std::vector<Key> phases_keys() {
  return {analysis_key().or_else("dynamic"),
          scheme_key().or_empty().only("where a phase has inertia"),
          walls_key("Walls of the grid.").or_empty(),
          gravity_ramp_key("Gravity that grows over time; none: full from the start."),
          key::objects("phases", phase_keys(), "Parts of the run, in the order of time.")
              .not_empty()
              .or_none()};
}

std::vector<Phase> read_phases(ConfigReader& in, int dim) {
  const Phase base = read_base(in, dim);
  if (!in.has("phases")) return {base};
  auto items = in.objects("phases");
  if (items.empty()) in.fail("phases", "found an empty list, allowed: at least one phase");
  std::vector<Phase> phases;
  for (std::size_t k = 0; k < items.size(); ++k) {
    ConfigReader& item = items[k];
    Phase phase = base;
    if (k > 0) {
      phase.start = phases.back().until;
      phase.gravity_ramp = phases.back().gravity_ramp;
    }
    read_overrides(item, dim, phase);
    require_inertia(item, phase);
    if (k + 1 < items.size()) {
      phase.until = item.number("until");
      if (!(phase.until > phase.start)) {
        item.fail("until", fmt::format("found {}, allowed: a time after the start of the phase, {}",
                                       phase.until, phase.start));
      }
    } else if (item.has("until")) {
      item.fail("until", "allowed in all phases but the last one, which lasts to the end");
    }
    phase.dt = item.optional_number("dt").value_or(0);
    item.finish();
    phases.push_back(std::move(phase));
  }
  return phases;
}

void resolve_rigid_walls(const ConfigReader& in, const std::vector<std::string>& all,
                         std::vector<Phase>& phases) {
  std::vector<std::string> acting = all;
  for (std::size_t k = 0; k < phases.size(); ++k) {
    if (!phases[k].rigid_walls) phases[k].rigid_walls = acting;
    for (const std::string& name : *phases[k].rigid_walls) {
      if (std::find(acting.begin(), acting.end(), name) != acting.end()) continue;
      in.fail(fmt::format("phases/{}/rigid_walls", k),
              fmt::format("found \"{}\", allowed: rigid walls that act in the phase before: {}",
                          name, fmt::join(acting, ", ")));
    }
    acting = *phases[k].rigid_walls;
  }
}

std::size_t phase_at(const std::vector<Phase>& phases, double time) {
  std::size_t k = 0;
  while (k + 1 < phases.size() && phases[k].until - time <= same_time * phases[k].until) ++k;
  return k;
}

bool begins(const Phase& phase, double time) {
  return std::abs(time - phase.start) <= same_time * phase.start;
}

void require_within(const Phase& phase, double time, double dt) {
  if (time + dt - phase.until > same_time * phase.until) {
    throw ConvergenceError(fmt::format("a step of {} s from {} s would pass the end of a phase at "
                                       "{} s",
                                       dt, time, phase.until),
                           phase_cause);
  }
  if (phase.dt > 0 && dt > (1 + same_time) * phase.dt) {
    throw ConvergenceError(fmt::format("the phase at {} s allows steps of {} s", time, phase.dt),
                           phase_cause);
  }
}

double largest_step(const Phase& phase, double time) {
  double step = phase.dt > 0 ? phase.dt : std::numeric_limits<double>::infinity();
  step = (1 + same_time) * std::min(step, phase.until - time);
  return std::isfinite(step) ? step : 0;
}

}  // namespace gabion::mpm
