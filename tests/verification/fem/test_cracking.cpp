// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/fem/concrete_bar.hpp"

namespace gabion::test {
namespace {

/// A bar of any number of cells, short enough not to snap back (L < E G_f / f_t^2 + h / 2), one of
/// them weaker by a tenth, is torn: the fracture energy times its section, and its strength.
/// Between the elastic cells the crack follows sigma = f_t exp[2 H (1 - E e / f_t)], e the strain
/// of its cell, H of (T28).
TEST(concrete_Bar, fracture_energy_on_any_mesh) {
  constexpr double L = 0.25, height = 0.1, E = 30e9, f_t = 2.7e6, G_f = 100;
  for (const int cells : {5, 10, 20}) {
    const TemporaryMesh mesh(strip(L, height, cells));
    Json json = pulled_strip(mesh.path(), cells, 6e-4);
    const double h = L / cells, H = h / (2 * E * G_f / (f_t * f_t) - h);
    const auto solver = fem_solver<2>(json);
    constexpr int steps = 480;
    double peak = 0;
    for (int n = 1; n <= steps; ++n) {
      advance(*solver, n, 1.0 / steps);
      const double force = -probe(*solver, "reaction_left_x");
      peak = std::max(peak, force);
      if (n != steps / 6) continue;
      // Elongation 1e-4 m: strain e of the weak cell from e h + sigma(e) / E (L - h).
      double low = f_t / E, high = 1e-4 / h;
      // Stress and strain are logarithmic: the force per section is sigma exp(-e).
      const auto force_at = [&](double e) {
        return f_t * std::exp(2 * H * (1 - E * e / f_t)) * std::exp(-e);
      };
      for (int k = 0; k < 100; ++k) {
        const double e = 0.5 * (low + high);
        (std::expm1(e) * h + force_at(e) / E * (L - h) < 1e-4 ? low : high) = e;
      }
      verify({.id = "concrete",
              .what = fmt::format("bar of {} cells: force while it is torn", cells),
              .exact = force_at(low) * height,
              .computed = force,
              .bound = 1e-5,
              .unit = "N"});
    }
    verify({.id = "concrete",
            .what = fmt::format("bar of {} cells: energy taken", cells),
            .exact = G_f * height,
            .computed = probe(*solver, "damage_work"),
            .bound = 1e-5,
            .unit = "J"});
    EXPECT_NEAR(peak, f_t * height, 0.02 * f_t * height);
  }
}

}  // namespace
}  // namespace gabion::test
