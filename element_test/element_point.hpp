// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element_test/element_settings.hpp"

namespace gabion::element {

using Vector6 = Eigen::Matrix<double, 6, 1>;
/// Derivatives by the six strains and the pore pressure.
using Vector7 = Eigen::Matrix<double, 7, 1>;

/// State of the sample.
struct ElementState {
  double time = 0;                   ///< [s]
  Vector6 strain = Vector6::Zero();  ///< from where strains are zero: F - 1 by components, tension
                                     ///< positive; angles of shear
  Matrix<3> F = Matrix<3>::Identity();
  double log_J = 0;                         ///< of the volume over the stress-free one
  double zero_log_J = 0;                    ///< that where strains are zero
  Symmetric<3> tau = Symmetric<3>::Zero();  ///< of the skeleton [Pa]
  double pore_pressure = 0;                 ///< compression positive [Pa]
  MaterialState<3> history;
  InternalState internal = InternalState::Zero();
  std::vector<double> variables{};  ///< of a Umat
  YieldRegion region = YieldRegion::elastic;

  /// Total Cauchy stress, tension positive, in the order of component_names [Pa].
  Vector6 stress() const;
  /// Effective stress, that of the skeleton.
  Vector6 effective_stress() const;
};

/// Trial values of an increment.
struct Trial {
  Vector6 strain;            ///< at its end
  double pore_pressure = 0;  ///< at its end, where the water does not follow from the volume [Pa]
  double dt = 0;             ///< [s]
};

/// Behaviour of the pore water in an increment.
struct PoreState {
  bool undrained = false;
  double content = 0;  ///< of undrained soil with water, see PoreWater
};

/// Answer of the law to a trial.
struct Response {
  ElementState state;
  Eigen::Matrix<double, 6, 7> stress_slope;  ///< of the total stress by strains and pore pressure
  Vector7 log_J_slope;
};

/// One material point under a uniform deformation; its law is called as the solvers call it.
class ElementPoint {
 public:
  explicit ElementPoint(const ElementSettings& settings) : settings_(settings) {}

  /// The sample without strain, drained; its memory is that of virgin soil in the law.
  /// @throws ConvergenceError  the law has no stress there
  ElementState start() const;

  /// @returns why there is no answer, empty: there is one
  std::string answer(const ElementState& from, const PoreState& pores, const Trial& trial,
                     Response& response) const;

  /// Give a clay the memory that `initial_stress` of a run gives it under the present stress.
  /// @throws ConvergenceError  there are shear stresses
  void consolidate(double ocr, ElementState& state) const;

  /// lambda + 2 mu of the virgin soil [Pa].
  double stiffness() const;

 private:
  Matrix<3> gradient(const Vector6& strain) const;
  std::string add_water(const PoreState& pores, const Trial& trial, Response& response) const;
  void set_slopes(const ElementState& from, const StressUpdate<3>& update, const Tangent<3>& A,
                  Response& response) const;

  const ElementSettings& settings_;
};

}  // namespace gabion::element
