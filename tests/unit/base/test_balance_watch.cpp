// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/balance_watch.hpp"

#include <gtest/gtest.h>

namespace gabion {
namespace {

using Rows = std::vector<std::vector<double>>;

std::vector<std::string> faults(const std::vector<std::string>& names, const Rows& rows) {
  BalanceWatch watch;
  watch.start(names);
  for (const auto& row : rows) watch.add(row);
  return watch.faults();
}

TEST(BalanceWatch, energy_and_momentum_of_the_soil) {
  const std::vector<std::string> names = {"soil.gravity_work", "soil.energy_balance",
                                          "soil.created_energy", "soil.momentum_x",
                                          "soil.momentum_error_x"};
  EXPECT_TRUE(faults(names, {{0, 0, 0, 0, 0}, {10, 0.09, 0.05, 2, 0.01}}).empty());
  const auto found = faults(names, {{0, 0, 0, 0, 0}, {10, -2, 3, 2, -1}, {10, 0, 0, 0, 0}});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0],
            "energy of \"soil\" is not closed: of the 10 J that went around the balance misses 20 "
            "%, and 30 % was created");
  EXPECT_EQ(
      found[1],
      "momentum of \"soil\" is not closed: it misses 50 % of 2 kg m/s, its largest or that of "
      "the energy that went around, sqrt(2 m E)");
}

/// Soil at rest has next to no momentum of which an error could be a share.
TEST(BalanceWatch, momentum_of_soil_at_rest) {
  const std::vector<std::string> names = {"mass", "gravity_work", "energy_balance", "momentum_y",
                                          "momentum_error_y"};
  EXPECT_TRUE(faults(names, {{480, 0, 0, 0, 0}, {480, 0.5, 0, 0.37, 0.1}}).empty());
  EXPECT_EQ(faults(names, {{480, 0, 0, 0, 0}, {480, 0.5, 0, 0.37, 0.3}}).size(), 1U);
}

TEST(BalanceWatch, energy_of_a_structure_and_what_its_damping_made) {
  const std::vector<std::string> names = {"kinetic_energy", "elastic_energy", "external_work",
                                          "damping_work"};
  EXPECT_TRUE(faults(names, {{0, 200, 200, 0}, {50, 149, 200, 1}}).empty());
  EXPECT_EQ(faults(names, {{0, 1, 0, 0}, {1, 2.5, 2, 0}}),
            std::vector<std::string>{
                "energy of the structure: it has 20 % more than the 2.5 J that came in"});
  EXPECT_EQ(faults(names, {{0, 0, 0, 0}, {1, 0, 2, -64.8}, {1, 0, 2, 1}}),
            std::vector<std::string>{"damping of the structure made 64.8 J"});
}

TEST(BalanceWatch, work_of_the_coupling_and_cuts) {
  BalanceWatch watch;
  watch.start({});
  for (int n = 0; n < 100; ++n) watch.add({});
  watch.add_work(-10, 0.05);
  watch.add_cuts(9);
  EXPECT_TRUE(watch.faults().empty());
  watch.add_work(0, 14.75);
  watch.add_cuts(1);
  EXPECT_EQ(watch.faults(),
            (std::vector<std::string>{"the coupling made 148 % of the work that it passed on",
                                      "10 cuts of the step size in 100 steps"}));
}

}  // namespace
}  // namespace gabion
