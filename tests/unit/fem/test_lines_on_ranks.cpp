// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "common/mechanics/ranks/sum.hpp"
#include "tests/unit/fem/line_scene.hpp"

namespace gabion::test::test_lines_on_ranks {
namespace {

/// Four squares in a row with a rope from each end to an anchor, one with a brake.
GmshText guyed_beam() {
  GmshText file{.groups = {{2, 1, "beam"}}, .entities = {{2, 1, {1}}}, .nodes = {}, .blocks = {}};
  std::vector<std::vector<int>> cells;
  for (int i = 0; i <= 4; ++i) {
    file.nodes.push_back({static_cast<double>(i), 0, 0});
    file.nodes.push_back({static_cast<double>(i), 1, 0});
    if (i > 0) cells.push_back({2 * i - 1, 2 * i + 1, 2 * i + 2, 2 * i});
  }
  file.blocks = {{2, 1, 3, cells}};
  file.nodes.insert(file.nodes.end(), {{-1, 3, 0}, {5, 3, 0}, {2, 3, 0}});
  const LineText ropes{.nodes = {},
                       .lines = {{"ropes", {{2, 11}, {6, 13}}}, {"braked", {{10, 12}}}},
                       .points = {{"anchors", {11, 12, 13}}}};
  ropes.add_to(file, 2);
  return file;
}

Json guyed_scene(const std::string& file) {
  Json ropes = line_material("cable", 1e9, 1e-4, 7000),
       braked = line_material("brake", 1e9, 1e-4, 7000);
  ropes["group"] = "ropes";
  braked["group"] = "braked";
  braked["brake_table"] = {{0, 3e3}, {1, 4e3}};
  Json beam = elastic("neo_hookean", 1e7, 0.3, 1000);
  beam["group"] = "beam";
  return {
      {"dimension", 2},
      {"mesh", {{"file", file}}},
      {"materials", {beam, ropes, braked}},
      {"gravity", {0, -10}},
      {"supports", {{{"group", "anchors"}, {"report_reaction", true}, {"report_moment", true}}}},
      {"point_masses", {{{"point", {2, 0}}, {"mass", 50}}}},
      {"springs", {{{"point", {0, 0}}, {"stiffness", {1e4, 1e4}}}}},
      {"probes", {{{"name", "M"}, {"point", {2, 0}}}}}};
}

void expect_equal(const Solver& found, const Solver& expected, double tolerance) {
  const auto names = expected.probe_names();
  EXPECT_EQ(found.probe_names(), names);
  const auto a = found.probes(), b = expected.probes();
  for (std::size_t i = 0; i < b.size(); ++i) {
    EXPECT_NEAR(a[i], b[i], tolerance * (1 + std::abs(b[i]))) << names[i];
  }
}

/// Lines belong to ranks as cells do.
TEST(LinesOnRanks, as_on_one) {
  const TemporaryMesh mesh(guyed_beam(), rank_of(comm()));
  const Json json = guyed_scene(mesh.path());
  const auto shared = fem_solver<2>(json), alone = fem_solver<2>(json, MPI_COMM_SELF);
  for (int n = 1; n <= 60; ++n) {
    for (auto* solver : {shared.get(), alone.get()}) advance(*solver, n, 0.005);
  }
  expect_equal(*shared, *alone, 1e-6);
  EXPECT_GT(probe(*alone, "axial_max_ropes"), 1e3);
  EXPECT_GT(probe(*alone, "brake_run_braked"), 1e-3);
  EXPECT_NEAR(probe(*alone, "kinetic_energy") + probe(*alone, "elastic_energy") +
                  probe(*alone, "brake_work"),
              probe(*alone, "external_work"), 1e-2 * probe(*alone, "external_work"));
}

/// A run that goes on from a saved state gives the same bits.
TEST(LinesOnRanks, saved_state_has_the_runs) {
  const TemporaryMesh mesh(guyed_beam(), rank_of(comm()));
  const Json json = guyed_scene(mesh.path());
  const auto whole = fem_solver<2>(json), second = fem_solver<2>(json);
  for (int n = 1; n <= 30; ++n) advance(*whole, n, 0.005);
  second->load_state(whole->save_state());
  for (int n = 31; n <= 60; ++n) {
    for (auto* solver : {whole.get(), second.get()}) advance(*solver, n, 0.005);
  }
  EXPECT_GT(probe(*whole, "brake_run_braked"), 1e-3);
  EXPECT_EQ(whole->probes(), second->probes());
}

}  // namespace
}  // namespace gabion::test::test_lines_on_ranks
