// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/mpm/pushed_soil.hpp"

namespace gabion::test::test_mpm_ranks {
namespace {

struct RankCase {
  std::string basis, cells, locking = "none", small_cuts = "none", contact = "boundary_points";
  int steps = 10;
  bool explicit_steps = false;
};

void expect_same_fields(const mpm::MpmSolver<2>& shared, const mpm::MpmSolver<2>& alone) {
  const auto a = shared.surfaces().fields(0, shared.points(), 0.25);
  const auto b = alone.surfaces().fields(0, alone.points(), 0.25);
  EXPECT_EQ(a.status, b.status);
  for (std::size_t f = 0; f < b.gap.size(); ++f) {
    EXPECT_LT((a.force[f] - b.force[f]).norm(), 1e-6);
    EXPECT_LT((a.slip[f] - b.slip[f]).norm(), 1e-9);
    EXPECT_NEAR(a.area[f], b.area[f], 1e-12);
    EXPECT_NEAR(a.gap[f], b.gap[f], 1e-12);
    EXPECT_GT(b.force[f].norm(), 1);
  }
}

/// Take equal steps on all ranks together and on each rank alone.
void check_ranks(const RankCase& given) {
  SCOPED_TRACE(given.basis + " " + given.cells + " " + given.locking + " " + given.small_cuts +
               " " + given.contact + (given.explicit_steps ? " explicit" : ""));
  Json json = pushed();
  json["grid"] = box({0, 0}, {2, 1}, {8, 4}, given.cells);
  json["basis"] = given.basis;
  json["locking"] = {{"method", given.locking}};
  json["small_cuts"] = {{"method", given.small_cuts}};
  json["interfaces"][0]["method"] = given.contact;
  if (given.explicit_steps) {
    json["time_integration"] = {{"scheme", "explicit"}, {"courant", 0.1}};
  } else {
    json["newton"] = exact_newton;
    json["linear_solver"] = {{"method", "mumps"}};
  }
  json["interfaces"][0]["friction"] = 0.4;
  json["probes"] = {{{"name", "A"}, {"point", {1.5, 0.5}}}};
  json["gauges"] = {{{"name", "middle"}, {"corners", {{1.0, 0.0}, {1.1, 1.0}}}},
                    {{"name", "left"}, {"corners", {{0.501, 0.0}, {0.501, 1.0}}}}};
  const auto shared = mpm_solver<2>(json), alone = mpm_solver<2>(json, MPI_COMM_SELF);
  EXPECT_EQ(shared->probe_names(), alone->probe_names());
  InterfaceValues together, single;
  for (int n = 1; n <= given.steps; ++n) {
    const StepRequest request{n, 0, (n - 1) * 0.002, 0.002};
    shared->solve_step(request, plate_at(0.002 * n), together);
    alone->solve_step(request, plate_at(0.002 * n), single);
    if (rank() == 0) {
      for (std::size_t k = 0; k < 6; ++k) {
        EXPECT_NEAR(together.at("plate")[k], single.at("plate")[k], 1e-6) << "step " << n;
      }
      EXPECT_GT(std::abs(single.at("plate")[0]), given.contact == "facets" ? 0.5 : 10);
    }
    const Json a = shared->accept_step(request, true).details;
    const Json b = alone->accept_step(request, true).details;
    EXPECT_EQ(a.at("active_nodes"), b.at("active_nodes"));
    EXPECT_EQ(a.at("points_changed_cell"), b.at("points_changed_cell"));
    EXPECT_NEAR(a.at("min_J_ratio").get<double>(), b.at("min_J_ratio").get<double>(), 1e-9);
  }
  const auto a = shared->probes(), b = alone->probes();
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_NEAR(a[k], b[k], 1e-7 * (1e-3 + std::abs(b[k]))) << shared->probe_names()[k];
  }
  expect_same_fields(*shared, *alone);
  EXPECT_EQ(shared->summary()["small_cuts"], alone->summary()["small_cuts"]);
}

TEST(MpmRanks, number_of_ranks_does_not_change_the_result) {
  check_ranks({.basis = "linear", .cells = "tri3"});
  check_ranks({.basis = "gimp", .cells = "quad4"});
  check_ranks({.basis = "bspline", .cells = "quad4"});
}

TEST(MpmRanks, number_of_ranks_does_not_change_the_cures_of_small_cuts) {
  check_ranks({.basis = "linear", .cells = "tri3", .small_cuts = "ghost", .steps = 3});
  check_ranks({.basis = "linear", .cells = "tri3", .small_cuts = "mass_cutoff", .steps = 3});
}

/// Each rank meets the surface with its own material points.
TEST(MpmRanks, number_of_ranks_does_not_change_the_contact_by_facets) {
  check_ranks({.basis = "linear", .cells = "tri3", .contact = "facets"});
  check_ranks({.basis = "gimp", .cells = "quad4", .contact = "facets"});
}

/// Groups whose points are on several ranks are averaged over all of them.
TEST(MpmRanks, number_of_ranks_does_not_change_averaged_volumes) {
  check_ranks({.basis = "linear", .cells = "tri3", .locking = "fbar"});
  check_ranks({.basis = "linear", .cells = "quad4", .locking = "fbar"});
  check_ranks({.basis = "gimp", .cells = "quad4", .locking = "fbar"});
  check_ranks({.basis = "bspline", .cells = "quad4", .locking = "fbar"});
}

TEST(MpmRanks, number_of_ranks_does_not_change_explicit_steps) {
  for (const std::string locking : {"none", "fbar"}) {
    check_ranks({"linear", "tri3", locking, "none", "facets", 10, true});
    check_ranks({"gimp", "quad4", locking, "none", "facets", 10, true});
    check_ranks({"bspline", "quad4", locking, "mass_cutoff", "facets", 10, true});
  }
}

}  // namespace
}  // namespace gabion::test::test_mpm_ranks
