// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/convergence_rate.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

/// Column under its own weight between smooth walls, Hencky elasticity with nu = 0, M = E:
///
///     sigma_v = -rho g (L - Z) ,   z(Z) = (E / rho g) [G(w(0)) - G(w(Z))] ,  G(w) = w + w^2 / 2 ,
///     w e^w = rho g (L - Z) / E
struct Column {
  double L, E, density, g;
  int steps;  ///< of the ramp of g

  double load(double Z) const {
    const double q = density * g * (L - Z) / E;
    double w = q;
    for (int k = 0; k < 50; ++k) w -= (w * std::exp(w) - q) / (std::exp(w) * (1 + w));
    return w;
  }
  double height_of(double Z) const {
    const auto G = [](double w) { return w + 0.5 * w * w; };
    return E / (density * g) * (G(load(0)) - G(load(Z)));
  }
  double stress(double Z) const { return -density * g * (L - Z); }
};

/// AMPLE's set, settlement 2 %; and one that is squeezed to half its height at the base.
const Column ample{50, 1e6, 80, 10, 20};
const Column severe{0.8, 392.4 / (2 * std::log(2.0)), 50, 9.81, 40};

struct Settled {
  double stress;  ///< mean of |sigma_v - exact|, by rho g L
  double height;  ///< largest |z - exact| of a point, by L
  int crossings;  ///< points that left the cell in which they started
  int newton;     ///< iterations
};

/// The column of one cell by `cells`, four points a cell, gravity raised in equal steps.
Settled settle(const std::string& basis, int cells, const Column& column, int points_per_cell = 4) {
  const double h = column.L / cells;
  const Json json = {
      {"dimension", 2},
      {"analysis", "quasi_static"},
      {"basis", basis},
      {"grid", box({0, 0}, {h, column.L + h}, {1, cells + 1}, "quad4")},
      {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
      {"bodies",
       {{{"name", "soil"},
         {"mesh", box({0, 0}, {h, column.L}, {1, cells}, "quad4")},
         {"points_per_cell", points_per_cell},
         {"point_placement", "regular"},
         {"material", elastic_soil("hencky_elastic", column.E, 0, column.density)}}}},
      {"newton", {{"residual_tolerance", 1e-9}, {"increment_tolerance", 1e-6}}}};
  const TemporaryScene folder("mpm.json", json);
  const Scene scene(folder.path(), {});
  ConfigReader in = scene.reader("mpm.json");
  in.integer("dimension");
  auto settings = mpm::read_mpm_settings<2>(scene, in, nullptr);
  settings.body_acceleration = [&](const Vector<2>&, double time) {
    return Vector<2>(0, -column.g * time / column.steps);
  };
  mpm::MpmSolver<2> solver(comm(), std::move(settings), "");
  const auto start = solver.points();
  run_steps(solver, 1, column.steps);

  const auto& points = solver.points();
  Settled result{0, 0, 0, solver.summary()["newton_iterations"]};
  double volume = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double Z = start.x[p][1];
    const double sigma = points.tau[p][1] / points.J[p];
    result.stress += points.V0[p] * std::abs(sigma - column.stress(Z));
    result.height =
        std::max(result.height, std::abs(points.x[p][1] - column.height_of(Z)) / column.L);
    result.crossings += points.cell[p] != start.cell[p];
    volume += points.V0[p];
    EXPECT_LT(std::abs(points.u[p][0]), 1e-12 * column.L);
  }
  result.stress /= volume * column.density * column.g * column.L;
  return result;
}

constexpr const char* id = "V2";

void error_row(const std::string& what, double error, double bound,
               const std::string& limitation = "") {
  verify({.id = id,
          .what = what,
          .exact = 0,
          .computed = error,
          .measure = Measure::absolute_error,
          .bound = bound,
          .limitation = limitation});
}

void order_row(const std::string& what, double exact, double order, double bound) {
  verify({.id = id,
          .what = what,
          .exact = exact,
          .computed = order,
          .measure = Measure::order,
          .bound = bound});
}

struct Study {
  std::vector<double> sizes, stress, height;
  int crossings = 0;  ///< on the finest grid

  Study(const std::string& basis, const std::vector<int>& levels, const Column& column,
        const std::string& set) {
    for (const int cells : levels) {
      const Settled found = settle(basis, cells, column);
      sizes.push_back(column.L / cells);
      stress.push_back(found.stress);
      height.push_back(found.height);
      crossings = found.crossings;
    }
    VerificationCurve curve{.id = id,
                            .figure = "stress of a column under its weight, " + set,
                            .x_label = "cell size [m]",
                            .y_label = "mean stress error by rho g L",
                            .label = basis};
    draw_curve(curve, sizes, stress);
  }
  double order(const std::vector<double>& errors, std::size_t from, std::size_t to) const {
    return std::log(errors[from] / errors[to]) / std::log(sizes[from] / sizes[to]);
  }
};

const std::string jumps = "gradients of the linear basis jump where points cross cells";
const std::string quadrature =
    "points at single places integrate splines with an error that depends on the strain, hardly on "
    "the points per cell and not on h";

/// No point crosses on 4 and 8 cells, all but the lowest do on the finest grid.
TEST(V2_CrossingColumn, two_percent) {
  const std::vector<int> levels = {4, 8, 16, 32, 64, 128};
  const std::string set = "E 1 MPa, 50 m";
  const Study linear("linear", levels, ample, set), gimp("gimp", levels, ample, set),
      bspline("bspline", levels, ample, set);
  EXPECT_GT(gimp.crossings, 0.8 * 4 * levels.back());
  order_row("order of heights in h, 4 to 32 cells, MPM gimp", 2, gimp.order(gimp.height, 0, 3),
            1.9);
  order_row("order of heights in h, 32 to 128 cells, MPM gimp", 1, gimp.order(gimp.height, 3, 5),
            1.5);
  order_row("order of stress in h, 8 to 32 cells, MPM gimp", 2, gimp.order(gimp.stress, 1, 3), 1.6);
  order_row("order of stress in h, 32 to 128 cells, MPM gimp", 1, gimp.order(gimp.stress, 3, 5),
            1.4);
  order_row("order of stress in h, 4 to 32 cells, MPM bspline", 2,
            bspline.order(bspline.stress, 0, 3), 1.4);
  error_row("mean stress error by rho g L, 128 cells, MPM gimp", gimp.stress.back(), 3e-4);
  error_row("mean stress error by rho g L, 128 cells, MPM bspline", bspline.stress.back(), 1e-3,
            quadrature);
  error_row("mean stress error by rho g L, 128 cells, MPM quad4", linear.stress.back(), 0.04,
            jumps);
  EXPECT_LT(linear.order(linear.stress, 2, 5), 0);  // it stalls: the reason for the other bases
}

TEST(V2_CrossingColumn, half_its_height) {
  const std::vector<int> levels = {8, 16, 32, 64};
  const std::string set = "base squeezed to a half";
  const Study linear("linear", levels, severe, set), gimp("gimp", levels, severe, set),
      bspline("bspline", levels, severe, set);
  // By hand: w = ln 2 at the base, so the height is L / (2 ln 2) (1 + ln 2 / 2) ...
  const double ln2 = std::log(2.0);
  EXPECT_NEAR(severe.height_of(severe.L), severe.L * (1 + ln2 / 2) / 2, 1e-12);
  order_row("order of stress in h at 50 %, 8 to 64 cells, MPM gimp", 1,
            gimp.order(gimp.stress, 0, 3), 1.4);
  order_row("order of heights in h at 50 %, 16 to 64 cells, MPM gimp", 1,
            gimp.order(gimp.height, 1, 3), 1.6);
  error_row("largest error of height by L at 50 %, 64 cells, MPM gimp", gimp.height.back(), 1e-4);
  error_row("mean stress error by rho g L at 50 %, 64 cells, MPM gimp", gimp.stress.back(), 5e-4);
  error_row("mean stress error by rho g L at 50 %, 64 cells, MPM bspline", bspline.stress.back(),
            8e-3, quadrature);
  error_row("mean stress error by rho g L at 50 %, 64 cells, MPM quad4", linear.stress.back(), 0.12,
            jumps);
}

}  // namespace
}  // namespace gabion::test
