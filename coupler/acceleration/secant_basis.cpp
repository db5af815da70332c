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

/// Partial sums side by side: the compiler must not reorder a plain sum, and waits for each
/// addition.
double dot(const double* a, const double* b, Eigen::Index n) {
  constexpr int width = 8;
  std::array<double, width> sums = {};
  Eigen::Index i = 0;
  for (; i + width <= n; i += width) {
    for (int k = 0; k < width; ++k) sums[k] += a[i + k] * b[i + k];
  }
  for (; i < n; ++i) sums[0] += a[i] * b[i];
  double sum = 0;
  for (const double part : sums) sum += part;
  return sum;
}

/// Call action(first row, number of rows) for blocks of n rows.
template <class Action>
void for_blocks(Eigen::Index n, Action action) {
  for (Eigen::Index begin = 0; begin < n; begin += block_size) {
    action(begin, std::min(block_size, n - begin));
  }
}

}  // namespace

void SecantBasis::extend(const Eigen::VectorXd& v, const Eigen::VectorXd& r, Eigen::VectorXd& s,
                         Eigen::VectorXd& t) {
  const Eigen::Index n = v.size();
  const Eigen::Index m = size();
  s.setZero(m + 1);
  t.setZero(m + 1);
  for_blocks(n, [&](Eigen::Index at, Eigen::Index rows) {
    for (Eigen::Index j = 0; j < m; ++j) {
      const double* q = q_[j].data() + at;
      s(j) += dot(q, v.data() + at, rows);
      t(j) += dot(q, r.data() + at, rows);
    }
  });
  Eigen::VectorXd rest = v;
  Eigen::VectorXd left = Eigen::VectorXd::Zero(m);  // along the basis, by round-off
  for_blocks(n, [&](Eigen::Index at, Eigen::Index rows) {
    auto part = rest.segment(at, rows);
    for (Eigen::Index j = 0; j < m; ++j) part -= s(j) * q_[j].segment(at, rows);
    for (Eigen::Index j = 0; j < m; ++j) {
      left(j) += dot(q_[j].data() + at, part.data(), rows);
    }
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
  Eigen::VectorXd t(size());
  for (Eigen::Index j = 0; j < size(); ++j) {
    t(j) = dot(q_[j].data(), r.data(), r.size());
  }
  return t;
}

void SecantBasis::add(double factor, const Eigen::VectorXd& t, Eigen::VectorXd& sum) const {
  for_blocks(sum.size(), [&](Eigen::Index at, Eigen::Index rows) {
    auto part = sum.segment(at, rows);
    for (Eigen::Index j = 0; j < t.size(); ++j) {
      part += (factor * t(j)) * q_[j].segment(at, rows);
    }
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
  for_blocks(q_.front().size(), [&](Eigen::Index at, Eigen::Index rows) {
    rows_of_q.resize(rows, size());
    for (Eigen::Index j = 0; j < size(); ++j) rows_of_q.col(j) = q_[j].segment(at, rows);
    rows_of_q.applyOnTheRight(H);
    for (Eigen::Index j = surplus; j < size(); ++j) q_[j].segment(at, rows) = rows_of_q.col(j);
  });
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
