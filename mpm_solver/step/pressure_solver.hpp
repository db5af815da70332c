// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace gabion::mpm {

/// A symmetric positive definite matrix by rows.
struct SparseRows {
  std::vector<std::int32_t> starts, columns;  ///< columns ascending in each row
  std::vector<double> values;
};

/// Solves A x = b for A that is known by its products alone, by conjugate gradients (PETSc's CG)
/// with the incomplete Cholesky factors (ICC) of a sparse matrix that is near to A. On one rank.
class PressureSolver {
 public:
  /// y = A x.
  using Product = std::function<void(std::span<const double> x, std::span<double> y)>;

  /// @param near     a matrix near to A, whose memory is used
  PressureSolver(SparseRows near, Product product);
  ~PressureSolver();
  PressureSolver(const PressureSolver&) = delete;
  PressureSolver& operator=(const PressureSolver&) = delete;
  PressureSolver(PressureSolver&&) = delete;
  PressureSolver& operator=(PressureSolver&&) = delete;

  /// @param tolerance  of |b - A x|, by |b|
  /// @returns iterations; none where they do not converge, as with a matrix that is not positive
  ///          definite
  std::optional<int> solve(std::span<const double> b, std::span<double> x, double tolerance);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> impl_;
};

}  // namespace gabion::mpm
