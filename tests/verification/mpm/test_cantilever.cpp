// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/verification/elastica.hpp"

namespace gabion::test {
namespace {

constexpr double E = 12e6, nu = 0.2, length = 10, thickness = 1;

/// A horizontal cantilever of material points in plane strain, fixed at x = 0, quasi-static. The
/// end load acts on the points of the last cells, as a body force that grows in `steps` equal
/// parts.
struct Tip {
  double down = 0, inward = 0;  ///< mean of the loaded points [m]
};

Tip bend(double alpha, int cells_across, int steps, const std::string& basis) {
  const double h = thickness / cells_across;
  const int along = static_cast<int>(std::lround(length / h));
  const int below = static_cast<int>(std::ceil(0.9 * length / h));
  Json json = {{"dimension", 2},
               {"analysis", "quasi_static"},
               {"grid", box({0, -below * h}, {length + h, thickness + h},
                            {along + 1, below + cells_across + 1}, "quad4")},
               {"basis", "linear"},
               {"walls", {wall("left", "fixed")}},
               {"bodies",
                {body("beam", box({0, 0}, {length, thickness}, {along, cells_across}, "quad4"), 4,
                      elastic_soil("hencky_elastic", E, nu, 1))}},
               {"newton", {{"residual_tolerance", 1e-8}, {"max_iterations", 40}}}};
  if (basis != "linear") json["basis"] = basis;
  auto settings = mpm_settings<2>(json);
  const double inertia = std::pow(thickness, 3) / 12;
  const double force = alpha * E / (1 - nu * nu) * inertia / (length * length);
  const double end_mass = h * thickness;  // density 1
  settings.body_acceleration = [=](const Vector<2>& X, double time) {
    return Vector<2>(0, X[0] > length - h ? -force / end_mass * time : 0);
  };
  mpm::MpmSolver<2> solver(comm(), std::move(settings), "");
  run_steps(solver, 1.0 / steps, steps);
  Tip tip;
  int count = 0;
  for (std::int32_t p = 0; p < solver.points().size(); ++p) {
    const Vector<2>&u = solver.points().u[p], X = solver.points().x[p] - u;
    if (X[0] < length - h) continue;
    tip.down -= u[1];
    tip.inward -= u[0];
    ++count;
  }
  return {tip.down / count, tip.inward / count};
}

/// Deflection by that of the elastica whose end is the middle of the loaded cells.
double deflection_ratio(double alpha, int cells_across, int steps, const std::string& basis) {
  const double reach = 1 - 0.5 * thickness / cells_across / length;  // by L
  const Elastica exact(alpha * reach * reach);
  return bend(alpha, cells_across, steps, basis).down / (exact.deflection * reach * length);
}

/// Hardly bent: four points a cell are as stiff as the full integration of finite elements; three
/// grids and their limit.
TEST(V6_Cantilever, small_load) {
  const double alpha = 0.01;
  const double coarse = deflection_ratio(alpha, 2, 1, "linear");
  const double middle = deflection_ratio(alpha, 4, 1, "linear");
  const double fine = deflection_ratio(alpha, 8, 1, "linear");
  verify({.id = "V6",
          .what = "cantilever, alpha = 0.01, MPM linear: order of the deflection in h",
          .exact = 2,
          .computed = std::log2((middle - coarse) / (fine - middle)),
          .measure = Measure::order,
          .bound = 1.8});
  verify({.id = "V6",
          .what = "cantilever, alpha = 0.01, MPM linear: deflection over the elastica's, h to 0",
          .exact = 1,
          .computed = fine + (fine - middle) / 3,
          .bound = 0.015});  // the shear deformation is 0.6 (1 + nu) (thickness / length)^2
}

TEST(V6_Cantilever, large_load) {
  verify({.id = "V6",
          .what = "cantilever, alpha = 1, 4 cells across, MPM linear: deflection over the "
                  "elastica's",
          .exact = 1,
          .computed = deflection_ratio(1, 4, 10, "linear"),
          .bound = 0.08,
          .limitation = "larger loads or smaller steps lead to points that just entered a cell "
                        "with the linear basis, and Newton's method finds no equilibrium"});
}

}  // namespace
}  // namespace gabion::test
