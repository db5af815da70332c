// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/filter.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <numeric>

#include "coupler/acceleration/vector_sums.hpp"

namespace gabion {

std::vector<Key> filter_keys() {
  const Filter defaults;
  const Range relative{.low = 0, .high = 1, .high_open = true, .allowed = "a number >= 0 and < 1"};
  const KeyTable table{
      "filter",
      "Which columns are dropped because newer ones nearly cover them (V = Q R, newest first).",
      {key::choice("kind", {"none", "qr1", "qr1_absolute", "qr2", "qr3"},
                   "`qr2`: the part orthogonal to the newer columns kept is shorter than `limit` "
                   "times the column; `qr3`: likewise, after a cheap test on R; `qr1`: R_ii < "
                   "`limit` |R|_F; `qr1_absolute`: R_ii < `limit`; `none`: only round-off."),
       key::number("limit", "", "Share below which a column is dropped.")
           .in(relative)
           .or_else(defaults.limit)
           .when("kind", {"qr1", "qr2", "qr3"}),
       key::number("limit", "",
                   "R_ii below which a column is dropped, in the units of the residual.")
           .in(positive())
           .when("kind", {"qr1_absolute"})}};
  return {key::number("filter", "",
                      "Limit of the filter `qr2`: a column is dropped when its part orthogonal to "
                      "the newer columns kept is shorter than this share of its length.")
              .in(relative)
              .or_else(defaults.limit),
          key::object("filter", table, "A filter of another kind.").or_none()};
}

Filter read_filter(ConfigReader& in) {
  static const std::map<std::string, FilterKind> kinds = {
      {"none", FilterKind::none},
      {"qr1", FilterKind::qr1},
      {"qr1_absolute", FilterKind::qr1_absolute},
      {"qr2", FilterKind::qr2},
      {"qr3", FilterKind::qr3}};
  Filter filter;
  if (!in.is_object("filter")) {
    filter.limit = in.number("filter");
    return filter;
  }
  ConfigReader object = in.object("filter");
  filter.kind = kinds.at(object.choice("kind"));
  filter.limit = filter.kind == FilterKind::none ? 0 : object.number("limit");
  object.finish();
  return filter;
}

namespace {

constexpr double round_off = 1e-13;  // share of a column's length that counts as rounding

double limit_of_length(const Filter& filter) {
  return filter.kind == FilterKind::qr2 || filter.kind == FilterKind::qr3 ? filter.limit : 0;
}

std::vector<Eigen::Index> numbers_below(Eigen::Index count) {
  std::vector<Eigen::Index> result(static_cast<std::size_t>(count));
  std::iota(result.begin(), result.end(), Eigen::Index{0});
  return result;
}

/// Take out of `rest` its part along orthonormal columns. @returns their factors
Eigen::VectorXd take_out(const Rows& q, Eigen::VectorXd& rest) {
  const auto size = static_cast<Eigen::Index>(q.size());
  Eigen::VectorXd along = Eigen::VectorXd::Zero(size);
  for (int pass = 0; pass < 2; ++pass) {  // the second pass removes the round-off of the first
    Eigen::VectorXd part = Eigen::VectorXd::Zero(size);
    add_dots(q, rest.data(), rest.size(), part.data());
    along += part;
    part = -part;
    add_columns(q, part.data(), rest.size(), rest.data());
  }
  return along;
}

/// Rotate rows i and i + 1 of R so that R(i + 1, column) vanishes, and columns of Q against them.
/// Left of `column` both rows are zero.
void rotate(Eigen::MatrixXd& Q, Eigen::MatrixXd& R, Eigen::Index i, Eigen::Index column) {
  Eigen::JacobiRotation<double> turn;
  double length = 0;
  turn.makeGivens(R(i, column), R(i + 1, column), &length);
  R(i, column) = length;
  R(i + 1, column) = 0;
  R.rightCols(R.cols() - column - 1).applyOnTheLeft(i, i + 1, turn.adjoint());
  Q.applyOnTheRight(i, i + 1, turn);
}

}  // namespace

FilteredLeastSquares::FilteredLeastSquares(const Eigen::MatrixXd& A, const Filter& filter) {
  factor(A, limit_of_length(filter));
  drop_covered(filter);
}

void FilteredLeastSquares::factor(const Eigen::MatrixXd& A, double limit) {
  const Eigen::Index most = std::min<Eigen::Index>(A.rows(), A.cols());
  q_.resize(A.rows(), most);
  r_.setZero(most, most);
  Eigen::Index kept = 0;
  Rows q;
  for (Eigen::Index column = 0; column < A.cols() && kept < most; ++column) {
    const double length = A.col(column).norm();
    Eigen::VectorXd rest = A.col(column);
    r_.col(kept).head(kept) = take_out(q, rest);
    const double across = rest.norm();
    if (!(across > round_off * length) || (kept > 0 && across < limit * length)) continue;
    q_.col(kept) = rest / across;
    q.push_back(q_.col(kept).data());
    r_(kept, kept) = across;
    kept_.push_back(column);
    ++kept;
  }
  q_.conservativeResize(Eigen::NoChange, kept);
  r_.conservativeResize(kept, kept);
}

// [a A] = [q Q] R with R a full first column beside the old R: rotations of neighbouring rows, from
// the last to the first, turn that column into one entry and fill only the next diagonal.
void FilteredLeastSquares::prepend(const Eigen::VectorXd& a, const Filter& filter) {
  const Eigen::Index old = r_.cols();
  Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(a.size(), old + 1);
  Q.topLeftCorner(q_.rows(), old) = q_;
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(old + 1, old + 1);
  R.topRightCorner(old, old) = r_;
  Rows q;
  for (Eigen::Index k = 0; k < old; ++k) q.push_back(Q.col(k).data());
  Eigen::VectorXd rest = a;
  R.col(0).head(old) = take_out(q, rest);
  const double across = rest.norm();
  if (across > round_off * a.norm()) {
    R(old, 0) = across;
    Q.col(old) = rest / across;
  }
  for (Eigen::Index i = old - 1; i >= 0; --i) rotate(Q, R, i, 0);
  q_ = std::move(Q);
  r_ = std::move(R);
  kept_ = numbers_below(old + 1);
  drop_covered(filter);
}

void FilteredLeastSquares::keep_newest(Eigen::Index count) {
  count = std::min(count, r_.cols());
  r_.conservativeResize(count, count);
  q_.conservativeResize(Eigen::NoChange, count);
  kept_ = numbers_below(count);
}

// The part of R without a dropped column is that of Gram-Schmidt without this column: the test of
// the next column is that of a factorisation from the newest to the oldest.
void FilteredLeastSquares::drop_covered(const Filter& filter) {
  const double limit = limit_of_length(filter);
  for (Eigen::Index i = 1; i < r_.cols();) {
    const double length = r_.col(i).head(i + 1).norm();
    const double across = std::abs(r_(i, i));
    if (!(across > round_off * length) || across < limit * length) {
      remove(i);
    } else {
      ++i;
    }
  }
  if (filter.kind != FilterKind::qr1 && filter.kind != FilterKind::qr1_absolute) return;
  for (Eigen::Index i = 1; i < r_.cols();) {
    const double least = filter.kind == FilterKind::qr1 ? filter.limit * r_.norm() : filter.limit;
    if (std::abs(r_(i, i)) < least) {
      remove(i);
      i = 1;
    } else {
      ++i;
    }
  }
}

void FilteredLeastSquares::remove(Eigen::Index column) {
  const Eigen::Index last = r_.cols() - 1;
  for (Eigen::Index k = column; k < last; ++k) r_.col(k) = r_.col(k + 1).eval();
  r_.conservativeResize(Eigen::NoChange, last);
  for (Eigen::Index i = column; i < last; ++i) rotate(q_, r_, i, i);
  r_.conservativeResize(last, Eigen::NoChange);
  q_.conservativeResize(Eigen::NoChange, last);
  kept_.erase(kept_.begin() + column);
}

Eigen::VectorXd FilteredLeastSquares::solve(Eigen::VectorXd& t) const {
  const Eigen::VectorXd along = q_.transpose() * t.head(q_.rows());
  t.head(q_.rows()).noalias() -= q_ * along;
  return -r_.triangularView<Eigen::Upper>().solve(along);
}

}  // namespace gabion
