// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem_solver/matrices/linear_model.hpp"

namespace gabion::fem {

/// Read a symmetric matrix; entries of one place are summed. The name of the file tells its format:
///
/// - `.sti`, `.mas`: of CalculiX, `*FREQUENCY, SOLVER=MATRIXSTORAGE`: rows "row column value" of
/// one
///   triangle, the diagonal complete;
/// - else Matrix Market, coordinate, real or integer: symmetric (lower triangle), or general, whose
///   two triangles may differ by 1e-9 of sqrt(|a_ii a_jj|) and are averaged.
///
/// @throws ConfigError  file and line: not of this format, not square, not symmetric
SparseMatrix read_symmetric_matrix(const std::string& path);

/// Read a vector: Matrix Market, array or coordinate, n x 1.
/// @throws ConfigError
Eigen::VectorXd read_vector(const std::string& path);

/// Read the unknowns of the matrices' rows: rows "node, direction", the direction from 1 to 6. A
/// name that ends in `.dof` is a file of CalculiX: rows "node.direction".
/// @throws ConfigError  not this, or an unknown twice
std::vector<Unknown> read_unknowns(const std::string& path);

/// Read the unknowns that are held: rows "node, direction", or "node" alone for all its directions.
/// @throws ConfigError
std::vector<Unknown> read_held(const std::string& path);

/// Write the lower triangle as Matrix Market, with all digits.
/// @throws Error  the file cannot be written
void write_symmetric_matrix(const std::string& path, const SparseMatrix& A);
/// Write n x 1 as Matrix Market, array.
void write_vector(const std::string& path, const Eigen::VectorXd& x);

}  // namespace gabion::fem
