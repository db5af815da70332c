// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/mechanics/ranks/sum.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/line_scene.hpp"
#include "tests/unit/fem/matrix_scene.hpp"
#include "tests/unit/fem/projectile.hpp"

namespace gabion::test::test_mesh_damping {
namespace {

using std::numbers::pi;

/// A cantilever of 1 m by 0.1 m that starts upwards and is free then: period of some 0.62 s.
Json cantilever(const Json& rayleigh) {
  Json material = elastic("linear_elastic", 1e7, 0, 1000);
  if (!rayleigh.is_null()) material["rayleigh"] = rayleigh;
  return {{"dimension", 2},
          {"mesh", box_2d({1, 0.1}, {6, 1}, "quad8")},
          {"material", material},
          {"initial_velocity", {0.0, 0.01}},
          {"supports", {{{"group", "left"}}}},
          {"probes", {{{"name", "tip"}, {"point", {1.0, 0.0}}}}}};
}

struct Peak {
  double time, height;
};

/// Maxima of the displacement of the tip, of the parabola through three steps.
std::vector<Peak> peaks(Solver& solver, double dt, int steps) {
  std::vector<Peak> found;
  double before = 0, middle = 0;
  for (int n = 1; n <= steps; ++n) {
    advance(solver, n, dt);
    const double last = probe(solver, "tip.uy");
    const double slope = 0.5 * (last - before), bend = before - 2 * middle + last;
    if (middle > before && middle >= last) {
      found.push_back({(n - 1) * dt - dt * slope / bend, middle - 0.5 * slope * slope / bend});
    }
    before = middle, middle = last;
  }
  return found;
}

/// Ratio of successive peaks exp(-2 pi z / sqrt(1 - z^2)), z = a / (2 w) + b w / 2. Higher modes
/// have gone when they are taken.
TEST(MeshDamping, a_free_cantilever_decays_as_it_should) {
  const double a = 0.4, b = 0.004, dt = 0.003;
  for (const Json& scheme : {Json{{"scheme", "newmark"}}, Json{{"scheme", "bossak"}},
                             Json{{"scheme", "generalized_alpha"}, {"rho_inf", 0.8}}}) {
    SCOPED_TRACE(scheme.dump());
    Json json = cantilever({{"mass", a}, {"stiffness", b}});
    json["time_integration"] = scheme;
    const auto solver = fem_solver<2>(json);
    const auto found = peaks(*solver, dt, 1100);
    ASSERT_GE(found.size(), 5U);
    const Peak& first = found[found.size() - 3];
    const Peak& last = found.back();
    const double w_damped = 2 * 2 * pi / (last.time - first.time);
    double w = w_damped, z = 0;
    for (int i = 0; i < 20; ++i) {
      z = a / (2 * w) + b * w / 2;
      w = w_damped / std::sqrt(1 - z * z);
    }
    EXPECT_NEAR(w, 1.0150 * 10, 0.15);  // 3.516 sqrt(E I / rho A) / L^2, with shear somewhat less
    EXPECT_GT(z, 0.03);
    const double expected = std::exp(-2 * 2 * pi * z / std::sqrt(1 - z * z));
    EXPECT_NEAR(last.height / first.height, expected, 1e-3 * expected);
  }
}

TEST(MeshDamping, of_zero_changes_no_bit) {
  const auto without = fem_solver<2>(cantilever(nullptr));
  const auto zero = fem_solver<2>(cantilever({{"mass", 0.0}, {"stiffness", 0.0}}));
  for (int n = 1; n <= 20; ++n) {
    for (auto* solver : {without.get(), zero.get()}) advance(*solver, n, 0.01);
  }
  EXPECT_EQ(without->probe_names(), zero->probe_names());
  EXPECT_EQ(without->probes(), zero->probes());
}

Json wall(double mass, double stiffness) {
  Json json = {{"dimension", 2},
               {"mesh", box_2d({0.1, 1}, {2, 8})},
               {"material", elastic("linear_elastic", 1e7, 0.3, 1000)},
               {"supports", {{{"group", "bottom"}}}},
               {"interfaces", {{{"name", "wall"}, {"groups", {"left"}}}}},
               {"probes", {{{"name", "A"}, {"point", {0.0, 1.0}}}}}};
  json["material"]["rayleigh"] = {{"mass", mass}, {"stiffness", stiffness}};
  return json;
}

TEST(MeshDamping, impacts_make_no_energy) {
  for (const std::string law : {"linear_elastic", "neo_hookean"}) {
    for (const double stiffness : {1e-5, 8e-4, 1e-2}) {
      for (const double dt : {1e-2, 5e-4, 2.5e-5}) {
        Json json = wall(0.5, stiffness);
        json["material"]["law"] = law;
        const auto solver = fem_solver<2>(json, MPI_COMM_SELF);
        const Projectile thrown{.mass = 1, .v = 0.1, .gap = 0.03 * dt, .penalty = 1e9};
        const ImpactEnergy found = impact(*solver, thrown, dt, 30, true);
        const auto what = testing::Message() << law << " stiffness " << stiffness << " dt " << dt;
        EXPECT_GT(found.largest_force, 0) << what;
        EXPECT_GE(found.least_damping, -1e-13) << what;
        const double margin = law == "linear_elastic" ? 1e-6 : 1e-3;
        EXPECT_LT(found.largest, 1 + margin) << what;
        EXPECT_LT(found.with_damping, 1 + margin) << what;
      }
    }
  }
}

/// A structure of cells moves as one of files with its matrices.
TEST(MeshDamping, moves_as_the_same_structure_of_matrices) {
  if (num_ranks(comm()) > 1) GTEST_SKIP() << "matrices are written on one rank";
  Json json = wall(0.5, 8e-4);
  Json undamped = json;
  undamped["material"].erase("rayleigh");
  MatrixScene scene = MatrixScene::of<2>(undamped);
  scene.json["matrices"]["rayleigh"] = json["material"]["rayleigh"];
  const auto cells = fem_solver<2>(json, MPI_COMM_SELF);
  const auto matrices = scene.solver<2>();
  for (Solver* solver : {static_cast<Solver*>(cells.get()), static_cast<Solver*>(matrices.get())}) {
    solver->set_force_kinds({{"wall", ForceKind::step_mean}});
    std::vector<double> forces(2 * solver->interfaces()[0].num_vertices(), 0.0);
    for (int n = 1; n <= 50; ++n) {
      for (std::size_t i = 0; i < forces.size(); i += 2) forces[i] = 10 * std::sin(0.7 * n);
      const StepRequest request{n, 0, (n - 1) * 0.002, 0.002};
      InterfaceValues sent;
      solver->solve_step(request, {{"wall", forces}}, sent);
      solver->accept_step(request, true);
    }
  }
  for (const std::string name : {"A.ux", "damping_work", "kinetic_energy"}) {
    EXPECT_NEAR(probe(*cells, name), probe(*matrices, name), 1e-6 * probe(*matrices, name)) << name;
  }
  EXPECT_GT(probe(*cells, "damping_work"), 0);
}

Json damped_metal() {
  Json json = cantilever({{"mass", 0.5}, {"stiffness", 1e-3}});
  json["material"].update({{"law", "von_mises"},
                           {"yield_stress", 1e5},
                           {"hardening_modulus", 1e6},
                           {"poisson_ratio", 0.3}});
  json["initial_velocity"] = {0.0, 2.0};
  json["dashpots"] = {{{"group", "right"}, {"damping", {0.0, 5.0}}}};
  return json;
}

TEST(MeshDamping, ranks_and_saved_states_of_yielding_structures) {
  const auto shared = fem_solver<2>(damped_metal()), second = fem_solver<2>(damped_metal());
  const auto alone = fem_solver<2>(damped_metal(), MPI_COMM_SELF);
  for (int n = 1; n <= 15; ++n) {
    for (auto* solver : {shared.get(), alone.get()}) advance(*solver, n, 0.004);
  }
  second->load_state(shared->save_state());
  for (int n = 16; n <= 40; ++n) {
    for (auto* solver : {shared.get(), alone.get(), second.get()}) advance(*solver, n, 0.004);
  }
  EXPECT_EQ(shared->probes(), second->probes());
  const auto a = shared->probes(), b = alone->probes();
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_NEAR(a[i], b[i], 1e-6 * (1 + std::abs(b[i]))) << alone->probe_names()[i];
  }
  EXPECT_GT(probe(*alone, "plastic_work"), 0);
  const double start = 0.5 * 1000 * 0.1 * 2 * 2, scale = 0.02 * start;
  EXPECT_GT(probe(*alone, "damping_work"), 0.01 * start);
  EXPECT_NEAR(probe(*alone, "kinetic_energy") + probe(*alone, "elastic_energy") +
                  probe(*alone, "plastic_work") + probe(*alone, "damping_work"),
              start, scale + 0.1 * start);
}

/// m v' = -c v, for a stiff block on a dashpot.
TEST(MeshDamping, dashpots_slow_a_block) {
  Json json = cantilever(nullptr);
  json["material"]["young_modulus"] = 1e10;
  json["supports"] = Json::array();
  json["initial_velocity"] = {1.0, -2.0};
  json["dashpots"] = {{{"group", "left"}, {"damping", {30.0, 0.0}}},
                      {{"group", "right"}, {"damping", {20.0, 0.0}}}};
  const auto solver = fem_solver<2>(json);
  for (int n = 1; n <= 200; ++n) advance(*solver, n, 0.005);
  EXPECT_NEAR(probe(*solver, "momentum_x"), 100 * std::exp(-50.0 / 100), 1e-2);
  EXPECT_NEAR(probe(*solver, "momentum_y"), -200, 1e-6);
  EXPECT_NEAR(probe(*solver, "damping_work"), 50 * (1 - std::exp(-1.0)), 1e-2);
}

TEST(MeshDamping, without_a_meaning_is_refused) {
  Json json = wall(0.5, 8e-4);
  json["time_integration"] = {{"scheme", "bossak"}};
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"/material/rayleigh", "\"interfaces\"", "\"newmark\""});
  json = cantilever({{"mass", 1.0}});
  json.erase("initial_velocity");
  json["analysis"] = "static";
  expect_error<ConfigError>([&] { fem_solver<2>(json); }, {"/material/rayleigh", "\"static\""});
  json = cantilever({{"mass", -1.0}});
  expect_error<ConfigError>([&] { fem_solver<2>(json); }, {"/material/rayleigh/mass", "-1"});
  json = cantilever(nullptr);
  json["dashpots"] = {{{"group", "left"}, {"damping", {0.0, 0.0}}}};
  expect_error<ConfigError>([&] { fem_solver<2>(json); }, {"/dashpots/0/damping", "zero"});
}

}  // namespace
}  // namespace gabion::test::test_mesh_damping
