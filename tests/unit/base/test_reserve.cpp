// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "common/base/reserve.hpp"

namespace gabion::test_reserve {
namespace {

TEST(Reserve, little_of_a_list_that_grows_stays_empty) {
  std::vector<int> values;
  for (int n = 1000; n < 200000; n += 700) {
    reserve_tightly(values, n);
    const int* const place = values.data();
    values.resize(n, 7);
    EXPECT_EQ(values.data(), place) << "it had no room for " << n;
    EXPECT_LE(values.capacity(), n * 9 / 8);
  }
  const std::size_t before = values.capacity();
  reserve_tightly(values, 10);
  EXPECT_EQ(values.capacity(), before);
}

}  // namespace
}  // namespace gabion::test_reserve
