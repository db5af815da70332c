// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

/// V17: a cylinder between two smooth rigid planes; a quarter of it, with the plane by facets.
///
///     b^2 = 4 F R / (pi E*) ,  p(x) = p0 sqrt(1 - (x / b)^2) ,  p0 = 2 F / (pi b)
///
/// E* = E / (1 - nu^2). The pressure is that of the facets in the contact frames; p0 and b come
/// from a straight line through p^2 over x^2, where x < 0.8 b.
constexpr double R = 1, E = 2e8, nu = 0.3, E_star = E / (1 - nu * nu);

/// A quarter of a disc below y = 0, of cells that are square at the contact.
Mesh<2> quarter(int cells) {
  const int wide = static_cast<int>(cells / std::sqrt(2.0));
  Mesh<2> mesh = box_mesh<2>({0, -1}, {1, 0}, {wide, cells}, CellType::quad4);
  for (auto& X : mesh.nodes) {
    X = R *
        Vector<2>(X[0] * std::sqrt(1 - 0.5 * X[1] * X[1]), X[1] * std::sqrt(1 - 0.5 * X[0] * X[0]));
  }
  return mesh;
}

/// @param cells  of the grid and of the body, along the radius
std::unique_ptr<mpm::MpmSolver<2>> pressed(int cells, double approach) {
  const double h = R / cells;
  const int grid = cells + 4;
  auto settings =
      mpm_settings<2>({{"dimension", 2},
                       {"grid", box({0, -grid * h}, {grid * h, 0}, {grid, grid}, "quad4")},
                       {"basis", "linear"},
                       {"analysis", "quasi_static"},
                       {"walls", {wall("left", "slip"), wall("top", "slip")}},
                       {"bodies",
                        {body("cylinder", box({0, -h}, {h, 0}, {1, 1}, "quad4"), 4,
                              elastic_soil("linear_elastic", E, nu, 1000))}},
                       {"rigid_walls",
                        {{{"name", "plane"},
                          {"surface", {{"polyline", {{R, -R}, {0, -R}}}, {"spacing", h}}},
                          {"mode", "slip"},
                          {"motion", {{"velocity", {0, approach}}}}}}}});
  settings.layouts[0].mesh = quarter(cells);
  return std::make_unique<mpm::MpmSolver<2>>(comm(), std::move(settings), "");
}

struct Found {
  double p0, b;  ///< over those of Hertz
};

/// The straight line p^2 = p0^2 - (p0 / b)^2 x^2 of least squares.
Found press(int cells) {
  constexpr int steps = 10;
  const auto solver = pressed(cells, 0.03 * R);
  run_steps(*solver, 1.0 / steps, steps);
  const double F = -2 * probe(*solver, "plane.fy");
  const double b = std::sqrt(4 * F * R / (M_PI * E_star)), p0 = 2 * F / (M_PI * b);
  const auto fields = solver->surfaces().fields(0, solver->points(), 0);
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  Vector<2> right = Vector<2>::Zero();
  for (std::size_t k = 0; k < fields.force.size(); ++k) {
    const Vector<2>&from = fields.vertices[k], &to = fields.vertices[k + 1];
    const double x = 0.5 * (from + to)[0] / b;
    if (x > 0.8) continue;
    const double p = -fields.force[k][1] / (to - from).norm() / p0;
    const Vector<2> row(1, -x * x);
    squares += row * row.transpose();
    right += row * p * p;
  }
  const Vector<2> line = squares.inverse() * right;
  return {std::sqrt(line[0]), std::sqrt(line[0] / line[1])};
}

TEST(V17_Hertz, cylinder_between_planes) {
  double before = 1;
  for (const auto& [cells, bound] :
       {std::pair(20, 0.103), std::pair(40, 0.05), std::pair(80, 0.05)}) {
    const Found found = press(cells);
    const std::string what =
        fmt::format("cylinder on a plane by facets, {} cells a radius: ", cells);
    verify({.id = "V17",
            .what = what + "p0 over that of Hertz",
            .exact = 1,
            .computed = found.p0,
            .bound = bound,
            .limitation = bound > 0.05
                              ? "half the width of the contact is 2.7 cells, of which the "
                                "penetration takes a part: 4.7 % with a penalty ten times as stiff"
                              : ""});
    EXPECT_LT(std::abs(found.p0 - 1), 0.7 * before) << cells;
    before = std::abs(found.p0 - 1);
    if (cells < 40) continue;
    verify({.id = "V17",
            .what = what + "b over that of Hertz",
            .exact = 1,
            .computed = found.b,
            .bound = 0.05});
  }
}

}  // namespace
}  // namespace gabion::test
