// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "mpm_solver/step/largest_part.hpp"

namespace gabion::test::test_largest_part {
namespace {

using mpm::MassValue;

/// The sum by sorting.
double sorted_sum(std::vector<MassValue> values, double left_out) {
  std::ranges::sort(values, {}, &MassValue::value);
  double sum = 0;
  for (auto v = values.rbegin(); v != values.rend(); ++v) {
    const double taken = std::min(left_out, v->mass);
    left_out -= taken;
    sum += (v->mass - taken) * v->value;
  }
  return sum;
}

double sum_without(const std::vector<MassValue>& values, double left_out) {
  return mpm::sum_without_largest(SharedNodes(), values, left_out);
}

TEST(LargestPart, sum_is_that_of_sorted_values) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-8, 8), mass(0, 2);
  for (const int count : {1, 2, 3, 10, 300}) {
    std::vector<MassValue> values;
    double total = 0;
    for (int k = 0; k < count; ++k) {
      values.push_back({std::pow(10, exponent(random)), mass(random)});
      total += values.back().mass;
    }
    for (const double share : {0.0, 0.01, 0.3, 0.99}) {
      const double expected = sorted_sum(values, share * total);
      EXPECT_NEAR(sum_without(values, share * total), expected, 1e-9 * expected)
          << count << " values, " << share;
    }
    EXPECT_EQ(sum_without(values, 1.01 * total), 0) << count << " values";
  }
}

TEST(LargestPart, equal_values_zeros_and_none) {
  EXPECT_EQ(sum_without({}, 1), 0);
  EXPECT_EQ(sum_without({{0, 1}, {0, 2}}, 0.5), 0);
  EXPECT_NEAR(sum_without({{3, 1}, {3, 1}, {3, 2}}, 1), 9, 1e-12);
  EXPECT_NEAR(sum_without({{3, 1}, {0, 1}, {0, 2}}, 0.5), 1.5, 1e-12);
  EXPECT_NEAR(sum_without({{3, 1}, {2, 1}}, 1), 2, 1e-12);
}

/// How large the largest value is does not matter while it is left out.
TEST(LargestPart, a_stray_value_does_not_matter) {
  const std::vector<MassValue> some = {{1, 5}, {2, 5}};
  for (const double stray : {3.0, 1e3, 1e12}) {
    std::vector<MassValue> values = some;
    values.push_back({stray, 0.1});
    EXPECT_NEAR(sum_without(values, 0.1), 15, 1e-9) << stray;
  }
}

}  // namespace
}  // namespace gabion::test::test_largest_part
