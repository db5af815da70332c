// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

class UmatModel;

/// Numbers that a point remembers of a Umat (UmatState).
inline constexpr int umat_state_size = 64;

/// A law that a shared library brings, called as Abaqus calls a user material (UMAT).
template <int dim>
class Umat {
 public:
  static constexpr bool is_elastic = false;

  explicit Umat(std::shared_ptr<const UmatModel> model) : model_(std::move(model)) {}

  /// The response in virgin soil, see ConstitutiveLaw.
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const {
    return update(PointContext{}, H, state_n, out, A);
  }
  bool update(const PointContext& context, const Matrix<dim>& H, const MaterialState<dim>& state_n,
              StressUpdate<dim>& out, Tangent<dim>* A) const;
  /// A step that strains the point by the same in all directions, without time; `out.P` has no
  /// meaning. @param strain  volumetric Hencky strain
  bool strain_evenly(const PointContext& context, double strain, StressUpdate<dim>& out) const;
  /// State variables of virgin soil, and of soil with a stress and a diagonal strain, which is
  /// elastic.
  void set_start(std::span<double> variables) const;
  void set_start(const Symmetric<dim>& tau, const Symmetric<dim>& log_strain,
                 std::span<double> variables) const;
  bool symmetric_tangent() const;
  double p_wave_modulus() const;  ///< of the stiffness at zero strain [Pa]
  double shear_modulus() const;   ///< of the stiffness at zero strain [Pa]
  int num_variables() const;      ///< NSTATV

 private:
  std::shared_ptr<const UmatModel> model_;
};

}  // namespace gabion
