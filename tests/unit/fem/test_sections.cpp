// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test::test_sections {
namespace {

constexpr double weight = 2 * 1000 * 9.81;  // of the whole cantilever [N]

/// A cantilever of 2 m by 1 m, clamped at x = 0, with a force on its end and a section at x = 1.
Json cantilever(const Json& material, const std::string& type, bool heavy) {
  Json json = {
      {"dimension", 2},
      {"mesh", box_2d({2, 1}, {8, 2}, type)},
      {"material", material},
      {"analysis", "static"},
      {"supports", {{{"group", "left"}, {"report_reaction", true}, {"report_moment", true}}}},
      {"loads", {{{"group", "right"}, {"force", {3e4, -2e4}}}}},
      {"sections", {{{"name", "mid"}, {"point", {1.0, 0.5}}, {"normal", {2.0, 0.0}}}}},
      {"newton", {{"residual_tolerance", 1e-12}}}};
  if (heavy) json["gravity"] = {0.0, -9.81};
  return json;
}

double column(const Solver& solver, const std::string& name) {
  const auto names = solver.probe_names();
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) throw std::runtime_error("no column " + name);
  return solver.probes()[found - names.begin()];
}

void solve(Solver& solver) {
  const StepRequest request{1, 0, 0, 1};
  InterfaceValues sent;
  solver.solve_step(request, {}, sent);
  solver.accept_step(request, true);
}

Json metal() {
  Json material = elastic("von_mises", 1e8, 0.3, 1000);
  material["yield_stress"] = 1e5;
  material["hardening_modulus"] = 1e7;
  return material;
}

TEST(Sections, force_is_what_loads_and_reactions_leave) {
  for (const Json& material : {elastic("neo_hookean", 1e8, 0.3, 1000), metal()}) {
    for (const std::string type : {"quad4", "quad8", "tri6"}) {
      SCOPED_TRACE(type + material["law"].get<std::string>());
      const auto solver = fem_solver<2>(cantilever(material, type, false));
      solve(*solver);
      EXPECT_NEAR(column(*solver, "mid.N"), 3e4, 1e-5);
      EXPECT_NEAR(column(*solver, "mid.V_x"), 0, 1e-5);
      EXPECT_NEAR(column(*solver, "mid.V_y"), -2e4, 1e-5);
      EXPECT_NEAR(column(*solver, "mid.N"), -column(*solver, "reaction_left_x"), 1e-5);
      // The arm of the end is its present one: 1 m but for some mm.
      EXPECT_NEAR(column(*solver, "mid.M_z"), -2e4, 2e3);
    }
  }
}

/// Moment about the moved point, from the moment of the reactions about the clamp.
TEST(Sections, moment_balances_that_of_the_reactions) {
  const auto solver = fem_solver<2>(
      cantilever(elastic("neo_hookean", 1e6, 0.3, 1000), "quad4", false), MPI_COMM_SELF);
  solve(*solver);
  const auto settings =
      fem_settings<2>(cantilever(elastic("neo_hookean", 1e6, 0.3, 1000), "quad4", false));
  const auto& u = solver->state().motion.u;
  Vector<2> moved(1, 0.5);
  for (std::size_t i = 0; i < settings.mesh.nodes.size(); ++i) {
    if (settings.mesh.nodes[i][0] == 1) moved += Vector<2>(u[2 * i], u[2 * i + 1]) / 3;
  }
  const Vector<2> arm = moved - Vector<2>(0, 0.5);
  EXPECT_GT(std::abs(u.back()), 0.05);
  const double of_force = arm[0] * -2e4 - arm[1] * 3e4;
  EXPECT_NEAR(column(*solver, "mid.M_z") + of_force + column(*solver, "moment_left_z"), 0, 1e-5);
}

/// Loads at nodes of the cut count with the part in front: half a cell of weight.
TEST(Sections, weight_of_the_part_in_front) {
  const auto solver =
      fem_solver<2>(cantilever(elastic("neo_hookean", 1e8, 0.3, 1000), "quad4", true));
  solve(*solver);
  EXPECT_NEAR(column(*solver, "mid.V_y"), -2e4 - weight * (1 + 0.125) / 2, 1e-5);
}

TEST(Sections, planes_beside_the_structure_and_without_normal_are_refused) {
  Json json = cantilever(elastic("neo_hookean", 1e8, 0.3, 1000), "quad4", false);
  json["sections"][0]["point"] = {2.5, 0.5};
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"fem.json: at /sections/0/point", "a plane that does not cut"});
  json["sections"][0]["normal"] = {0.0, 0.0};
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"fem.json: at /sections/0/normal", "found length 0, allowed: > 0"});
}

}  // namespace
}  // namespace gabion::test::test_sections
