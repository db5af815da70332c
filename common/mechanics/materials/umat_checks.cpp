// SPDX-License-Identifier: BSD-3-Clause
// Checks of a user material when it is loaded.
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/mechanics/materials/umat_model.hpp"

namespace gabion {
namespace {

using Vector6 = UmatCall::Vector6;
using Matrix6 = UmatAnswer::Matrix6;

constexpr double dt = 1e-3;           // of the trial increments [s]
constexpr double difference = 1e-7;   // of a strain, for derivatives
constexpr double exact = 1e-6;        // relative error of a derivative by such differences
constexpr double poor = 1e-2;         // relative error of a tangent from which on a warning is
                                      // given
constexpr double same_stress = 1e-8;  // of a turned path
constexpr std::array sizes = {1e-5, 1e-3, 1e-2};  // of the trial strains
constexpr double visible = 1e-3;                  // change of a constant that has an effect
constexpr double fine = 0x1p-30;  // change of a constant that single precision does not see
constexpr double effect = 1e-5;   // relative change of the answer that is one

// A strain of this size with shear and change of volume.
Vector6 trial_strain(double size, int n) {
  Vector6 strain;
  strain << -1, 0.4, -0.3, 0.5, -0.2, 0.3;
  strain.tail(6 - n).setZero();
  return size * strain;
}

Matrix6 turned(const Eigen::Matrix3d& Q) {
  // maps true components; of each unit tensor
  constexpr int row[] = {0, 1, 2, 0, 1, 0}, column[] = {0, 1, 2, 1, 2, 2};
  Matrix6 T;
  for (int l = 0; l < 6; ++l) {
    Eigen::Matrix3d unit = Eigen::Matrix3d::Zero();
    unit(row[l], column[l]) = 1;
    unit(column[l], row[l]) = 1;
    const Eigen::Matrix3d moved = Q * unit * Q.transpose();
    for (int k = 0; k < 6; ++k) T(k, l) = moved(row[k], column[k]);
  }
  return T;
}

/// The trial calls of one model.
struct Trial {
  const UmatModel& model;
  std::vector<double> virgin = model.initial_variables();

  UmatCall from_virgin(double size) const {
    return {.increment = trial_strain(size, model.size()), .variables = virgin, .dt = dt};
  }
  UmatAnswer answer(double size) const { return model.call(from_virgin(size)); }

  // The answer with a filling behind PROPS, and another one behind STATEV.
  UmatAnswer answer(double size, double behind_constants, double behind_variables) const {
    std::vector<double> constants = model.constants();
    std::fill(constants.end() - umat_room, constants.end(), behind_constants);
    UmatCall call = from_virgin(size);
    call.constants = constants;
    call.behind_variables = behind_variables;
    return model.call(call);
  }

  // Relative change of the answer where a constant is larger by this share.
  double change(double size, std::size_t constant, double share) const {
    const UmatAnswer plain = answer(size);
    std::vector<double> constants = model.constants();
    constants[constant] *= 1 + share;
    UmatCall call = from_virgin(size);
    call.constants = constants;
    const UmatAnswer other = model.call(call);
    return (other.stress - plain.stress).norm() / plain.stress.norm() +
           (other.tangent - plain.tangent).norm() / plain.tangent.norm();
  }

  // Derivative of the stress by the increment.
  Matrix6 differences(double size) const {
    Matrix6 D = Matrix6::Zero();
    for (int l = 0; l < model.size(); ++l) {
      UmatCall call = from_virgin(size);
      call.increment[l] += difference;
      const Vector6 up = model.call(call).stress;
      call.increment[l] -= 2 * difference;
      D.col(l) = (up - model.call(call).stress) / (2 * difference);
    }
    return D;
  }

  // The second of two increments in turned axes against the same in the axes of the first.
  double turned_error() const {
    const UmatAnswer first = answer(sizes[1]);
    UmatCall call{.stress = first.stress,
                  .strain = trial_strain(sizes[1], model.size()),
                  .increment = -0.3 * trial_strain(sizes[1], model.size()),
                  .variables = std::span(first.variables).first(virgin.size()),
                  .time = dt,
                  .dt = dt,
                  .number = 2};
    call.increment[3] = sizes[1];
    const Vector6 plain = model.call(call).stress;
    const double angle = 0.7;
    Eigen::Matrix3d Q = Eigen::Matrix3d::Identity();
    Q.topLeftCorner<2, 2>() << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    const Matrix6 T = turned(Q);
    call.stress = T * call.stress;
    call.strain = T * call.strain;
    call.increment = T * call.increment;
    call.rotation = Q;
    call.F1 = Q;
    return (model.call(call).stress - T * plain).norm() / plain.norm();
  }

  bool repeats() const {
    const UmatAnswer once = answer(sizes[1]);
    if (!once.finite()) return true;  // check_finite says it better
    answer(-0.5 * sizes[2]);
    return same(once, answer(sizes[1]));
  }

  static bool same(const UmatAnswer& a, const UmatAnswer& b) {
    return a.stress == b.stress && a.tangent == b.tangent &&
           std::memcmp(a.variables.data(), b.variables.data(), sizeof(a.variables)) == 0;
  }
};

}  // namespace

void UmatModel::check_finite(const UmatAnswer& answer, const char* of) const {
  if (answer.finite()) return;
  throw ConfigError(fmt::format(
      "{}: found numbers that are not finite in the answer of the UMAT of {} to {}, allowed: "
      "finite stress, tangent and state variables; \"constants\" ({}) or \"initial_variables\" "
      "({}) may be too few or out of order",
      settings_.where, settings_.library, of, settings_.constants.size(), num_variables()));
}

// Check that a subroutine neither reads nor writes behind PROPS and STATEV.
void UmatModel::check_room() const {
  const Trial trial{*this};
  const double no_number = std::numeric_limits<double>::quiet_NaN();
  for (const double size : sizes) {
    const UmatAnswer plain = trial.answer(size);
    if (!plain.finite()) continue;  // check_finite says it better
    for (const double filling : {1.0, no_number}) {
      if (!Trial::same(plain, trial.answer(size, filling, 0))) {
        throw ConfigError(fmt::format(
            "{}/constants: found {} numbers, allowed: as many as the UMAT of {} reads, which are "
            "more",
            settings_.where, settings_.constants.size(), settings_.library));
      }
      const UmatAnswer other = trial.answer(size, 0, filling);
      if (plain.overrun || other.overrun || !Trial::same(plain, other)) {
        throw ConfigError(fmt::format(
            "{}/initial_variables: found {} numbers, allowed: as many as the UMAT of {} has state "
            "variables, which are more",
            settings_.where, num_variables(), settings_.library));
      }
    }
  }
}

void UmatModel::check_precision() const {
  const Trial trial{*this};
  for (std::size_t k = 0; k < settings_.constants.size(); ++k) {
    bool has_effect = false, is_fine = false;
    for (const double size : sizes) {
      has_effect = has_effect || trial.change(size, k, visible) > effect;
      is_fine = is_fine || trial.change(size, k, fine) > 0 || trial.change(size, k, 2 * fine) > 0;
    }
    if (!has_effect || is_fine) continue;
    log::warn(
        "{}/constants/{}: a change by {:.0e} changes what the UMAT answers, a change by {:.0e} "
        "does not: it computes in single precision (look for IMPLICIT REAL*8), or takes steps",
        settings_.where, k, visible, fine);
  }
}

void UmatModel::check() {
  const Trial trial{*this};
  const UmatAnswer still = call({.variables = trial.virgin, .dt = dt});
  check_finite(still, "no strain");
  if (!trial.repeats()) {
    throw ConfigError(settings_.where + ": found two answers of the UMAT of " + settings_.library +
                      " to the same call, allowed: a subroutine that remembers nothing but STATEV "
                      "(look for SAVE and COMMON)");
  }
  check_room();
  stiffness_ = still.tangent;
  if (!(stiffness_.diagonal().head(size()).minCoeff() > 0)) {
    throw ConfigError(fmt::format(
        "{}: found a tangent without stiffness ({:.4g} Pa) in virgin soil, allowed: DDSDDE with a "
        "positive diagonal",
        settings_.where, stiffness_.diagonal().head(size()).minCoeff()));
  }
  check_precision();
  double error = 0;
  for (const double size : sizes) {
    const UmatAnswer answer = trial.answer(size);
    check_finite(answer, "a strain");
    const Matrix6 D = trial.differences(size);
    Matrix6 less = answer.tangent;
    for (int l = 0; l < 3; ++l) less.col(l) -= answer.stress;
    const double cauchy = (answer.tangent - D).norm() / D.norm();
    const double kirchhoff = (less - D).norm() / D.norm();
    if (kirchhoff < exact && cauchy > 10 * kirchhoff) tangent_ = UmatTangent::kirchhoff;
    error = std::max(error, std::min(cauchy, kirchhoff));
  }
  if (error > poor) {
    log::warn(
        "{}: the tangent of the UMAT differs by {:.2g} from differences of its stress: "
        "Newton's method may need many iterations, or shorter steps",
        settings_.where, error);
  }
  const double turned = trial.turned_error();
  if (!(turned < same_stress)) {
    log::warn(
        "{}: the stress of the UMAT in turned axes differs by {:.2g} from the turned stress: "
        "state variables that are tensors have to be turned by DROT, or constants belong to "
        "fixed axes",
        settings_.where, turned);
  }
}

}  // namespace gabion
