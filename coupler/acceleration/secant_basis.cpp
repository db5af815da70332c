// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/secant_basis.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

namespace gabion {

namespace {

constexpr Eigen::Index block_size = 1024;  // rows that stay in the cache between two uses
constexpr double round_off = 1e-13;

/// sums[k] += columns[k] . v of n rows, with partial sums side by side: the compiler must not
/// reorder a plain sum, and would wait for each addition.
void add_dots(const std::vector<const double*>& columns, const double* v, Eigen::Index n,
              double* sums) {
  constexpr int width = 8;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    const double* q = columns[j];
    std::array<double, width> parts = {};
    Eigen::Index i = 0;
    for (; i + width <= n; i += width) {
      for (int k = 0; k < width; ++k) parts[k] += q[i + k] * v[i + k];
    }
    for (; i < n; ++i) parts[0] += q[i] * v[i];
    for (const double part : parts) sums[j] += part;
  }
}

/// v += sum_k factors[k] columns[k] of n rows, four columns at a time: v is read and written less.
void add_columns(const std::vector<const double*>& columns, const double* factors, Eigen::Index n,
                 double* v) {
  constexpr int width = 4;
  const std::size_t even = columns.size() / width * width;
  for (std::size_t j = 0; j < even; j += width) {
    const double *a = columns[j], *b = columns[j + 1], *c = columns[j + 2], *d = columns[j + 3];
    const double* f = factors + j;
    for (Eigen::Index i = 0; i < n; ++i) {
      v[i] += (f[0] * a[i] + f[1] * b[i]) + (f[2] * c[i] + f[3] * d[i]);
    }
  }
  for (std::size_t j = even; j < columns.size(); ++j) {
    for (Eigen::Index i = 0; i < n; ++i) v[i] += factors[j] * columns[j][i];
  }
}

/// Where the rows of a block begin in each vector.
std::vector<const double*> rows_at(const std::vector<Eigen::VectorXd>& q, Eigen::Index at) {
  std::vector<const double*> result;
  result.reserve(q.size());
  for (const Eigen::VectorXd& vector : q) result.push_back(vector.data() + at);
  return result;
}

/// Call action(first row, number of rows) for blocks of n rows.
template <class Action>
void for_blocks(Eigen::Index n, Action action, Eigen::Index size = block_size) {
  for (Eigen::Index begin = 0; begin < n; begin += size) action(begin, std::min(size, n - begin));
}

}  // namespace

void SecantBasis::extend(const Eigen::VectorXd& v, const Eigen::VectorXd& r, Eigen::VectorXd& s,
                         Eigen::VectorXd& t) {
  const Eigen::Index n = v.size();
  const Eigen::Index m = size();
  s.setZero(m + 1);
  t.setZero(m + 1);
  for_blocks(n, [&](Eigen::Index at, Eigen::Index rows) {
    const auto columns = rows_at(q_, at);
    add_dots(columns, v.data() + at, rows, s.data());
    add_dots(columns, r.data() + at, rows, t.data());
  });
  Eigen::VectorXd rest = v;
  Eigen::VectorXd left = Eigen::VectorXd::Zero(m);  // along the basis, by round-off
  const Eigen::VectorXd minus_s = -s;
  for_blocks(n, [&](Eigen::Index at, Eigen::Index rows) {
    const auto columns = rows_at(q_, at);
    add_columns(columns, minus_s.data(), rows, rest.data() + at);
    add_dots(columns, rest.data() + at, rows, left.data());
  });
  if (left.norm() > round_off * rest.norm()) {
    add(-1, left, rest);
    s.head(m) += left;
  }
  const double across = rest.norm();
  if (!(across > round_off * v.norm())) {
    s.conservativeResize(m);
    t.conservativeResize(m);
    return;
  }
  s(m) = across;
  q_.push_back(rest / across);
  t(m) = q_.back().dot(r);
}

Eigen::VectorXd SecantBasis::coordinates(const Eigen::VectorXd& r) const {
  Eigen::VectorXd t = Eigen::VectorXd::Zero(size());
  for_blocks(r.size(), [&](Eigen::Index at, Eigen::Index rows) {
    add_dots(rows_at(q_, at), r.data() + at, rows, t.data());
  });
  return t;
}

void SecantBasis::add(double factor, const Eigen::VectorXd& t, Eigen::VectorXd& sum) const {
  const Eigen::VectorXd factors = factor * t;
  for_blocks(sum.size(), [&](Eigen::Index at, Eigen::Index rows) {
    auto columns = rows_at(q_, at);
    columns.resize(static_cast<std::size_t>(t.size()));
    add_columns(columns, factors.data(), rows, sum.data() + at);
  });
}

void add_combination(const std::vector<const Eigen::VectorXd*>& columns,
                     const std::vector<double>& factors, Eigen::VectorXd& sum) {
  for_blocks(sum.size(), [&](Eigen::Index at, Eigen::Index rows) {
    std::vector<const double*> parts;
    for (const Eigen::VectorXd* column : columns) parts.push_back(column->data() + at);
    add_columns(parts, factors.data(), rows, sum.data() + at);
  });
}

void SecantBasis::truncate(Eigen::Index size) {
  q_.resize(std::min(q_.size(), static_cast<std::size_t>(size)));
}

void SecantBasis::shrink(Eigen::MatrixXd& s) {
  const Eigen::Index surplus = size() - s.cols();
  if (surplus <= 0) return;
  if (s.cols() == 0) {
    q_.clear();
    s.resize(0, 0);
    return;
  }
  // Z: what no column has a part along. Householder reflections that turn Z into the first unit
  // vectors change the basis so that its first vectors are not needed: work grows with the surplus,
  // not with the square of the size.
  const Eigen::HouseholderQR<Eigen::MatrixXd> of_s(s);
  Eigen::MatrixXd Z = Eigen::MatrixXd::Identity(s.rows(), s.rows()).rightCols(surplus);
  Z.applyOnTheLeft(of_s.householderQ());
  const Eigen::HouseholderQR<Eigen::MatrixXd> of_Z(Z);
  const auto H = of_Z.householderQ();
  s.applyOnTheLeft(H.adjoint());
  s = s.bottomRows(s.rows() - surplus).eval();
  Eigen::MatrixXd rows_of_q;
  for_blocks(
      q_.front().size(),
      [&](Eigen::Index at, Eigen::Index rows) {
        rows_of_q.resize(rows, size());
        for (Eigen::Index j = 0; j < size(); ++j) rows_of_q.col(j) = q_[j].segment(at, rows);
        rows_of_q.applyOnTheRight(H);
        for (Eigen::Index j = surplus; j < size(); ++j) q_[j].segment(at, rows) = rows_of_q.col(j);
      },
      block_size / 8);
  q_.erase(q_.begin(), q_.begin() + surplus);
}

Eigen::MatrixXd SecantBasis::rescale(const Eigen::VectorXd& ratio) {
  std::vector<Eigen::VectorXd> old;
  old.swap(q_);
  const auto m = static_cast<Eigen::Index>(old.size());
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(m, m);
  for (Eigen::Index j = 0; j < m; ++j) {
    Eigen::VectorXd rest = ratio.cwiseProduct(old[j]);
    for (int pass = 0; pass < 2; ++pass) {
      const Eigen::VectorXd part = coordinates(rest);
      add(-1, part, rest);
      T.col(j).head(j) += part;
    }
    T(j, j) = rest.norm();
    q_.push_back(rest / T(j, j));
  }
  return T;
}

}  // namespace gabion
