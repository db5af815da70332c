// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/time_steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/require.hpp"

namespace gabion {

namespace {

constexpr int steps_before_growth = 4;
constexpr double max_ticks = 1e15;         // all of them are exact in a double
constexpr double raster_tolerance = 1e-9;  // [ticks relative to all]: `end` counts as on the raster

}  // namespace

KeyTable time_keys() {
  return {
      "time",
      "Steps are `dt` times a power of two; a step that fails is halved.",
      {key::number("end", "s", "End of the run.").in(positive()),
       key::number("dt", "s", "Size of the first step.").in(positive()),
       key::number("dt_min", "s",
                   "Smallest step, at most `dt` and at least `end` / 1e15. A step that would have "
                   "to be smaller ends the run with an error.")
           .in(positive()),
       key::number("dt_max", "s",
                   "Largest step, at least `dt`. After four accepted steps of one size the next "
                   "one may be twice as long.")
           .in(positive())
           .or_computed("`dt`")}};
}

KeyTable output_keys() {
  return {"output",
          "When frames are written: at 0, at the first accepted step at or after each multiple of "
          "`interval`, and at the end.",
          {key::number("interval", "s", "Time from one frame to the next.").in(positive())}};
}

TimeSettings read_time_settings(ConfigReader in) {
  TimeSettings settings;
  settings.end = in.number("end");
  settings.dt = in.number("dt");
  settings.dt_min = in.number("dt_min");
  settings.dt_max = in.number_or("dt_max", settings.dt);
  in.finish();
  if (settings.dt_max < settings.dt) {
    in.fail("dt_max",
            fmt::format("found {}, allowed: a number >= dt = {}", settings.dt_max, settings.dt));
  }
  if (settings.dt_min > settings.dt) {
    in.fail("dt_min",
            fmt::format("found {}, allowed: a number <= dt = {}", settings.dt_min, settings.dt));
  }
  if (settings.end / settings.dt_min > max_ticks) {
    in.fail("dt_min", fmt::format("found {}, allowed: a number >= end / {:g} = {}", settings.dt_min,
                                  max_ticks, settings.end / max_ticks));
  }
  return settings;
}

TimeSteps::TimeSteps(const TimeSettings& settings) : settings_(settings) {
  while (std::ldexp(settings_.dt, -(max_level_ + 1)) >= settings_.dt_min) ++max_level_;
  while (std::ldexp(settings_.dt, 1 - min_level_) <= settings_.dt_max &&
         level_dt(min_level_) < settings_.end) {
    --min_level_;
  }
  count_end_ticks();
}

void TimeSteps::count_end_ticks() {
  const double ticks = std::ldexp((settings_.end - origin_) / settings_.dt, max_level_);
  const double nearest = std::round(ticks);
  const bool on_raster = nearest >= 1 && std::abs(ticks - nearest) <= raster_tolerance * nearest;
  end_ticks_ = static_cast<std::int64_t>(on_raster ? nearest : std::ceil(ticks));
}

bool TimeSteps::finished() const {
  return ticks_ >= end_ticks_;
}

double TimeSteps::time() const {
  if (finished()) return settings_.end;
  return raster_time();
}

double TimeSteps::raster_time() const {
  return origin_ + std::ldexp(settings_.dt * static_cast<double>(ticks_), -max_level_);
}

void TimeSteps::visit_state(StateVisitor& visitor) {
  double now = time();
  visitor.real("time", now);
  visitor.real("origin", origin_);
  visitor.integer("ticks", ticks_);
  visitor.integer("step", step_);
  visitor.integer("level", level_);
  visitor.integer("accepted_at_level", accepted_at_level_);
  const auto check = [](const char* name, std::int64_t found, std::int64_t from, std::int64_t to) {
    require(found >= from && found <= to, "saved state: \"{}\" is {}, allowed: {} to {}", name,
            found, from, to);
  };
  // The settings may be others than in the run that was saved.
  constexpr int widest = 50;  // 2^50 > max_ticks
  check("ticks", ticks_, 0, std::int64_t{1} << widest);
  check("step", step_, 1, std::numeric_limits<std::int64_t>::max() - 1);
  check("level", level_, max_level_ - widest, max_level_);
  check("accepted_at_level", accepted_at_level_, 0, std::numeric_limits<int>::max());
  require(now >= 0 && std::isfinite(now) && origin_ >= 0 && std::isfinite(origin_),
          "saved state: found time {} s and origin {} s, allowed: >= 0", now, origin_);
  if (std::abs(raster_time() - now) > raster_tolerance * now) {
    origin_ = now;  // the run ended off the raster: one that extends it starts a raster there
    ticks_ = 0;
  }
  count_end_ticks();
}

double TimeSteps::level_dt(int level) const {
  return std::ldexp(settings_.dt, -level);
}

std::int64_t TimeSteps::ticks_under_way() const {
  return std::min(level_ticks(level_), end_ticks_ - ticks_);
}

double TimeSteps::dt() const {
  const double rest = settings_.end - time();
  const bool shortened = ticks_ + ticks_under_way() == end_ticks_ &&
                         std::abs(rest - level_dt(level_)) > raster_tolerance * level_dt(level_);
  return shortened ? rest : level_dt(level_);
}

void TimeSteps::accept(double proposed_dt) {
  ticks_ += ticks_under_way();
  ++step_;
  ++accepted_at_level_;
  const auto wanted = [&](int level) { return proposed_dt <= 0 || level_dt(level) <= proposed_dt; };
  while (level_ < max_level_ && !wanted(level_)) {
    ++level_;
    accepted_at_level_ = 0;
  }
  const bool may_grow = level_ > min_level_ && accepted_at_level_ >= steps_before_growth &&
                        ticks_ % level_ticks(level_ - 1) == 0 && wanted(level_ - 1);
  if (may_grow) {
    --level_;
    accepted_at_level_ = 0;
  }
}

TimeSteps TimeSteps::after(double proposed_dt) const {
  TimeSteps next = *this;
  next.accept(proposed_dt);
  return next;
}

DtRange TimeSteps::same_next(double proposed_dt) const {
  const int level = after(proposed_dt).level_;
  DtRange range;
  if (level < max_level_) range.from = level_dt(level);
  if (after(0).level_ < level) range.below = level_dt(level - 1);
  return range;
}

void TimeSteps::cut(const std::string& reason) {
  const std::int64_t failed = ticks_under_way();
  int level = level_;
  while (level <= max_level_ && level_ticks(level) >= failed) ++level;
  if (level > max_level_) {
    throw ConvergenceError(
        fmt::format("step {} at time {} s failed with dt = {} s and no smaller dt is allowed "
                    "(dt_min = {} s): {}",
                    step_, time(), dt(), settings_.dt_min, reason));
  }
  level_ = level;
  accepted_at_level_ = 0;
  ++cuts_;
}

}  // namespace gabion
