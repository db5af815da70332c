// SPDX-License-Identifier: BSD-3-Clause
// Random numbers that are found from their number, and statistics of random fields.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "mpm_solver/parameters/random_field.hpp"

namespace gabion::test::test_random_field {
namespace {

using mpm::CountedRandom;
using mpm::Lognormal;
using mpm::RandomLattice;
using Words = std::array<std::uint32_t, 4>;

/// Known answers of the authors' library (Random123, kat_vectors).
TEST(CountedRandom, philox_of_the_authors) {
  const std::uint32_t ones = 0xffffffff;
  EXPECT_EQ(mpm::philox({0, 0, 0, 0}, {0, 0}),
            (Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(mpm::philox({ones, ones, ones, ones}, {ones, ones}),
            (Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(mpm::philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

/// Moments of 1e6 numbers, within four deviations of their estimates.
TEST(CountedRandom, normal_numbers) {
  const CountedRandom random(3, "soil/cohesion"), other(3, "soil/young_modulus");
  constexpr int n = 1'000'000;
  double sums[4] = {}, product = 0;
  for (std::uint64_t i = 0; i < n; ++i) {
    const double z = random.normal(i);
    double power = 1;
    for (double& sum : sums) sum += power *= z;
    product += z * other.normal(i);
  }
  const double moments[] = {0, 1, 0, 3},
               deviations[] = {1, std::sqrt(2.), std::sqrt(15.), std::sqrt(96.)};
  for (int k = 0; k < 4; ++k) {
    EXPECT_NEAR(sums[k] / n, moments[k], 4 * deviations[k] / std::sqrt(n)) << k + 1;
  }
  EXPECT_NEAR(product / n, 0, 4 / std::sqrt(n));
}

TEST(CountedRandom, seed_and_stream_make_other_numbers) {
  const double z = CountedRandom(1, "a").normal(7);
  EXPECT_EQ(CountedRandom(1, "a").normal(7), z);
  EXPECT_NE(CountedRandom(2, "a").normal(7), z);
  EXPECT_NE(CountedRandom(1, "b").normal(7), z);
  EXPECT_NE(CountedRandom(1, "a").normal(8), z);
  EXPECT_NE(CountedRandom(1, "a").normal(7 + (std::uint64_t{1} << 32)), z);
  EXPECT_NE(CountedRandom(1 + (std::uint64_t{1} << 32), "a").normal(7), z);
}

TEST(RandomLattice, cells_fill_the_box) {
  const RandomLattice<2> lattice({Vector<2>(1, -2), Vector<2>(2, 0)}, Vector<2>(0.3, 0.5));
  EXPECT_EQ(lattice.count, (std::array<int, 2>{4, 4}));
  EXPECT_EQ(lattice.num_cells(), 16);
  EXPECT_EQ(lattice.cell_of({1.01, -1.99}), 0);
  EXPECT_EQ(lattice.cell_of({1.01, -0.01}), 3);
  EXPECT_EQ(lattice.cell_of({1.26, -1.99}), 4);
  EXPECT_EQ(lattice.cell_of({2, 0}), 15);
}

/// Mean, variance and correlation at lags along and across the axes, over a box of 1600 by 1600
/// steps and so 200 by 200 scales of fluctuation: estimates have deviations below 0.006.
TEST(RandomField, correlation_of_markov) {
  const Vector<2> theta(20, 2);
  const RandomLattice<2> lattice({Vector<2>(0, 0), Vector<2>(4000, 400)}, theta / 8);
  const auto z = mpm::normal_field<2>(lattice, theta, CountedRandom(5, "soil/cohesion"));
  const auto [nx, ny] = lattice.count;
  const auto correlation = [&, nx = nx, ny = ny](int i, int j) {
    double sum = 0;
    for (int x = 0; x + i < nx; ++x) {
      for (int y = 0; y + j < ny; ++y) sum += z[x * ny + y] * z[(x + i) * ny + y + j];
    }
    return sum / (static_cast<double>(nx - i) * (ny - j));
  };
  double mean = 0;
  for (const double value : z) mean += value / static_cast<double>(z.size());
  EXPECT_NEAR(mean, 0, 0.02);
  for (const auto& [i, j] :
       {std::pair{0, 0}, {1, 0}, {0, 1}, {4, 0}, {0, 4}, {8, 0}, {0, 8}, {4, 4}, {2, 8}}) {
    EXPECT_NEAR(correlation(i, j), std::exp(-2 * (i + j) / 8.0), 0.02) << i << " " << j;
  }
}

TEST(RandomField, three_axes) {
  const Vector<3> theta(8, 4, 2);
  const RandomLattice<3> lattice({Vector<3>(0, 0, 0), Vector<3>(240, 120, 60)}, theta / 4);
  const auto z = mpm::normal_field<3>(lattice, theta, CountedRandom(1, "soil/cohesion"));
  const int n = 120;
  ASSERT_EQ(lattice.count, (std::array<int, 3>{n, n, n}));
  const int strides[] = {n * n, n, 1};
  for (const int stride : strides) {
    double sum = 0;
    std::int64_t count = 0;
    for (std::int64_t i = 0; i + stride < std::ssize(z); ++i) {
      if (i / stride % n == n - 1) continue;
      sum += z[i] * z[i + stride];
      ++count;
    }
    EXPECT_NEAR(sum / static_cast<double>(count), std::exp(-0.5), 0.02) << stride;
  }
}

/// Variance of the mean over a length L, as a cell of the grid sees it through its points:
/// Gamma^2 = (2 r - 1 + exp(-2 r)) / (2 r^2), r = L / theta.
TEST(RandomField, variance_of_local_averages) {
  const Vector<2> theta(1, 1);
  const RandomLattice<2> lattice({Vector<2>(0, 0), Vector<2>(0.02, 40000)}, Vector<2>(0.02, 0.02));
  const auto z = mpm::normal_field<2>(lattice, theta, CountedRandom(2, "soil/cohesion"));
  for (const auto& [r, expected] : {std::pair{0.5, 0.7358}, {1.0, 0.5677}, {2.0, 0.3773}}) {
    EXPECT_NEAR((2 * r - 1 + std::exp(-2 * r)) / (2 * r * r), expected, 5e-5);
    const auto n = static_cast<std::size_t>(std::lround(r / 0.02));
    double squares = 0;
    const std::size_t count = z.size() / n;
    for (std::size_t k = 0; k < count; ++k) {
      double mean = 0;
      for (std::size_t i = 0; i < n; ++i) mean += z[k * n + i] / static_cast<double>(n);
      squares += mean * mean;
    }
    EXPECT_NEAR(squares / static_cast<double>(count), expected, 0.02) << r;
  }
}

TEST(RandomField, lognormal_values) {
  const Lognormal law = Lognormal::of(1e4, 0.3);
  EXPECT_NEAR(law.deviation, 0.293560, 5e-7);
  EXPECT_NEAR(law.mean, 9.167252, 5e-7);
  EXPECT_NEAR(law.at(0), 9578.26, 5e-3);
  const CountedRandom random(4, "soil/cohesion");
  constexpr int n = 400'000;
  double sum = 0, squares = 0;
  for (std::uint64_t i = 0; i < n; ++i) {
    const double x = law.at(random.normal(i)) / 1e4;
    sum += x / n;
    squares += x * x / n;
  }
  EXPECT_NEAR(sum, 1, 4 * 0.3 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares - sum * sum), 0.3, 0.003);
}

}  // namespace
}  // namespace gabion::test::test_random_field
