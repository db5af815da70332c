// SPDX-License-Identifier: BSD-3-Clause
// Messages between ranks of which each knows only its own.
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "common/mechanics/ranks/packet.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test_packet {
namespace {

std::vector<double> numbers_of(int sender, int receiver, int round) {
  std::vector<double> numbers(1 + 1000 * ((sender + 2 * receiver + round) % 3));
  std::iota(numbers.begin(), numbers.end(), 100.0 * round + 10 * sender + receiver);
  return numbers;
}

/// Every second pair of ranks has something to say, a rank to itself too.
bool speaks(int sender, int receiver, int round) {
  return (sender + 2 * receiver + round) % 2 == 0;
}

TEST(Packets, reach_those_they_are_for_round_after_round) {
  const int own = test::rank();
  for (int round = 0; round < 50; ++round) {
    Packets out;
    for (int r = 0; r < test::size(); ++r) {
      if (!speaks(own, r, round)) continue;
      const std::vector<double> numbers = numbers_of(own, r, round);
      out[r].put(static_cast<int>(numbers.size()));
      out[r].put_all(std::span<const double>(numbers));
    }
    Packets in = send_packets(test::comm(), out);
    for (int r = 0; r < test::size(); ++r) {
      ASSERT_EQ(in.contains(r), speaks(r, own, round)) << round << ' ' << r;
      if (!in.contains(r)) continue;
      std::vector<double> numbers(in[r].take<int>());
      in[r].take_all(numbers);
      EXPECT_EQ(numbers, numbers_of(r, own, round));
      EXPECT_TRUE(in[r].empty());
    }
  }
}

TEST(Packets, may_be_empty_and_may_be_none) {
  EXPECT_TRUE(send_packets(test::comm(), {}).empty());
  Packets out;
  if (test::rank() == 0) out[test::size() - 1] = Packet();
  const Packets in = send_packets(test::comm(), out);
  EXPECT_EQ(in.size(), test::rank() == test::size() - 1 ? 1u : 0u);
  for (const auto& [rank, packet] : in) EXPECT_TRUE(rank == 0 && packet.empty());
}

}  // namespace
}  // namespace gabion::test_packet
