// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/secant_basis.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "coupler/acceleration/vector_sums.hpp"
#include "coupler/state_vectors.hpp"

namespace gabion {

namespace {

// Rows of a block: few enough for the cache, enough to read memory in one go.
constexpr Eigen::Index block_size = 1024;
constexpr double round_off = 1e-13;
constexpr double cancelled = 1e-3;

/// Pointers to the first row of a block in each vector.
Rows rows_at(const std::vector<Eigen::VectorXd>& q, Eigen::Index at) {
  Rows result;
  result.reserve(q.size());
  for (const Eigen::VectorXd& vector : q) result.push_back(vector.data() + at);
  return result;
}

/// Pointers to the columns of a matrix or of a block of it.
template <class Matrix>
auto columns_of(Matrix&& A) {
  std::vector<decltype(A.col(0).data())> result;
  for (Eigen::Index k = 0; k < A.cols(); ++k) result.push_back(A.col(k).data());
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
    add_dots(rows_at(q_, at), rows, {v.data() + at, s.data()}, {r.data() + at, t.data()});
  });
  Eigen::VectorXd rest = v;
  Eigen::VectorXd left = take_out(s, rest);
  // The part left along the basis is round-off of v. A second pass removes it but for an equally
  // small share. That suffices unless the rest is small itself: then this share counts against the
  // small rest, and the basis would lose its orthogonality column by column.
  for (int pass = 0; pass < 3 && left.norm() > round_off * rest.norm(); ++pass) {
    s.head(m) += left;
    if (left.norm() < cancelled * rest.norm()) {
      add(-1, left, rest);
      break;
    }
    left = take_out(left, rest);
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

Eigen::VectorXd SecantBasis::take_out(const Eigen::VectorXd& t, Eigen::VectorXd& rest) const {
  const Eigen::VectorXd minus_t = -t;
  Eigen::VectorXd left = Eigen::VectorXd::Zero(size());
  for_blocks(rest.size(), [&](Eigen::Index at, Eigen::Index rows) {
    const Rows columns = rows_at(q_, at);
    add_columns(columns, minus_t.data(), rows, rest.data() + at);
    add_dots(columns, rest.data() + at, rows, left.data());
  });
  return left;
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
    Rows parts;
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
  // Z spans the directions along which no column has a part. Householder reflections H that turn Z
  // into the first unit vectors change the basis so that its first vectors are not needed: work
  // grows with the surplus, not with the square of the size. Together they are H = I - Y T Y^T
  // (Schreiber, Van Loan 1989).
  const Eigen::HouseholderQR<Eigen::MatrixXd> of_s(s);
  Eigen::MatrixXd Z = Eigen::MatrixXd::Identity(s.rows(), s.rows()).rightCols(surplus);
  Z.applyOnTheLeft(of_s.householderQ());
  const Eigen::HouseholderQR<Eigen::MatrixXd> of_Z(Z);
  s.applyOnTheLeft(of_Z.householderQ().adjoint());
  s = s.bottomRows(s.rows() - surplus).eval();
  Eigen::MatrixXd Y = of_Z.matrixQR().triangularView<Eigen::UnitLower>();
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(surplus, surplus);
  for (Eigen::Index k = 0; k < surplus; ++k) {
    T(k, k) = of_Z.hCoeffs()(k);
    T.col(k).head(k) = -T(k, k) * (T.topLeftCorner(k, k) * (Y.leftCols(k).transpose() * Y.col(k)));
  }
  reflect(Y, Y * T);
  q_.erase(q_.begin(), q_.begin() + surplus);
}

void SecantBasis::reflect(const Eigen::MatrixXd& Y, const Eigen::MatrixXd& YT) {
  const Eigen::MatrixXd minus_Y = -Y.transpose();
  Eigen::MatrixXd P;  // Q Y T
  for_blocks(
      q_.front().size(),
      [&](Eigen::Index at, Eigen::Index rows) {
        P.setZero(rows, Y.cols());
        const std::vector<double*> in_P = columns_of(P);
        add_columns(rows_at(q_, at), columns_of(YT), rows, in_P);
        std::vector<double*> of_q;
        for (Eigen::VectorXd& q : q_) of_q.push_back(q.data() + at);
        of_q.erase(of_q.begin(), of_q.begin() + Y.cols());
        add_columns({in_P.begin(), in_P.end()}, columns_of(minus_Y.rightCols(size() - Y.cols())),
                    rows, of_q);
      },
      block_size / 4);  // every column is used as often as Y has columns
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

void SecantBasis::visit_state(StateVisitor& visitor) {
  visit_vectors(
      visitor, "secants.basis", q_.size(), [&](std::size_t count) { q_.resize(count); },
      [&](std::size_t k) -> Eigen::VectorXd& { return q_[k]; });
}

}  // namespace gabion
