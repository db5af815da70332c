// SPDX-License-Identifier: BSD-3-Clause
// Memory in the summary.
#include <gtest/gtest.h>
#include <malloc.h>

#include "tests/unit/mpm/collapse.hpp"

namespace gabion::test::test_memory {
namespace {

std::size_t bytes_of_a_point(const mpm::MaterialPoints<2>& points) {
  std::size_t sum = 0;
  mpm::for_each_field<2>([&](const char*, auto field) {
    using Values = std::remove_cvref_t<decltype(points.*field)>;
    if (!(points.*field).empty()) sum += sizeof(typename Values::value_type);
  });
  return sum;
}

TEST(Memory, fields_of_the_summary_are_those_of_all_ranks) {
  const Json json = collapse_scene({.basis = "gimp"});
  const auto shared = mpm_solver<2>(json), alone = mpm_solver<2>(json, MPI_COMM_SELF);
  run_collapse(*shared, 1, 4);
  run_collapse(*alone, 1, 4);
  const Json one = alone->summary().at("memory"), all = shared->summary().at("memory");
  const std::size_t num_points = alone->points().m.size();
  ASSERT_EQ(num_points, 240u);
  EXPECT_EQ(one.at("points"), num_points * bytes_of_a_point(alone->points()));
  EXPECT_EQ(one.at("preconditioner"), 0);  // MUMPS keeps its own
  for (const auto& [name, bytes] : one.items()) {
    if (name == "preconditioner" || name == "stiffness") continue;
    EXPECT_GT(bytes, 1000) << name;
    EXPECT_GE(all.at(name), bytes) << name;
  }
  EXPECT_EQ(all.at("trial"), one.at("trial"));
  // Pairs of nodes that cells of several ranks join stand on each; one rank has a column number for
  // each block, too.
  const double blocks = all.at("stiffness").get<double>() / (size() > 1 ? 32 : 36);
  const double blocks_of_one = one.at("stiffness").get<double>() / 36;
  EXPECT_GE(blocks, blocks_of_one);
  EXPECT_LT(blocks, 1.5 * blocks_of_one);
}

TEST(Memory, a_factor_without_fill_is_as_large_as_the_stiffness) {
  Json json = collapse_scene({.basis = "gimp"});
  json["linear_solver"] = {{"method", "bicgstab"}, {"preconditioner", "ilu"}};
  const auto solver = mpm_solver<2>(json, MPI_COMM_SELF);
  run_collapse(*solver, 1, 2);
  const Json memory = solver->summary().at("memory");
  EXPECT_EQ(memory.at("preconditioner"), memory.at("stiffness"));
}

std::size_t bytes_in_use() {
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

/// Bytes of a collapse in a box that is `times` as long and as high; sanitizers count none.
double bytes_of_collapse(int times) {
  Json json = collapse_scene({.basis = "bspline", .locking = "fbar"});
  json["grid"] = box({0, 0}, {2.4 * times, 1.2 * times}, {12 * times, 6 * times}, "quad4");
  const std::size_t before = bytes_in_use();
  const auto solver = mpm_solver<2>(json);
  run_collapse(*solver, 1, 2);
  return static_cast<double>(bytes_in_use()) - static_cast<double>(before);
}

TEST(Memory, cells_without_soil_take_none) {
  bytes_of_collapse(1);  // what libraries keep
  const double small = bytes_of_collapse(1);
  const int times = 100;
  const double cells = 72 * times * times;
  EXPECT_LT(bytes_of_collapse(times) - small, cells);  // a mesh would take 40 for each
}

/// Memory that only a step needs is released while others want memory; nothing else changes by it.
TEST(Memory, a_frame_or_a_saved_state_between_steps_changes_no_bit) {
  Json json = collapse_scene({.basis = "gimp", .locking = "fbar"});
  json["linear_solver"] = {{"method", "bicgstab"},
                           {"preconditioner", "ilu"}};  // MUMPS adds in any order
  const auto straight = mpm_solver<2>(json), interrupted = mpm_solver<2>(json);
  for (int step = 1; step <= 6; ++step) {
    run_collapse(*straight, step, step);
    run_collapse(*interrupted, step, step);
    if (step % 2 == 0) {
      interrupted->save_state();
    } else {
      interrupted->write_output(0);
    }
  }
  const mpm::MaterialPoints<2>&a = straight->points(), &b = interrupted->points();
  ASSERT_EQ(a.id, b.id);
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.v, b.v);
  EXPECT_EQ(a.tau, b.tau);
}

}  // namespace
}  // namespace gabion::test::test_memory
