// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/own_weight.hpp"

#include <cmath>

#include "common/base/log.hpp"

namespace gabion {

namespace {

constexpr double slowest = 5, fastest = 20000;  // [m/s]
constexpr double largest_share = 0.05;          // settlement by height

}  // namespace

double WeightedColumn::wave_speed() const {
  return std::sqrt(p_wave_modulus / density);
}

double WeightedColumn::settlement() const {
  return density * gravity * height * height / (2 * p_wave_modulus);
}

double WeightedColumn::period() const {
  return 4 * height / wave_speed();
}

void log_own_weight(const std::string& where, const WeightedColumn& column) {
  const double speed = column.wave_speed(), settlement = column.settlement();
  if (column.gravity > 0) {
    log::info(
        "{}: wave speed {:.4g} m/s; {:.3g} m deep, it settles by {:.2g} m under its own weight",
        where, speed, column.height, settlement);
  } else {
    log::info("{}: wave speed {:.4g} m/s", where, speed);
  }
  if (speed < slowest || speed > fastest) {
    log::warn(
        "{}: wave speed {:.3g} m/s, plausible: {} to {} m/s; young_modulus and density in Pa and "
        "kg/m^3?",
        where, speed, slowest, fastest);
  }
  if (settlement > largest_share * column.height) {
    log::warn(
        "{}: settles by {:.2g} m under its own weight, {:.3g} of its depth of {:.3g} m, "
        "plausible: at most {}; young_modulus in Pa, lengths in m?",
        where, settlement, settlement / column.height, column.height, largest_share);
  }
}

}  // namespace gabion
