// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "common/mechanics/ranks/sum.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/yielding_tower.hpp"

namespace gabion::test::test_cell_groups {
namespace {

InterfaceValues push_top(const Solver& solver, double force) {
  InterfaceValues values;
  for (int i = 0; i < solver.interfaces().at(0).num_vertices(); ++i) {
    values["wall"].insert(values["wall"].end(), {force, 0.0});
  }
  return values;
}

/// Groups of cells come to the ranks that have the cells; some ranks have none.
TEST(CellGroups, on_ranks) {
  const TemporaryMesh mesh(two_groups(), rank_of(comm()));
  const Json json = tower_scene(mesh.path());
  const auto shared = fem_solver<2>(json), alone = fem_solver<2>(json, MPI_COMM_SELF);
  EXPECT_EQ(shared->probe_names(), alone->probe_names());
  for (int n = 1; n <= 20; ++n) {
    for (auto* solver : {shared.get(), alone.get()}) {
      const StepRequest request{n, 0, (n - 1) * 0.01, 0.01};
      InterfaceValues sent;
      solver->solve_step(request, push_top(*solver, 200 * std::sin(0.25 * n)), sent);
      solver->accept_step(request, true);
    }
    const auto found = shared->probes(), expected = alone->probes();
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_NEAR(found[i], expected[i], 1e-7 * (1 + std::abs(expected[i]))) << i;
    }
  }
  EXPECT_GT(probe(*alone, "plastic_strain_lower"), 5e-4);
}

TEST(CellGroups, errors_reach_all_ranks) {
  const TemporaryMesh mesh(two_groups(), rank_of(comm()));
  Json json = tower_scene(mesh.path());
  json["materials"].erase(1);
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"cell 1 near (0.5, 1.5)", "in no group of \"materials\""});
}

}  // namespace
}  // namespace gabion::test::test_cell_groups
