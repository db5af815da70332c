// SPDX-License-Identifier: BSD-3-Clause
// Cells of concrete that fail by the strain that opens their crack, or that which crushes them.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/concrete_bar.hpp"
#include "tests/unit/fem/energy_balance.hpp"

namespace gabion::test::test_failing_concrete {
namespace {

constexpr double E = 30e9, f_t = 2.7e6, fracture_energy = 100;

/// Energy per volume that cracking to the opening strain e takes, in a band of the width h and with
/// Poisson's ratio 0; then half of the stress times e is stored.
double taken_per_volume(double e, double h, double strength) {
  const double H = h / (2 * E * fracture_energy / (strength * strength) - h);
  const double left = std::exp(2 * H * (1 - E * e / strength));
  return 0.5 * strength * strength / E * (1 + (1 - left) / H) - 0.5 * strength * left * e;
}

/// Five cells of 0.05 m are pulled slowly against their mass; the weak one fails.
Json pulled_until_gone(const std::string& file, double limit, double nu) {
  Json json = pulled_strip(file, 5, 0);
  json["analysis"] = "dynamic";
  json["time_integration"] = {{"scheme", "newmark"}};
  json["prescribed"][0]["table"] = {{0, 0}, {0.03125, 6e-4}};
  json["materials"][0]["failure_strain"] = limit;
  for (auto& material : json["materials"]) material["poisson_ratio"] = nu;
  return json;
}

/// What the crack took is the area under its curve up to the limit, what failed is what the cell
/// still stored; the ledger closes, and what is left of the bar swings without the force.
TEST(FailingConcrete, torn_bar_comes_apart) {
  const TemporaryMesh mesh(strip(0.25, 0.1, 5));
  constexpr double dt = 1.0 / 65536;
  for (const double limit : {1e-3, 3e-3}) {
    const auto solver = fem_solver<2>(pulled_until_gone(mesh.path(), limit, 0));
    double largest = 0;
    for (int n = 1; n <= 2048; ++n) {
      advance(*solver, n, dt);
      largest = std::max(largest, std::abs(imbalance(*solver)));
    }
    const double volume = 0.05 * 0.1;
    EXPECT_EQ(probe(*solver, "failed_cells"), 1);
    EXPECT_NEAR(probe(*solver, "damage_work"), volume * taken_per_volume(limit, 0.05, f_t),
                0.03 * fracture_energy * 0.1)
        << limit;
    EXPECT_GT(probe(*solver, "failed_energy"), 0) << limit;
    EXPECT_LT(probe(*solver, "damage_work") + probe(*solver, "failed_energy"),
              fracture_energy * 0.1)
        << limit;
    EXPECT_LT(largest, 0.01 * probe(*solver, "external_work")) << limit;
  }
}

/// A square, two triangles or a brick of 0.1 m that is pulled slowly and free at its sides.
std::unique_ptr<Solver> pulled_cell(const std::string& type) {
  const bool space = type == "hex8";
  Json material = concrete("");
  material["poisson_ratio"] = 0.2;
  material["failure_strain"] = 2e-3;
  material["fade_steps"] = 4;
  Json json = {
      {"dimension", space ? 3 : 2},
      {"mesh", space ? box_3d({0.1, 0.1, 0.1}, {1, 1, 1}, type) : box_2d({0.1, 0.1}, {1, 1}, type)},
      {"material", material},
      {"analysis", "static"},
      {"supports",
       {{{"group", "left"}, {"components", {"x"}}, {"report_reaction", true}},
        {{"group", "bottom"}, {"components", {"y"}}}}},
      {"prescribed", {{{"group", "right"}, {"component", "x"}, {"table", {{0, 0}, {1, 4e-4}}}}}}};
  if (!space) return fem_solver<2>(json);
  json["supports"][1] = {{"group", "front"}, {"components", {"y"}}};
  json["supports"].push_back({{"group", "bottom"}, {"components", {"z"}}});
  return fem_solver<3>(json);
}

TEST(FailingConcrete, plane_and_space) {
  for (const std::string type : {"quad4", "tri3", "hex8"}) {
    const auto solver = pulled_cell(type);
    for (int n = 1; n <= 256; ++n) advance(*solver, n, 1.0 / 256);
    const double area = type == "hex8" ? 0.01 : 0.1, work = probe(*solver, "external_work");
    EXPECT_EQ(probe(*solver, "failed_cells"), type == "tri3" ? 2 : 1) << type;
    EXPECT_GT(probe(*solver, "damage_work"), 0.9 * fracture_energy * area) << type;
    EXPECT_LT(probe(*solver, "damage_work"), fracture_energy * area) << type;
    EXPECT_GT(probe(*solver, "failed_energy"), 0) << type;
    EXPECT_NEAR(imbalance(*solver), 0, 5e-3 * work) << type;
    EXPECT_NEAR(probe(*solver, "reaction_left_x"), 0, 1e-6 * 3e6 * area) << type;
  }
}

/// Reinforcement holds on where the concrete around it is gone.
TEST(FailingConcrete, steel_holds_on) {
  const TemporaryMesh mesh(strip(0.25, 0.1, 5, /*with_steel=*/true));
  Json json = pulled_until_gone(mesh.path(), 2e-3, 0.2);
  const double area = 1e-3;
  json["materials"].push_back({{"group", "steel"},
                               {"law", "bar"},
                               {"density", 5450},
                               {"young_modulus", 200e9},
                               {"area", area},
                               {"yield_stress", 500e6}});
  const auto run = fem_solver<2>(json), restarted = fem_solver<2>(json);
  double largest = 0;
  for (int n = 1; n <= 1024; ++n) {
    advance(*run, n, 1.0 / 32768);
    largest = std::max(largest, imbalance(*run));
    if (n >= 600) {
      if (n == 600) restarted->load_state(run->save_state());
      if (n > 600) advance(*restarted, n, 1.0 / 32768);
      ASSERT_EQ(restarted->probes(), run->probes()) << n;
    }
  }
  EXPECT_EQ(probe(*run, "failed_cells"), 1);
  EXPECT_GT(probe(*run, "axial_max_steel"), 0.2 * area * 500e6);
  EXPECT_LT(largest, 0.01 * probe(*run, "external_work"));
}

/// Energy per volume that crushing to the strain e takes, of the material of concrete() with
/// another strength and Poisson's ratio 0, in a band of the width h.
double crushing_per_volume(double e, double h, double strength = 38e6) {
  constexpr double crushing_energy = 54e3, at_strength = 2.2e-3;
  const double limit = 0.4 * strength, first = limit / E, run = at_strength - first;
  const double decay = crushing_energy / (h * strength);
  const double left = std::exp((at_strength - e) / decay);
  const double to_strength = limit * first / 2 + (strength - (strength - limit) / 3) * run;
  return to_strength + strength * decay * (1 - left) - strength * left * e / 2;
}

/// A square, two triangles or a brick of 0.1 m that is pressed slowly to the strain 0.06 and free
/// at its sides; it fails at 0.04.
std::unique_ptr<Solver> pressed_cell(const std::string& type, double nu) {
  const bool space = type == "hex8";
  Json material = concrete("");
  material["poisson_ratio"] = nu;
  material["failure_crushing_strain"] = 0.04;
  material["fade_steps"] = 4;
  Json json = {
      {"dimension", space ? 3 : 2},
      {"mesh", space ? box_3d({0.1, 0.1, 0.1}, {1, 1, 1}, type) : box_2d({0.1, 0.1}, {1, 1}, type)},
      {"material", material},
      {"analysis", "static"},
      {"supports",
       {{{"group", "left"}, {"components", {"x"}}, {"report_reaction", true}},
        {{"group", "bottom"}, {"components", {"y"}}}}},
      {"prescribed", {{{"group", "right"}, {"component", "x"}, {"table", {{0, 0}, {1, -6e-3}}}}}}};
  if (!space) return fem_solver<2>(json);
  json["supports"][1] = {{"group", "front"}, {"components", {"y"}}};
  json["supports"].push_back({{"group", "bottom"}, {"components", {"z"}}});
  return fem_solver<3>(json);
}

/// The work of crushing is the area under its curve up to the limit; the force is gone, and the run
/// goes on from a saved state with the same bits.
TEST(FailingConcrete, crushed_cell_leaves) {
  for (const std::string type : {"quad4", "tri3", "hex8"}) {
    for (const double nu : {0.0, 0.2}) {
      SCOPED_TRACE(type + ", Poisson's ratio " + std::to_string(nu));
      const auto solver = pressed_cell(type, nu), restarted = pressed_cell(type, nu);
      constexpr int steps = 256;
      double before = 0;  // force of the cell in the step before it fails
      for (int n = 1; n <= steps; ++n) {
        advance(*solver, n, 1.0 / steps);
        if (probe(*solver, "failed_cells") == 0) before = probe(*solver, "reaction_left_x");
        if (n == steps / 2) restarted->load_state(solver->save_state());
        if (n <= steps / 2) {
          ASSERT_EQ(probe(*solver, "failed_cells"), 0);
          continue;
        }
        advance(*restarted, n, 1.0 / steps);
        ASSERT_EQ(restarted->probes(), solver->probes()) << n;
      }
      const double area = type == "hex8" ? 0.01 : 0.1, work = probe(*solver, "external_work");
      EXPECT_EQ(probe(*solver, "failed_cells"), type == "tri3" ? 2 : 1);
      EXPECT_GT(before, 0.01 * 38e6 * area);
      EXPECT_NEAR(probe(*solver, "reaction_left_x"), 0, 1e-6 * 38e6 * area);
      EXPECT_GT(probe(*solver, "failed_energy"), 0);
      EXPECT_NEAR(imbalance(*solver), 0, 0.01 * work);
      if (nu == 0) {
        EXPECT_NEAR(probe(*solver, "damage_work"), 0.1 * area * crushing_per_volume(0.04, 0.1),
                    0.01 * work);
      }
    }
  }
}

/// Five cells of 0.05 m are pressed slowly against their mass; the weak one is crushed and leaves,
/// what is left of the bar stands without the force.
TEST(FailingConcrete, crushed_bar_comes_apart) {
  const TemporaryMesh mesh(strip(0.25, 0.1, 5));
  constexpr double limit = 0.03, weak = 34e6, dt = 1.0 / 65536;
  Json json = pulled_until_gone(mesh.path(), 1, 0);
  json["prescribed"][0]["table"] = {{0, 0}, {0.03125, -2.5e-3}};
  json["materials"][0].erase("failure_strain");
  json["materials"][0]["compressive_strength"] = weak;
  json["materials"][0]["failure_crushing_strain"] = limit;
  const auto run = fem_solver<2>(json), restarted = fem_solver<2>(json);
  double largest = 0;
  int failed_at = 0;
  for (int n = 1; n <= 2048; ++n) {
    advance(*run, n, dt);
    largest = std::max(largest, std::abs(imbalance(*run)));
    if (failed_at == 0 && probe(*run, "failed_cells") == 1) {
      failed_at = n;
      restarted->load_state(run->save_state());  // while its stress falls
    } else if (failed_at > 0 && n < failed_at + 200) {
      advance(*restarted, n, dt);
      ASSERT_EQ(restarted->probes(), run->probes()) << n;
    }
  }
  EXPECT_GT(failed_at, 1000);
  EXPECT_EQ(probe(*run, "failed_cells"), 1);
  EXPECT_NEAR(probe(*run, "damage_work"), 0.05 * 0.1 * crushing_per_volume(limit, 0.05, weak),
              0.03 * 54e3 * 0.1);
  EXPECT_GT(probe(*run, "failed_energy"), 0);
  EXPECT_LT(largest, 0.01 * probe(*run, "external_work"));
}

/// Facets of a cell that is crushed leave the wet surface with it.
TEST(FailingConcrete, facets_go_with_crushed_cells) {
  Json material = concrete("");
  material["failure_crushing_strain"] = 0.04;
  Json json = {
      {"dimension", 2},
      {"mesh", box_2d({0.1, 0.2}, {1, 2})},
      {"material", material},
      {"analysis", "static"},
      {"supports",
       {{{"group", "left"}, {"components", {"x"}}}, {{"group", "bottom"}, {"components", {"y"}}}}}};
  json["prescribed"] = {{{"group", "right"}, {"component", "x"}, {"table", {{0, 0}, {1, -6e-3}}}}};
  json["interfaces"] = {{{"name", "wall"}, {"groups", {"top"}}, {"behind", {"all"}}}};
  const auto solver = fem_solver<2>(json);
  EXPECT_EQ(solver->facets().at("wall").size(), 2);
  for (int n = 1; n <= 256; ++n) {
    advance(*solver, n, 1.0 / 256);
    if (probe(*solver, "failed_cells") == 0) {
      ASSERT_EQ(solver->facets().at("wall").size(), 2) << n;
    }
  }
  EXPECT_EQ(probe(*solver, "failed_cells"), 2);
  EXPECT_EQ(solver->facets().at("wall").size(), 0);
}

TEST(FailingConcrete, wrong_input) {
  const TemporaryMesh mesh(strip(0.25, 0.1, 5));
  const auto refused = [&](const std::string& key, const Json& value,
                           const std::vector<std::string_view>& parts) {
    Json json = pulled_strip(mesh.path(), 5, 1e-4);
    json["materials"][0][key] = value;
    expect_error<ConfigError>([&] { fem_solver<2>(json); }, parts);
  };
  refused("failure_strain", 0, {"/materials/0/failure_strain", "0"});
  refused("failure_crushing_strain", 0, {"/materials/0/failure_crushing_strain", "0"});
  refused("failure_crushing_strain", -0.01, {"/materials/0/failure_crushing_strain", "-0.01"});
  refused("failure_crushing_strain", 2.2e-3,
          {"/materials/0/failure_crushing_strain", "0.0022", "strain_at_strength"});
  refused("failure_plastic_strain", 0.1, {"/materials/0/failure_plastic_strain"});
  refused("failure_force", 1e3, {"/materials/0/failure_force"});
  refused("fade_steps", 2, {"/materials/0/fade_steps", "without a limit"});
  Json json = pulled_strip(mesh.path(), 5, 1e-4);
  json["materials"][1] = elastic("neo_hookean", 30e9, 0.2, 2400);
  json["materials"][1]["group"] = "strong";
  json["materials"][1]["failure_crushing_strain"] = 0.01;
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"/materials/1/failure_crushing_strain", "unknown key"});
}

}  // namespace
}  // namespace gabion::test::test_failing_concrete
