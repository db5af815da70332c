// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fem_solver/matrices/craig_bampton.hpp"
#include "fem_solver/matrices/linear_model.hpp"

namespace gabion::fem {

/// The coordinates in which steps are solved: the unknowns, or the fewer ones of a reduction.
/// Refers to the model of the unknowns.
class Coordinates {
 public:
  /// Coordinates that are the unknowns themselves.
  explicit Coordinates(const LinearModel& full);
  /// A reduction to the unknowns `kept`, ascending, and so many modes.
  Coordinates(const LinearModel& full, std::vector<int> kept, int num_modes);

  /// The model in the coordinates.
  const LinearModel& model() const { return reduction_ ? reduction_->model : full_; }
  const LinearModel& full() const { return full_; }
  /// Omega^2 of the modes [1/s^2]; empty: none.
  Eigen::VectorXd omega2() const { return reduction_ ? reduction_->omega2 : Eigen::VectorXd(); }

  /// Coordinate that equals an unknown. @pre it is one of those kept
  int of_unknown(int unknown) const;
  /// One unknown, and all of them, from coordinates. @param q  coordinates, or their rates
  double unknown(const Eigen::VectorXd& q, int unknown) const;
  Eigen::VectorXd unknowns(const Eigen::VectorXd& q) const;
  /// Forces with the same work, T^T f.
  Eigen::VectorXd forces(const Eigen::VectorXd& f) const;
  /// The velocity whose difference to these velocities of the unknowns has the least energy.
  Eigen::VectorXd velocity(const Eigen::VectorXd& v) const;

 private:
  const LinearModel& full_;
  std::vector<int> kept_;
  std::optional<Reduction> reduction_;
};

}  // namespace gabion::fem
