// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/run/solver.hpp"

namespace gabion::test {

/// A rigid block on a spring, m y'' = P - P_0 - k y, by the trapezoidal rule: the structure that
/// soil pushes on.
struct SpringBlock {
  double m = 0, k = 0;  ///< [kg], [N/m]
  double P_0 = 0;       ///< load at which it rests at y = 0 [N]
  double y = 0, v = 0, a = 0;

  double place(double P, double dt) const {
    return (y + dt * v + dt * dt / 4 * (a + (P - P_0) / m)) / (1 + dt * dt * k / (4 * m));
  }
  void move(double P, double dt) {
    y = place(P, dt);
    const double a_end = (P - P_0 - k * y) / m;
    v += dt / 2 * (a + a_end);
    a = a_end;
  }
};

/// One step of soil and block that agree at its end, by the secant rule.
/// @param face  interface, which moves along x as the block does
/// @param area  of the block by that of the interface
/// @returns the load on the block [N]
inline double step_with(Solver& soil, SpringBlock& block, const std::string& face, int step,
                        double dt, double area) {
  const std::size_t vertices = static_cast<std::size_t>(soil.interfaces()[0].num_vertices());
  StepRequest request{step, 0, (step - 1) * dt, dt};
  const auto load = [&](double y) {
    InterfaceValues received, sent;
    for (std::size_t i = 0; i < vertices; ++i) {
      received[face].push_back(y);
      received[face].push_back(0);
    }
    soil.solve_step(request, received, sent);
    ++request.iteration;
    double P = 0;
    for (std::size_t i = 0; i < vertices; ++i) P += sent.at(face)[2 * i];
    return area * P;
  };
  double before = block.y + dt * block.v + dt * dt / 2 * block.a;
  double P = load(before), off_before = block.place(P, dt) - before;
  double now = before + off_before / 2;
  const double size = dt * std::abs(block.v) + std::abs(off_before);
  for (int i = 0; i < 40 && std::abs(off_before) > 1e-6 * size; ++i) {
    P = load(now);
    const double off = block.place(P, dt) - now;
    if (std::abs(off) <= 1e-6 * size || off == off_before) break;
    const double next = now - off * (now - before) / (off - off_before);
    before = now, off_before = off, now = next;
  }
  EXPECT_LT(std::abs(block.place(P, dt) - (request.iteration > 1 ? now : before)), 1e-3 * size);
  soil.accept_step(request, true);
  block.move(P, dt);
  return P;
}

}  // namespace gabion::test
