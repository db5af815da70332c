// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/mechanics/tensor_functions.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

/// A column of sand that yields at constant volume falls against a wall and comes to rest there.
/// However it moved, its volume is then what the pressure makes of it, point by point,
///
///     ln J = tr(tau) / (3 K) ,
///
/// with no volume left open, but at the free surface. Neighbours bear the pressure together: within
/// a cell it differs by rho g h and what shear adds, much less than the pressure itself.
struct FallenColumn {
  double length = 0.2, height = 0.1, wall = 0.25, cell = 0.01;
  double E = 840e3, nu = 0.3;

  double bulk_modulus() const { return E / (3 * (1 - 2 * nu)); }
  /// Whether x lies in the heap before the wall, well below its surface.
  bool inside(const Vector<2>& x) const { return x[0] > 0.15 && x[1] < 0.03; }
};

Json fallen_column_scene(const FallenColumn& column, const std::string& type,
                         const std::string& basis, int points_per_cell) {
  const auto cells = [&](double size) { return static_cast<int>(std::lround(size / column.cell)); };
  Json sand = elastic_soil("mohr_coulomb", column.E, column.nu, 2650);
  sand["friction_angle"] = 19.8;
  sand["dilation_angle"] = 0;
  const double top = 3 * column.height;
  return {{"dimension", 2},
          {"basis", basis},
          {"gravity", {0, -9.81}},
          {"grid", box({0, 0}, {column.wall, top}, {cells(column.wall), cells(top)}, type)},
          {"walls", {wall("left", "fixed"), wall("bottom", "fixed"), wall("right", "slip")}},
          {"time_integration", {{"scheme", "bossak"}, {"alpha", -0.3}}},
          {"bodies",
           {body("soil",
                 box({0, 0}, {column.length, column.height},
                     {cells(column.length), cells(column.height)}, type),
                 points_per_cell, sand)}},
          {"transfer", {{"noise_damping", 0}}},  // shaken down: nothing arches over open cells
          {"locking", {{"method", "fbar"}}}};
}

struct AtRest {
  double open = 0;        ///< mean of ln J - tr(tau) / (3 K) inside
  double difference = 0;  ///< root mean square of (p - mean p of the cell), by the mean of p
};

AtRest at_rest(const FallenColumn& column, const mpm::MaterialPoints<2>& points) {
  struct Sum {
    int n = 0;
    double p = 0, p2 = 0;
  };
  std::vector<Sum> cells(1 + *std::max_element(points.cell.begin(), points.cell.end()));
  AtRest result;
  int inside = 0;
  double pressure = 0, squares = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    if (!column.inside(points.x[p])) continue;
    const double mean = -trace<2>(points.tau[p]) / 3;
    result.open += std::log(points.J[p]) + mean / column.bulk_modulus();
    pressure += mean;
    ++inside;
    Sum& cell = cells[points.cell[p]];
    ++cell.n;
    cell.p += mean;
    cell.p2 += mean * mean;
  }
  for (const Sum& cell : cells) {
    if (cell.n > 0) squares += cell.p2 - cell.p * cell.p / cell.n;
  }
  result.open /= inside;
  result.difference = std::sqrt(std::max(squares, 0.0) * inside) / pressure;
  return result;
}

void check_volume_at_rest(const std::string& type, const std::string& basis,
                          int points_per_cell = 4) {
  const FallenColumn column;
  const auto solver = mpm_solver<2>(fallen_column_scene(column, type, basis, points_per_cell));
  run_steps(*solver, 5e-4, 700);
  const AtRest rest = at_rest(column, solver->points());
  std::string which = ", MPM " + type + " " + basis;
  if (points_per_cell != 4) which += fmt::format(", {} points a cell", points_per_cell);
  verify({.id = "V21",
          .what = "volume open in a fallen column" + which,
          .exact = 0,
          .computed = rest.open,
          .measure = Measure::absolute_error,
          .bound = 1e-4});
  verify({.id = "V21",
          .what = "pressure within cells of a fallen column, deviation from their mean" + which,
          .exact = 0,
          .computed = rest.difference,
          .measure = Measure::absolute_error,
          .bound = 0.2});
  verify(
      {.id = "V21",
       .what = "error of the energy balance of a fallen column, over the work of gravity" + which,
       .exact = 0,
       .computed = probe(*solver, "energy_balance") / probe(*solver, "gravity_work"),
       .measure = Measure::absolute_error,
       .bound = 1e-3});
}

/// Pressure that alternates from cell to cell acts on splines half as much as on linear functions
/// (docs/theory/soil.md). With 4 points a cell some at the floor have 2, and open.
TEST(V21_VolumeAtRest, of_a_column_that_fell_against_a_wall) {
  check_volume_at_rest("quad4", "linear");
  check_volume_at_rest("quad4", "gimp");
  check_volume_at_rest("quad4", "bspline", 16);
}

/// Without noise sand may arch over a cell: of 36 cells inside some thousandths of one stay open.
TEST(V21_VolumeAtRest, with_the_noise_damped) {
  const FallenColumn column;
  Json scene = fallen_column_scene(column, "quad4", "gimp", 4);
  scene.erase("transfer");
  const auto solver = mpm_solver<2>(scene);
  run_steps(*solver, 5e-4, 700);
  verify({.id = "V21",
          .what = "volume open in a fallen column, noise damped, MPM quad4 gimp",
          .exact = 0,
          .computed = at_rest(column, solver->points()).open,
          .measure = Measure::absolute_error,
          .bound = 0.01 / 36});
}

}  // namespace
}  // namespace gabion::test
