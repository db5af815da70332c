// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace gabion {

/// Pointers to the first of equally many rows of several vectors.
using Rows = std::vector<const double*>;

/// dots[k] += columns[k] . v
void add_dots(const Rows& columns, const double* v, std::ptrdiff_t rows, double* dots);

/// The sums of two vectors at once: sums[k] += columns[k] . vector
struct Dots {
  const double* vector;
  double* sums;
};
void add_dots(const Rows& columns, std::ptrdiff_t rows, const Dots& first, const Dots& second);

/// sum += factors[0] columns[0] + factors[1] columns[1] + ...
void add_columns(const Rows& columns, const double* factors, std::ptrdiff_t rows, double* sum);

/// Several sums at once: sums[l] += factors[l][0] columns[0] + factors[l][1] columns[1] + ...
void add_columns(const Rows& columns, const Rows& factors, std::ptrdiff_t rows,
                 const std::vector<double*>& sums);

}  // namespace gabion
