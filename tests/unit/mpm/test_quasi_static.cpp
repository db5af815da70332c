// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "mpm_solver/small_cuts/light_nodes.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_quasi_static {
namespace {

/// Soil between smooth walls on a smooth base, one cell of free grid above it.
Json box_of_soil(const Json& material, const std::string& type, int points_per_cell) {
  return {
      {"dimension", 2},
      {"analysis", "quasi_static"},
      {"grid", box({0, 0}, {0.5, 1.25}, {2, 5}, type)},
      {"basis", "linear"},
      {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
      {"gravity", {0, -10}},
      {"bodies", {body("soil", box({0, 0}, {0.5, 1}, {2, 4}, type), points_per_cell, material)}},
      {"newton", exact_newton}};
}

Json soft_soil() {
  return elastic_soil("hencky_elastic", 1e6, 0.3, 1000);
}

template <int dim>
double largest_motion(const mpm::MaterialPoints<dim>& points) {
  double largest = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    largest = std::max({largest, points.v[p].norm(), points.a[p].norm()});
  }
  return largest;
}

/// The state that a damped dynamic run with endless steps comes to, but without motion left. The
/// paths to it differ, and with them the positions at which the shape functions are taken: by the
/// strain, here 4e-5.
TEST(QuasiStatic, is_the_limit_of_long_dynamic_steps) {
  for (const char* type : {"quad4", "tri3"}) {
    const int count = std::string(type) == "tri3" ? 3 : 4;
    Json json = box_of_soil(soft_soil(), type, count);
    json["gravity"] = {0, -0.1};
    const auto quasi_static = mpm_solver<2>(json);
    run_steps(*quasi_static, 1, 40);
    json["analysis"] = "dynamic";
    json["time_integration"] = {{"scheme", "bossak"}, {"alpha", -0.3}};
    const auto dynamic = mpm_solver<2>(json);
    run_steps(*dynamic, 1e4, 40);
    const auto &a = quasi_static->points(), &b = dynamic->points();
    for (std::int32_t p = 0; p < a.size(); ++p) {
      EXPECT_LT((a.u[p] - b.u[p]).norm(), 1e-4 * a.u.back().norm()) << type;
      EXPECT_LT((a.tau[p] - b.tau[p]).norm(), 1e-4 * 100) << type;
    }
    EXPECT_GT(-a.u.back()[1], 3e-5);
    EXPECT_EQ(largest_motion(a), 0);
    EXPECT_EQ(probe(*quasi_static, "kinetic_energy"), 0);
  }
}

/// Nothing but the load decides: neither dt nor another step under the same load changes anything.
TEST(QuasiStatic, time_is_only_a_parameter) {
  const Json json = box_of_soil(soft_soil(), "quad4", 4);
  const auto quick = mpm_solver<2>(json), slow = mpm_solver<2>(json);
  run_steps(*quick, 1e-6, 1);
  run_steps(*slow, 1e3, 1);
  EXPECT_TRUE(same_bits(quick->points(), slow->points()));
}

TEST(QuasiStatic, without_load_nothing_moves) {
  Json json = box_of_soil(soft_soil(), "quad4", 4);
  json.erase("gravity");
  const auto solver = mpm_solver<2>(json);
  const auto before = solver->points();
  run_steps(*solver, 0.1, 2);
  EXPECT_TRUE(same_bits(before, solver->points()));
}

void check_newton(const std::string& locking, int most_iterations) {
  Json soil = elastic_soil("mohr_coulomb", 1e6, 0.3, 1000);
  soil["friction_angle"] = 25;
  soil["dilation_angle"] = 5;
  soil["cohesion"] = 600;
  Json json = box_of_soil(soil, "quad4", 4);
  json["walls"] = {wall("bottom", "fixed"), wall("left", "slip")};
  json["grid"] = box({0, 0}, {1.0, 1.25}, {4, 5}, "quad4");
  json["gravity"] = {0, -4.5};
  json["locking"] = {{"method", locking}};
  const auto solver = mpm_solver<2>(json);
  const StepRequest request{1, 0, 0, 1};
  InterfaceValues sent;
  const StepReport report = solver->solve_step(request, {}, sent);
  solver->accept_step(request, true);
  int yielding = 0;
  for (const auto& history : solver->points().history) yielding += history.plastic_strain > 0;
  EXPECT_GT(yielding, 3);
  EXPECT_LE(report.newton_iterations, most_iterations) << locking;
}

TEST(QuasiStatic, newton_converges_quadratically_in_yielding_soil) {
  check_newton("none", 7);
  check_newton("fbar", 9);
}

std::int32_t join(SoilPatch<2>& soil, const mpm::WallConditions<2>& walls, double share) {
  return mpm::join_light_nodes<2>(comm(),
                                  {.grid = soil.grid,
                                   .points = soil.points,
                                   .weights = soil.weights,
                                   .walls = walls,
                                   .share = share},
                                  soil.nodes);
}

/// A bar of points one of which just entered the cell above: its far nodes carry 1e-6 of its mass.
TEST(LightNodes, join_the_nearest_heavy_node_and_keep_the_mass) {
  SoilPatch<2> soil(CellType::quad4, 3);
  const double h = 1.0 / 3;
  soil.add({0.5 * h, 0.5 * h});
  soil.add({1.5 * h, 0.5 * h});
  soil.add({1.5 * h, h + 1e-6 * h});
  soil.to_grid();
  const auto total = [&] {
    double sum = 0;
    for (const double m : soil.nodes.m) sum += m;
    return sum;
  };
  const double mass = total();
  const std::int32_t before = soil.nodes.size();
  EXPECT_EQ(before, 8);
  const mpm::WallConditions<2> free(soil.grid, {});
  EXPECT_EQ(join(soil, free, 1e-8), 0);
  EXPECT_EQ(join(soil, free, 1e-4), 2);
  EXPECT_EQ(soil.nodes.size(), 6);
  points_to_grid(soil.points, soil.weights, soil.nodes);
  EXPECT_NEAR(total(), mass, 1e-14 * mass);
  for (const int column : {1, 2}) {  // nodes of the 4 x 4 grid: row 2 joined row 1 of its column
    EXPECT_EQ(soil.nodes.active[8 + column], soil.nodes.active[4 + column]);
  }
}

TEST(LightNodes, nodes_of_walls_stay) {
  SoilPatch<2> soil(CellType::quad4, 1);
  soil.add({0.5, 1e-6});
  soil.to_grid();
  const mpm::WallConditions<2> roof(soil.grid, {{"top", false, "here", {}}});
  EXPECT_EQ(join(soil, roof, 1e-4), 0);
  const mpm::WallConditions<2> floor(soil.grid, {{"bottom", false, "here", {}}});
  EXPECT_EQ(join(soil, floor, 1e-4), 0);
  const mpm::WallConditions<2> free(soil.grid, {});
  EXPECT_EQ(join(soil, free, 1e-4), 2);
}

/// The column settles by a hair into points just above a row of nodes, and the steps go on.
TEST(QuasiStatic, steps_with_joined_nodes) {
  Json json = box_of_soil(soft_soil(), "quad4", 4);
  // a body whose uppermost points start 1e-6 above the row of nodes at y = 0.75
  json["bodies"][0]["mesh"] = box({0, 0}, {0.5, 0.750001 / 0.875}, {2, 4}, "quad4");
  json["bodies"][0]["points_per_cell"] = 1;
  json["gravity"] = {0, -1e-3};
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 1, 1);
  EXPECT_EQ(solver->summary().at("small_cuts").at("joined_nodes"), 1);  // of three, walls hold two
  EXPECT_EQ(largest_motion(solver->points()), 0);
}

}  // namespace
}  // namespace gabion::test::test_quasi_static
