// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_outflow {
namespace {

/// A heavy elastic block that slides on a smooth bed, settles under its weight as it goes, and
/// leaves over the edge on the right.
Json sliding(int dim, const std::string& basis, const std::string& transfer = "flip") {
  std::vector<double> low(dim, 0.0), high(dim, 1.0), from(dim, 0.0), to(dim, 0.5), v(dim, 0.0);
  std::vector<double> gravity(dim, 0.0);
  high[0] = 2;
  from[0] = 1;
  to[0] = 1.75;
  v[0] = 3;
  gravity[dim - 1] = -9.81;
  std::vector<int> cells(dim, 4), parts(dim, 2);
  cells[0] = 8;
  parts[0] = 3;
  const std::string type = dim == 2 ? "quad4" : "hex8";
  Json walls = {wall("bottom", "slip"), wall("right", "outflow")};
  if (dim == 3) walls.push_back(wall("front", "slip"));
  std::vector<std::vector<double>> edge = {{2, 0}, {2, 1}};
  if (dim == 3) edge = {{2, 0, 0}, {2, 1, 0}, {2, 0, 1}};
  return {{"dimension", dim},
          {"grid", box(low, high, cells, type)},
          {"basis", basis},
          {"gravity", gravity},
          {"walls", walls},
          {"transfer", {{"method", transfer}}},
          {"bodies",
           {body("block", box(from, to, parts, type), dim == 2 ? 4 : 8,
                 elastic_soil("linear_elastic", 1e6, 0.3, 1000), v)}},
          {"gauges", {{{"name", "edge"}, {"corners", edge}}}},
          {"newton", {{"residual_tolerance", 1e-12}, {"increment_tolerance", 1e-12}}}};
}

void take_steps(Solver& solver, double dt, int first, int count) {
  InterfaceValues sent;
  for (int n = first; n < first + count; ++n) {
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    solver.solve_step(request, {}, sent);
    solver.accept_step(request, true);
  }
}

/// Mass, momentum and energy of what has gone stay in the balances, though it was under stress and
/// did not fall freely.
void expect_balances(int dim, const std::string& basis, const std::string& transfer) {
  SCOPED_TRACE(std::to_string(dim) + basis + transfer);
  const auto solver = make_mpm(sliding(dim, basis, transfer));
  const double mass = probe(*solver, "mass"), energy = 0.5 * mass * 9;
  take_steps(*solver, 0.005, 1, 40);
  const double removed = probe(*solver, "removed_mass");
  EXPECT_GT(removed, 0.3 * mass);
  EXPECT_LT(removed, 0.9 * mass);
  EXPECT_NEAR(probe(*solver, "mass") + removed, mass, 1e-12 * mass);
  EXPECT_NEAR(probe(*solver, "removed.right.mass"), removed, 1e-12 * mass);
  EXPECT_NEAR(probe(*solver, "edge.passed_mass"), removed, 1e-12 * mass);
  EXPECT_NEAR(probe(*solver, "edge.passed_momentum_x"), probe(*solver, "removed_momentum_x"),
              1e-12 * mass);
  // Soil that leaves under stress takes half of its last acceleration along, soil that stays keeps
  // the other half of the reaction.
  EXPECT_NEAR(probe(*solver, "momentum_x") + probe(*solver, "removed_momentum_x"), 3 * mass,
              2e-3 * 3 * mass);
  EXPECT_GT(probe(*solver, "removed_elastic_energy"), 1e-4 * energy);
  EXPECT_NEAR(probe(*solver, "removed_kinetic_energy"), 0.5 * removed * 9, 0.2 * energy);
  for (int d = 0; d < dim; ++d) {
    const std::string axis(1, "xyz"[d]);
    EXPECT_NEAR(probe(*solver, "momentum_error_" + axis), 0, 1e-10 * mass) << axis;
  }
  EXPECT_NEAR(probe(*solver, "energy_balance"), 0, 1e-10 * energy);
  EXPECT_EQ(solver->summary()["removed_mass"]["right"], probe(*solver, "removed.right.mass"));
}

TEST(Outflow, what_leaves_stays_in_the_balances) {
  expect_balances(2, "linear", "flip");
  expect_balances(2, "gimp", "flip");
  expect_balances(2, "linear", "tpic");
  expect_balances(3, "linear", "flip");
}

/// Soil that has left takes the forces of facets on it out of the scheme, too. The bed lies off the
/// lines of the grid: forces on nodes of next to no mass are lost to 1e-8.
TEST(Outflow, momentum_over_the_edge_of_facets) {
  for (const Json& scheme : {trapezoid, Json{{"scheme", "bossak"}, {"alpha", -0.3}}}) {
    Json json = sliding(2, "gimp");
    json["time_integration"] = scheme;
    json["walls"] = {wall("right", "outflow")};
    json["bodies"][0]["mesh"] = box({1, 0.2}, {1.75, 0.7}, {3, 2}, "quad4");
    json["rigid_walls"] = {
        {{"name", "bed"},
         {"surface", {{"polyline", {{2.5, 0.2}, {-0.5, 0.2}}}, {"spacing", 0.1}}},
         {"friction", 0.3}}};
    const auto solver = make_mpm(json);
    const double momentum = probe(*solver, "momentum_x");
    take_steps(*solver, 0.005, 1, 40);
    EXPECT_GT(probe(*solver, "removed_mass"), 100);
    EXPECT_GT(probe(*solver, "contact_friction"), 0);
    EXPECT_NEAR(probe(*solver, "momentum_error_x"), 0, 1e-11 * momentum) << scheme;
    EXPECT_NEAR(probe(*solver, "momentum_error_y"), 0, 1e-11 * momentum) << scheme;
  }
}

/// The side does not reflect: without gravity the block leaves as if the grid went on.
TEST(Outflow, a_free_side_does_not_hold_soil_back) {
  Json json = sliding(2, "gimp");
  json["gravity"] = {0, 0};
  const auto solver = mpm_solver<2>(json);
  take_steps(*solver, 0.005, 1, 40);
  EXPECT_GT(probe(*solver, "removed_mass"), 100);
  for (const auto& v : solver->points().v) EXPECT_LT((v - Vector<2>(3, 0)).norm(), 1e-9);
}

TEST(Outflow, soil_that_leaves_elsewhere_is_an_error) {
  Json json = sliding(2, "linear");
  json["bodies"][0]["velocity"] = {-6, 0};
  json["bodies"][0]["mesh"] = box({0.25, 0}, {1, 0.5}, {3, 2}, "quad4");
  const auto solver = make_mpm(json);
  expect_error<ConvergenceError>([&] { take_steps(*solver, 0.01, 1, 20); },
                                 {"side \"left\" (no wall)", "\"outflow\""});
}

/// A point that leaves at a corner counts for the side that its path meets first.
TEST(Outflow, each_side_has_its_mass) {
  Json json = sliding(2, "linear");
  json["outside"] = "remove";
  json["gravity"] = {0, 0};
  json["walls"] = Json::array();
  json["bodies"] = {body("right", box({1.25, 0.25}, {1.75, 0.5}, {2, 1}, "quad4"), 4,
                         elastic_soil("linear_elastic", 1e3, 0, 1000), {6, 3.2}),
                    body("up", box({0.25, 0.5}, {0.5, 0.75}, {1, 1}, "quad4"), 4,
                         elastic_soil("linear_elastic", 1e3, 0, 2000), {-1, 5}),
                    body("rest", box({0, 0}, {0.25, 0.25}, {1, 1}, "quad4"), 4,
                         elastic_soil("linear_elastic", 1e3, 0, 1000))};
  const auto solver = make_mpm(json);
  take_steps(*solver, 0.01, 1, 12);
  EXPECT_NEAR(probe(*solver, "removed.right.mass"), 125, 1e-9);
  EXPECT_NEAR(probe(*solver, "removed.top.mass"), 125, 1e-9);
  EXPECT_EQ(probe(*solver, "removed.left.mass"), 0);
}

TEST(Outflow, goes_on_from_a_saved_state_to_the_bit) {
  const Json json = sliding(2, "gimp");
  const auto through = make_mpm(json), first = make_mpm(json), second = make_mpm(json);
  take_steps(*through, 0.005, 1, 40);
  take_steps(*first, 0.005, 1, 25);
  EXPECT_GT(probe(*first, "removed_mass"), 0);
  second->load_state(first->save_state());
  take_steps(*second, 0.005, 26, 15);
  EXPECT_EQ(second->probes(), through->probes());
}

/// @returns whether a column is empty
bool is_empty(const Solver& solver, const std::string& name) {
  return std::isnan(probe(solver, name));
}

/// A block that is out of the grid at 0.33 s, with a probe at its front that leaves at 0.1 s.
Json leaving(const std::string& basis) {
  Json json = sliding(2, basis);
  json["gravity"] = {0, 0};
  json["probes"] = {{{"name", "tip"}, {"point", {1.7, 0.2}}}};
  return json;
}

TEST(Outflow, a_probe_that_has_left_is_empty_and_the_run_goes_on) {
  const auto solver = make_mpm(leaving("linear"));
  take_steps(*solver, 0.01, 1, 7);
  EXPECT_NEAR(probe(*solver, "tip.ux"), 0.21, 1e-9);
  take_steps(*solver, 0.01, 8, 10);
  EXPECT_TRUE(is_empty(*solver, "tip.ux"));
  EXPECT_TRUE(is_empty(*solver, "tip.uy"));
  EXPECT_GT(probe(*solver, "mass"), 100);
  const double left_at = solver->summary()["probes_left_at"]["tip"];
  EXPECT_GT(left_at, 0.08);
  EXPECT_LT(left_at, 0.12);
  EXPECT_FALSE(solver->summary().contains("soil_left_at"));
}

/// Whatever the steps and the surfaces are: no soil is left, no force acts, the balances stay.
void expect_goes_on_without_soil(Json json) {
  const auto solver = make_mpm(json);
  const double mass = probe(*solver, "mass");
  take_steps(*solver, 0.01, 1, 45);
  const double left_at = solver->summary()["soil_left_at"];
  EXPECT_GT(left_at, 0.3);
  EXPECT_LT(left_at, 0.4);
  EXPECT_EQ(solver->summary()["points"], 0);
  EXPECT_EQ(probe(*solver, "mass"), 0);
  EXPECT_NEAR(probe(*solver, "removed_mass"), mass, 1e-9 * mass);
  EXPECT_NEAR(probe(*solver, "removed_momentum_x"), 3 * mass, 1e-6 * mass);
  EXPECT_NEAR(probe(*solver, "energy_balance"), 0, 1e-9 * mass);
  EXPECT_NEAR(probe(*solver, "momentum_error_x"), 0, 1e-9 * mass);
  EXPECT_TRUE(is_empty(*solver, "front"));
  EXPECT_TRUE(is_empty(*solver, "tip.ux"));
  EXPECT_EQ(probe(*solver, "edge.mass_flux"), 0);
  EXPECT_EQ(probe(*solver, "bed.fy"), 0);
  // A run that goes on from there, on these ranks.
  const auto second = make_mpm(json);
  second->load_state(solver->save_state());
  take_steps(*solver, 0.01, 46, 3);
  take_steps(*second, 0.01, 46, 3);
  EXPECT_EQ(second->summary()["soil_left_at"], left_at);
  EXPECT_EQ(probe(*second, "removed_mass"), probe(*solver, "removed_mass"));
  EXPECT_TRUE(is_empty(*second, "tip.ux"));
}

TEST(Outflow, a_run_goes_on_without_soil) {
  const Json bed = {{"name", "bed"},
                    {"surface", {{"polyline", {{3, 0}, {-1, 0}}}, {"spacing", 0.25}}},
                    {"friction", 0.2}};
  for (const std::string basis : {"linear", "gimp", "bspline"}) {
    SCOPED_TRACE(basis);
    Json json = leaving(basis);
    json["rigid_walls"] = {bed};
    json["step_control"] = Json::object();
    expect_goes_on_without_soil(json);
    json["rigid_walls"][0]["method"] = "boundary_points";
    expect_goes_on_without_soil(json);
    json["rigid_walls"] = {bed};
    json["time_integration"] = {{"scheme", "explicit"}};
    json.erase("newton");
    expect_goes_on_without_soil(json);
  }
}

TEST(Outflow, an_interface_gets_no_force_of_soil_that_has_left) {
  Json json = leaving("gimp");
  json["interfaces"] = {
      {{"name", "plate"}, {"surface", {{"polyline", {{2, -0.5}, {2, -1}}}, {"spacing", 0.25}}}}};
  json["grid"] = box({0, -1}, {2, 1}, {8, 8}, "quad4");
  const auto solver = make_mpm(json);
  take_steps(*solver, 0.01, 1, 40);
  InterfaceValues sent;
  const auto report = solver->solve_step({41, 0, 0.4, 0.01}, {}, sent);
  EXPECT_FALSE(report.interface_active);
  EXPECT_EQ(sent.at("plate"), std::vector<double>(6, 0.0));
}

/// Soil that stays is as it is without the body that leaves.
TEST(Outflow, a_body_that_has_left_is_empty) {
  Json json = leaving("linear");
  json["bodies"].push_back(body("rest", box({0, 0}, {0.25, 0.25}, {1, 1}, "quad4"), 4,
                                elastic_soil("linear_elastic", 1e6, 0.3, 1000)));
  const auto solver = make_mpm(json);
  take_steps(*solver, 0.01, 1, 40);
  EXPECT_TRUE(is_empty(*solver, "front_block"));
  EXPECT_NEAR(probe(*solver, "front_rest"), 0.1972, 1e-3);
  EXPECT_NEAR(probe(*solver, "mass"), 62.5, 1e-9);
}

TEST(Outflow, bad_input) {
  Json json = sliding(2, "linear");
  json["walls"][1]["motion"] = {{"velocity", {1, 0}}};
  expect_error<ConfigError>([&] { make_mpm(json); }, {"/walls/1/motion"});
  json = sliding(2, "linear");
  json["walls"][1]["group"] = "outlet";
  expect_error<ConfigError>([&] { make_mpm(json); }, {"/walls/1/group", "outlet"});
}

}  // namespace
}  // namespace gabion::test::test_outflow
