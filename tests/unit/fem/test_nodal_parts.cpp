// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/line_scene.hpp"

namespace gabion::test::test_nodal_parts {
namespace {

/// A mass of 10 kg on a spring of 4000 N/m across a rope of 3 kg without force, half of whose mass
/// takes part.
/// @returns  largest error of the displacement over its amplitude, within 1 s
double oscillator_error(double dt) {
  const TemporaryMesh mesh(chain(1, 1).file());
  Json json = line_scene(2, mesh.path(), line_material("cable", 1e6, 1e-3, 3000));
  json["supports"] = {{{"group", "low"}}};
  json["point_masses"] = {{{"group", "high"}, {"mass", 10}}};
  json["springs"] = {{{"point", {1, 0}}, {"stiffness", {0, 4000}}}};
  json["time_integration"] = {{"scheme", "newmark"}};
  json["initial_velocity"] = {0, 1e-5};
  json["probes"] = {{{"name", "M"}, {"point", {1, 0}}}};
  const auto solver = fem_solver<2>(json);
  const double omega = std::sqrt(4000 / (10 + 1.5));
  double worst = 0;
  for (int n = 1; n * dt < 1; ++n) {
    advance(*solver, n, dt);
    worst =
        std::max(worst, std::abs(probe(*solver, "M.uy") * omega / 1e-5 - std::sin(omega * n * dt)));
    EXPECT_NEAR(probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy"), 5.75e-10,
                1e-6 * 5.75e-10);
  }
  return worst;
}

TEST(NodalParts, mass_on_a_spring) {
  const double coarse = oscillator_error(0.01), fine = oscillator_error(0.005);
  EXPECT_LT(coarse, 0.1);
  EXPECT_GT(std::log2(coarse / fine), 1.9);
}

TEST(NodalParts, mass_has_weight) {
  const TemporaryMesh mesh(chain(2, 1).file());
  Json json = line_scene(3, mesh.path(), line_material("cable", 1e9, 1e-3, 3000));
  json["analysis"] = "static";
  json["gravity"] = {10, 0, 0};
  json["supports"] = {{{"group", "low"}}};
  json["point_masses"] = {{{"point", {2, 0, 0}}, {"mass", 100}}};
  const auto solver = fem_solver<3>(json);
  advance(*solver, 1, 1);
  EXPECT_NEAR(probe(*solver, "axial_max_rope"), (100 + 3) * 10, 1e-6);
}

/// Springs hold a body in statics; the mean settlement of their nodes is weight over stiffness.
TEST(NodalParts, body_on_springs) {
  Json json = {{"dimension", 2},
               {"mesh", box_2d({2, 1}, {2, 1})},
               {"material", elastic("neo_hookean", 1e7, 0.3, 1000)},
               {"analysis", "static"},
               {"gravity", {0, -10}},
               {"springs", {{{"group", "bottom"}, {"stiffness", {1e6, 2e6}}}}},
               {"probes", Json::array()}};
  for (int i = 0; i <= 2; ++i) {
    json["probes"].push_back({{"name", "b" + std::to_string(i)}, {"point", {i, 0}}});
  }
  const auto solver = fem_solver<2>(json);
  advance(*solver, 1, 1);
  const double sum = probe(*solver, "b0.uy") + probe(*solver, "b1.uy") + probe(*solver, "b2.uy");
  EXPECT_NEAR(sum / 3, -2e4 / 2e6, 1e-9);
}

TEST(NodalParts, wrong_places_and_values) {
  const auto refused = [](const char* list, const Json& item,
                          const std::vector<std::string_view>& parts) {
    Json json = {{"dimension", 2},
                 {"mesh", box_2d({1, 2}, {1, 2})},
                 {"material", elastic("neo_hookean", 1e7, 0.3, 1000)}};
    json[list] = Json::array({item});
    expect_error<ConfigError>([&] { fem_solver<2>(json); }, parts);
  };
  refused("point_masses", {{"group", "top"}, {"mass", -1}}, {"/point_masses/0/mass", "-1"});
  refused("point_masses", {{"group", "roof"}, {"mass", 1}},
          {"/point_masses/0/group", "roof", "bottom, left, right, top"});
  refused("point_masses", {{"mass", 1}}, {"/point_masses/0"});
  refused("point_masses", {{"group", "top"}, {"point", {0, 0}}, {"mass", 1}}, {"/point_masses/0"});
  refused("point_masses", {{"point", {0.5, 0.5}}, {"mass", 1}},
          {"/point_masses/0/point", "0.5", "nearest"});
  refused("springs", {{"group", "top"}, {"stiffness", {0, 0}}}, {"/springs/0/stiffness", "zero"});
  refused("springs", {{"group", "top"}, {"stiffness", {1, -2}}}, {"/springs/0/stiffness", "-2"});
}

}  // namespace
}  // namespace gabion::test::test_nodal_parts
