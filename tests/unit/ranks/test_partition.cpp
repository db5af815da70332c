// SPDX-License-Identifier: BSD-3-Clause
// The partition of space among ranks.
#include <gtest/gtest.h>

#include <random>

#include "common/mechanics/ranks/partition.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test::test_partition {
namespace {

template <int dim>
std::vector<Vector<dim>> random_places(int count) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> number(0, 1);
  std::vector<Vector<dim>> places(count);
  for (auto& x : places) {
    for (int d = 0; d < dim; ++d) x[d] = std::pow(number(engine), d + 1);  // not evenly spread
  }
  return places;
}

template <int dim>
std::vector<int> counts_of(const Partition<dim>& partition,
                           const std::vector<Vector<dim>>& places) {
  std::vector<int> counts(partition.num_parts(), 0);
  for (const auto& x : places) ++counts[partition.rank_of(x)];
  return counts;
}

/// Every step of the tree rounds to a whole place.
template <int dim>
void expect_equal_parts(int num_parts) {
  const auto places = random_places<dim>(3000);
  const auto partition = bisect<dim>(MPI_COMM_SELF, num_parts, places);
  ASSERT_EQ(partition.num_parts(), num_parts);
  for (const int count : counts_of(partition, places)) {
    EXPECT_NEAR(count, 3000.0 / num_parts, 2) << num_parts << " parts";
  }
}

TEST(Partition, parts_have_equal_numbers_of_places) {
  for (int num_parts = 1; num_parts <= 9; ++num_parts) {
    expect_equal_parts<2>(num_parts);
    expect_equal_parts<3>(num_parts);
  }
}

/// Who has which place does not matter: the planes have the same bits.
TEST(Partition, depends_on_all_places_together) {
  const auto places = random_places<3>(500);
  std::vector<Vector<3>> own;
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (static_cast<int>(k * k % 7) % size() == rank()) own.push_back(places[k]);
  }
  const auto one = bisect<3>(MPI_COMM_SELF, 6, places);
  const auto shared = bisect<3>(comm(), 6, own);
  const std::vector<Vector<3>> none;
  const auto on_first = bisect<3>(comm(), 6, rank() == 0 ? places : none);
  for (std::size_t k = 0; k < 5; ++k) {
    for (const auto* other : {&shared, &on_first}) {
      EXPECT_EQ(one.planes()[k].axis, other->planes()[k].axis);
      EXPECT_EQ(one.planes()[k].position, other->planes()[k].position);
    }
  }
}

/// The first plane lies across the longest side. A part of one rank has no plane.
TEST(Partition, planes_lie_across_the_longest_side) {
  std::vector<Vector<2>> places;
  for (int i = 0; i < 30; ++i) {
    for (int k = 0; k < 10; ++k) places.emplace_back(0.1 * k, 0.1 * i);
  }
  const auto partition = bisect<2>(MPI_COMM_SELF, 3, places);
  EXPECT_EQ(partition.planes()[0].axis, 1);
  EXPECT_NEAR(partition.planes()[0].position, 0.95, 0.05 + 1e-6);
  EXPECT_EQ(partition.planes()[1].axis, 1);
  EXPECT_EQ(counts_of(partition, places), (std::vector<int>{100, 100, 100}));
}

/// Equal coordinates stay together; where there are too few, ranks get none.
TEST(Partition, places_that_cannot_be_parted_leave_ranks_empty) {
  const std::vector<Vector<2>> same(10, Vector<2>(0.3, 0.7));
  const auto counts = counts_of(bisect<2>(MPI_COMM_SELF, 4, same), same);
  EXPECT_EQ(std::count(counts.begin(), counts.end(), 0), 3);
  const std::vector<Vector<2>> none;
  EXPECT_EQ(bisect<2>(comm(), 4, none).num_parts(), 4);
}

}  // namespace
}  // namespace gabion::test::test_partition
