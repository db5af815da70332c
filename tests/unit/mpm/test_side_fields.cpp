// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_side_fields {
namespace {

struct ThinWall {
  std::string basis = "linear";
  double thickness = 0, offset = 0;  // by the cell
  std::string scheme = "explicit";
  std::string locking = "none";
  double dt = 2e-4;
};

constexpr double h = 0.1;

/// Impulses on the left and the right face of a wall up to 0.02 s. Soil of 3 m/s comes from the
/// left, soil of 1 m/s from the right.
std::array<double, 2> impulses(const ThinWall& given, bool with_left, bool with_right) {
  const double left = 1 + given.offset * h, right = left + given.thickness * h;
  const Json material = elastic_soil("neo_hookean", 1e6, 0.3, 1500);
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {2, 0.8}, {20, 8}, "quad4")},
               {"basis", given.basis},
               {"locking", {{"method", given.locking}}},
               {"walls", {wall("bottom", "slip")}},
               {"rigid_walls",
                {{{"name", "left"},
                  {"method", "facets"},
                  {"surface", {{"polyline", {{left, 0.75}, {left, -0.1}}}, {"spacing", h}}}},
                 {{"name", "right"},
                  {"method", "facets"},
                  {"surface", {{"polyline", {{right, -0.1}, {right, 0.75}}}, {"spacing", h}}}}}}};
  json["bodies"] = Json::array();
  if (given.scheme == "explicit") {
    json["time_integration"] = {{"scheme", "explicit"}};
  } else {
    json["newton"] = exact_newton;
  }
  if (with_left) {
    json["bodies"].push_back(
        body("from_left", box({left - 0.4, 0}, {left, 0.4}, {4, 4}, "quad4"), 4, material, {3, 0}));
  }
  if (with_right) {
    json["bodies"].push_back(body(
        "from_right", box({right, 0}, {right + 0.4, 0.4}, {4, 4}, "quad4"), 4, material, {-1, 0}));
  }
  const auto solver = make_mpm(json);
  std::array<double, 2> sum{};
  for (int n = 1; n <= std::lround(0.02 / given.dt); ++n) {
    run_steps(*solver, given.dt, 1, n);
    sum[0] += given.dt * probe(*solver, "left.fx");
    sum[1] += given.dt * probe(*solver, "right.fx");
  }
  return sum;
}

/// The impulse on each face of the wall is that with the soil of this face alone.
void expect_as_alone(const ThinWall& given) {
  const auto both = impulses(given, true, true);
  const double left = impulses(given, true, false)[0], right = impulses(given, false, true)[1];
  const auto where = testing::Message()
                     << given.basis << " " << given.scheme << " " << given.locking << ", thickness "
                     << given.thickness << ", offset " << given.offset;
  EXPECT_GT(left, 1) << where;
  EXPECT_LT(right, -1) << where;
  EXPECT_NEAR(both[0], left, 1e-9 * left) << where;
  EXPECT_NEAR(both[1], right, 1e-9 * -right) << where;
}

TEST(SideFields, each_side_of_a_thin_wall_is_as_if_alone) {
  for (const char* basis : {"linear", "gimp", "bspline"}) {
    for (const double thickness : {0.0, 0.25, 0.5, 1.0, 1.5}) {
      for (const double offset : {0.0, 0.25, 0.5}) {
        expect_as_alone({.basis = basis, .thickness = thickness, .offset = offset});
      }
    }
  }
}

TEST(SideFields, implicit_steps_and_averaged_volumes) {
  for (const char* basis : {"linear", "gimp", "bspline"}) {
    expect_as_alone({.basis = basis, .thickness = 0.5, .scheme = "implicit", .dt = 2e-3});
    expect_as_alone({.basis = basis, .thickness = 0.25, .offset = 0.25, .locking = "fbar"});
  }
}

/// Impulses to 0.02 s on the outer and the inner faces of a wall with a corner, as an angle wall
/// has, whose ends are far. Soil comes to the inner corner, and to both outer faces.
/// @param outer, inner  share of the speed of the soil there, 0: none is there
std::array<Vector<2>, 2> impulses_at_corner(const ThinWall& given, double outer, double inner) {
  const double x = 0.8 + given.offset * h, y = 0.7 + given.offset * h, t = given.thickness * h;
  const Json material = elastic_soil("neo_hookean", 1e6, 0.3, 1500);
  const auto face = [](const std::string& name, const Json& line) {
    return Json{
        {"name", name}, {"method", "facets"}, {"surface", {{"polyline", line}, {"spacing", h}}}};
  };
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {1.6, 1.6}, {16, 16}, "quad4")},
               {"basis", given.basis},
               {"time_integration", {{"scheme", "explicit"}}},
               {"rigid_walls",
                {face("outer", {{x, 1.7}, {x, y}, {1.7, y}}),
                 face("inner", {{1.7, y + t}, {x + t, y + t}, {x + t, 1.7}})}},
               {"bodies", Json::array()}};
  const auto add = [&](const std::string& name, double left, double low, Vector<2> v) {
    json["bodies"].push_back(body(name, box({left, low}, {left + 0.4, low + 0.4}, {4, 4}, "quad4"),
                                  4, material, {v[0], v[1]}));
  };
  if (outer > 0) {
    add("beside", x - 0.4, y, {3 * outer, 0});
    add("below", x, y - 0.4, {0, 2 * outer});
  }
  if (inner > 0) add("within", x + t, y + t, {-inner, -2 * inner});
  const auto solver = make_mpm(json);
  std::array<Vector<2>, 2> sum{Vector<2>::Zero(), Vector<2>::Zero()};
  for (int n = 1; n <= std::lround(0.02 / given.dt); ++n) {
    run_steps(*solver, given.dt, 1, n);
    for (int k = 0; k < 2; ++k) {
      const std::string name = k == 0 ? "outer" : "inner";
      sum[k] += given.dt * Vector<2>(probe(*solver, name + ".fx"), probe(*solver, name + ".fy"));
    }
  }
  return sum;
}

/// The impulse on each face is the same when the soil at the other one is slower by 40 %, and
/// nearly that without other soil.
TEST(SideFields, sides_of_a_corner_do_not_act_on_each_other) {
  for (const char* basis : {"linear", "gimp", "bspline"}) {
    for (const double thickness : {0.0, 0.5, 1.0}) {
      for (const double offset : {0.0, 0.25}) {
        const ThinWall given = {.basis = basis, .thickness = thickness, .offset = offset};
        const auto both = impulses_at_corner(given, 1, 1);
        const Vector<2> outer = impulses_at_corner(given, 1, 0.6)[0];
        const Vector<2> inner = impulses_at_corner(given, 0.6, 1)[1];
        const Vector<2> alone = impulses_at_corner(given, 0, 1)[1];
        const auto where = testing::Message()
                           << basis << ", thickness " << thickness << ", offset " << offset << ": "
                           << both[0].transpose() << " for " << outer.transpose() << ", "
                           << both[1].transpose() << " for " << inner.transpose();
        EXPECT_GT(outer.minCoeff(), 1) << where;
        EXPECT_LT(inner.maxCoeff(), -1) << where;
        const double bound = thickness == 0 ? 1e-9 : 0.005;
        EXPECT_LT((both[0] - outer).norm(), bound * outer.norm()) << where;
        EXPECT_LT((both[1] - inner).norm(), bound * inner.norm()) << where;
        EXPECT_LT((both[1] - alone).norm(), 0.03 * alone.norm()) << where;
      }
    }
  }
}

/// Impulse in z on the lower and the upper face of a plate in space, of half a cell.
double impulse_in_space(const std::string& basis, bool with_lower, bool with_upper) {
  const Json material = elastic_soil("neo_hookean", 1e6, 0.3, 1500);
  Json json = {{"dimension", 3},
               {"grid", box({0, 0, 0}, {0.4, 0.4, 1.2}, {4, 4, 12}, "hex8")},
               {"basis", basis},
               {"time_integration", {{"scheme", "explicit"}}},
               {"rigid_walls",
                {{{"name", "plate"},
                  {"method", "facets"},
                  {"surface",
                   {{"mesh", box({0, 0, 0.6}, {0.4, 0.4, 0.65}, {4, 4, 1}, "hex8")},
                    {"groups", {"bottom", "top"}}}}}}},
               {"bodies", Json::array()}};
  if (with_lower) {
    json["bodies"].push_back(body("lower", box({0.1, 0.1, 0.4}, {0.3, 0.3, 0.6}, {2, 2, 2}, "hex8"),
                                  8, material, {0, 0, 3}));
  }
  if (with_upper) {
    json["bodies"].push_back(body("upper",
                                  box({0.1, 0.1, 0.65}, {0.3, 0.3, 0.85}, {2, 2, 2}, "hex8"), 8,
                                  material, {0, 0, -1}));
  }
  const auto solver = make_mpm(json);
  double sum = 0;
  for (int n = 1; n <= 40; ++n) {
    run_steps(*solver, 2e-4, 1, n);
    sum += 2e-4 * probe(*solver, "plate.fz");
  }
  return sum;
}

TEST(SideFields, in_space) {
  for (const char* basis : {"linear", "gimp", "bspline"}) {
    const double lower = impulse_in_space(basis, true, false);
    const double upper = impulse_in_space(basis, false, true);
    EXPECT_GT(lower, 1) << basis;
    EXPECT_LT(upper, -1) << basis;
    EXPECT_NEAR(impulse_in_space(basis, true, true), lower + upper, 1e-6 * lower) << basis;
  }
}

/// Soil that goes over the crest keeps its mass, and gives away no momentum but to the wall.
TEST(SideFields, soil_over_the_crest_keeps_its_momentum) {
  for (const char* basis : {"linear", "gimp", "bspline"}) {
    const Json material = elastic_soil("neo_hookean", 2e5, 0.3, 1500);
    const auto solver = make_mpm(
        {{"dimension", 2},
         {"grid", box({0, 0}, {2.4, 1}, {24, 10}, "quad4")},
         {"basis", basis},
         {"walls", {wall("bottom", "slip")}},
         {"time_integration", {{"scheme", "explicit"}}},
         {"rigid_walls",
          {{{"name", "wall"},
            {"method", "facets"},
            {"friction", 0},
            {"surface",
             {{"polyline", {{1.05, -0.1}, {1.05, 0.25}, {1, 0.25}, {1, -0.1}}}, {"spacing", h}}}}}},
         {"bodies",
          {body("low", box({0.5, 0}, {1, 0.2}, {5, 2}, "quad4"), 4, material, {2, 0}),
           body("high", box({0.5, 0.3}, {1, 0.6}, {5, 3}, "quad4"), 4, material, {4, 0}),
           body("behind", box({1.05, 0}, {1.4, 0.2}, {4, 2}, "quad4"), 4, material)}}});
    const double mass = probe(*solver, "mass"), momentum = probe(*solver, "momentum_x");
    double impulse = 0;
    for (int n = 1; n <= 150; ++n) {
      run_steps(*solver, 4e-4, 1, n);
      impulse += 4e-4 * probe(*solver, "wall.fx");
    }
    EXPECT_DOUBLE_EQ(probe(*solver, "mass"), mass) << basis;
    EXPECT_GT(impulse, 10) << basis;
    EXPECT_NEAR(probe(*solver, "momentum_x") + impulse, momentum, 1e-9 * momentum) << basis;
  }
}

/// Soil at rest on both sides of a wall of 0.8 cells that creeps away: points that reach into a cell
/// by next to nothing hold no node of the slip wall below. Such a node joins its neighbour along
/// the wall, which has the force of the two once.
TEST(SideFields, a_light_node_on_a_wall_of_the_grid_joins_along_it) {
  const auto wet = [](const std::string& name, double from, double to) {
    Json soil = body(name, box({from, 0}, {to, 1}, {8, 8}, "quad4"), 4,
                     elastic_soil("linear_elastic", 1e7, 0.3, 2000));
    soil["water"] = {{"porosity", 0.4}, {"permeability", 1e-4}};
    soil["initial_stress"] = {{"k0", 0.5}, {"surface", 1.0}, {"water_table", 1.2}};
    return soil;
  };
  const auto solver = make_mpm(
      {{"dimension", 2},
       {"grid", box({0, 0}, {2.125, 2}, {17, 16}, "quad4")},
       {"analysis", "quasi_static"},
       {"gravity", {0, -9.81}},
       {"walls", {wall("left", "slip"), wall("bottom", "slip"), wall("right", "slip")}},
       {"rigid_walls",
        {{{"name", "wall"},
          {"friction", 0},
          {"motion", {{"velocity", {5e-7, 0}}}},
          {"surface",
           {{"polyline", {{1.1, 0}, {1.1, 1.6}, {1, 1.6}, {1, 0}}}, {"spacing", 0.0625}}}}}},
       {"pools",
        {{{"table", {{0, 1.2}, {10, 1.5}}}, {"to", 1.0}}, {{"level", 1.2}, {"from", 1.1}}}},
       {"bodies", {wet("left", 0, 1), wet("right", 1.1, 2.125)}}});
  int most = 0;
  for (int n = 1; n <= 12; ++n) {
    InterfaceValues sent;
    const StepRequest request{n, 0, n - 1.0, 1.0};
    most = std::max(most, solver->solve_step(request, {}, sent).newton_iterations);
    solver->accept_step(request, true);
  }
  EXPECT_LE(most, 5);
  const double weight = 2 * 2000 * 9.81;
  EXPECT_LT(std::abs(probe(*solver, "momentum_error_y")), 1e-7 * 12 * weight);
}

}  // namespace
}  // namespace gabion::test::test_side_fields
