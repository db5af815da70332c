// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace gabion {

/// Block compressed rows, blocks column-major.
struct BlockRows {
  const std::int32_t* row_starts;
  const std::int32_t* columns;
  const double* values;
};

/// y_i = sum_s A_s x_(column of s) of one row, from block `begin` to block `end`.
template <int block_size>
void multiply_row(const BlockRows& A, std::int32_t begin, std::int32_t end, const double* x,
                  double* y);

/// Two columns side by side in one vector.
template <>
inline void multiply_row<2>(const BlockRows& A, std::int32_t begin, std::int32_t end,
                            const double* x, double* y) {
  using Four = double __attribute__((vector_size(32)));
  Four even{}, odd{};
  const auto add = [&](std::int32_t s, Four& sum) {
    Four a;
    std::memcpy(&a, A.values + static_cast<std::ptrdiff_t>(s) * 4, sizeof a);
    const double* x_j = x + static_cast<std::ptrdiff_t>(A.columns[s]) * 2;
#ifdef __AVX2__
    const __m128d pair = _mm_loadu_pd(x_j);
    sum += a * Four(_mm256_permute4x64_pd(_mm256_castpd128_pd256(pair), 0x50));
#else
    sum += a * Four{x_j[0], x_j[0], x_j[1], x_j[1]};
#endif
  };
  std::int32_t s = begin;
  for (; s + 1 < end; s += 2) {
    add(s, even);
    add(s + 1, odd);
  }
  if (s < end) add(s, even);
  even += odd;
  y[0] = even[0] + even[2];
  y[1] = even[1] + even[3];
}

/// A column in three of four numbers, of which the fourth belongs to the next one.
template <>
inline void multiply_row<3>(const BlockRows& A, std::int32_t begin, std::int32_t end,
                            const double* x, double* y) {
  using Four = double __attribute__((vector_size(32)));
  Four sums[3] = {};
  for (std::int32_t s = begin; s < end; ++s) {
    const double* a = A.values + static_cast<std::ptrdiff_t>(s) * 9;
    const double* x_j = x + static_cast<std::ptrdiff_t>(A.columns[s]) * 3;
    Four column_0, column_1, last;
    std::memcpy(&column_0, a, sizeof column_0);
    std::memcpy(&column_1, a + 3, sizeof column_1);
    std::memcpy(&last, a + 5, sizeof last);  // ends with the block: one number ahead of column 2
    sums[0] += column_0 * x_j[0];
    sums[1] += column_1 * x_j[1];
    sums[2] += last * x_j[2];
  }
  const Four sum = sums[0] + sums[1];
  for (int r = 0; r < 3; ++r) y[r] = sum[r] + sums[2][r + 1];
}

/// A column a vector.
template <>
inline void multiply_row<4>(const BlockRows& A, std::int32_t begin, std::int32_t end,
                            const double* x, double* y) {
  using Four = double __attribute__((vector_size(32)));
  Four even{}, odd{};
  for (std::int32_t s = begin; s < end; ++s) {
    const double* a = A.values + static_cast<std::ptrdiff_t>(s) * 16;
    const double* x_j = x + static_cast<std::ptrdiff_t>(A.columns[s]) * 4;
    Four columns[4];
    std::memcpy(columns, a, sizeof columns);
    even += columns[0] * x_j[0] + columns[2] * x_j[2];
    odd += columns[1] * x_j[1] + columns[3] * x_j[3];
  }
  even += odd;
  std::memcpy(y, &even, sizeof even);
}

/// y = A x
template <int block_size>
inline void multiply_blocks(const BlockRows& A, std::int32_t num_rows, const double* x, double* y) {
  for (std::int32_t i = 0; i < num_rows; ++i) {
    multiply_row<block_size>(A, A.row_starts[i], A.row_starts[i + 1], x,
                             y + static_cast<std::ptrdiff_t>(i) * block_size);
  }
}

}  // namespace gabion
