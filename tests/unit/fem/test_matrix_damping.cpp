// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/convergence_rate.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/matrix_scene.hpp"
#include "tests/unit/fem/projectile.hpp"

namespace gabion::test::test_matrix_damping {
namespace {

Json bossak(double alpha) {
  return {{"scheme", "bossak"}, {"alpha", alpha}};
}

const Json trapezoid = {{"scheme", "newmark"}};
const Json strongest = {{"scheme", "generalized_alpha"}, {"rho_inf", 0}};
const std::vector<Json> schemes = {trapezoid, bossak(-0.1), bossak(-0.3), bossak(-1.0 / 3),
                                   strongest};

/// An upright wall that is clamped at its foot, hit from its left: period of some 0.1 s.
Json wall() {
  return {{"dimension", 2},
          {"mesh", box_2d({0.1, 1}, {2, 8})},
          {"material", elastic("linear_elastic", 1e7, 0.3, 1000)},
          {"supports", {{{"group", "bottom"}}}},
          {"interfaces", {{{"name", "wall"}, {"groups", {"left"}}}}}};
}

TEST(MatrixDamping, impacts_make_no_energy) {
  MatrixScene scene = MatrixScene::of<2>(wall());
  for (const Json& scheme : schemes) {
    scene.json["time_integration"] = scheme;
    for (const double stiffness : {1e-5, 8e-4, 1e-2}) {
      scene.json["matrices"]["rayleigh"] = {{"mass", 0.5}, {"stiffness", stiffness}};
      for (const double dt : {1e-2, 5e-4, 2.5e-5}) {
        for (const double mass : {1.0, 1000.0}) {
          const auto solver = scene.solver<2>();
          const ImpactEnergy found =
              impact(*solver, {.mass = mass, .gap = 0.3 * dt, .penalty = 1e9}, dt, 40, true);
          const auto what = testing::Message()
                            << scheme << " stiffness " << stiffness << " dt " << dt << " " << mass;
          EXPECT_GT(found.largest_force, 0) << what;
          EXPECT_GE(found.least_damping, -1e-13) << what;
          EXPECT_LT(found.largest, 1 + 1e-9) << what;
          EXPECT_LT(found.in_structure, 1e-9) << what;
          EXPECT_LT(found.with_damping, scheme == trapezoid ? 1 + 1e-9 : 1.1) << what;
        }
      }
    }
  }
}

/// m u'' + c u' + k u = F for a node on a spring and a dashpot.
MatrixScene one_mass(double m, double c, double k) {
  MatrixScene scene;
  const auto matrix = [](double value) {
    return fmt::format("%%MatrixMarket matrix coordinate real symmetric\n1 1 1\n1 1 {}\n", value);
  };
  scene.write("K.mtx", matrix(k));
  scene.write("M.mtx", matrix(m));
  scene.write("C.mtx", matrix(c));
  scene.write("unknowns.csv", "1,1\n");
  scene.write("held.csv", "1,2\n2\n");
  scene.write("nodes.csv", "1,1,0\n2,0,0\n");
  scene.write("wall.csv", "1 2\n");
  scene.json = {{"dimension", 2},
                {"matrices",
                 {{"stiffness", "K.mtx"},
                  {"mass", "M.mtx"},
                  {"damping", "C.mtx"},
                  {"unknowns", "unknowns.csv"},
                  {"held", "held.csv"},
                  {"nodes", "nodes.csv"}}},
                {"interfaces", {{{"name", "wall"}, {"facets", "wall.csv"}}}},
                {"probes", {{{"name", "A"}, {"point", {1, 0}}}}}};
  return scene;
}

/// @returns displacement at the end
double pushed(const MatrixScene& scene, double dt, int steps, double force) {
  const auto solver = scene.solver<2>();
  solver->set_force_kinds({{"wall", ForceKind::step_mean}});
  for (int n = 1; n <= steps; ++n) {
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    InterfaceValues sent;
    solver->solve_step(request, {{"wall", {force, 0, 0, 0}}}, sent);
    solver->accept_step(request, true);
  }
  return probe(*solver, "A.ux");
}

/// u = F / k (1 - exp(-d t) (cos w t + d / w sin w t)), d = c / 2 m, w^2 = k / m - d^2
TEST(MatrixDamping, a_sudden_force_moves_an_oscillator_as_it_should) {
  const double m = 2, c = 0.8, k = 9, F = 3, end = 2;
  const double d = c / (2 * m), w = std::sqrt(k / m - d * d);
  const double exact =
      F / k * (1 - std::exp(-d * end) * (std::cos(w * end) + d / w * std::sin(w * end)));
  MatrixScene scene = one_mass(m, c, k);
  for (const Json& scheme : schemes) {
    scene.json["time_integration"] = scheme;
    std::vector<double> sizes, errors;
    for (const int steps : {40, 80, 160}) {
      sizes.push_back(1.0 / steps);
      errors.push_back(std::abs(pushed(scene, end / steps, steps, F) - exact));
    }
    EXPECT_GT(last_rate(sizes, errors), 1.8) << scheme;
  }
}

/// A strong dashpot yields at the speed F / c, and never backwards.
TEST(MatrixDamping, a_strong_dashpot_is_not_pushed_backwards) {
  const double m = 1, c = 1e6, F = 1, dt = 1;
  MatrixScene scene = one_mass(m, c, 1e-3);
  for (const Json& scheme : schemes) {
    scene.json["time_integration"] = scheme;
    const double first = pushed(scene, dt, 1, F);
    EXPECT_GT(first, 0) << scheme;
    EXPECT_LT(first, 2 * F / c * dt) << scheme;
    EXPECT_NEAR(pushed(scene, dt, 100, F), 100 * F / c * dt, F / c * dt) << scheme;
  }
}

TEST(MatrixDamping, impulse_of_a_free_mass_is_dt_times_the_force) {
  MatrixScene scene = one_mass(2, 0, 0);
  for (const Json& scheme : schemes) {
    scene.json["time_integration"] = scheme;
    const auto solver = scene.solver<2>();
    solver->set_force_kinds({{"wall", ForceKind::step_mean}});
    double impulse = 0;
    for (int n = 1; n <= 10; ++n) {
      const double force = std::sin(2.3 * n);
      const StepRequest request{n, 0, (n - 1) * 0.1, 0.1};
      InterfaceValues sent;
      solver->solve_step(request, {{"wall", {force, 0, 0, 0}}}, sent);
      solver->accept_step(request, true);
      impulse += 0.1 * force;
      EXPECT_NEAR(2 * solver->state().v[0], impulse, 1e-13) << scheme;
    }
  }
}

TEST(MatrixDamping, that_would_make_energy_is_refused) {
  MatrixScene scene = one_mass(1, 1, 1);
  scene.write("C.mtx", "%%MatrixMarket matrix coordinate real symmetric\n1 1 1\n1 1 -0.1\n");
  expect_error<ConfigError>([&] { scene.solver<2>(); },
                            {"/matrices", "damping", "node 1, direction 1"});
}

}  // namespace
}  // namespace gabion::test::test_matrix_damping
