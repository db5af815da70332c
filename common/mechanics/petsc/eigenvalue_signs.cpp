// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/eigenvalue_signs.hpp"

#include "common/mechanics/petsc/petsc_handle.hpp"
#include "common/mechanics/petsc/petsc_matrix.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"

namespace gabion {

template <int block_size>
std::int64_t count_negative_eigenvalues(const BlockMatrix<block_size>& K) {
  PetscMatrix<block_size> matrix(PETSC_COMM_SELF);
  matrix.set(K, {});
  MatHandle upper, factor;
  check_petsc(MatSetOption(matrix.rows(), MAT_SYMMETRIC, PETSC_TRUE), "MatSetOption");
  check_petsc(MatConvert(matrix.rows(), MATSEQSBAIJ, MAT_INITIAL_MATRIX, upper.receive()),
              "MatConvert");
  check_petsc(
      MatGetFactor(upper.get(), MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, factor.receive()),
      "MatGetFactor");
  MatFactorInfo info;
  check_petsc(MatFactorInfoInitialize(&info), "MatFactorInfoInitialize");
  check_petsc(MatCholeskyFactorSymbolic(factor.get(), upper.get(), nullptr, &info),
              "MatCholeskyFactorSymbolic");
  check_petsc(MatCholeskyFactorNumeric(factor.get(), upper.get(), &info),
              "MatCholeskyFactorNumeric");
  PetscInt negative = 0;
  check_petsc(MatGetInertia(factor.get(), &negative, nullptr, nullptr), "MatGetInertia");
  return negative;
}

template std::int64_t count_negative_eigenvalues<2>(const BlockMatrix<2>&);
template std::int64_t count_negative_eigenvalues<3>(const BlockMatrix<3>&);

}  // namespace gabion
