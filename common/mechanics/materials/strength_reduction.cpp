// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/strength_reduction.hpp"

#include <cmath>

namespace gabion {

namespace {

/// The parameters of a law with friction, reduced.
template <class Parameters>
Parameters reduce_friction(Parameters parameters, double factor) {
  parameters.friction_angle = std::atan(std::tan(parameters.friction_angle) / factor);
  parameters.dilation_angle = std::atan(std::tan(parameters.dilation_angle) / factor);
  parameters.cohesion /= factor;
  return parameters;
}

template <int dim>
MaterialLaw<dim> reduce(const MohrCoulomb<dim>& law, double factor) {
  return MohrCoulomb<dim>(reduce_friction(law.parameters(), factor));
}

template <int dim>
MaterialLaw<dim> reduce(const DruckerPrager<dim>& law, double factor) {
  return DruckerPrager<dim>(reduce_friction(law.parameters(), factor));
}

template <int dim>
MaterialLaw<dim> reduce(const Tresca<dim>& law, double factor) {
  TrescaParameters parameters = law.parameters();
  parameters.cohesion /= factor;
  return Tresca<dim>(parameters);
}

}  // namespace

template <int dim>
std::optional<MaterialLaw<dim>> with_reduced_strength(const MaterialLaw<dim>& law, double factor) {
  return std::visit(
      [&](const auto& model) -> std::optional<MaterialLaw<dim>> {
        if constexpr (requires { reduce<dim>(model, factor); }) {
          return factor == 1 ? law : reduce<dim>(model, factor);
        } else {
          return std::nullopt;
        }
      },
      law);
}

template std::optional<MaterialLaw<2>> with_reduced_strength<2>(const MaterialLaw<2>&, double);
template std::optional<MaterialLaw<3>> with_reduced_strength<3>(const MaterialLaw<3>&, double);

}  // namespace gabion
