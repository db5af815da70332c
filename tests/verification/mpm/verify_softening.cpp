// SPDX-License-Identifier: BSD-3-Clause
// Soil that softens: the work of a slip surface and the load of a footing on several grids; clay
// that is remoulded and runs out.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/verification/mpm/turned_layer.hpp"

namespace gabion::test {
namespace {

constexpr double peak = 40e3, residual = 2e3, softening_slip = 0.1, G = 3e6;  // [Pa], [Pa], [m]

/// A layer of 0.4 m between two rough plates of which the upper one moves.
Json sheared_layer(double length, double h, double speed) {
  const auto number = [h](double size) { return static_cast<int>(std::lround(size / h)); };
  const double height = 0.4, room = 0.6;
  Json clay = elastic_soil("tresca", 2 * G * 1.45, 0.45, 2000);
  clay["cohesion"] = peak;
  clay["softening"] = {{"slip", softening_slip}, {"residual_cohesion", residual}};
  Json top = wall("top", "fixed");
  top["motion"] = {{"velocity", {speed, 0}}};
  return {{"dimension", 2},
          {"analysis", "quasi_static"},
          {"basis", "linear"},
          {"grid", box({0, 0}, {length + 2 * room, height},
                       {number(length + 2 * room), number(height)}, "quad4")},
          {"walls", {wall("bottom", "fixed"), top}},
          {"bodies",
           {body("soil",
                 box({room, 0}, {room + length, height}, {number(length), number(height)}, "quad4"),
                 4, clay)}}};
}

/// Work of the plate until it has slipped by 0.5 m [J/m].
double work_of_slip(double length, double h) {
  const double end = 0.5 + 0.4 * residual / G, dt = 2e-3;
  const int steps = static_cast<int>(std::lround(1 / dt));
  const auto solver = make_mpm(sheared_layer(length, h, end));
  double work = 0, before = 0;
  for (int n = 1; n <= steps; ++n) {
    run_steps(*solver, dt, 1, n);
    const double force = std::abs(probe(*solver, "wall.top.fx"));
    work += 0.5 * (before + force) * end * dt;
    before = force;
  }
  return work;
}

/// The work of a slip surface by its area is c_r d + (c_p - c_r) d_c (1 - exp(-d / d_c)), 4.774396
/// kJ/m^2, whatever the cells. Two lengths of the layer leave out its ends.
TEST(VA2_SlipSurface, does_the_same_work_in_all_cells) {
  const double d = 0.5;
  const double exact =
      residual * d + (peak - residual) * softening_slip * (1 - std::exp(-d / softening_slip));
  for (const double h : {0.2, 0.1, 0.05}) {
    verify({.id = "VA2",
            .what = fmt::format("work over area of a slip of 0.5 m, Tresca that softens, linear, "
                                "cells of {} m, layers of 4 and 2 m",
                                h),
            .exact = exact,
            .computed = (work_of_slip(4, h) - work_of_slip(2, h)) / 2,
            .bound = 0.03,
            .unit = "J/m^2"});
  }
}

/// Half of a rough rigid footing of width 2 m that settles on weightless clay, 2 m deep.
struct Footing {
  double slip;        ///< of the softening [m]; 0: none
  double settlement;  ///< beyond that of the largest load [m]
};

/// Largest load of a footing over its area [Pa]. @param cells  under half of the footing
double largest_load(const Footing& footing, int cells) {
  const double E = 4e8, width = 4, depth = 2, h = 1.0 / cells;
  const int steps = 40, nx = 4 * cells, ny = 2 * cells;
  Json clay = elastic_soil("tresca", E, 0.49, 1000);
  clay["cohesion"] = peak;
  if (footing.slip > 0) {
    clay["softening"] = {{"slip", footing.slip}, {"residual_cohesion", residual}};
  }
  const Json plate = {{"name", "footing"},
                      {"surface", {{"polyline", {{0, depth}, {1, depth}}}, {"spacing", h}}},
                      {"method", "boundary_points"},
                      {"mode", "fixed"},
                      {"penalty", 1000 * E / h},
                      {"motion", {{"velocity", {0, -footing.settlement / steps}}}}};
  const auto solver =
      make_mpm({{"dimension", 2},
                {"analysis", "quasi_static"},
                {"basis", "linear"},
                {"grid", box({0, 0}, {width, depth + h}, {nx, ny + 1}, "quad4")},
                {"walls", {wall("bottom", "fixed"), wall("left", "slip"), wall("right", "slip")}},
                {"bodies", {body("soil", box({0, 0}, {width, depth}, {nx, ny}, "quad4"), 4, clay)}},
                {"rigid_walls", {plate}},
                {"locking", {{"method", "fbar"}}},
                {"newton", {{"max_iterations", 60}}},
                {"linear_solver", {{"method", "lu"}}}});
  double largest = 0;
  for (int n = 1; n <= steps; ++n) {
    run_steps(*solver, 1, 1, n);
    largest = std::max(largest, std::abs(probe(*solver, "footing.fy")));
  }
  return largest;
}

/// (2 + pi) c_r <= q <= (2 + pi) c_p: clay that falls off over a long slip bears the load of its
/// peak, clay that is brittle less. All bounds are those of the same cells, which bear a little
/// more than the exact load (V11).
TEST(VA6_StripFooting, bears_less_the_more_brittle_the_clay_is) {
  const double most_coarse = largest_load({0, 3e-3}, 4), most_fine = largest_load({0, 3e-3}, 8);
  double last = residual * (2 + M_PI);
  for (const Footing footing : {Footing{1e-4, 6e-4}, {1e-3, 1.2e-3}, {1e-2, 1.6e-3}, {0.1, 2e-3}}) {
    const double coarse = largest_load(footing, 4), fine = largest_load(footing, 8);
    EXPECT_GT(fine, last) << footing.slip;
    EXPECT_LT(fine, most_fine) << footing.slip;
    EXPECT_LT(coarse, most_coarse) << footing.slip;
    last = fine;
    verify({.id = "VA6",
            .what = fmt::format("largest load of a footing of 2 m on clay that softens over {} m: "
                                "cells of 0.125 m against 0.25 m",
                                footing.slip),
            .exact = fine,
            .computed = coarse,
            .bound = 0.05,
            .unit = "Pa"});
  }
  verify({.id = "VA6",
          .what = "the same, softening over 0.1 m, cells of 0.125 m: load of the peak",
          .exact = peak * (2 + M_PI),
          .computed = last,
          .bound = 0.065,
          .unit = "Pa",
          .limitation = "a cell beside the edge of the footing is carried along"});
}

/// Largest load of the whole footing over its area on clay whose axes are turned by 20 degrees
/// against the grid [Pa]. @param cells  under half of the footing
double largest_load_turned(const Footing& footing, int cells) {
  const double E = 4e8;
  const int steps = 40;
  const TurnedLayer clay{.width = 8, .height = 2, .h = 1.0 / cells, .angle = M_PI / 9};
  const double penalty = 1000 * E / clay.h;
  Json material = elastic_soil("tresca", E, 0.49, 1000);
  material["cohesion"] = peak;
  if (footing.slip > 0) {
    material["softening"] = {{"slip", footing.slip}, {"residual_cohesion", residual}};
  }
  mpm::MpmSolver<2> solver(
      comm(),
      clay.settings(
          {{"dimension", 2},
           {"analysis", "quasi_static"},
           {"basis", "linear"},
           {"grid", clay.grid()},
           {"bodies", {body("soil", clay.mesh(), 4, material)}},
           {"rigid_walls",
            {clay.plate("footing", {{-1, 1}, {1, 1}}, {0, -footing.settlement / steps}, penalty),
             clay.plate("base", {{4, -1}, {-4, -1}}, {0, 0}, penalty),
             clay.plate("left", {{-4, -1}, {-4, 1}}, {0, 0}, penalty),
             clay.plate("right", {{4, 1}, {4, -1}}, {0, 0}, penalty)}},
           {"locking", {{"method", "fbar"}}},
           {"newton", {{"max_iterations", 60}}},
           {"linear_solver", {{"method", "lu"}}}}),
      "");
  double largest = 0;
  for (int n = 1; n <= steps; ++n) {
    run_steps(solver, 1, 1, n);
    const Vector<2> force(probe(solver, "footing.fx"), probe(solver, "footing.fy"));
    largest = std::max(largest, std::abs(force.dot(clay.across())) / 2);
  }
  return largest;
}

/// Cells that lie along the surface and cells that are turned by 20 degrees. Coarse cells bear more
/// where they are turned, at any softening, as they cut the edges of the footing: that share is
/// the same without softening, and falls with the cells.
TEST(VA6_StripFooting, bears_as_much_on_turned_grids) {
  const std::string what = "largest load of a footing of 2 m on clay that softens over {} m, ";
  const double plastic = largest_load({0, 3e-3}, 8);
  const double plastic_turned = largest_load_turned({0, 3e-3}, 8);
  for (const Footing footing : {Footing{1e-4, 6e-4}, {1e-3, 1.2e-3}, {1e-2, 1.6e-3}, {0.1, 2e-3}}) {
    verify({.id = "VA6",
            .what = fmt::format(
                fmt::runtime(what + "by that without softening, cells of 0.125 m: turned by 20 deg "
                                    "against straight ones"),
                footing.slip),
            .exact = largest_load(footing, 8) / plastic,
            .computed = largest_load_turned(footing, 8) / plastic_turned,
            .bound = 0.05});
  }
  for (const Footing footing : {Footing{1e-4, 6e-4}, {1e-2, 1.6e-3}}) {
    const double straight = largest_load(footing, 16), turned = largest_load_turned(footing, 16);
    verify({.id = "VA6",
            .what = fmt::format(
                fmt::runtime(what + "cells of 0.0625 m: turned by 20 deg against straight ones"),
                footing.slip),
            .exact = straight,
            .computed = turned,
            .bound = 0.05,
            .unit = "Pa"});
    verify({.id = "VA6",
            .what =
                fmt::format(fmt::runtime(what + "cells of 0.125 m against 0.0625 m"), footing.slip),
            .exact = straight,
            .computed = largest_load(footing, 8),
            .bound = 0.05,
            .unit = "Pa"});
    verify({.id = "VA6",
            .what = fmt::format(
                fmt::runtime(what + "turned by 20 deg: cells of 0.125 m against 0.0625 m"),
                footing.slip),
            .exact = turned,
            .computed = largest_load_turned(footing, 8),
            .bound = 0.05,
            .unit = "Pa"});
  }
}

/// Deposit of soft clay on a rough bed behind a smooth wall, at yield everywhere. The thrust of
/// clay that spreads is F = rho g h^2 / 2 - (pi / 2) c h (Nye 1951), and the bed bears c:
///
///     dF/dx = -c ,  x = rho g (h_0^2 - h^2) / (2 c) - (pi / 2) (h_0 - h)
///
/// The long-wave limit has no second terms. F ends at h = pi c / (rho g), where the front begins.
struct Deposit {
  double c, a;        ///< strength [Pa], rho g / (2 c) [1/m]
  double height = 0;  ///< at the wall [m]

  double place_of(double h) const {
    return a * (height * height - h * h) - M_PI / 2 * (height - h);
  }
};

Deposit deposit(double volume, double c, double weight) {
  Deposit result{c, weight / (2 * c)};
  double low = 0.1, high = 100;
  while (high - low > 1e-12) {
    const double h = result.height = 0.5 * (low + high);
    (h * h * (2 * result.a * h / 3 - M_PI / 4) < volume ? low : high) = h;
  }
  return result;
}

/// Depths of columns as wide as `width` [m].
std::vector<double> depths_of(const mpm::MaterialPoints<2>& points, double width) {
  std::vector<double> depths;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const auto k = static_cast<std::size_t>(points.x[p][0] / width);
    if (k >= depths.size()) depths.resize(k + 1);
    depths[k] += points.V0[p] * points.J[p] / width;
  }
  return depths;
}

/// A heap of 4 x 2 m of remoulded clay whose weight comes so slowly that inertia does little.
TEST(VA19_RunOut, remoulded_clay_comes_to_rest_on_its_slope) {
  const double c = 1130, rho = 1800, g = 9.81, time = 36, width = 0.8, shallow = 0.4;
  Json clay = elastic_soil("tresca", 300 * c, 0.49, rho);
  clay["cohesion"] = c;
  const auto solver =
      mpm_solver<2>({{"dimension", 2},
                     {"gravity", {0, -g}},
                     {"gravity_ramp", {{"duration", time}}},
                     {"grid", box({0, 0}, {16, 2.4}, {160, 24}, "quad4")},
                     {"walls", {wall("bottom", "fixed"), wall("left", "slip")}},
                     {"time_integration", {{"scheme", "explicit"}}},
                     {"bodies", {body("clay", box({0, 0}, {4, 2}, {40, 20}, "quad4"), 4, clay)}}});
  run_steps(*solver, 0.02, static_cast<int>(std::lround((time + 1) / 0.02)));
  const Deposit exact = deposit(8, c, rho * g);
  const auto depths = depths_of(solver->points(), width);
  std::size_t k = 1;
  while (k + 1 < depths.size() && depths[k] > shallow) ++k;
  const double share = (depths[k - 1] - shallow) / (depths[k - 1] - depths[k]);
  // Slope of the surface in the middle of the column at the wall.
  const double slope = c / (rho * g * exact.height - M_PI / 2 * c);
  const std::string what = "deposit of 8 m^2 of clay of 1.13 kPa, Tresca, cells of 0.1 m: ";
  verify({.id = "VA19",
          .what = what + "depth at the wall",
          .exact = exact.height - width / 2 * slope,
          .computed = depths[0],
          .bound = 0.05,
          .unit = "m"});
  verify({.id = "VA19",
          .what = what + "where it is 0.4 m deep",
          .exact = exact.place_of(shallow),
          .computed = width * (k - 0.5 + share),
          .bound = 0.05,
          .unit = "m",
          .limitation = "the deposit is steeper than its profile, with cells of 0.2 m more so"});
}

}  // namespace
}  // namespace gabion::test
