// SPDX-License-Identifier: BSD-3-Clause
// The model alone, without a coupler.
#include <cmath>
#include <cstdio>

#include "model.hpp"

namespace {

const std::vector<double> points = model::surface().points;

/// 2 N on each point along x.
std::vector<double> load() {
  std::vector<double> force(points.size());
  for (std::size_t i = 0; i < force.size(); i += model::dimension) force[i] = 2;
  return force;
}

/// k u = F
double at_rest() {
  return 2.0 * static_cast<double>(points.size()) / model::dimension / model::stiffness;
}

/// Error after 0.1 s of a sudden load, against the closed form of the damped oscillator.
double error_with(int steps) {
  const double end = 0.1, decay = model::damping / (2 * model::mass);
  const double omega = std::sqrt(model::stiffness / model::mass - decay * decay);
  const double swing = std::cos(omega * end) + decay / omega * std::sin(omega * end);
  model::State state;
  for (int n = 0; n < steps; ++n) state = model::step(state, end / steps, load());
  return std::abs(state.u[0] - at_rest() * (1 - std::exp(-decay * end) * swing));
}

int failures = 0;

void expect_near(const char* what, double found, double expected, double tolerance) {
  if (std::abs(found - expected) <= tolerance) return;
  std::printf("%s: found %.9g, expected %.9g within %g\n", what, found, expected, tolerance);
  ++failures;
}

}  // namespace

int main() {
  const model::State state = model::step({}, 1e9, load());
  expect_near("rest", state.u[0] / at_rest(), 1, 1e-9);
  expect_near("rest across", state.u[1], 0, 0);
  // Implicit Euler is of first order: half the step, half the error.
  expect_near("order", std::log2(error_with(2000) / error_with(4000)), 1, 0.05);
  return failures;
}
