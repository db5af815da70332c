// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double radius = 0.2, E = 1000, nu = 0.3, density = 1000, speed = 0.1;

/// A box of cells, pulled into a disk: x sqrt(1 - y^2 / 2), y sqrt(1 - x^2 / 2) on -1 .. 1.
Mesh<2> disk(const Vector<2>& centre, int cells) {
  Mesh<2> mesh = box_mesh<2>({-1, -1}, {1, 1}, {cells, cells}, CellType::quad4);
  for (auto& X : mesh.nodes) {
    const Vector<2> x(X[0] * std::sqrt(1 - 0.5 * X[1] * X[1]),
                      X[1] * std::sqrt(1 - 0.5 * X[0] * X[0]));
    X = centre + radius * x;
  }
  return mesh;
}

/// Two disks that meet in the middle of a unit square along its diagonal, `offset` aside of a
/// central collision; set-up of Sulsky, Chen, Schreyer (1994) with offset 0.
std::unique_ptr<mpm::MpmSolver<2>> two_disks(int grid_cells, double offset) {
  const double n = grid_cells;
  auto settings =
      mpm_settings<2>({{"dimension", 2},
                       {"grid", box({0, 0}, {1, 1}, {grid_cells, grid_cells}, "quad4")},
                       {"basis", "linear"},
                       {"bodies",
                        {body("first", box({0, 0}, {1, 1}, {1, 1}, "quad4"), 4,
                              elastic_soil("neo_hookean", E, nu, density), {speed, speed}),
                         body("second", box({0, 0}, {1, 1}, {1, 1}, "quad4"), 4,
                              elastic_soil("neo_hookean", E, nu, density), {-speed, -speed})}},
                       {"newton", exact_newton},
                       {"time_integration", trapezoid}});
  const int cells = static_cast<int>(std::lround(2 * radius * n));
  const Vector<2> aside(-0.5 * offset / std::sqrt(2), 0.5 * offset / std::sqrt(2));
  settings.layouts[0].mesh = disk(Vector<2>(0.3, 0.3) + aside, cells);
  settings.layouts[1].mesh = disk(Vector<2>(0.7, 0.7) - aside, cells);
  return std::make_unique<mpm::MpmSolver<2>>(comm(), std::move(settings), "");
}

struct Totals {
  Vector<2> momentum = Vector<2>::Zero();
  double angular = 0, kinetic = 0, elastic = 0;

  explicit Totals(const mpm::MaterialPoints<2>& points) {
    for (std::int32_t p = 0; p < points.size(); ++p) {
      const Vector<2>&x = points.x[p], &v = points.v[p];
      momentum += points.m[p] * v;
      angular += points.m[p] * (x[0] * v[1] - x[1] * v[0]);
      kinetic += 0.5 * points.m[p] * v.squaredNorm();
      elastic += points.V0[p] * points.energy[p];
    }
  }
};

void row(const std::string& what, double error, double bound, const std::string& limitation = "") {
  verify({.id = "V18",
          .what = what,
          .exact = 0,
          .computed = error,
          .measure = Measure::absolute_error,
          .bound = bound,
          .limitation = limitation});
}

const std::string one_grid =
    "disks of one grid meet inelastically, up to a cell before contact, and the linear basis "
    "scatters energy when points cross cells";

/// Flight, collision at about 1.4 s, flight until the given time.
void collide(const std::string& name, double end_time, double offset, double energy_bound) {
  const auto solver = two_disks(20, offset);
  const Totals start(solver->points());
  const double mass = density * M_PI * radius * radius, size = 2 * mass * speed * std::sqrt(2);
  double momentum = 0, angular = 0, stored = 0;
  std::vector<double> time, kinetic, elastic;
  constexpr int steps = 300;
  for (int n = 1; n <= steps; ++n) {
    run_steps(*solver, end_time / steps, 1, n);
    const Totals now(solver->points());
    momentum = std::max(momentum, (now.momentum - start.momentum).norm() / size);
    angular = std::max(angular, std::abs(now.angular - start.angular) / (size * radius));
    stored = std::max(stored, now.elastic / start.kinetic);
    time.push_back(end_time * n / steps);
    kinetic.push_back(now.kinetic);
    elastic.push_back(now.elastic);
  }
  const Totals end(solver->points());
  EXPECT_GT(stored, 0.3);  // they met
  VerificationCurve curve{.id = "V18",
                          .figure = "energies of colliding disks, " + name,
                          .x_label = "t [s]",
                          .y_label = "energy [J/m]",
                          .label = "kinetic",
                          .logarithmic = false};
  draw_curve(curve, time, kinetic);
  curve.label = "elastic";
  draw_curve(curve, time, elastic);
  const std::string what = "two disks, " + name + ", MPM quad4: ";
  row(what + "momentum over 2 m v", momentum, 1e-12);
  row(what + "angular momentum over 2 m v R", angular, offset == 0 ? 1e-3 : 0.05);
  row(what + "share of energy lost", 1 - (end.kinetic + end.elastic) / start.kinetic, energy_bound,
      one_grid);
}

TEST(V18_Disks, central_collision) {
  collide("central", 3, 0, 0.15);
}
TEST(V18_Disks, offset_collision) {
  collide("offset R / 2", 2.4, 0.1, 0.15);
}

}  // namespace
}  // namespace gabion::test
