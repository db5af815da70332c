// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

/// Li2(x) = sum x^k / k^2, 0 <= x < 1.
double dilogarithm(double x) {
  double sum = 0, power = x;
  for (int k = 1; power > 1e-18; ++k, power *= x) sum += power / (static_cast<double>(k) * k);
  return sum;
}

/// Cylindrical cavity of radius a0 in an incompressible Tresca body of radius b0 with a free outer
/// side, opened to the radius a. With r^2 - r0^2 = K = a^2 - a0^2, x(r) = K / r^2 and Hencky's
/// elasticity sigma_t - sigma_r = 4 G ln(r / r0) = -2 G ln(1 - x), which yields at 2 c up to the
/// radius R with x(R) = 1 - exp(-c / G),
///
///     p = int_a^b (sigma_t - sigma_r) / r dr = c ln(R^2 / a^2) + G [Li2(x(R)) - Li2(x(b))]
///
/// at any strain. Its limits are the known ones: a thick ring yields first at c (1 - a^2 / b^2) and
/// collapses at 2 c ln(b / a) (Hill, 1950); a cavity in an infinite body opens without end at
/// c [1 + ln(G / c)] (Gibson and Anderson, 1961).
struct Cavity {
  double a0 = 1, b0 = 2;   // [m]
  double c = 1, G = 1000;  // [Pa]
  double nu = 0.499;

  double pressure(double a) const {
    const double K = a * a - a0 * a0, b2 = b0 * b0 + K, x_y = 1 - std::exp(-c / G);
    const double R2 = std::min(std::max(K / x_y, a * a), b2);
    return c * std::log(R2 / (a * a)) + G * (dilogarithm(K / R2) - dilogarithm(K / b2));
  }
  /// Radius at which its wall begins to yield.
  double first_yield() const { return a0 * std::exp(0.5 * c / G); }
};

TEST(V16_Cavity, known_limits_of_the_closed_form) {
  const Cavity stiff{.G = 1e6}, wide{.b0 = 1e8, .G = 100};
  const auto limit = [](const std::string& what, double exact, double found, double bound) {
    verify({.id = "V16",
            .what = "closed form: " + what,
            .exact = exact,
            .computed = found,
            .bound = bound,
            .unit = "c"});
  };
  limit("stiff ring, first yield", 0.75, stiff.pressure(stiff.first_yield()), 1e-5);
  limit("stiff ring, collapse", 2 * std::log(2.0), stiff.pressure(1 + 1e-5), 1e-4);
  limit("cavity in an infinite body", 1 + std::log(100.0), wide.pressure(1e3), 6e-4);
}

// A sector of 10 degrees between smooth sides, cells wider by a constant factor from ring to ring.
constexpr double half_angle = 5 * M_PI / 180;

void bend_to_sector(Mesh<2>& mesh, const Cavity& cavity) {
  for (auto& X : mesh.nodes) {
    const double r = cavity.a0 * std::pow(cavity.b0 / cavity.a0, X[0]);
    const double angle = half_angle * (2 * X[1] - 1);
    X = r * Vector<2>(std::cos(angle), std::sin(angle));
  }
}

Json sector_scene(const Cavity& cavity, const std::string& type, int rings, int points_per_cell) {
  Json material = elastic_soil("tresca", 2 * (1 + cavity.nu) * cavity.G, cavity.nu, 1);
  material["cohesion"] = cavity.c;
  const Json unit = box({0, 0}, {1, 1}, {rings, 1}, type);
  return {{"dimension", 2},
          {"analysis", "quasi_static"},
          {"grid", unit},
          {"basis", "linear"},
          {"walls", {wall("bottom", "slip"), wall("top", "slip")}},
          {"bodies", {body("soil", unit, points_per_cell, material)}},
          {"newton", {{"max_iterations", 60}}},
          {"linear_solver", {{"method", "lu"}}}};
}

mpm::MpmSolver<2> bent_solver(const Cavity& cavity, const Json& scene) {
  auto settings = mpm_settings<2>(scene);
  Mesh<2>& sector = settings.layouts[0].mesh;  // that of the grid, too
  bend_to_sector(sector, cavity);
  settings.grid = mpm::BackgroundGrid<2>(sector);
  return mpm::MpmSolver<2>(comm(), std::move(settings), "");
}

/// The cavity's wall is a wall of the grid and moves: small strain, points stay in their cells.
void open_ring(const std::string& type) {
  const Cavity ring;
  Json scene = sector_scene(ring, type, 24, type == "tri3" ? 3 : 4);
  Json inner = wall("left", "slip");
  // The corners of the chord move along the sides: by 1 / cos(half_angle) of the wall.
  inner["motion"] = {{"velocity", {std::cos(half_angle), 0}}};
  scene["walls"].push_back(inner);
  auto solver = bent_solver(ring, scene);
  const auto pressure = [&] {
    return -probe(solver, "wall.left.fx") / (2 * ring.a0 * std::sin(half_angle));
  };
  const double dt = (ring.first_yield() - ring.a0) / 5;
  const std::string what = " of a ring, b / a = 2, Tresca, MPM " + type;
  run_steps(solver, dt, 5);
  verify({.id = "V16",
          .what = "pressure over c at first yield" + what,
          .exact = ring.pressure(ring.a0 + 5 * dt),
          .computed = pressure(),
          .bound = 0.01});
  run_steps(solver, dt, 20, 6);
  verify({.id = "V16",
          .what = "pressure over c at collapse" + what,
          .exact = ring.pressure(ring.a0 + 25 * dt),
          .computed = pressure(),
          .bound = 0.01});
}

TEST(V16_Cavity, thick_ring) {
  open_ring("quad4");
  open_ring("tri3");
}

const std::string half_empty =
    "triangles at a surface that has moved on hold few points, and their patches few constraints";

/// The cavity's wall is an interface that moves through the grid to three times its radius.
void open_wide(const std::string& type, int points_per_cell, double bound,
               const std::string& limitation) {
  const Cavity cavity{.b0 = 300, .G = 100};
  constexpr int rings = 56, steps = 100;
  const double x = cavity.a0 * std::cos(half_angle), y = cavity.a0 * std::sin(half_angle);
  const double h = cavity.a0 * (std::pow(cavity.b0 / cavity.a0, 1.0 / rings) - 1);
  Json scene = sector_scene(cavity, type, rings, points_per_cell);
  scene["interfaces"] = {{{"name", "cavity"},
                          {"surface", {{"polyline", {{x, -y}, {x, y}}}, {"spacing", 1}}},
                          {"method", "boundary_points"},
                          {"mode", "slip"},
                          {"points_per_facet", 8},
                          {"penalty", 1000 * cavity.G / h}}};
  auto solver = bent_solver(cavity, scene);
  const auto X = solver.interfaces()[0].coordinates;
  const auto open_to = [&](int n) {
    InterfaceValues displacement, force;
    for (const double value : X) displacement["cavity"].push_back(2.0 * n / steps * value);
    solver.solve_step({n, 0, n - 1.0, 1}, displacement, force);
    solver.accept_step({n, 0, n - 1.0, 1}, true);
    return -(force.at("cavity")[0] + force.at("cavity")[2]) / (2 * y * (1 + 2.0 * n / steps));
  };
  double p = 0;
  for (int n = 1; n <= steps; ++n) p = open_to(n);
  const std::string what = ", Tresca, G / c = 100, MPM " + type;
  verify({.id = "V16",
          .what = "pressure over c in a cavity opened to 3 radii" + what,
          .exact = cavity.pressure(3 * cavity.a0),
          .computed = p,
          .bound = bound,
          .limitation = limitation});
  verify({.id = "V16",
          .what = "limit pressure over c of a cavity (that at 3 radii + ln(9 / 8))" + what,
          .exact = 1 + std::log(cavity.G / cavity.c),
          .computed = p + std::log(9.0 / 8),
          .bound = bound,
          .limitation = limitation});
}

TEST(V16_Cavity, opened_to_three_radii) {
  open_wide("quad4", 4, 0.01, "");
  open_wide("tri3", 12, 0.08, half_empty);
}

/// A quarter of a ring in a box of cells, its wall an interface: opened by a tenth, all of it
/// yields.
void open_on_box(const std::string& basis) {
  const Cavity ring{.b0 = 4, .G = 10};
  constexpr int cells = 8, facets = 12, steps = 5;
  Json scene = sector_scene(ring, "quad4", 1, 16);
  scene["basis"] = basis;
  scene["grid"] = box({0, 0}, {5, 5}, {5 * cells, 5 * cells}, "quad4");
  scene["walls"] = {wall("bottom", "slip"), wall("left", "slip")};
  scene["bodies"][0]["mesh"] = box({0, 0}, {1, 1}, {cells, cells}, "quad4");
  std::vector<std::vector<double>> arc;
  for (int k = facets; k >= 0; --k) {
    const double angle = 0.5 * M_PI * k / facets;
    arc.push_back({ring.a0 * std::cos(angle), ring.a0 * std::sin(angle)});
  }
  scene["interfaces"] = {{{"name", "cavity"},
                          {"surface", {{"polyline", arc}, {"spacing", 1}}},
                          {"method", "boundary_points"},
                          {"mode", "fixed"},
                          {"penalty", 100 * ring.G * cells}}};
  auto settings = mpm_settings<2>(scene);
  Mesh<2>& mesh = settings.layouts[0].mesh;
  mesh = box_mesh<2>({0, 0}, {1, 1}, {3 * cells, 3 * cells}, CellType::quad4);
  for (auto& X : mesh.nodes) {
    const double r = ring.a0 + (ring.b0 - ring.a0) * X[0], angle = 0.5 * M_PI * X[1];
    X = r * Vector<2>(std::cos(angle), std::sin(angle));
  }
  mpm::MpmSolver<2> solver(comm(), std::move(settings), "");
  const auto X = solver.interfaces()[0].coordinates;
  double p = 0;
  for (int n = 1; n <= steps; ++n) {
    InterfaceValues displacement, force;
    for (const double value : X) displacement["cavity"].push_back(0.1 * n / steps * value);
    solver.solve_step({n, 0, n - 1.0, 1}, displacement, force);
    solver.accept_step({n, 0, n - 1.0, 1}, true);
    p = 0;
    for (std::size_t k = 0; k < X.size(); ++k) p -= force.at("cavity")[k] * X[k];
    p /= 0.5 * M_PI * ring.a0 * (ring.a0 + 0.1 * n / steps);
  }
  verify(
      {.id = "V16",
       .what = "pressure over c of a ring, b / a = 4, opened by a tenth, 8 cells a radius, MPM " +
               basis,
       .exact = ring.pressure(1.1 * ring.a0),
       .computed = p,
       .bound = 0.02});
}

TEST(V16_Cavity, round_wall_in_a_box_of_cells) {
  open_on_box("linear");
  open_on_box("gimp");
  open_on_box("bspline");
}

}  // namespace
}  // namespace gabion::test
