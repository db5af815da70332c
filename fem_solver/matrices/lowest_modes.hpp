// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "fem_solver/matrices/linear_model.hpp"

namespace gabion::fem {

/// Free vibrations K phi = omega^2 M phi.
struct Modes {
  Eigen::VectorXd omega2;  ///< ascending [1/s^2]
  Eigen::MatrixXd shapes;  ///< a column each, phi^T M phi = 1, the largest component positive
};

/// The modes of the lowest frequencies (SLEPc): all of them by LAPACK where the model is small or a
/// third of its modes is wanted, else by Krylov and Schur with K factorised. They are equal in
/// every bit when computed again.
/// @pre K and M positive definite; PETSc runs
/// @throws ConvergenceError  not found, or |K phi - omega^2 M phi| > 1e-6 |K phi|
Modes lowest_modes(const LinearModel& model, int count);

}  // namespace gabion::fem
