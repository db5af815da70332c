// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/progress.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "common/base/log.hpp"

namespace gabion {

namespace {

constexpr double live_period = 0.1;  // [s] wall time between two updates of a terminal's line
constexpr double plain_period = 10;  // [s] wall time between two log lines
constexpr double plain_fraction = 0.1;

}  // namespace

std::string duration_text(double seconds) {
  if (seconds < 119.5) return fmt::format("{:.0f} s", seconds);
  if (seconds >= 3599.5) return fmt::format("{:.1f} h", seconds / 3600);
  const auto whole = std::lround(seconds);
  return fmt::format("{} min {} s", whole / 60, whole % 60);
}

Progress::Progress(double end, bool speaks)
    : end_(end), speaks_(speaks), terminal_(log::on_terminal()) {}

Progress::~Progress() {
  if (line_open_) std::fputc('\n', stderr);
}

void Progress::update(std::int64_t step, double time, double dt, int iterations) {
  if (!speaks_) return;
  const double wall = watch_.seconds();
  const double fraction = time / end_;
  const bool done = time >= end_;
  const bool due =
      terminal_ ? wall - last_shown_ >= live_period
                : wall - last_shown_ >= plain_period || fraction - last_fraction_ >= plain_fraction;
  if (!due && !done) return;
  last_shown_ = wall;
  last_fraction_ = fraction;
  const std::string text = fmt::format(
      "step {}, time {:.6g} of {:.6g} s ({:.0f} %), dt {:.3g} s, iterations {}, {} so far, {} to "
      "go",
      step, time, end_, 100 * fraction, dt, iterations, duration_text(wall),
      duration_text(wall * (1 - fraction) / fraction));
  if (!terminal_) {
    log::info("{}", text);
    return;
  }
  fmt::print(stderr, "{}{}{}", log::erase_line, text, done ? "\n" : "");
  std::fflush(stderr);
  line_open_ = !done;
}

}  // namespace gabion
