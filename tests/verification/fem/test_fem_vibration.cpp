// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/convergence_rate.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test {
namespace {

using std::numbers::pi;

constexpr double E = 100, rho = 1, L = 25, v0 = 0.1;
constexpr double wave_number = pi / (2 * L);

/// A bar fixed at x = 0 and free at x = L; without lateral strain the plate moves like a bar.
Json bar(const std::string& law, int cells, const std::string& mass, const Json& scheme) {
  return {{"dimension", 2},
          {"mesh", box_2d({L, 1}, {cells, 1})},
          {"material", elastic(law, E, 0, rho)},
          {"mass", mass},
          {"time_integration", scheme},
          {"newton", {{"residual_tolerance", 1e-11}}},
          {"supports", {{{"group", "left"}}, {{"group", "bottom"}, {"components", {"y"}}}}},
          {"probes", {{{"name", "tip"}, {"point", {L, 0}}}}}};
}

/// First mode v = v0 sin(k x).
void start_mode(fem::FemSolver<2>& solver) {
  std::vector<double> u(solver.mesh().nodes.size() * 2, 0.0), v(u.size(), 0.0);
  for (std::size_t i = 0; i < u.size(); i += 2) {
    v[i] = v0 * std::sin(wave_number * solver.mesh().nodes[i / 2][0]);
  }
  solver.set_motion(u, v);
}

/// Frequency of the mode in a mesh of linear cells: omega^2 = 6 c^2/h^2 (1 - cos kh) / (2 + cos kh)
/// with the consistent mass, 2 c^2/h^2 (1 - cos kh) with the lumped one.
double mesh_frequency(int cells, const std::string& mass) {
  const double h = L / cells, c2 = E / rho, cosine = std::cos(wave_number * h);
  const double divisor = mass == "lumped" ? 1 : (2 + cosine) / 3;
  return std::sqrt(2 * c2 / (h * h) * (1 - cosine) / divisor);
}

const Json trapezoid = {{"scheme", "newmark"}};
const Json bossak = {{"scheme", "bossak"}, {"alpha", -0.1}};
const Json generalized = {{"scheme", "generalized_alpha"}, {"rho_inf", 0.6}};
const Json midpoint = {{"scheme", "generalized_alpha"}, {"rho_inf", 1}};  // has no damping

/// Error of the tip's displacement after 0.9 periods against the motion of the same mesh with exact
/// time integration.
double tip_error(const std::string& mass, const Json& scheme, int steps_per_period) {
  const int cells = 10, steps = steps_per_period * 9 / 10;
  const auto solver = fem_solver<2>(bar("linear_elastic", cells, mass, scheme));
  start_mode(*solver);
  const double dt = 10.0 / steps_per_period;
  run_steps(*solver, dt, steps);
  const double omega = mesh_frequency(cells, mass);
  return std::abs(probe(*solver, "tip.ux") - v0 / omega * std::sin(omega * steps * dt));
}

TEST(V7_VibratingBar, second_order_in_dt) {
  for (const std::string mass : {"consistent", "lumped"}) {
    for (const Json& scheme : {trapezoid, bossak, generalized}) {
      const std::vector<int> steps = {40, 80, 160};
      std::vector<double> sizes, errors;
      for (const int n : steps) {
        sizes.push_back(1.0 / n);
        errors.push_back(tip_error(mass, scheme, n));
      }
      verify({.id = "V7",
              .what = "order in dt, " + scheme["scheme"].get<std::string>() + ", " + mass +
                      " mass, FEM 2D",
              .exact = 2,
              .computed = lowest_rate(sizes, errors),
              .measure = Measure::order,
              .bound = 1.9});
      EXPECT_LT(lowest_rate(sizes, errors), 2.2) << mass << " " << scheme;
    }
  }
}

/// Fixed at x = 0, free or fixed at x = L, 50 cells with smooth sides.
template <int dim>
Json bar_along_x(bool free_end) {
  Json json = bar("linear_elastic", 50, "consistent", trapezoid);
  json["dimension"] = dim;
  json["supports"] = {{{"group", "left"}}};
  if (!free_end) json["supports"].push_back({{"group", "right"}});
  if constexpr (dim == 2) {
    json["supports"].push_back({{"group", "bottom"}, {"components", {"y"}}});
  } else {
    json["mesh"] = box_3d({L, 1, 1}, {50, 1, 1});
    json["supports"].push_back({{"group", "front"}, {"components", {"y"}}});
    json["supports"].push_back({{"group", "bottom"}, {"components", {"z"}}});
  }
  std::vector<double> point(dim, 0.0);
  point[0] = free_end ? L : L / 2;
  json["probes"] = {{{"name", "tip"}, {"point", point}}};
  return json;
}

/// Period from the upward zero crossing: 4 L / c = 10 s of the fixed-free, 2 L / c of the
/// fixed-fixed bar.
template <int dim>
void check_period(bool free_end) {
  const double period = free_end ? 10 : 5, k = (free_end ? 0.5 : 1) * pi / L;
  const auto solver = fem_solver<dim>(bar_along_x<dim>(free_end));
  std::vector<double> u(solver->mesh().nodes.size() * dim, 0.0), v(u.size(), 0.0);
  for (std::size_t i = 0; i < u.size(); i += dim) {
    v[i] = v0 * std::sin(k * solver->mesh().nodes[i / dim][0]);
  }
  for (const auto i : solver->mesh().group_nodes("right", "test")) {
    if (!free_end) v[static_cast<std::size_t>(i) * dim] = 0;  // the sine leaves a rounding error
  }
  solver->set_motion(u, v);
  const double dt = period / 200;
  double before = 0, crossing = 0;
  for (int n = 1; n <= 210 && crossing == 0; ++n) {
    run_steps(*solver, dt, 1, n);
    const double tip = probe(*solver, "tip.ux");
    if (before < 0 && tip >= 0) crossing = (n - 1) * dt + dt * before / (before - tip);
    before = tip;
  }
  verify({.id = "V7",
          .what = std::string(free_end ? "fixed-free" : "fixed-fixed") + " bar, 50 cells, FEM " +
                  (dim == 2 ? "quad4" : "hex8") + ": period",
          .exact = period,
          .computed = crossing,
          .bound = 1e-3,
          .unit = "s"});
}

TEST(V7_VibratingBar, period) {
  for (const bool free_end : {true, false}) {
    check_period<2>(free_end);
    check_period<3>(free_end);
  }
}

TEST(V7_VibratingBar, schemes_without_damping_keep_the_energy_of_a_linear_bar) {
  for (const Json& scheme : {trapezoid, midpoint}) {
    const auto solver = fem_solver<2>(bar("linear_elastic", 20, "consistent", scheme));
    start_mode(*solver);
    const auto energy = [&] {
      return probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy");
    };
    const double start = energy();
    // A sine at the nodes, linear in between: (2 + cos kh) / 3 of the sine's energy.
    const double share = (2 + std::cos(wave_number * L / 20)) / 3;
    EXPECT_NEAR(start, share * 0.25 * rho * L * v0 * v0, 1e-12 * start);
    double drift = 0;
    for (int n = 1; n <= 100; ++n) {
      run_steps(*solver, 0.3, 1, n);
      drift = std::max(drift, std::abs(energy() / start - 1));
    }
    verify(
        {.id = "V7",
         .what = "largest energy drift in 3 periods, linear, " +
                 std::string(scheme == midpoint ? "generalized-alpha rho 1" : "trapezoidal rule") +
                 ", FEM 2D",
         .exact = 0,
         .computed = drift,
         .measure = Measure::absolute_error,
         .bound = 1e-10});
  }
}

/// A smaller rho_inf takes more.
TEST(V7_VibratingBar, generalized_alpha_damps) {
  double lost[2];
  for (const int k : {0, 1}) {
    const Json scheme = {{"scheme", "generalized_alpha"}, {"rho_inf", k == 0 ? 0.9 : 0.5}};
    const auto solver = fem_solver<2>(bar("linear_elastic", 20, "consistent", scheme));
    start_mode(*solver);
    const double start = probe(*solver, "kinetic_energy");
    run_steps(*solver, 0.1, 100);
    lost[k] = 1 - (probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy")) / start;
  }
  EXPECT_GT(lost[0], 0);
  EXPECT_GT(lost[1], 5 * lost[0]);
  verify({.id = "V7",
          .what = "energy loss in a period, generalized-alpha rho 0.5, FEM 2D",
          .exact = 0,
          .computed = lost[1],
          .measure = Measure::absolute_error,
          .bound = 0.01});
}

/// Finite strain: no closed form of the energy, but it must come back within 0.1 % a period.
TEST(V7_VibratingBar, energy_drift_at_finite_strain) {
  const auto solver = fem_solver<2>(bar("hencky_elastic", 20, "consistent", trapezoid));
  start_mode(*solver);
  const auto energy = [&] {
    return probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy");
  };
  const double start = energy();
  run_steps(*solver, 0.1, 100);
  verify({.id = "V7",
          .what = "energy after a period, Hencky, FEM 2D",
          .exact = start,
          .computed = energy(),
          .bound = 1e-3,
          .unit = "J/m"});
}

/// The energy that loads bring in is the energy that is there.
TEST(V7_VibratingBar, work_of_loads_is_the_energy) {
  for (const Json& scheme : {trapezoid, midpoint}) {
    Json json = bar("linear_elastic", 20, "consistent", scheme);
    json["tractions"] = {
        {{"group", "right"}, {"traction", {0.5, 0.0}}, {"table", {{0, 0}, {3, 1}}}}};
    json["gravity"] = {0.01, 0};
    const auto solver = fem_solver<2>(json);
    double difference = 0;
    for (int n = 1; n <= 40; ++n) {
      run_steps(*solver, 0.2, 1, n);
      const double work = probe(*solver, "external_work");
      const double energy = probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy");
      difference = std::max(difference, std::abs(energy - work) / (1 + work));
    }
    verify(
        {.id = "V7",
         .what = "energy minus work of loads, over (1 J/m + work), " +
                 std::string(scheme == midpoint ? "generalized-alpha rho 1" : "trapezoidal rule") +
                 ", FEM 2D",
         .exact = 0,
         .computed = difference,
         .measure = Measure::absolute_error,
         .bound = 1e-10});
    EXPECT_GT(probe(*solver, "external_work"), 1e-2);
  }
}

/// No supports: the centre of mass follows the parabola and the momentum the gravity impulse.
TEST(V18_FreeFlight, momentum_is_that_of_the_impulse) {
  Json json = bar("neo_hookean", 10, "consistent", trapezoid);
  json["supports"] = Json::array();
  json["gravity"] = {0, -9.81};
  json["initial_velocity"] = {2, 3};
  const auto solver = fem_solver<2>(json);
  run_steps(*solver, 0.05, 20);
  const double mass = rho * L, t = 1;
  EXPECT_NEAR(probe(*solver, "momentum_x"), 2 * mass, 1e-10 * mass);
  verify({.id = "V18",
          .what = "vertical momentum in free flight, FEM 2D",
          .exact = (3 - 9.81 * t) * mass,
          .computed = probe(*solver, "momentum_y"),
          .bound = 1e-10,
          .unit = "N s/m"});
  EXPECT_NEAR(probe(*solver, "tip.ux"), 2 * t, 1e-9);
  EXPECT_NEAR(probe(*solver, "tip.uy"), 3 * t - 9.81 / 2 * t * t, 1e-9);
}

}  // namespace
}  // namespace gabion::test
