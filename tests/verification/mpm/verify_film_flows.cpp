// SPDX-License-Identifier: BSD-3-Clause
// Layers of grains and mud that flow down a rough slope, on three grids.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double g = 9.81, depth = 0.1, density = 1500, degree = std::numbers::pi / 180;

/// A layer in steady flow, axes along and across the slope. Smooth walls end it so far off that the
/// middle does not feel them. Cells are as long as the depth, since nothing changes along the flow.
struct Film {
  Json soil;
  double slope = 0;                        ///< [rad]
  std::function<double(double y)> steady;  ///< speed at a height over the bed [m/s]

  static constexpr int columns = 48;
};

mpm::MpmSettings<2> settings_of(const Film& film, int rows) {
  const double length = Film::columns * depth;
  Json layer =
      body("layer", box({0, 0}, {length, depth}, {Film::columns, rows}, "quad4"), 4, film.soil);
  layer["initial_stress"] = {{"k0", 1}, {"surface", depth}, {"max_displacement", 0.01}};
  auto settings = mpm_settings<2>(
      {{"dimension", 2},
       {"basis", "gimp"},
       {"grid", box({0, 0}, {length, 1.5 * depth}, {Film::columns, rows + rows / 2}, "quad4")},
       {"walls", {wall("bottom", "fixed"), wall("left", "slip"), wall("right", "slip")}},
       {"gravity", {0, -g * std::cos(film.slope)}},
       {"time_integration", {{"scheme", "explicit"}}},
       {"step_control", {{"strain", nullptr}}},
       {"bodies", {layer}}});
  const double pull = g * std::sin(film.slope);
  settings.body_acceleration = [pull](const Vector<2>&, double) -> Vector<2> {
    return pull * Vector<2>::Unit(0);
  };
  return settings;
}

struct Speeds {
  double error;    ///< root mean square of the difference to the steady profile
  double surface;  ///< mean of the highest points, over that of the profile
};

/// Speeds in the middle of a film in the last step of a run, by that of the surface: those of the
/// grid, by which the points moved. FLIP leaves the points beside the bed an error of their own.
Speeds speeds(const Film& film, int rows, double time, int steps) {
  mpm::MpmSolver<2> solver(comm(), settings_of(film, rows), "");
  std::vector<Vector<2>> v;
  for (const Vector<2>& x : solver.points().x) v.emplace_back(film.steady(x[1]), 0);
  const std::vector<Vector<2>> at_rest(v.size(), Vector<2>::Zero());
  solver.set_motion(v, at_rest);
  const double dt = time / steps;
  run_steps(solver, dt, steps - 1);
  v = solver.points().u;
  run_steps(solver, dt, 1, steps);
  const auto& points = solver.points();
  double squares = 0, count = 0, top = 0, exact_top = 0;
  for (std::size_t p = 0; p < points.x.size(); ++p) {
    const Vector<2>& x = points.x[p];
    if (std::abs(x[0] - 0.5 * Film::columns * depth) > depth) continue;
    const Vector<2> moved = (points.u[p] - v[p]) / dt;
    const double exact = film.steady(std::min(x[1], depth));
    squares += (moved - exact * Vector<2>::Unit(0)).squaredNorm();
    ++count;
    if (x[1] < depth - depth / rows) continue;
    top += moved[0];
    exact_top += exact;
  }
  return {std::sqrt(squares / count) / film.steady(depth), top / exact_top};
}

/// Rows of a film on three grids: error of its velocities by that of the surface, and its order.
void verify_film(const std::string& id, const std::string& what, const Film& film) {
  constexpr double time = 0.2;
  std::array<Speeds, 3> found;
  int rows = 6;
  for (Speeds& one : found) {
    one = speeds(film, rows, time, 60);
    rows *= 2;
  }
  verify({.id = id,
          .what = what + "24 rows of cells, 0.2 s: error of the velocities by that of the surface",
          .exact = 0,
          .computed = found[2].error,
          .measure = Measure::absolute_error,
          .bound = 0.005});
  verify({.id = id,
          .what = what + "24 rows of cells, 0.2 s: speed of the surface",
          .exact = film.steady(depth),
          .computed = film.steady(depth) * found[2].surface,
          .bound = 0.005,
          .unit = "m/s"});
  verify({.id = id,
          .what = what + "6 to 24 rows: order of the error in h",
          .exact = 2,
          .computed = 0.5 * std::log2(found[0].error / found[2].error),
          .measure = Measure::order,
          .bound = 1.9});
}

/// mu(I) on a slope theta (Bagnold's profile): tan(theta) = mu(I) gives I, and
///
///     u = 2/3 I / d sqrt(share g cos theta) (h^1.5 - (h - y)^1.5)
///
/// with the share of the volume that grains fill. Grains of a fifth of the depth are a test of
/// the equations: so thick a flow comes to its balance within a length that is cheap. The pressure
/// at the bed is below a thousandth of the bulk modulus: grains of a quarter of it flow faster by
/// 0.5 %.
TEST(N14_Bagnold, keeps_its_profile) {
  constexpr double mu_s = 0.3819, mu_2 = 0.6435, I_0 = 0.279, d = 0.02, share = 0.6;
  const double slope = 24 * degree, weight = g * std::cos(slope), friction = std::tan(slope);
  const double I = I_0 * (friction - mu_s) / (mu_2 - friction);
  Json grains = elastic_soil("mu_i", 2.4e6, 0.3, density);
  grains.update({{"static_friction", mu_s},
                 {"limit_friction", mu_2},
                 {"inertial_number", I_0},
                 {"grain_size", d},
                 {"grain_density", density / share}});
  const Film film{.soil = grains, .slope = slope, .steady = [=](double y) {
                    return 2.0 / 3 * I / d * std::sqrt(share * weight) *
                           (std::pow(depth, 1.5) - std::pow(depth - y, 1.5));
                  }};
  verify_film("N14", "mu(I) down a slope of 24 deg, ", film);
}

/// Mud of tau = tau_y + K rate^n: a plug floats where the stress f (h - y), f = rho g sin theta, is
/// below tau_y, and below it, at a depth of h_p = h - tau_y / f and less over the bed,
///
///     u = n / (n + 1) (f / K)^(1/n) [h_p^(1 + 1/n) - (h_p - y)^(1 + 1/n)]
Film mud_film(double consistency, double n) {
  constexpr double tau_y = 50, slope = 10 * degree, G = 5e4;
  const double force = density * g * std::sin(slope), sheared = depth - tau_y / force;
  Json mud = elastic_soil("herschel_bulkley", 2 * G * 1.45, 0.45, density);
  mud["yield_stress"] = tau_y;
  mud["consistency"] = consistency;
  mud["flow_index"] = n;
  return {.soil = mud, .slope = slope, .steady = [=](double y) {
            const double below = std::max(0.0, sheared - y), power = 1 + 1 / n;
            return n / (n + 1) * std::pow(force / consistency, 1 / n) *
                   (std::pow(sheared, power) - std::pow(below, power));
          }};
}

TEST(N3_BinghamFilm, keeps_its_profile) {
  verify_film("N3", "Bingham down a slope of 10 deg, ", mud_film(50, 1));
}

TEST(N5_HerschelBulkleyFilm, keeps_its_profile) {
  verify_film("N5", "Herschel-Bulkley, flow index 0.5, down a slope of 10 deg, ",
              mud_film(150, 0.5));
}

}  // namespace
}  // namespace gabion::test
