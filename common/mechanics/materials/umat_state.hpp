// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <span>

#include "common/mechanics/materials/umat.hpp"

namespace gabion {

/// State of a user material at a point, in one array: Cauchy stress, STRAN, F - 1, the stored
/// energy, time and number of increments, then STATEV. Tensors are those at the end of the last
/// increment, with true components.
class UmatState {
 public:
  static constexpr int first_variable = 24, size = umat_state_size;
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  explicit UmatState(std::span<const double> values) {
    std::copy_n(values.begin(), size, values_.begin());
  }
  static UmatState virgin(std::span<const double> variables) {
    UmatState state;
    std::ranges::copy(variables, state.values_.begin() + first_variable);
    return state;
  }

  Vector6 stress() const { return Eigen::Map<const Vector6>(values_.data()); }      ///< [Pa]
  Vector6 strain() const { return Eigen::Map<const Vector6>(values_.data() + 6); }  ///< STRAN
  Eigen::Matrix3d displacement_gradient() const {                                   ///< F - 1
    return Eigen::Map<const Eigen::Matrix3d>(values_.data() + 12);
  }
  double energy() const { return values_[21]; }  ///< stored, over V0 [J/m^3]
  double time() const { return values_[22]; }    ///< [s]
  int count() const { return static_cast<int>(values_[23]); }
  std::span<const double> variables(int count) const {
    return std::span(values_).subspan(first_variable, count);
  }

  /// An increment at its end.
  struct End {
    Vector6 stress, strain;
    Eigen::Matrix3d displacement_gradient;
    double energy = 0, dt = 0;
    std::span<const double> variables{};
  };
  void set(const End& end) {
    Eigen::Map<Vector6>(values_.data()) = end.stress;
    Eigen::Map<Vector6>(values_.data() + 6) = end.strain;
    Eigen::Map<Eigen::Matrix3d>(values_.data() + 12) = end.displacement_gradient;
    values_[21] = end.energy;
    values_[22] += end.dt;
    values_[23] += 1;
    std::ranges::copy(end.variables, values_.begin() + first_variable);
  }
  /// The next increment is the first one.
  void forget_count() { values_[23] = 0; }
  void copy_to(std::span<double> values) const { std::ranges::copy(values_, values.begin()); }

 private:
  UmatState() = default;
  std::array<double, size> values_{};
};

}  // namespace gabion
