// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/mpm/pushed_soil.hpp"

namespace gabion::test {
namespace {

/// The same steps on all ranks together and on each rank alone.
void check_ranks(const std::string& basis, const std::string& cells, const std::string& locking,
                 const std::string& small_cuts = "none", int steps = 10) {
  SCOPED_TRACE(basis + " " + cells + " " + locking + " " + small_cuts);
  Json json = pushed();
  json["grid"] = box({0, 0}, {2, 1}, {8, 4}, cells);
  json["basis"] = basis;
  json["locking"] = {{"method", locking}};
  json["small_cuts"] = {{"method", small_cuts}};
  json["newton"] = exact_newton;
  json["linear_solver"] = {{"method", "mumps"}};
  json["interfaces"][0]["friction"] = 0.4;
  json["probes"] = {{{"name", "A"}, {"point", {1.5, 0.5}}}};
  const auto shared = mpm_solver<2>(json), alone = mpm_solver<2>(json, MPI_COMM_SELF);
  EXPECT_EQ(shared->probe_names(), alone->probe_names());
  InterfaceValues together, single;
  for (int n = 1; n <= steps; ++n) {
    const StepRequest request{n, 0, (n - 1) * 0.002, 0.002};
    shared->solve_step(request, plate_at(0.002 * n), together);
    alone->solve_step(request, plate_at(0.002 * n), single);
    if (rank() == 0) {
      for (std::size_t k = 0; k < 6; ++k) {
        EXPECT_NEAR(together.at("plate")[k], single.at("plate")[k], 1e-6) << "step " << n;
      }
      EXPECT_GT(std::abs(single.at("plate")[0]), 10);
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
  EXPECT_EQ(shared->summary()["small_cuts"], alone->summary()["small_cuts"]);
}

TEST(MpmRanks, number_of_ranks_does_not_change_the_result) {
  check_ranks("linear", "tri3", "none");
  check_ranks("gimp", "quad4", "none");
  check_ranks("bspline", "quad4", "none");
}

TEST(MpmRanks, number_of_ranks_does_not_change_the_cures_of_small_cuts) {
  check_ranks("linear", "tri3", "none", "ghost", 3);
  check_ranks("linear", "tri3", "none", "mass_cutoff", 3);
}

/// Groups whose points are on several ranks are averaged over all of them.
TEST(MpmRanks, number_of_ranks_does_not_change_averaged_volumes) {
  check_ranks("linear", "tri3", "fbar");
  check_ranks("linear", "quad4", "fbar");
  check_ranks("gimp", "quad4", "fbar");
}

}  // namespace
}  // namespace gabion::test
