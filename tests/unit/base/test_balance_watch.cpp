// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/balance_watch.hpp"

#include <gtest/gtest.h>

namespace gabion::test_balance_watch {
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
            "energy balance of \"soil\" is not closed: of the 10 J that were exchanged, 20 % are "
            "missing and 30 % were created");
  EXPECT_EQ(
      found[1],
      "momentum balance of \"soil\" is not closed: 50 % of 2 kg m/s are missing (of the largest "
      "momentum, or of sqrt(2 m E) of the energy exchanged)");
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
  EXPECT_EQ(
      faults(names, {{0, 1, 0, 0}, {1, 2.5, 2, 0}}),
      std::vector<std::string>{"energy of the structure: 25 % more than the 2 J that came in"});
  const auto rings = faults(names, {{0, 1, 0, 0}, {30, 1, 2, 0}, {3, 1, 2, 0}});
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_TRUE(rings[0].starts_with(
      "energy of the structure: 50 % more than the 2 J that came in; waves that are "
      "shorter than the step ring"));
  EXPECT_NE(rings[0].find("rho_inf"), std::string::npos);
  for (const char* part : {"plastic_work", "damage_work", "brake_work", "failed_energy"}) {
    const std::vector<std::string> of_part = {"kinetic_energy", "external_work", part};
    EXPECT_TRUE(faults(of_part, {{0, 0, 0}, {1, 10, 9}}).empty()) << part;
    EXPECT_EQ(faults(of_part, {{0, 0, 0}, {2, 10, 9}}).size(), 1U) << part;
  }
  EXPECT_EQ(faults(names, {{0, 0, 0, 0}, {1, 0, 2, -64.8}, {1, 0, 2, 1}}),
            std::vector<std::string>{"damping of the structure created 64.8 J"});
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
}  // namespace gabion::test_balance_watch
