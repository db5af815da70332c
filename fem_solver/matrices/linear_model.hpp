// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCore>
#include <cstdint>
#include <string>
#include <vector>

namespace gabion::fem {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// An unknown: a component of a node's displacement (directions 1, 2, 3) or rotation (4, 5, 6), or
/// the amplitude of a mode (node 0, its number as direction).
struct Unknown {
  std::int64_t node = 0;
  int direction = 0;
  bool operator==(const Unknown&) const = default;
};

/// "node 12, direction 2"
std::string name(const Unknown& unknown);

/// K u + C v + M a = f over the unknowns that are free. Symmetric; both triangles are stored.
struct LinearModel {
  SparseMatrix K;  ///< stiffness [N/m]
  SparseMatrix M;  ///< mass [kg]; 0 x 0: none, statics only
  SparseMatrix C;  ///< damping [N s/m]; 0 x 0: none
  std::vector<Unknown> unknowns;

  int size() const { return static_cast<int>(K.rows()); }
  bool damped() const { return C.rows() > 0; }
};

/// Rows and columns of a matrix. @param rows, columns  each once
SparseMatrix part_of(const SparseMatrix& A, const std::vector<int>& rows,
                     const std::vector<int>& columns);
/// The model whose other unknowns are held.
LinearModel part_of(const LinearModel& model, const std::vector<int>& kept);

}  // namespace gabion::fem
