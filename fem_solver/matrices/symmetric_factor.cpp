// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/symmetric_factor.hpp"

#include <cmath>

#include "common/base/require.hpp"

namespace gabion::fem {

namespace {

/// A pivot that is smaller than this part of its diagonal entry is rounding of a zero.
constexpr double smallest_pivot = 1e-13;
constexpr int largest_dense = 5000;

}  // namespace

SymmetricFactor::SymmetricFactor(const SparseMatrix& A, const std::vector<Unknown>& unknowns,
                                 const char* what) {
  const auto n = static_cast<double>(A.rows());
  if (A.rows() <= largest_dense && static_cast<double>(A.nonZeros()) > 0.25 * n * n) {
    factor_dense(A);
  } else {
    factor_sparse(A);
  }
  require<ConfigError>(bad_unknown_ < 0, [&] {
    return fmt::format(
        "{}: not positive definite: found the pivot {:.2g} of the diagonal entry at {} (row {} of "
        "the free unknowns), allowed: > {}",
        what, bad_pivot_, name(unknowns[bad_unknown_]), bad_unknown_ + 1, smallest_pivot);
  });
}

void SymmetricFactor::take_pivots(const Eigen::VectorXd& pivots,
                                  const Eigen::VectorXi& unknown_of_pivot,
                                  const Eigen::VectorXd& diagonal) {
  for (int k = 0; k < pivots.size() && bad_unknown_ < 0; ++k) {
    const int i = unknown_of_pivot[k];
    if (diagonal[i] > 0 && pivots[k] > smallest_pivot * diagonal[i]) continue;
    bad_unknown_ = i;
    bad_pivot_ = diagonal[i] != 0 ? pivots[k] / std::abs(diagonal[i]) : pivots[k];
  }
}

void SymmetricFactor::factor_dense(const SparseMatrix& A) {
  dense_.emplace(Eigen::MatrixXd(A));
  if (dense_->info() != Eigen::Success) {
    dense_.reset();
    factor_sparse(A);  // says which pivot is not positive
    return;
  }
  const auto n = static_cast<int>(A.rows());
  take_pivots(dense_->matrixLLT().diagonal().array().square(),
              Eigen::VectorXi::LinSpaced(n, 0, n - 1), A.diagonal());
}

void SymmetricFactor::factor_sparse(const SparseMatrix& A) {
  sparse_.emplace(A);
  Eigen::VectorXd pivots = sparse_->vectorD();
  for (double& pivot : pivots) pivot = std::isfinite(pivot) ? pivot : 0;
  Eigen::VectorXi order(A.rows());
  const auto& inverse = sparse_->permutationPinv().indices();
  for (int k = 0; k < order.size(); ++k) order[k] = inverse.size() > 0 ? inverse[k] : k;
  take_pivots(pivots, order, A.diagonal());
}

Eigen::VectorXd SymmetricFactor::solve(const Eigen::VectorXd& b) const {
  return dense_ ? Eigen::VectorXd(dense_->solve(b)) : Eigen::VectorXd(sparse_->solve(b));
}

Eigen::MatrixXd SymmetricFactor::solve(const Eigen::MatrixXd& b) const {
  return dense_ ? Eigen::MatrixXd(dense_->solve(b)) : Eigen::MatrixXd(sparse_->solve(b));
}

}  // namespace gabion::fem
