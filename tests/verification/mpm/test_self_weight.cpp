// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/convergence_rate.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

/// Column under its own weight between smooth walls, Hencky elasticity with nu = 0, q = rho g L /
/// M:
///
///     ln(lambda) / lambda = -rho g (L - Z) / M ,   sigma_v = -rho g (L - Z) ,
///     z(Z) = (M / rho g) [G(w(0)) - G(w(Z))] ,  G(w) = w + w^2 / 2 ,  w e^w = rho g (L - Z) / M
struct Column {
  double L = 1, M = 1e6, density = 1000, g = 10;

  static double lambert(double q) {
    double w = q;
    for (int k = 0; k < 50; ++k) w -= (w * std::exp(w) - q) / (std::exp(w) * (1 + w));
    return w;
  }
  double height_of(double Z) const {
    const auto G = [](double w) { return w + 0.5 * w * w; };
    return M / (density * g) * (G(load(0)) - G(load(Z)));
  }
  double load(double Z) const { return lambert(density * g * (L - Z) / M); }
  double stress(double Z) const { return -density * g * (L - Z); }
};

struct ColumnErrors {
  double settlement;   ///< of the uppermost points, relative to the closed form
  double base_stress;  ///< mean of the lowest cell, relative to its value at the middle of the cell
  double stress;       ///< largest error of any point, relative to rho g L
};

/// Static limit: steps so long that inertia vanishes, with the damping of alpha_B = -0.3.
template <int dim>
ColumnErrors settle(const std::string& type, int cells, const Column& column) {
  const double h = column.L / cells;
  std::vector<double> low(dim, 0.0), high(dim, h), grid_high(dim, h), gravity(dim, 0.0);
  std::vector<int> count(dim, 1), grid_count(dim, 1);
  high[dim - 1] = column.L;
  count[dim - 1] = cells;
  grid_high[dim - 1] = column.L + h;
  grid_count[dim - 1] = cells + 1;
  gravity[dim - 1] = -column.g;
  const int points_per_cell = type == "hex8" ? 8 : type == "tri3" ? 3 : 4;
  Json walls = {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")};
  if (dim == 3) {
    walls.push_back(wall("front", "slip"));
    walls.push_back(wall("back", "slip"));
  }
  const Json json = {{"dimension", dim},
                     {"grid", box(low, grid_high, grid_count, type)},
                     {"basis", "linear"},
                     {"walls", walls},
                     {"gravity", gravity},
                     {"bodies",
                      {body("soil", box(low, high, count, type), points_per_cell,
                            elastic_soil("hencky_elastic", column.M, 0, column.density))}},
                     {"time_integration", {{"scheme", "bossak"}, {"alpha", -0.3}}},
                     {"newton", {{"residual_tolerance", 1e-10}}}};
  const auto solver = mpm_solver<dim>(json);
  const auto start = solver->points();
  run_steps(*solver, 1e4, 40);

  const auto& points = solver->points();
  ColumnErrors errors{0, 0, 0};
  double base_stress = 0, base_volume = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double Z = start.x[p][dim - 1];
    const double exact = column.height_of(Z) - Z;
    const double sigma = points.tau[p][dim - 1] / points.J[p];
    errors.stress = std::max(errors.stress, std::abs(sigma - column.stress(Z)));
    if (Z > column.L - h) {
      errors.settlement =
          std::max(errors.settlement, std::abs(points.u[p][dim - 1] - exact) / std::abs(exact));
    }
    if (Z < h) {
      base_stress += points.V0[p] * sigma;
      base_volume += points.V0[p];
    }
    for (int d = 0; d + 1 < dim; ++d) EXPECT_LT(std::abs(points.u[p][d]), 1e-12);
  }
  errors.base_stress = std::abs(base_stress / base_volume / column.stress(h / 2) - 1);
  errors.stress /= column.density * column.g * column.L;
  return errors;
}

/// Without points that cross cells, V0 tau grad N sees the volume of the undeformed cell: the
/// stress error is the strain q, the settlement error q and a part that falls with h^2.
template <int dim>
void check_columns(const std::vector<std::string>& types) {
  const Column settled{.g = 10}, hardly_strained{.g = 0.1};  // q = 1e-2 and 1e-4
  for (const std::string& type : types) {
    const ColumnErrors coarse = settle<dim>(type, 8, settled);
    const auto row = [&](const std::string& what, double error, double bound) {
      verify({.id = "V2",
              .what = what + ", 8 cells, MPM " + type,
              .exact = 0,
              .computed = error,
              .measure = Measure::absolute_error,
              .bound = bound});
    };
    row("relative error of settlement at 1 % strain", coarse.settlement, 0.012);
    row("relative error of base stress at 1 % strain", coarse.base_stress, 0.01);
    // one value a cell: 0.29 h / L and a lumped end
    row("largest stress error over rho g L at 1 % strain", coarse.stress, 0.055);
    std::vector<double> sizes, errors;
    for (const int cells : {4, 8, 16}) {
      const ColumnErrors fine = settle<dim>(type, cells, hardly_strained);
      EXPECT_LT(fine.base_stress, 1.2e-4) << type;
      sizes.push_back(1.0 / cells);
      errors.push_back(fine.settlement);
    }
    EXPECT_LT(errors.back(), 1.5e-3) << type;
    verify({.id = "V2",
            .what = "order of settlement in h at 0.01 % strain, MPM " + type,
            .exact = 2,
            .computed = last_rate(sizes, errors),
            .measure = Measure::order,
            .bound = 1.7});
  }
}

TEST(V2_SelfWeight, column_in_plane_strain) {
  check_columns<2>({"quad4", "tri3"});
}

TEST(V2_SelfWeight, column_in_3d) {
  check_columns<3>({"hex8", "tet4"});
}

/// V2: 50 m of soft soil, gravity in 20 quasi-static steps. The error of the settlement is that of
/// the volumes, the strain q, as in the columns above.
TEST(V2_SelfWeight, quasi_static_column_in_twenty_load_steps) {
  const int cells = 25;
  const Column column{.L = 50, .M = 1e6, .density = 80, .g = 10};
  Json json = {{"dimension", 2},
               {"analysis", "quasi_static"},
               {"grid", box({0, 0}, {2, 52}, {1, cells + 1}, "quad4")},
               {"basis", "linear"},
               {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
               {"gravity", {0, -column.g}},
               {"gravity_ramp", {{"duration", 20.0}}},
               {"bodies",
                {body("soil", box({0, 0}, {2, 50}, {1, cells}, "quad4"), 4,
                      elastic_soil("hencky_elastic", column.M, 0, column.density))}},
               {"newton", exact_newton}};
  const auto solver = mpm_solver<2>(json);
  const auto start = solver->points();
  run_steps(*solver, 1, 20);
  EXPECT_NEAR(column.height_of(column.L), 49.037991, 1e-6);
  const auto& points = solver->points();
  double error = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double Z = start.x[p][1];
    error = std::max(error, std::abs(points.x[p][1] - column.height_of(Z)));
  }
  const double q = column.density * column.g * column.L / column.M;
  verify({.id = "V2",
          .what = "50 m column in 20 quasi-static steps, MPM quad4: largest error of position over "
                  "L",
          .exact = 0,
          .computed = error / column.L,
          .measure = Measure::absolute_error,
          .bound = q * (1 - 49.037991 / column.L)});
  EXPECT_NEAR(probe(*solver, "wall.bottom.fy"), -2 * 40e3, 1e-6 * 80e3);
}

}  // namespace
}  // namespace gabion::test
