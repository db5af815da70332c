// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/filter.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <numeric>

#include "coupler/acceleration/vector_sums.hpp"

namespace gabion {

namespace {

constexpr double round_off = 1e-13;  // of a column's length

}  // namespace

Filter read_filter(ConfigReader& in, const std::string& key, const Filter& fallback) {
  static const std::map<std::string, FilterKind> kinds = {
      {"none", FilterKind::none},
      {"qr1", FilterKind::qr1},
      {"qr1_absolute", FilterKind::qr1_absolute},
      {"qr2", FilterKind::qr2},
      {"qr3", FilterKind::qr3}};
  const Range relative{[](double x) { return x >= 0 && x < 1; }, "a number >= 0 and < 1"};
  Filter filter = fallback;
  if (!in.is_object(key)) {
    filter.limit = in.number_or(key, fallback.limit, relative);
    return filter;
  }
  ConfigReader object = in.object(key);
  filter.kind = kinds.at(object.choice("kind", {"none", "qr1", "qr1_absolute", "qr2", "qr3"}));
  if (filter.kind == FilterKind::none) {
    filter.limit = 0;
  } else if (filter.kind == FilterKind::qr1_absolute) {
    filter.limit = object.number("limit", positive());
  } else {
    filter.limit = object.number_or("limit", fallback.limit, relative);
  }
  object.finish();
  return filter;
}

FilteredLeastSquares::FilteredLeastSquares(const Eigen::MatrixXd& A, const Filter& filter) {
  std::vector<Eigen::Index> columns(static_cast<std::size_t>(A.cols()));
  std::iota(columns.begin(), columns.end(), Eigen::Index{0});
  const bool by_length = filter.kind == FilterKind::qr2 || filter.kind == FilterKind::qr3;
  factor(A, columns, by_length ? filter.limit : 0);
  if (filter.kind != FilterKind::qr1 && filter.kind != FilterKind::qr1_absolute) return;
  for (;;) {
    const double least = filter.kind == FilterKind::qr1 ? filter.limit * r_.norm() : filter.limit;
    Eigen::Index i = 1;
    while (i < r_.cols() && r_(i, i) >= least) ++i;
    if (i >= r_.cols()) return;
    columns = kept_;
    columns.erase(columns.begin() + i);
    factor(A, columns, 0);
  }
}

void FilteredLeastSquares::factor(const Eigen::MatrixXd& A,
                                  const std::vector<Eigen::Index>& columns, double limit) {
  const Eigen::Index most = std::min<Eigen::Index>(A.rows(), A.cols());
  kept_.clear();
  q_.resize(A.rows(), most);
  r_.setZero(most, most);
  Eigen::Index kept = 0;
  Rows q;
  for (const Eigen::Index column : columns) {
    if (kept == most) break;
    const double length = A.col(column).norm();
    Eigen::VectorXd rest = A.col(column);
    Eigen::VectorXd along = Eigen::VectorXd::Zero(kept);
    for (int pass = 0; pass < 2; ++pass) {  // the second pass removes the round-off of the first
      Eigen::VectorXd part = Eigen::VectorXd::Zero(kept);
      add_dots(q, rest.data(), rest.size(), part.data());
      along += part;
      part = -part;
      add_columns(q, part.data(), rest.size(), rest.data());
    }
    const double across = rest.norm();
    if (!(across > round_off * length) || (kept > 0 && across < limit * length)) continue;
    q_.col(kept) = rest / across;
    q.push_back(q_.col(kept).data());
    r_.col(kept).head(kept) = along;
    r_(kept, kept) = across;
    kept_.push_back(column);
    ++kept;
  }
  q_.conservativeResize(Eigen::NoChange, kept);
  r_.conservativeResize(kept, kept);
}

Eigen::VectorXd FilteredLeastSquares::solve(Eigen::VectorXd& t) const {
  const Eigen::VectorXd along = q_.transpose() * t;
  t.noalias() -= q_ * along;
  return -r_.triangularView<Eigen::Upper>().solve(along);
}

}  // namespace gabion
