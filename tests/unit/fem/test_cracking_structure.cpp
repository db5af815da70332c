// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/concrete_bar.hpp"

namespace gabion::test::test_cracking_structure {
namespace {

struct Torn {
  double energy = 0, work = 0, peak = 0, width = 0;
  int most_iterations = 0;
};

Torn tear(double length, double height, int cells) {
  // Longer than E G_f / f_t^2 + h / 2 = 0.41 m + h / 2 it would snap back.
  const TemporaryMesh mesh(strip(length, height, cells));
  const double elongation = 6e-4;
  const auto solver = fem_solver<2>(pulled_strip(mesh.path(), cells, elongation));
  Torn torn;
  constexpr int steps = 480;
  for (int n = 1; n <= steps; ++n) {
    torn.most_iterations = std::max(torn.most_iterations, advance(*solver, n, 1.0 / steps));
    torn.peak = std::max(torn.peak, -probe(*solver, "reaction_left_x"));
  }
  torn.energy = probe(*solver, "damage_work");
  torn.work = probe(*solver, "external_work");
  torn.width = probe(*solver, "crack_width");
  return torn;
}

/// A bar is torn in its weak cell, and takes the fracture energy once whatever its cells are.
TEST(CrackingStructure, energy_does_not_depend_on_the_cells) {
  for (const int cells : {1, 2, 4, 8}) {
    const Torn torn = tear(0.25, 0.1, cells);
    EXPECT_NEAR(torn.energy, 100 * 0.1, 1e-4 * 10) << cells;
    EXPECT_NEAR(torn.work, torn.energy, 0.02 * torn.energy) << cells;  // trapezoids of the load
    EXPECT_NEAR(torn.peak, 2.7e6 * 0.1, 0.02 * 2.7e5) << cells;
    EXPECT_NEAR(torn.width, 6e-4, 0.01 * 6e-4) << cells;
    EXPECT_LE(torn.most_iterations, 16) << cells;
  }
}

/// Cells that are longer than high, or higher than long, by their length along the bar.
TEST(CrackingStructure, slender_cells) {
  for (const double height : {0.004, 0.02, 0.5}) {
    EXPECT_NEAR(tear(0.25, height, 5).energy, 100 * height, 1e-4 * 100 * height) << height;
  }
}

/// A slender cell that is turned tears along its length all the same.
TEST(CrackingStructure, slender_cell_that_is_turned) {
  for (const double angle : {0.0, 0.15, 0.26}) {
    const double length = 0.05, height = 0.5;
    GmshText file = strip(length, height, 1);
    for (auto& x : file.nodes) {
      x = {std::cos(angle) * x[0] - std::sin(angle) * x[1],
           std::sin(angle) * x[0] + std::cos(angle) * x[1], 0};
    }
    const TemporaryMesh mesh(file);
    Json json = pulled_strip(mesh.path(), 1, 0);
    json["prescribed"] = {{{"group", "right"}, {"component", "x"}, {"table", {{0, 0}, {1, 6e-4}}}},
                          {{"group", "right"}, {"component", "y"}, {"table", {{0, 0}}}}};
    const auto solver = fem_solver<2>(json);
    for (int n = 1; n <= 120; ++n) advance(*solver, n, 1.0 / 120);
    EXPECT_NEAR(probe(*solver, "damage_work"), 100 * height, 0.05 * 100 * height) << angle;
  }
}

TEST(CrackingStructure, triangles_and_space) {
  for (const std::string type : {"tri3", "hex8"}) {
    Json material = concrete("");
    Json json = {
        {"dimension", type == "hex8" ? 3 : 2},
        {"mesh", type == "hex8" ? box_3d({0.1, 0.1, 0.1}, {1, 1, 1}, type)
                                : box_2d({0.1, 0.1}, {1, 1}, type)},
        {"material", material},
        {"analysis", "static"},
        {"supports", {{{"group", "left"}}}},
        {"prescribed", {{{"group", "right"}, {"component", "x"}, {"table", {{0, 0}, {1, 6e-4}}}}}}};
    const auto solver = type == "hex8" ? std::unique_ptr<Solver>(fem_solver<3>(json))
                                       : std::unique_ptr<Solver>(fem_solver<2>(json));
    for (int n = 1; n <= 60; ++n) advance(*solver, n, 1.0 / 60);
    const double area = type == "hex8" ? 0.01 : 0.1;
    EXPECT_NEAR(probe(*solver, "damage_work"), 100 * area, 0.05 * 100 * area) << type;
  }
}

TEST(CrackingStructure, widest_crack_with_place_and_time) {
  const TemporaryMesh mesh(strip(0.25, 0.1, 5));
  Json json = pulled_strip(mesh.path(), 5, 6e-4);
  json["prescribed"][0]["table"] = {{0, 0}, {1, 2e-4}, {2, 0}};
  const auto solver = fem_solver<2>(json);
  for (int n = 1; n <= 200; ++n) advance(*solver, n, 0.01);
  EXPECT_LT(probe(*solver, "crack_width"), 1e-9);  // closed
  const Json crack = solver->summary().at("widest_crack");
  EXPECT_NEAR(crack.at("time").get<double>(), 1, 1e-9);
  EXPECT_NEAR(crack.at("place")[0].get<double>(), 0.125, 1e-12);
  EXPECT_NEAR(crack.at("place")[1].get<double>(), 0.05, 1e-12);
  EXPECT_NEAR(crack.at("width").get<double>(), 2e-4, 5e-6);  // the rest is elastic
}

/// Steel along the bar yields while the concrete cracks: the force is that of both, in cycles too.
TEST(CrackingStructure, bars_of_steel) {
  const TemporaryMesh mesh(strip(0.5, 0.1, 1, /*with_steel=*/true));
  Json json = pulled_strip(mesh.path(), 1, 0);
  const double area = 1e-3, E = 200e9, limit = 500e6, H_i = 1e9, H_k = 5e9;
  json["materials"].push_back({{"group", "steel"},
                               {"law", "bar"},
                               {"density", 7850},
                               {"young_modulus", E},
                               {"area", area},
                               {"yield_stress", limit},
                               {"hardening_modulus", H_i},
                               {"kinematic_modulus", H_k}});
  json["prescribed"][0]["table"] = {{0, 0}, {1, 0.5 * 0.005}, {2, 0}};
  json["prescribed"].push_back({{"group", "right"}, {"component", "y"}, {"table", {{0, 0}}}});
  const auto solver = fem_solver<2>(json);
  const double H = H_i + H_k;
  for (int n = 1; n <= 20; ++n) advance(*solver, n, 0.05);
  const double plastic = (E * 0.005 - limit) / (E + H);
  EXPECT_NEAR(probe(*solver, "stress_max_steel"), E * (0.005 - plastic), 1);
  EXPECT_NEAR(probe(*solver, "axial_max_steel"), area * E * (0.005 - plastic), 1e-3);
  EXPECT_NEAR(probe(*solver, "plastic_strain_steel"), plastic, 1e-12);
  EXPECT_NEAR(probe(*solver, "plastic_work"),
              0.5 * area * (limit * plastic + 0.5 * H * plastic * plastic), 1e-6);
  // A millionth of the stiffness of concrete is left.
  EXPECT_NEAR(-probe(*solver, "reaction_left_x"),
              probe(*solver, "axial_max_steel") + 1e-6 * 30e9 * 0.005 * 0.1, 0.5);
  for (int n = 21; n <= 40; ++n) advance(*solver, n, 0.05);
  // Back at strain 0: the elastic range has moved by H_k and grown by H_i.
  const double trial = -E * plastic - H_k * plastic;
  const double more = std::max((-trial - (limit + H_i * plastic)) / (E + H), 0.0);
  EXPECT_NEAR(probe(*solver, "stress_min_steel"), -E * (plastic - more), 1);
  EXPECT_EQ(probe(*solver, "plastic_strain"), probe(*solver, "plastic_strain_steel"));

  json["materials"].back()["pretension"] = 1.6 * limit * area;
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"/materials/1/pretension", "8e+08 Pa", "5e+08 Pa"});
  json["materials"].back().erase("pretension");
  json["materials"].back()["length_ratio"] = 0.99;
  expect_error<ConfigError>([&] { fem_solver<2>(json); }, {"/materials/1/length_ratio"});
}

/// A run that saved its state goes on as the one that starts from it, to the bit.
TEST(CrackingStructure, restart_gives_the_same_bits) {
  const TemporaryMesh mesh(strip(0.25, 0.1, 5, /*with_steel=*/true));
  Json json = pulled_strip(mesh.path(), 5, 6e-4);
  json["materials"].push_back({{"group", "steel"},
                               {"law", "bar"},
                               {"density", 7850},
                               {"young_modulus", 200e9},
                               {"area", 1e-4},
                               {"yield_stress", 50e6}});
  json["prescribed"][0]["table"] = {{0, 0}, {1, 4e-4}, {2, 3e-4}};
  const auto run = fem_solver<2>(json), restarted = fem_solver<2>(json);
  for (int n = 1; n <= 60; ++n) advance(*run, n, 0.0125);
  restarted->load_state(run->save_state());
  EXPECT_EQ(restarted->probes(), run->probes());
  for (int n = 61; n <= 160; ++n) {
    EXPECT_EQ(advance(*restarted, n, 0.0125), advance(*run, n, 0.0125));
    EXPECT_EQ(restarted->probes(), run->probes()) << n;
  }
  EXPECT_EQ(restarted->save_state().reals, run->save_state().reals);
  EXPECT_EQ(restarted->summary().at("widest_crack"), run->summary().at("widest_crack"));
  EXPECT_GT(probe(*run, "damage_work"), 1);
  EXPECT_GT(probe(*run, "plastic_strain_steel"), 1e-4);
}

void expect_refused(const std::function<void(Json&)>& change,
                    const std::vector<std::string_view>& parts, const std::string& type = "quad4") {
  Json json = {{"dimension", 2},
               {"mesh", box_2d({1, 0.5}, {2, 1}, type)},
               {"material", concrete("")},
               {"supports", {{{"group", "left"}}}}};
  change(json);
  expect_error<ConfigError>([&] { fem_solver<2>(json); }, parts);
}

TEST(CrackingStructure, refused_settings) {
  expect_refused([](Json& json) { json["material"]["fracture_energy"] = 50; },
                 {"/material/fracture_energy", "50", "cell 0", "0.5 m wide", "below 0.333333 m",
                  "more than 75 J/m^2"});
  expect_refused([](Json& json) { json["material"]["crushing_energy"] = 20e3; },
                 {"/material/crushing_energy", "0.5 m wide", "below 0.415512 m"});
  expect_refused([](Json& json) { json["material"]["tensile_strength"] = 38e6; },
                 {"/material/tensile_strength", "below compressive_strength"});
  expect_refused([](Json& json) { json["material"]["strain_at_strength"] = 1e-3; },
                 {"/material/strain_at_strength", "0.001", "at least 0.00202667"});
  expect_refused([](Json& json) { json["material"]["biaxial_ratio"] = 0.9; },
                 {"/material/biaxial_ratio", "0.9"});
  expect_refused([](Json& json) { json["material"].erase("fracture_energy"); },
                 {"/material", "fracture_energy"});
  expect_refused([](Json& json) { json["material"]["yield_stress"] = 1e6; },
                 {"/material/yield_stress"});
  expect_refused([](Json& json) { json["material"]["formulation"] = "enhanced"; },
                 {"/material/law", "enhanced", "full"});
  expect_refused([](Json&) {}, {"/material/law", "quad8", "linear"}, "quad8");
}

/// With reinforcement cells may be wider than the band of one crack.
TEST(CrackingStructure, crack_spacing) {
  Json json = {{"dimension", 2},
               {"mesh", box_2d({1, 0.5}, {2, 1})},
               {"material", concrete("")},
               {"supports", {{{"group", "left"}}}}};
  json["material"]["fracture_energy"] = 50;
  json["material"]["crack_spacing"] = 0.2;
  EXPECT_NO_THROW(fem_solver<2>(json));
}

}  // namespace
}  // namespace gabion::test::test_cracking_structure
