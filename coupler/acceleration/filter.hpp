// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/settings/config_reader.hpp"

namespace gabion {

enum class FilterKind { none, qr1, qr1_absolute, qr2, qr3 };

/// The "filter" of coupler.json: which columns of a least-squares problem are dropped because the
/// newer ones nearly cover them.
///
/// With V = Q R from the newest column to the oldest, column i is dropped when
///
///     qr1            R_ii < limit |R|_F, repeated until none is left
///     qr1_absolute   R_ii < limit, repeated
///     qr2            the part of v_i across the newer kept ones is shorter than limit |v_i|
///     qr3            as qr2; there the test on R decides only whether qr2 has anything to do
///
/// The newest column is always kept. With every kind a column is dropped whose part across the
/// others is only round-off of the column.
/// @see Haelterman et al. (2016) for QR1 and QR2, Davis et al. (2022) for QR3
struct Filter {
  FilterKind kind = FilterKind::qr2;
  double limit = 1e-2;  ///< >= 0; < 1 where it is relative
};

/// The key "filter": a number is the limit of qr2, an object has "kind" and "limit".
std::vector<Key> filter_keys();
Filter read_filter(ConfigReader& in);

/// Least squares c = argmin |A c + t| over the columns of A that pass a filter, from a
/// factorisation that takes in a newer column with work that grows with the square of the size
/// only.
class FilteredLeastSquares {
 public:
  /// @param A  columns from the newest to the oldest
  FilteredLeastSquares(const Eigen::MatrixXd& A, const Filter& filter);

  /// Put a column before all others and filter again. New rows of the others are zero.
  /// @param a  as many rows as the columns have, or more
  void prepend(const Eigen::VectorXd& a, const Filter& filter);
  /// Forget the oldest columns, all but `count`. Those that are left count from 0 in kept().
  void keep_newest(Eigen::Index count);

  /// Columns that passed, in their order: of A; after prepend, of a and those kept before it.
  const std::vector<Eigen::Index>& kept() const { return kept_; }

  /// @param[in,out] t  becomes t + A c; as many rows as the columns have, or more
  /// @returns c of the kept columns
  Eigen::VectorXd solve(Eigen::VectorXd& t) const;

 private:
  void factor(const Eigen::MatrixXd& A, double limit);
  void drop_covered(const Filter& filter);
  void remove(Eigen::Index column);

  std::vector<Eigen::Index> kept_;
  Eigen::MatrixXd q_;  // rows of A x kept, orthonormal
  Eigen::MatrixXd r_;  // kept x kept, upper triangular
};

}  // namespace gabion
