// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "common/mechanics/ranks/shared_nodes.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test_shared_nodes {
namespace {

constexpr std::int32_t num_ids = 40;

/// Rank r holds 10 r .. 10 r + 14 and 39, so 10 to 14, 20 to 24 and 39 are shared.
std::vector<std::int32_t> own_ids() {
  std::vector<std::int32_t> ids(15);
  std::iota(ids.begin(), ids.end(), 10 * test::rank());
  ids.push_back(num_ids - 1);
  return ids;
}

int holders(std::int32_t id) {
  int count = id == num_ids - 1 ? test::size() : 0;
  for (int r = 0; r < test::size() && id != num_ids - 1; ++r) {
    count += id >= 10 * r && id < 10 * r + 15;
  }
  return count;
}

TEST(SharedNodes, the_lowest_holder_owns_a_node_and_each_has_one_number) {
  const auto ids = own_ids();
  const SharedNodes shared(test::comm(), ids, num_ids);
  ASSERT_EQ(shared.alone(), test::size() == 1);
  if (shared.alone()) return;
  std::vector<double> numbers(num_ids, 0), owners(num_ids, 0);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto node = static_cast<std::int32_t>(i);
    const int lowest = ids[i] == num_ids - 1 ? 0 : std::max(0, (ids[i] - 5) / 10);
    EXPECT_EQ(shared.owner(node), lowest) << ids[i];
    EXPECT_EQ(shared.owns(node), lowest == test::rank());
    if (!shared.owns(node)) continue;
    numbers[shared.numbers()[i]] += 1;
    owners[ids[i]] += shared.numbers()[i];
  }
  shared.total(numbers);
  shared.total(owners);
  EXPECT_EQ(shared.num_of_all(), 10 * test::size() + 5 + 1);
  EXPECT_EQ(shared.num_shared(),
            std::ranges::count_if(ids, [](auto id) { return holders(id) > 1; }));
  for (std::int64_t k = 0; k < num_ids; ++k) EXPECT_EQ(numbers[k], k < shared.num_of_all() ? 1 : 0);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    EXPECT_EQ(shared.numbers()[i], owners[ids[i]]) << "the same number on each holder";
  }
}

TEST(SharedNodes, sums_take_the_part_of_every_holder) {
  const auto ids = own_ids();
  const SharedNodes shared(test::comm(), ids, num_ids);
  std::vector<double> values;
  for (const std::int32_t id : ids) {
    values.insert(values.end(), {1.0, static_cast<double>(id), 0.1 * test::rank()});
  }
  shared.sum(values, 3);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const int count = holders(ids[i]);
    EXPECT_EQ(values[3 * i], count);
    EXPECT_EQ(values[3 * i + 1], count * ids[i]);
  }
}

TEST(SharedNodes, owners_give_their_values) {
  const auto ids = own_ids();
  const SharedNodes shared(test::comm(), ids, num_ids);
  std::vector<double> values;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const bool own = shared.owns(static_cast<std::int32_t>(i));
    values.insert(values.end(), {own ? 2.0 * ids[i] : -1, own ? 3.0 : -1});
  }
  shared.take_from_owners(values, 2);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    EXPECT_EQ(values[2 * i], 2.0 * ids[i]);
    EXPECT_EQ(values[2 * i + 1], 3.0);
  }
}

TEST(SharedNodes, products_count_each_node_once) {
  const auto ids = own_ids();
  const SharedNodes shared(test::comm(), ids, num_ids);
  const std::vector<double> ones(2 * ids.size(), 1.0);
  const double nodes = test::size() == 1 ? 16 : 10 * test::size() + 6;
  EXPECT_EQ(shared.dot(ones, ones), 2 * nodes);
  EXPECT_DOUBLE_EQ(shared.norm(ones), std::sqrt(2 * nodes));
}

TEST(SharedNodes, a_rank_may_hold_none) {
  std::vector<std::int32_t> ids;
  if (test::rank() == 0) ids = {3, 7};
  const SharedNodes shared(test::comm(), ids, num_ids);
  std::vector<double> values(2 * ids.size(), 1.5);
  shared.sum(values, 2);
  for (const double value : values) EXPECT_EQ(value, 1.5);
  EXPECT_EQ(shared.dot(values, values), 9);
}

}  // namespace
}  // namespace gabion::test_shared_nodes
