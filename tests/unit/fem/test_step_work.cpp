// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/convergence_rate.hpp"
#include "tests/unit/fem/fem_scene.hpp"
#include "tests/unit/fem/projectile.hpp"

namespace gabion::test::test_step_work {
namespace {

const Json trapezoid = {{"scheme", "newmark"}};
const Json strongest = {{"scheme", "generalized_alpha"}, {"rho_inf", 0}};

/// A linear bar between a clamp and an end that moves as given; the end is a surface, too.
Json driven_bar(const Json& table, const Json& scheme, const std::string& mass = "lumped") {
  return {
      {"dimension", 2},
      {"mesh", box_2d({4, 1}, {8, 2})},
      {"material", elastic("linear_elastic", 50, 0.3, 2)},
      {"mass", mass},
      {"time_integration", scheme},
      {"newton", {{"residual_tolerance", 1e-12}}},
      {"supports", {{{"group", "left"}}}},
      {"prescribed",
       {{{"group", "right"}, {"component", "x"}, {"table", table}},
        {{"group", "right"}, {"component", "y"}, {"table", {{0, 0}}}}}},
      {"tractions", {{{"group", "top"}, {"traction", {0.1, -0.2}}, {"table", {{0, 0}, {1, 1}}}}}},
      {"interfaces",
       {{{"name", "end"}, {"groups", {"right"}}}, {{"name", "roof"}, {"groups", {"top"}}}}}};
}

struct Balance {
  double error = 0, largest = 0, work = 0;  // [J]
};

/// Steps under mean forces that jump, on nodes that move as given and on others.
/// @param push  [N] of a vertex
Balance drive(const Json& json, int steps, double dt, double push) {
  const auto solver = fem_solver<2>(json);
  solver->set_force_kinds({{"end", ForceKind::step_mean}, {"roof", ForceKind::step_mean}});
  const auto energy = [&] {
    return probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy");
  };
  Balance found;
  found.error = std::abs(energy() - probe(*solver, "external_work"));
  for (int n = 1; n <= steps; ++n) {
    InterfaceValues forces, sent;
    for (const InterfaceMesh& mesh : solver->interfaces()) {
      for (std::size_t i = 0; i < mesh.coordinates.size(); ++i) {
        forces[mesh.name].push_back(push * std::sin(1.3 * double(i) + 2.1 * n));
      }
    }
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    solver->solve_step(request, forces, sent);
    solver->accept_step(request, true);
    found.work = probe(*solver, "external_work");
    found.error = std::max(found.error, std::abs(energy() - found.work));
    found.largest = std::max(found.largest, energy());
  }
  return found;
}

const Json ramp = {{0, 0}, {10, 1}};
const Json up_and_down = {{0, 0}, {1, 0.2}, {2, -0.1}, {5, 0.3}};

TEST(StepWork, of_supports_that_move_under_forces_that_jump) {
  for (const Json& table : {ramp, up_and_down}) {
    for (const double push : {0.0, 0.3}) {
      const Balance found = drive(driven_bar(table, trapezoid), 30, 0.15, push);
      EXPECT_GT(found.largest, 0.01);
      EXPECT_LT(found.error, 1e-10 * found.largest) << table << push;
    }
  }
}

/// A consistent mass passes the accelerations of the support on, which backward differences have
/// half a step late.
TEST(StepWork, of_supports_with_a_consistent_mass) {
  Json table = Json::array();
  for (int k = 0; k <= 4000; ++k) {
    const double t = 1e-3 * k;
    table.push_back({t, 0.1 * (1 - std::cos(3 * t))});
  }
  std::vector<double> sizes, errors;
  for (const int steps : {40, 80, 160}) {
    sizes.push_back(1.0 / steps);
    const Balance found = drive(driven_bar(table, trapezoid, "consistent"), steps, 2.0 / steps, 0);
    errors.push_back(found.error / found.largest);
  }
  EXPECT_LT(errors.back(), 2e-3);
  EXPECT_GT(lowest_rate(sizes, errors), 0.9);
}

/// Where a node moves as given, a force on it is borne by what moves it.
TEST(StepWork, of_forces_on_nodes_that_move_as_given_is_none) {
  Json json = driven_bar(up_and_down, trapezoid);
  json["interfaces"].erase(1);
  double without = 0;
  for (const double push : {0.0, 100.0}) {
    const Json scene = json;
    const auto solver = fem_solver<2>(scene);
    solver->set_force_kinds({{"end", ForceKind::step_mean}});
    for (int n = 1; n <= 20; ++n) {
      std::vector<double> forces(6, n % 3 == 0 ? push : -push);
      InterfaceValues sent;
      const StepRequest request{n, 0, (n - 1) * 0.1, 0.1};
      solver->solve_step(request, {{"end", forces}}, sent);
      solver->accept_step(request, true);
    }
    if (push == 0) without = probe(*solver, "external_work");
    EXPECT_NEAR(probe(*solver, "external_work"), without, 1e-12 * std::abs(without));
  }
  EXPECT_GT(std::abs(without), 0.01);
}

TEST(StepWork, of_supports_that_begin_elsewhere) {
  Json json = driven_bar({{0, 0.2}, {1, 0.2}}, trapezoid);
  json.erase("tractions");
  const Balance found = drive(json, 5, 0.15, 0);
  EXPECT_GT(found.work, 1);
  EXPECT_LT(found.error, 1e-10 * found.work);
}

/// A stiff bar is hit at its end: where waves are much shorter than the step, the energy that a
/// mean force gives them is not more than its work.
TEST(StepWork, impacts_make_no_energy_with_the_strongest_damping) {
  const Json bar = {{"dimension", 2},
                    {"mesh", box_2d({4, 1}, {16, 2})},
                    {"material", elastic("linear_elastic", 1e9, 0.2, 1000)},
                    {"time_integration", strongest},
                    {"newton", {{"residual_tolerance", 1e-10}}},
                    {"supports", {{{"group", "right"}}}},
                    {"interfaces", {{{"name", "wall"}, {"groups", {"left"}}}}}};
  for (const double dt : {1e-2, 1e-3, 1e-4, 1e-5}) {
    for (const double mass : {10.0, 1e4}) {
      const auto solver = fem_solver<2>(bar);
      const ImpactEnergy found =
          impact(*solver, {.mass = mass, .gap = 0.3 * dt, .penalty = 1e11}, dt, 20, false);
      EXPECT_GT(found.largest_force, 0);
      EXPECT_LT(found.largest, 1 + 1e-7) << dt << " " << mass;
      EXPECT_LT(found.in_structure, 1e-7) << dt << " " << mass;
    }
  }
}

/// Log lines while a free block turns by 60 degrees.
std::string said_while_turning(const std::string& law) {
  const Json block = {{"dimension", 2},
                      {"mesh", box_2d({1, 1}, {2, 2})},
                      {"material", elastic(law, 1e5, 0.3, 1000)},
                      {"time_integration", trapezoid},
                      {"gravity", {0, -1}}};
  const auto solver = fem_solver<2>(block);
  std::vector<double> u, v;
  for (const auto& x : solver->mesh().nodes) {
    u.insert(u.end(), {0.0, 0.0});
    v.insert(v.end(), {-(x[1] - 0.5), x[0] - 0.5});
  }
  solver->set_motion(u, v);
  testing::internal::CaptureStderr();
  run_steps(*solver, 0.01, 105);
  return testing::internal::GetCapturedStderr();
}

TEST(SmallStrain, a_block_that_turns_is_said) {
  const std::string said = said_while_turning("linear_elastic");
  for (const char* words :
       {"structure: linear_elastic has rotated by 10 degrees", "by 20", "by 40"}) {
    EXPECT_NE(said.find(words), std::string::npos) << words << " in " << said;
  }
  EXPECT_EQ(said_while_turning("neo_hookean").find("turned"), std::string::npos);
}

}  // namespace
}  // namespace gabion::test::test_step_work
