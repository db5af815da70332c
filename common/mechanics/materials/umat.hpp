// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

class UmatModel;

/// A law that a shared library brings, called as Abaqus calls a user material (UMAT).
template <int dim>
class Umat {
 public:
  static constexpr bool is_elastic = false;

  explicit Umat(std::shared_ptr<const UmatModel> model) : model_(std::move(model)) {}

  /// In virgin soil, see ConstitutiveLaw.
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const {
    return update(PointContext{}, H, state_n, out, A);
  }
  bool update(const PointContext& context, const Matrix<dim>& H, const MaterialState<dim>& state_n,
              StressUpdate<dim>& out, Tangent<dim>* A) const;
  bool symmetric_tangent() const;
  double p_wave_modulus() const;  ///< of the stiffness at zero strain [Pa]
  double shear_modulus() const;   ///< the same [Pa]
  int num_variables() const;      ///< NSTATV

 private:
  std::shared_ptr<const UmatModel> model_;
};

}  // namespace gabion
