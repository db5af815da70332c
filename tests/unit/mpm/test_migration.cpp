// SPDX-License-Identifier: BSD-3-Clause
// Material points follow their cells from rank to rank.
#include <gtest/gtest.h>

#include "tests/unit/mpm/collapse.hpp"

namespace gabion::test::test_migration {
namespace {

/// Take equal steps on all ranks together and on each rank alone.
void check_scene(const Json& json, int steps, double tolerance) {
  const auto shared = mpm_solver<2>(json), alone = mpm_solver<2>(json, MPI_COMM_SELF);
  expect_same_points<2>(shared->points(), alone->points(), 0);
  run_collapse(*shared, 1, steps);
  run_collapse(*alone, 1, steps);
  expect_same_points<2>(shared->points(), alone->points(), tolerance);
  expect_same_probes(*shared, *alone, 1e3 * tolerance);
  const Json summary = shared->summary();
  EXPECT_EQ(summary.contains("ranks"), size() > 1);
  if (size() == 1) return;
  EXPECT_GT(summary.at("ranks").at("moved_points"), 10);
  EXPECT_LT(summary.at("ranks").at("largest_share"), 1.6);
  const auto energy = alone->surfaces().energy();
  EXPECT_EQ(energy.stored + energy.friction > 0, json.contains("interfaces"));
}

void check_collapse(const Collapse& given) {
  SCOPED_TRACE(given.basis + " " + given.cells + " " + given.locking);
  check_scene(collapse_scene(given), 40, 1e-8);
}

void check_sliding(const Collapse& given) {
  SCOPED_TRACE("sliding " + given.basis + " " + given.law);
  check_scene(sliding_scene(given), 40, 1e-8);
}

TEST(Migration, a_collapse_is_the_same_on_any_number_of_ranks) {
  check_collapse({.cells = "tri3"});
  check_collapse({.basis = "gimp"});
  check_collapse({.locking = "fbar"});
  check_collapse({.cells = "tri3", .locking = "fbar"});
  check_collapse({.small_cuts = "ghost"});
}

TEST(Migration, a_collapse_in_space_is_the_same_on_any_number_of_ranks) {
  for (const char* cells : {"hex8", "tet4"}) {
    Json material = elastic_soil("mohr_coulomb", 2e5, 0.3, 1500);
    material["friction_angle"] = 20;
    const Json json = {{"dimension", 3},
                       {"grid", box({0, 0, 0}, {1.6, 0.8, 1.0}, {8, 4, 5}, cells)},
                       {"basis", cells == std::string("hex8") ? "gimp" : "linear"},
                       {"locking", {{"method", "fbar"}}},
                       {"walls", {wall("bottom", "fixed"), wall("left", "slip")}},
                       {"gravity", {0, 0, -9.81}},
                       {"newton", exact_newton},
                       {"linear_solver", {{"method", "mumps"}}},
                       {"bodies",
                        {body("soil", box({0, 0.2, 0}, {0.8, 0.6, 0.4}, {4, 2, 2}, cells),
                              cells == std::string("hex8") ? 8 : 4, material, {3, 0, 0})}}};
    const auto shared = mpm_solver<3>(json), alone = mpm_solver<3>(json, MPI_COMM_SELF);
    run_collapse(*shared, 1, 20);
    run_collapse(*alone, 1, 20);
    expect_same_points<3>(shared->points(), alone->points(), 1e-8);
    if (size() > 1) {
      EXPECT_GT(shared->summary().at("ranks").at("moved_points"), 10);
    }
  }
}

TEST(Migration, contact_by_facets_goes_with_the_points) {
  check_collapse({.with_plate = true});
  check_collapse({.with_plate = true, .law = "neo_hookean"});
  check_sliding({});
  check_sliding({.basis = "gimp", .law = "neo_hookean"});
}

/// A cell's points are on one rank, ordered by id, and every id is on one rank.
TEST(Migration, points_lie_on_the_rank_of_their_cell) {
  const auto solver = mpm_solver<2>(collapse_scene({}));
  run_collapse(*solver, 1, 30);
  const auto& points = solver->points();
  EXPECT_TRUE(std::is_sorted(points.id.begin(), points.id.end()));
  EXPECT_EQ(points.body_starts.back(), points.size());
  std::vector<int> holders(12 * 6, 0), ids(points.body_ids.back(), 0);
  for (const std::int32_t cell : points.cell) holders[cell] = 1;
  for (const std::int64_t id : points.id) ++ids[id];
  for (std::int32_t p = 0; p < points.body_starts[1]; ++p) EXPECT_LT(points.id[p], 144);
  for (auto* counts : {&holders, &ids}) {
    MPI_Allreduce(MPI_IN_PLACE, counts->data(), static_cast<int>(counts->size()), MPI_INT, MPI_SUM,
                  comm());
  }
  EXPECT_LE(*std::max_element(holders.begin(), holders.end()), 1);
  EXPECT_EQ(std::count(ids.begin(), ids.end(), 1), std::ssize(ids));
}

/// A point that moves to another rank keeps every bit of every field: here all points go to the
/// next rank and back.
TEST(Migration, moved_points_keep_all_fields) {
  Json json = collapse_scene({.basis = "gimp"});
  json["transfer"] = {{"method", "tpic"}};
  const auto alone = mpm_solver<2>(json, MPI_COMM_SELF);
  run_collapse(*alone, 1, 3);
  auto points = rank() == 0 ? alone->points() : mpm::MaterialPoints<2>();
  points.body_ids = alone->points().body_ids;
  points.body_starts.resize(3, 0);
  const mpm::BackgroundGrid<2> grid = mpm_settings<2>(json).grid;
  const std::vector<mpm::ContactSettings<2>> no_interfaces;
  const std::vector<mpm::RigidWallSettings<2>> no_walls;
  mpm::Surfaces<2> surfaces(comm(), no_interfaces, no_walls, 1);
  for (const double shift : {0.3, -1.0}) {
    std::vector<AxisPlane> planes;
    for (int k = 1; k < size(); ++k) planes.push_back({0, shift < 0 ? 10 : shift * k});
    const Partition<2> partition(planes);
    mpm::migrate<2>({comm(), grid, partition}, points, surfaces);
  }
  EXPECT_EQ(points.size(), rank() == 0 ? alone->points().size() : 0);
  EXPECT_TRUE(rank() != 0 || same_bits<2>(points, alone->points()));
}

/// One cell with soil: all ranks but one are empty, from the start.
TEST(Migration, ranks_may_be_empty) {
  for (const char* basis : {"linear", "gimp", "bspline"}) {
    for (const char* method : {"auto", "cg"}) {
      Json json = collapse_scene({.basis = basis});
      json["bodies"] = {body("soil", box({0.22, 0.02}, {0.38, 0.18}, {2, 2}, "quad4"), 4,
                             elastic_soil("neo_hookean", 2e5, 0.3, 1500), {6, 0})};
      json["linear_solver"] = {{"method", method}};
      json["probes"][0]["point"] = {0.3, 0.1};
      json["walls"] = {wall("bottom", "slip"), wall("left", "slip")};
      const auto shared = mpm_solver<2>(json), alone = mpm_solver<2>(json, MPI_COMM_SELF);
      double empty = shared->points().size() == 0 ? 1 : 0;
      MPI_Allreduce(MPI_IN_PLACE, &empty, 1, MPI_DOUBLE, MPI_SUM, comm());
      EXPECT_EQ(empty, size() - 1);
      run_collapse(*shared, 1, 20);
      run_collapse(*alone, 1, 20);
      expect_same_points<2>(shared->points(), alone->points(), 1e-8);
      expect_same_probes(*shared, *alone, 1e-6);
    }
  }
}

/// All soil flies over a plane of the tree: space is parted anew.
TEST(Migration, space_is_parted_anew_when_a_rank_has_too_many_points) {
  Json json = collapse_scene({});
  json["gravity"] = {0, 0};
  json["walls"] = Json::array();
  for (auto& each : json["bodies"]) each["velocity"] = {0, 0};
  json["bodies"][0]["mesh"] = box({0, 0.2}, {2.4, 0.4}, {24, 2}, "quad4");
  json["bodies"][1]["mesh"] = box({0, 0.6}, {0.4, 1.0}, {4, 4}, "quad4");
  json["bodies"][1]["velocity"] = {25, 0};
  const auto shared = mpm_solver<2>(json), alone = mpm_solver<2>(json, MPI_COMM_SELF);
  run_collapse(*shared, 1, 18);
  run_collapse(*alone, 1, 18);
  expect_same_points<2>(shared->points(), alone->points(), 1e-8);
  if (size() == 1) return;
  const Json ranks = shared->summary().at("ranks");
  EXPECT_GE(ranks.at("partitions"), 1);
  EXPECT_LE(ranks.at("largest_share"), 1.4);
}

}  // namespace
}  // namespace gabion::test::test_migration
