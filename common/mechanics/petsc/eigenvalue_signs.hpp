// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "common/mechanics/petsc/block_matrix.hpp"

namespace gabion {

/// Negative eigenvalues of a symmetric matrix on one rank, counted in its factors L D L^T
/// (Sylvester's law of inertia, 1852). Of a matrix that is not symmetric the upper triangle counts.
/// @note Costs a factorisation.
template <int block_size>
std::int64_t count_negative_eigenvalues(const BlockMatrix<block_size>& K);

}  // namespace gabion
