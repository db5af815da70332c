// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_solver/matrices/linear_model.hpp"

namespace gabion::fem {

/// A model over fewer coordinates q, u = T q: the unknowns that are kept, then amplitudes of the
/// lowest modes with these held (Craig and Bampton 1968):
///
///     T = [ 1 0 ; -K_ii^-1 K_ib Phi ] ,  K_ii Phi = M_ii Phi omega^2 ,  Phi^T M_ii Phi = 1
///
/// Static answers to forces on the kept unknowns are exact with any number of modes.
struct Reduction {
  LinearModel model;       ///< of q
  Eigen::MatrixXd T;       ///< unknowns x coordinates; takes that much memory
  Eigen::VectorXd omega2;  ///< of the modes, ascending [1/s^2]
};

/// @param kept  unknowns, ascending
/// @throws ConfigError       more modes than other unknowns; K_ii or M not positive definite
/// @throws ConvergenceError  modes were not found
Reduction craig_bampton(const LinearModel& full, const std::vector<int>& kept, int num_modes);

}  // namespace gabion::fem
