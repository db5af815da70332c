// SPDX-License-Identifier: BSD-3-Clause
// Reading the columns from memory is what takes the time, once the sums keep pace with it: partial
// sums lie side by side (the compiler must not reorder a plain sum, and would wait for each
// addition), and four columns are taken at a time, so that v is read less.
#include "coupler/acceleration/vector_sums.hpp"

namespace gabion {

namespace {

constexpr std::size_t width = 4;  // columns at a time

double dot(const double* q, const double* v, std::ptrdiff_t begin, std::ptrdiff_t end) {
  double sum = 0;
  for (std::ptrdiff_t i = begin; i < end; ++i) sum += q[i] * v[i];
  return sum;
}

struct Combination {
  const double* factors;
  double* sum;
};

/// Add to two sums at once, so that the columns are read less often.
void add_to_two(const Rows& columns, std::ptrdiff_t rows, const Combination& first,
                const Combination& second) {
  const double *u_factors = first.factors, *v_factors = second.factors;
  double *u = first.sum, *v = second.sum;
  std::size_t j = 0;
  for (; j + width <= columns.size(); j += width) {
    const double *a = columns[j], *b = columns[j + 1], *c = columns[j + 2], *d = columns[j + 3];
    const double *f = u_factors + j, *g = v_factors + j;
    const double f0 = f[0], f1 = f[1], f2 = f[2], f3 = f[3];
    const double g0 = g[0], g1 = g[1], g2 = g[2], g3 = g[3];
    for (std::ptrdiff_t i = 0; i < rows; ++i) {
      u[i] = u[i] + f0 * a[i] + f1 * b[i] + f2 * c[i] + f3 * d[i];
      v[i] = v[i] + g0 * a[i] + g1 * b[i] + g2 * c[i] + g3 * d[i];
    }
  }
  for (; j < columns.size(); ++j) {
    for (std::ptrdiff_t i = 0; i < rows; ++i) {
      u[i] += u_factors[j] * columns[j][i];
      v[i] += v_factors[j] * columns[j][i];
    }
  }
}

}  // namespace

void add_dots(const Rows& columns, const double* v, std::ptrdiff_t rows, double* dots) {
  constexpr int lanes = 4;
  const std::ptrdiff_t even = rows / lanes * lanes;
  std::size_t j = 0;
  for (; j + width <= columns.size(); j += width) {
    const double *a = columns[j], *b = columns[j + 1], *c = columns[j + 2], *d = columns[j + 3];
    double parts[width][lanes] = {};
    for (std::ptrdiff_t i = 0; i < even; i += lanes) {
      for (int k = 0; k < lanes; ++k) parts[0][k] += a[i + k] * v[i + k];
      for (int k = 0; k < lanes; ++k) parts[1][k] += b[i + k] * v[i + k];
      for (int k = 0; k < lanes; ++k) parts[2][k] += c[i + k] * v[i + k];
      for (int k = 0; k < lanes; ++k) parts[3][k] += d[i + k] * v[i + k];
    }
    for (std::size_t m = 0; m < width; ++m) {
      for (const double part : parts[m]) dots[j + m] += part;
      dots[j + m] += dot(columns[j + m], v, even, rows);
    }
  }
  for (; j < columns.size(); ++j) dots[j] += dot(columns[j], v, 0, rows);
}

void add_dots(const Rows& columns, std::ptrdiff_t rows, const Dots& first, const Dots& second) {
  constexpr int lanes = 2;  // more would not fit in the registers
  const double *v = first.vector, *r = second.vector;
  double *v_dots = first.sums, *r_dots = second.sums;
  const std::ptrdiff_t even = rows / lanes * lanes;
  std::size_t j = 0;
  for (; j + width <= columns.size(); j += width) {
    const double *a = columns[j], *b = columns[j + 1], *c = columns[j + 2], *d = columns[j + 3];
    double of_v[width][lanes] = {}, of_r[width][lanes] = {};
    for (std::ptrdiff_t i = 0; i < even; i += lanes) {
      for (int k = 0; k < lanes; ++k) {
        of_v[0][k] += a[i + k] * v[i + k];
        of_v[1][k] += b[i + k] * v[i + k];
        of_v[2][k] += c[i + k] * v[i + k];
        of_v[3][k] += d[i + k] * v[i + k];
        of_r[0][k] += a[i + k] * r[i + k];
        of_r[1][k] += b[i + k] * r[i + k];
        of_r[2][k] += c[i + k] * r[i + k];
        of_r[3][k] += d[i + k] * r[i + k];
      }
    }
    for (std::size_t m = 0; m < width; ++m) {
      v_dots[j + m] += of_v[m][0] + of_v[m][1] + dot(columns[j + m], v, even, rows);
      r_dots[j + m] += of_r[m][0] + of_r[m][1] + dot(columns[j + m], r, even, rows);
    }
  }
  for (; j < columns.size(); ++j) {
    v_dots[j] += dot(columns[j], v, 0, rows);
    r_dots[j] += dot(columns[j], r, 0, rows);
  }
}

void add_columns(const Rows& columns, const double* factors, std::ptrdiff_t rows, double* sum) {
  std::size_t j = 0;
  for (; j + width <= columns.size(); j += width) {
    const double *a = columns[j], *b = columns[j + 1], *c = columns[j + 2], *d = columns[j + 3];
    const double f0 = factors[j], f1 = factors[j + 1], f2 = factors[j + 2], f3 = factors[j + 3];
    for (std::ptrdiff_t i = 0; i < rows; ++i) {
      sum[i] = sum[i] + f0 * a[i] + f1 * b[i] + f2 * c[i] + f3 * d[i];
    }
  }
  for (; j < columns.size(); ++j) {
    for (std::ptrdiff_t i = 0; i < rows; ++i) sum[i] += factors[j] * columns[j][i];
  }
}

void add_columns(const Rows& columns, const Rows& factors, std::ptrdiff_t rows,
                 const std::vector<double*>& sums) {
  std::size_t l = 0;
  for (; l + 2 <= sums.size(); l += 2) {
    add_to_two(columns, rows, {factors[l], sums[l]}, {factors[l + 1], sums[l + 1]});
  }
  if (l < sums.size()) add_columns(columns, factors[l], rows, sums[l]);
}

}  // namespace gabion
