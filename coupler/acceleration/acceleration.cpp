// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/acceleration.hpp"

#include "coupler/acceleration/quasi_newton.hpp"
#include "coupler/acceleration/relaxation.hpp"

namespace gabion {

AccelerationSettings read_acceleration_settings(ConfigReader in) {
  AccelerationSettings s;
  s.method = in.choice_or("method", {"constant", "aitken", "iqn_ils", "mvqn"}, s.method);
  const Range omega{[](double x) { return x > 0 && x <= 2; }, "a number > 0 and <= 2"};
  s.relaxation = in.number_or("relaxation", s.relaxation, omega);
  if (s.method == "iqn_ils" || s.method == "mvqn") {
    const Range limit{[](double x) { return x >= 0 && x < 1; }, "a number >= 0 and < 1"};
    const Range beta{[](double x) { return x > 0 && x <= 1; }, "a number > 0 and <= 1"};
    s.filter = in.number_or("filter", s.filter, limit);
    s.history = in.integer_or("history", s.history, non_negative());
    s.max_columns = in.integer_or("max_columns", s.max_columns, at_least(1));
    s.damping = in.number_or("damping", s.damping, beta);
  }
  in.finish();
  return s;
}

std::unique_ptr<Acceleration> make_acceleration(const AccelerationSettings& settings) {
  if (settings.method == "constant") return std::make_unique<Constant>(settings.relaxation);
  if (settings.method == "aitken") return std::make_unique<Aitken>(settings.relaxation);
  if (settings.method == "iqn_ils") return std::make_unique<IqnIls>(settings);
  if (settings.method == "mvqn") return std::make_unique<Mvqn>(settings);
  throw ConfigError("acceleration: found \"" + settings.method +
                    "\", allowed: constant, aitken, iqn_ils, mvqn");
}

}  // namespace gabion
