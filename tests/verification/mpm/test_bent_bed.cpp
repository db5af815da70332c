// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/verification_row.hpp"
#include "tests/verification/mpm/bent_bed.hpp"

namespace gabion::test {
namespace {

constexpr double degree = M_PI / 180, g = 9.81;

/// A bed of 20 degrees whose slope changes by some degrees at 1 m, and a block of 0.5 m on it.
BentBed<2> bent_slope(double bend) {
  const double slope = 20 * degree, after = slope - bend * degree;
  BentBed<2> bed;
  bed.map = [=](const Vector<2>& x) {
    const double s = x[0] - 1, turn = s < 0 ? slope : after;
    const double middle = 0.5 * (slope + after);
    // Columns of cells lie along the bisector, so they are as high on either side.
    return Vector<2>(s * std::cos(turn) + x[1] * std::sin(middle),
                     -s * std::sin(turn) + x[1] * std::cos(middle));
  };
  bed.low = {0, 0};
  bed.high = {3, 0.6};
  bed.block_low = {0.2, 0};
  bed.block_high = {0.7, 0.3};
  bed.gravity = {0, -g};
  return bed;
}

Vector<2> momentum(const Solver& solver) {
  return {probe(solver, "momentum_x"), probe(solver, "momentum_y")};
}

/// V9: what a bend takes goes to nothing with its angle.
TEST(V9_BentBed, small_bends_are_no_bends) {
  const auto after = [](double bend) {
    const auto solver = bent_slope(bend).solver();
    run_steps(*solver, 2e-3, 300);
    return Vector<2>(momentum(*solver));
  };
  const Vector<2> straight = after(0);
  const double mass = 150, speed = g * std::sin(20 * degree) * 0.6;
  verify({.id = "V9",
          .what = "block on a smooth conforming bed of 20 degrees, momentum after 0.6 s",
          .exact = mass * speed,
          .computed = straight.norm(),
          .bound = 1e-4,
          .unit = "N s"});
  for (const double bend : {1e-5, 1e-3, 0.01, 0.1, 1.0, -1e-3, -0.01, -0.1, -1.0}) {
    const Vector<2> found = after(bend);
    // The impulse of the bed turns the momentum by the bend, once the block is past it.
    verify({.id = "V9",
            .what = fmt::format("the same on a bed that bends by {} degrees at 1 m, change of "
                                "momentum over momentum and angle",
                                bend),
            .exact = 0,
            .computed = (found - straight).norm() / straight.norm() / std::abs(bend * degree),
            .measure = Measure::absolute_error,
            .bound = 1.5});
  }
}

/// V9: a block that is bent as its circular bed turns about the middle of the circle as a rigid
/// body, a pendulum. `up`: 1 in a valley, -1 on a hill.
template <int dim>
void swing(BentBed<dim> bed, double up, double time, const std::string& what) {
  const auto solver = bed.solver();
  const auto& points = solver->points();
  double m = 0, I = 0;
  Vector<dim> centre = Vector<dim>::Zero();
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double x = points.x[p][0], z = points.x[p][dim - 1];
    m += points.m[p];
    I += points.m[p] * (x * x + z * z);
    centre += points.m[p] * points.x[p];
  }
  centre /= m;
  const double r = std::hypot(centre[0], centre[dim - 1]);
  Pendulum pendulum{.angle = std::atan2(centre[0], -up * centre[dim - 1])};
  const double top = up * r * std::cos(pendulum.angle);
  pendulum.swing(up * m * g * r / I, time);
  constexpr double dt = 2e-3;
  run_steps(*solver, dt, static_cast<int>(std::lround(time / dt)));
  verify({.id = "V9",
          .what = what + ", gravity_work",
          .exact = m * g * (up * r * std::cos(pendulum.angle) - top),
          .computed = probe(*solver, "gravity_work"),
          .bound = 0.01,
          .unit = "J"});
  verify({.id = "V9",
          .what = what + ", kinetic energy",
          .exact = 0.5 * I * pendulum.rate * pendulum.rate,
          .computed = probe(*solver, "kinetic_energy"),
          .bound = 0.01,
          .unit = "J"});
  // Steps along tangents leave a circle by half the angle of a step, along the path: first order.
  const double angle_of_step = std::abs(pendulum.rate) * dt;
  EXPECT_LT(probe(*solver, "created_energy"), angle_of_step * probe(*solver, "gravity_work"));
  EXPECT_LT(std::abs(probe(*solver, "energy_balance")), 1e-6 * probe(*solver, "gravity_work"));
}

/// A bed along a circle of the radius R: inside of it, a valley, or outside, a hill.
BentBed<2> arc(double R, double h, bool valley) {
  BentBed<2> bed;
  bed.map = [=](const Vector<2>& x) {
    const double phi = x[0] / R, r = valley ? R - x[1] : R + x[1];
    return Vector<2>(r * std::sin(phi), (valley ? -r : r) * std::cos(phi));
  };
  bed.h = h;
  bed.gravity = {0, -g};
  bed.low = {-0.8 * R, 0};
  bed.high = {0.8 * R, 6 * h};
  return bed;
}

TEST(V9_BentBed, valley_and_hill) {
  for (const std::string type : {"quad4", "tri3"}) {
    for (const double R : {2.0, 8.0}) {
      BentBed<2> valley = arc(R, 0.1, true);
      valley.type = type;
      valley.block_low = {-0.7 * R, 0};
      valley.block_high = {-0.7 * R + 0.6, 0.3};
      swing(valley, 1, 0.45 * std::sqrt(R),
            fmt::format("block in a circular valley of {} m, {}, "
                        "smooth conforming bed",
                        R, type));
      BentBed<2> hill = arc(R, 0.1, false);
      hill.type = type;
      hill.block_low = {0.2 * R, 0};
      hill.block_high = {0.2 * R + 0.6, 0.3};
      swing(hill, -1, 0.3 * std::sqrt(R),
            fmt::format("block on a circular hill of {} m, {}, "
                        "smooth conforming bed",
                        R, type));
    }
  }
}

/// A bowl: the inside of a sphere.
TEST(V9_BentBed, bowl) {
  constexpr double R = 4;
  for (const std::string type : {"hex8", "tet4"}) {
    BentBed<3> bed;
    bed.map = [=](const Vector<3>& x) {
      const double phi = x[0] / R, psi = x[1] / R, r = R - x[2];
      return Vector<3>(r * std::sin(phi) * std::cos(psi), r * std::sin(psi),
                       -r * std::cos(phi) * std::cos(psi));
    };
    bed.type = type;
    bed.h = 0.2;
    bed.gravity = {0, 0, -g};
    bed.low = {-3, -0.8, 0};
    bed.high = {3, 0.8, 0.8};
    bed.block_low = {-2.6, -0.4, 0};
    bed.block_high = {-1.8, 0.4, 0.4};
    swing(bed, 1, 0.6, "block in a bowl, " + type + ", smooth conforming bed");
  }
}

}  // namespace
}  // namespace gabion::test
