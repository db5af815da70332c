// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <optional>

#include "fem_solver/matrices/linear_model.hpp"

namespace gabion::fem {

/// L D L^T of a symmetric positive definite matrix (Eigen): sparse with a minimum degree ordering,
/// dense where a quarter of the entries is there, as after a reduction.
class SymmetricFactor {
 public:
  /// @param what  for messages, such as "mass"
  /// @throws ConfigError  not positive definite, with the unknown whose pivot says so
  SymmetricFactor(const SparseMatrix& A, const std::vector<Unknown>& unknowns, const char* what);

  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;

 private:
  void factor_dense(const SparseMatrix& A);
  void factor_sparse(const SparseMatrix& A);
  void take_pivots(const Eigen::VectorXd& pivots, const Eigen::VectorXi& unknown_of_pivot,
                   const Eigen::VectorXd& diagonal);

  int bad_unknown_ = -1;  // has a pivot that is not positive
  double bad_pivot_ = 0;  // by the entry of its diagonal
  std::optional<Eigen::LLT<Eigen::MatrixXd>> dense_;
  std::optional<Eigen::SimplicialLDLT<SparseMatrix>> sparse_;
};

}  // namespace gabion::fem
