// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/phases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace gabion::mpm {

namespace {

// Times that differ by this share are one: they are sums of steps, rounded.
constexpr double same_time = 1e-9;

std::vector<WallSettings> read_walls(ConfigReader& in, int dim) {
  std::vector<WallSettings> walls;
  std::set<std::string> groups;
  for (auto& item : in.objects_or_none("walls")) {
    WallSettings wall;
    wall.group = item.text("group");
    if (!groups.insert(wall.group).second) {
      item.fail("group",
                fmt::format("found \"{}\" a second time, allowed: one wall a group", wall.group));
    }
    wall.fixed = item.choice("condition", {"fixed", "slip"}) == "fixed";
    wall.where = item.where("group");
    if (auto motion = item.optional_object("motion")) {
      wall.motion = read_wall_motion(*motion, dim);
    }
    item.finish();
    walls.push_back(std::move(wall));
  }
  return walls;
}

LoadRamp read_load_ramp(ConfigReader in, double start) {
  LoadRamp ramp;
  ramp.start = start;
  ramp.duration = in.number("duration", positive());
  ramp.smooth = in.choice_or("shape", {"linear", "smooth"}, "linear") == "smooth";
  ramp.from = in.number_or("from", ramp.from);
  ramp.to = in.number_or("to", ramp.to);
  in.finish();
  return ramp;
}

// Replace what the object names.
void read_overrides(ConfigReader& in, int dim, Phase& phase) {
  phase.dynamic = in.choice_or("analysis", {"dynamic", "quasi_static"},
                               phase.dynamic ? "dynamic" : "quasi_static") == "dynamic";
  if (in.has("walls")) phase.walls = read_walls(in, dim);
  if (auto scheme = in.optional_object("time_integration")) {
    phase.scheme = read_newmark_bossak(*scheme);
  }
  if (auto ramp = in.optional_object("gravity_ramp")) {
    phase.gravity_ramp = read_load_ramp(*ramp, phase.start);
  }
}

void require_inertia(const ConfigReader& in, const Phase& phase) {
  if (phase.dynamic || !in.has("time_integration")) return;
  in.fail("time_integration", "has no meaning when \"analysis\" is \"quasi_static\"");
}

}  // namespace

std::vector<Phase> read_phases(ConfigReader& in, int dim) {
  Phase base;
  read_overrides(in, dim, base);
  if (!in.has("phases")) {
    require_inertia(in, base);
    return {base};
  }
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
      phase.until = item.number("until", positive());
      if (!(phase.until > phase.start)) {
        item.fail("until", fmt::format("found {}, allowed: a time after the start of the phase, {}",
                                       phase.until, phase.start));
      }
    } else if (item.has("until")) {
      item.fail("until", "allowed in all phases but the last one, which lasts to the end");
    }
    if (item.has("dt")) phase.dt = item.number("dt", positive());
    item.finish();
    phases.push_back(std::move(phase));
  }
  return phases;
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
