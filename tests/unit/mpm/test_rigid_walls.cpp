// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "mpm_solver/contact/rigid_motion.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_rigid_walls {
namespace {

template <int dim>
mpm::RigidMotion<dim> read(const Json& json) {
  return mpm::read_rigid_motion<dim>(ConfigReader(json, "mpm.json", mpm::rigid_motion_keys()));
}

TEST(RigidMotion, velocity_and_table) {
  const std::vector<Vector<2>> X = {{1, 2}, {3, 4}};
  EXPECT_EQ(read<2>({{"velocity", {0.5, -1}}}).displacement(X, 2),
            (std::vector<double>{1, -2, 1, -2}));
  const auto table = read<2>({{"table", {{0, 0, 0}, {1, 2, 0}, {3, 2, 4}}}});
  EXPECT_EQ(table.translation(0), Vector<2>(0, 0));
  EXPECT_EQ(table.translation(0.5), Vector<2>(1, 0));
  EXPECT_EQ(table.translation(1), Vector<2>(2, 0));
  EXPECT_EQ(table.translation(2), Vector<2>(2, 2));
  EXPECT_EQ(table.translation(9), Vector<2>(2, 4));
  EXPECT_EQ(read<3>(Json::object()).translation(1), (Vector<3>::Zero()));
}

TEST(RigidMotion, rotation_about_a_centre_that_moves) {
  const Json turn = {{"centre", {1, 0}}, {"rate", M_PI / 2}};
  const auto u = read<2>({{"velocity", {0, 1}}, {"rotation", turn}}).displacement({{2, 0}}, 1);
  EXPECT_NEAR(u[0], -1, 1e-15);  // (2, 0) goes to (1, 1), and 1 upwards
  EXPECT_NEAR(u[1], 2, 1e-15);
  const Json about_x = {{"centre", {0, 0, 0}}, {"rate", M_PI / 2}, {"axis", {3, 0, 0}}};
  const auto w = read<3>({{"rotation", about_x}}).displacement({{5, 1, 0}}, 1);
  EXPECT_NEAR(w[0], 0, 1e-15);
  EXPECT_NEAR(w[1], -1, 1e-15);
  EXPECT_NEAR(w[2], 1, 1e-15);
}

TEST(RigidMotion, tables_that_do_not_ascend_are_refused_with_their_row) {
  const auto refused = [](const Json& rows, std::string_view row, std::string_view found) {
    expect_error<ConfigError>(
        [&] {
          read<2>({{"table", rows}});
        },
        {row, found, "allowed: times that start with 0 and ascend"});
  };
  refused({{0.5, 0, 0}, {1, 2, 0}}, "/table/0:", "found time 0.5,");
  refused({{0, 0, 0}, {1, 2, 0}, {1, 3, 0}}, "/table/2:", "found time 1 after 1,");
  refused({{0, 0, 0}, {2, 2, 0}, {1, 3, 0}, {3, 3, 0}}, "/table/2:", "found time 1 after 2,");
}

/// Soil on a fixed floor and a wall on its right.
Json walled() {
  return {{"dimension", 2},
          {"grid", box({0, 0}, {2, 1}, {8, 4}, "quad4")},
          {"basis", "linear"},
          {"walls", {wall("bottom", "fixed")}},
          {"bodies",
           {body("soil", box({0.5, 0}, {1, 0.5}, {4, 4}, "quad4"), 4,
                 elastic_soil("neo_hookean", 1e5, 0.3, 1000))}},
          {"newton", exact_newton},
          {"rigid_walls",
           {{{"name", "ram"},
             {"surface", {{"polyline", {{1, 0.5}, {1, 0}}}, {"spacing", 0.25}}},
             {"method", "boundary_points"},
             {"friction", 0.3},
             {"motion", {{"velocity", {-0.1, 0.02}}}}}}}};
}

void expect_refused(const Json& json, const std::vector<std::string_view>& parts) {
  expect_error<ConfigError>([&] { make_mpm(json); }, parts);
}

TEST(RigidWalls, bad_input) {
  const auto with = [](const Json& motion) {
    Json json = walled();
    json["rigid_walls"][0]["motion"] = motion;
    return json;
  };
  expect_refused(with({{"velocity", {1}}}), {"/rigid_walls/0/motion/velocity", "2 numbers"});
  expect_refused(with({{"speed", 1}}), {"/rigid_walls/0/motion/speed", "unknown"});
  expect_refused(with({{"velocity", {1, 0}}, {"table", {{0, 0, 0}}}}),
                 {"/rigid_walls/0/motion/table", "one of"});
  expect_refused(with({{"table", {{1, 0, 0}}}}),
                 {"/rigid_walls/0/motion/table/0", "found time 1,", "start with 0"});
  expect_refused(with({{"table", {{0, 0, 0}, {2, 1, 0}, {2, 1, 1}}}}),
                 {"/rigid_walls/0/motion/table/2", "found time 2 after 2", "ascend"});
  expect_refused(with({{"table", {{0, 1, 0}}}}), {"/rigid_walls/0/motion/table", "at the time 0"});
  expect_refused(with({{"table", Json::array()}}), {"/rigid_walls/0/motion/table", "one row"});
  expect_refused(with({{"rotation", {{"centre", {0, 0}}}}}),
                 {"/rigid_walls/0/motion/rotation/rate"});
  Json json = walled();
  json["rigid_walls"][0]["method"] = "mortar";
  expect_refused(json, {"/rigid_walls/0/method", "mortar", "boundary_points, facets"});
  json = walled();
  json["rigid_walls"].push_back(json["rigid_walls"][0]);
  expect_refused(json, {"/rigid_walls/1/name", "ram", "second time"});
}

TEST(RigidWalls, force_and_moment_are_probes_and_interfaces_do_not_see_walls) {
  const auto solver = make_mpm(walled());
  EXPECT_TRUE(solver->interfaces().empty());
  const auto names = solver->probe_names();
  EXPECT_EQ(std::vector<std::string>(names.end() - 3, names.end()),
            (std::vector<std::string>{"ram.fx", "ram.fy", "ram.mz"}));
  EXPECT_EQ(probe(*solver, "ram.fx"), 0);
  InterfaceValues sent;
  const StepRequest request{1, 0, 0, 0.01};
  const StepReport report = solver->solve_step(request, {}, sent);
  EXPECT_TRUE(sent.empty());
  EXPECT_FALSE(report.interface_active);
  EXPECT_EQ(report.details.at("ram.closed_points"), 4);
  EXPECT_GT(report.details.at("ram.max_penetration"), 0);
  EXPECT_FALSE(report.details.contains("closed_points"));
  solver->accept_step(request, true);
  EXPECT_GT(probe(*solver, "ram.fx"), 0);
  EXPECT_LT(probe(*solver, "ram.mz"), 0);  // a push to the right, above the origin
}

TEST(RigidWalls, moment_about_a_place) {
  Json json = walled();
  const auto about_origin = make_mpm(json);
  json["rigid_walls"][0]["moment_about"] = {0.5, 0.3};
  const auto about_place = make_mpm(json);
  for (auto* solver : {about_origin.get(), about_place.get()}) {
    InterfaceValues sent;
    const StepRequest request{1, 0, 0, 0.01};
    solver->solve_step(request, {}, sent);
    solver->accept_step(request, true);
  }
  const double fx = probe(*about_place, "ram.fx"), fy = probe(*about_place, "ram.fy");
  EXPECT_EQ(fx, probe(*about_origin, "ram.fx"));
  EXPECT_NEAR(probe(*about_place, "ram.mz"), probe(*about_origin, "ram.mz") - (0.5 * fy - 0.3 * fx),
              1e-12 * std::abs(fx));
}

/// The wall lies on a line of the grid; soil is in the cells of the higher or the lower number.
TEST(RigidWalls, soil_on_either_side_of_a_grid_line_is_felt) {
  for (const char* type : {"quad4", "tri3"}) {
    std::vector<double> force;
    for (const bool mirrored : {false, true}) {
      Json json = walled();
      json["grid"] = box({-1, 0}, {1, 1}, {8, 4}, type);
      json["grid"]["box"]["alternate"] = true;
      json["bodies"][0]["mesh"] = mirrored ? box({0, 0}, {0.5, 0.5}, {4, 4}, "quad4")
                                           : box({-0.5, 0}, {0, 0.5}, {4, 4}, "quad4");
      auto& ram = json["rigid_walls"][0];
      ram["surface"]["polyline"] = {{0, 0.5}, {0, 0}};
      ram["motion"]["velocity"] = {-0.1, 0};
      if (mirrored) {
        ram["surface"]["polyline"] = {{0, 0}, {0, 0.5}};
        ram["motion"]["velocity"] = {0.1, 0};
      }
      if (std::string(type) == "quad4") json["grid"]["box"].erase("alternate");
      const auto solver = make_mpm(json);
      run_steps(*solver, 0.01, 1);
      force.push_back(probe(*solver, "ram.fx"));
    }
    EXPECT_GT(force[0], 1) << type;
    EXPECT_NEAR(force[0], -force[1], 1e-8 * force[0]) << type;
  }
}

/// Nothing but contact that is open at first holds the block: each stiffness matrix of the first
/// steps is singular, and without friction those of all.
TEST(RigidWalls, a_block_at_rest_comes_to_lie_on_one) {
  for (const double friction : {0.0, 0.3}) {
    const Json json = {{"dimension", 2},
                       {"analysis", "quasi_static"},
                       {"grid", box({0, -0.5}, {2, 1}, {8, 6}, "quad4")},
                       {"gravity", {0, -10}},
                       {"gravity_ramp", {{"duration", 1}}},
                       {"bodies",
                        {body("block", box({0.5, 0}, {1.5, 0.5}, {4, 2}, "quad4"), 4,
                              elastic_soil("neo_hookean", 1e6, 0.3, 1000))}},
                       {"rigid_walls",
                        {{{"name", "bed"},
                          {"surface", {{"polyline", {{2, 0}, {0, 0}}}, {"spacing", 0.25}}},
                          {"friction", friction}}}}};
    const auto solver = mpm_solver<2>(json);
    for (int n = 1; n <= 5; ++n) {
      InterfaceValues sent;
      ASSERT_NO_THROW(solver->solve_step({n, 0, 0.2 * (n - 1), 0.2}, {}, sent)) << friction;
      solver->accept_step({n, 0, 0.2 * (n - 1), 0.2}, true);
      const double weight = 0.2 * n * 0.5 * 1000 * 10;
      EXPECT_NEAR(probe(*solver, "bed.fy"), -weight, 2e-5 * weight) << friction << ' ' << n;
      EXPECT_NEAR(probe(*solver, "bed.fx"), 0, 2e-5 * weight) << friction << ' ' << n;
    }
  }
}

/// Sand that collapses on a floor and along a side to which it sticks: it separates from the side,
/// and without a bound on the tangential traction there no step of any size would have a solution.
TEST(RigidWalls, sand_comes_off_walls_without_friction_coefficient) {
  constexpr double h = 0.005;
  Json sand = elastic_soil("mohr_coulomb", 840e3, 0.3, 2650);
  sand["friction_angle"] = 19.8;
  const auto rough = [&](const std::string& name, const Json& line) {
    return Json{{"name", name}, {"surface", {{"polyline", line}, {"spacing", h / 2}}}};
  };
  for (const auto& [columns, layers] : {std::pair{8, 4}, {12, 12}}) {
    const double top = (layers + 4) * h;
    const auto solver = mpm_solver<2>(
        {{"dimension", 2},
         {"grid", box({-2 * h, -2 * h}, {24 * h, top}, {26, layers + 6}, "quad4")},
         {"gravity", {0, -9.81}},
         {"time_integration", {{"scheme", "bossak"}, {"alpha", -0.3}}},
         {"bodies",
          {body("soil", box({0, 0}, {columns * h, layers * h}, {columns, layers}, "quad4"), 4,
                sand)}},
         {"rigid_walls",
          {rough("floor", {{30 * h, 0}, {-2 * h, 0}}), rough("side", {{0, -2 * h}, {0, top}})}}});
    ASSERT_NO_THROW(run_steps(*solver, 1e-3, 20)) << layers;
    EXPECT_LT(probe(*solver, "floor.fy"), 0);
    EXPECT_GT(probe(*solver, "momentum_x"), 0);
  }
}

}  // namespace
}  // namespace gabion::test::test_rigid_walls
