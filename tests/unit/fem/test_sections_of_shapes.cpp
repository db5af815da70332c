// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/mechanics/ranks/sum.hpp"
#include "tests/unit/fem/line_scene.hpp"

namespace gabion::test::test_sections_of_shapes {
namespace {

constexpr double stiff = 1e14;  // Young's modulus that leaves no displacement to speak of [Pa]
constexpr double slope = std::numbers::pi / 6;
const Vector<2> along(std::cos(slope), std::sin(slope)), across(-std::sin(slope), std::cos(slope));

/// A bar of 4 m by 1 m that rises by `slope` from the origin, with `columns` x 2 cells whose inner
/// nodes are displaced; with a bow its axis is a parabola.
GmshText inclined_bar(int columns, double bow) {
  GmshText file{.groups = {{1, 1, "foot"}}, .entities = {{1, 1, {1}}}, .nodes = {}, .blocks = {}};
  std::vector<std::vector<int>> cells;
  for (int i = 0; i <= columns; ++i) {
    for (int j = 0; j <= 2; ++j) {
      double s = 4.0 * i / columns, t = 0.5 * j + bow * (4.0 * i / columns) * (4.0 * i / columns);
      if (j == 1 && i > 0 && i < columns)
        s += 0.08 * std::sin(7.0 * i), t += 0.1 * std::cos(3.0 * i);
      const Vector<2> x = s * along + t * across;
      file.nodes.push_back({x[0], x[1], 0});
    }
    for (int j = 1; j <= 2 && i > 0; ++j) {
      const int low = 3 * (i - 1) + j;
      cells.push_back({low, low + 3, low + 4, low + 1});
    }
  }
  file.blocks = {{1, 1, 1, {{1, 2}, {2, 3}}}, {2, 1, 3, cells}};
  return file;
}

Json bar_scene(const GmshText& bar, const std::string& file) {
  const auto& tip = bar.nodes.back();
  const Vector<2> place = 2.0 * along + 0.5 * across;
  return {{"dimension", 2},
          {"mesh", {{"file", file}}},
          {"material", elastic("neo_hookean", stiff, 0.3, 1000)},
          {"analysis", "static"},
          {"supports", {{{"group", "foot"}}}},
          {"loads", {{{"point", {tip[0], tip[1]}}, {"force", {3e4, -2e4}}}}},
          {"sections",
           {{{"name", "mid"}, {"point", {place[0], place[1]}}, {"normal", {along[0], along[1]}}}}},
          {"newton", {{"residual_tolerance", 1e-12}}}};
}

void solve_static(Solver& solver) {
  const StepRequest request{1, 0, 0, 1};
  InterfaceValues sent;
  solver.solve_step(request, {}, sent);
  solver.accept_step(request, true);
}

/// Straight and bowed, with planes on sides of cells and, with 9 columns, through their middles.
TEST(SectionsOfShapes, inclined_bars_of_distorted_cells) {
  for (const double bow : {0.0, 0.05}) {
    for (const int columns : {8, 9}) {
      SCOPED_TRACE(testing::Message() << bow << " " << columns);
      const GmshText bar = inclined_bar(columns, bow);
      const TemporaryMesh mesh(bar, rank_of(comm()));
      const Json scene = bar_scene(bar, mesh.path());
      const auto solver = fem_solver<2>(scene);
      solve_static(*solver);
      const Vector<2> force(3e4, -2e4);
      const double N = force.dot(along);
      const Vector<2> V = force - N * along;
      const Vector<2> tip(bar.nodes.back()[0], bar.nodes.back()[1]);
      const Vector<2> arm = tip - (2.0 * along + 0.5 * across);
      EXPECT_NEAR(probe(*solver, "mid.N"), N, 1e-3);
      EXPECT_NEAR(probe(*solver, "mid.V_x"), V[0], 1e-3);
      EXPECT_NEAR(probe(*solver, "mid.V_y"), V[1], 1e-3);
      EXPECT_NEAR(probe(*solver, "mid.M_z"), arm[0] * force[1] - arm[1] * force[0], 1e-2);
    }
  }
}

/// A pair of forces on the end of a post, and one along it at a corner.
Json twisted_post(const std::string& type) {
  return {{"dimension", 3},
          {"mesh", box_3d({1, 2, 4}, {1, 2, 4}, type)},
          {"material", elastic("neo_hookean", stiff, 0.3, 1000)},
          {"analysis", "static"},
          {"supports", {{{"group", "bottom"}}}},
          {"loads",
           {{{"point", {0.0, 0.0, 4.0}}, {"force", {-5e3, 0.0, 0.0}}},
            {{"point", {1.0, 2.0, 4.0}}, {"force", {5e3, 0.0, 0.0}}},
            {{"point", {1.0, 0.0, 4.0}}, {"force", {0.0, 0.0, -7e3}}}}},
          {"sections",
           {{{"name", "up"}, {"point", {0.5, 1.0, 2.0}}, {"normal", {0.0, 0.0, 1.0}}},
            {{"name", "down"}, {"point", {0.5, 1.0, 2.0}}, {"normal", {0.0, 0.0, -3.0}}}}},
          {"newton", {{"residual_tolerance", 1e-12}}}};
}

TEST(SectionsOfShapes, twisted_posts) {
  for (const std::string type : {"hex8", "tet4", "hex20", "tet10"}) {
    SCOPED_TRACE(type);
    const auto solver = fem_solver<3>(twisted_post(type));
    solve_static(*solver);
    EXPECT_NEAR(probe(*solver, "up.N"), -7e3, 1e-3);
    EXPECT_NEAR(probe(*solver, "up.V_x"), 0, 1e-3);
    EXPECT_NEAR(probe(*solver, "up.V_y"), 0, 1e-3);
    EXPECT_NEAR(probe(*solver, "up.V_z"), 0, 1e-3);
    EXPECT_NEAR(probe(*solver, "up.M_x"), 7e3, 1e-2);  // (0.5, -1, 2) x (0, 0, -7e3)
    EXPECT_NEAR(probe(*solver, "up.M_y"), 3.5e3, 1e-2);
    EXPECT_NEAR(probe(*solver, "up.M_z"), -1e4, 1e-2);
    // Seen from the other side force and moment change their signs, tension stays what it is.
    EXPECT_NEAR(probe(*solver, "down.N"), -7e3, 1e-3);
    EXPECT_NEAR(probe(*solver, "down.M_z"), 1e4, 1e-2);
  }
}

Json shaken_beam() {
  Json material = elastic("von_mises", 1e8, 0.3, 1000);
  material["yield_stress"] = 1e5;
  material["hardening_modulus"] = 1e7;
  return {{"dimension", 2},
          {"mesh", box_2d({2, 0.5}, {8, 2})},
          {"material", material},
          {"gravity", {0.0, -9.81}},
          {"supports", {{{"group", "left"}}}},
          {"loads", {{{"group", "right"}, {"force", {0.0, -3e4}}}}},
          {"sections", {{{"name", "mid"}, {"point", {1.0, 0.25}}, {"normal", {1.0, 0.0}}}}}};
}

TEST(SectionsOfShapes, a_run_from_a_saved_state_has_the_same_bits) {
  const auto whole = fem_solver<2>(shaken_beam()), second = fem_solver<2>(shaken_beam());
  for (int n = 1; n <= 10; ++n) advance(*whole, n, 0.002);
  second->load_state(whole->save_state());
  EXPECT_EQ(probe(*whole, "mid.M_z"), probe(*second, "mid.M_z"));
  for (int n = 11; n <= 20; ++n) {
    for (auto* solver : {whole.get(), second.get()}) advance(*solver, n, 0.002);
  }
  EXPECT_GT(probe(*whole, "plastic_work"), 0);
  EXPECT_LT(probe(*whole, "mid.M_z"), -1e3);
  EXPECT_EQ(whole->probes(), second->probes());
}

}  // namespace
}  // namespace gabion::test::test_sections_of_shapes
