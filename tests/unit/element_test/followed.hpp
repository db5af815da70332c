// SPDX-License-Identifier: BSD-3-Clause
// Element tests from settings in JSON, without files.
#pragma once

#include <numbers>

#include "element_test/element_stage.hpp"

namespace gabion::testing {

using element::ElementState;

inline constexpr double degree = std::numbers::pi / 180;

inline Json sand() {
  return {{"law", "mohr_coulomb"}, {"density", 2000},      {"young_modulus", 2e7},
          {"poisson_ratio", 0.3},  {"friction_angle", 33}, {"dilation_angle", 5},
          {"cohesion", 5000}};
}

inline Json clay() {
  return {{"law", "tresca"},
          {"density", 2000},
          {"young_modulus", 1e7},
          {"poisson_ratio", 0.45},
          {"cohesion", 4e4}};
}

inline Json elastic(double poisson_ratio = 0.3) {
  return {{"law", "hencky_elastic"},
          {"density", 2000},
          {"young_modulus", 1e7},
          {"poisson_ratio", poisson_ratio}};
}

inline Json mud(double flow_index = 1) {
  return {{"law", "herschel_bulkley"}, {"density", 2000},     {"young_modulus", 1e7},
          {"poisson_ratio", 0.45},     {"yield_stress", 100}, {"consistency", 50},
          {"flow_index", flow_index}};
}

inline Json all_around(double p) {
  return {{"xx", p}, {"yy", p}, {"zz", p}};
}

inline Json consolidation(double p) {
  return {{"name", "consolidation"}, {"stress", all_around(p)}, {"increments", 5}};
}

inline element::ElementSettings read(const Json& test) {
  ConfigReader in(test, "element.json", element::element_keys());
  return element::read_element_settings(in, nullptr);
}

/// States at the start and after each increment, until the end or, with `reason`, until the test
/// cannot be followed.
inline std::vector<ElementState> follow(const Json& test, std::string* reason = nullptr) {
  const element::ElementSettings settings = read(test);
  ElementState state = element::ElementPoint(settings).start();
  std::vector<ElementState> states = {state};
  try {
    for (const auto& stage : settings.stages) {
      element::follow_stage(
          settings, stage, state,
          [&](const ElementState& reached, const element::Effort&) { states.push_back(reached); });
    }
  } catch (const ConvergenceError& error) {
    if (reason == nullptr) throw;
    *reason = error.what();
  }
  return states;
}

}  // namespace gabion::testing
