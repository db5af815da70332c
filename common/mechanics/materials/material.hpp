// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <concepts>
#include <string>
#include <type_traits>
#include <variant>

#include "common/mechanics/materials/cam_clay.hpp"
#include "common/mechanics/materials/drucker_prager.hpp"
#include "common/mechanics/materials/elastic.hpp"
#include "common/mechanics/materials/herschel_bulkley.hpp"
#include "common/mechanics/materials/mohr_coulomb.hpp"
#include "common/mechanics/materials/mu_i.hpp"
#include "common/mechanics/materials/newtonian.hpp"
#include "common/mechanics/materials/softening_soil.hpp"
#include "common/mechanics/materials/tresca.hpp"
#include "common/mechanics/materials/umat.hpp"
#include "common/settings/config_reader.hpp"

namespace gabion {

/// Law of a material, held as a value. Stress and tangent are those of `update`, whose H = du_i /
/// dX_J is the displacement gradient of the step and X the position in the accepted state
/// `state_n`. For a total Lagrangian solver that is the virgin state, and H the total gradient.
template <class Law, int dim>
concept ConstitutiveLaw = std::copyable<Law> &&
    requires(const Law& law, const Matrix<dim>& H, const MaterialState<dim>& state_n,
             StressUpdate<dim>& out, Tangent<dim>* A) {
  // Fills out and, unless it is null, A with the exact consistent dP/dH.
  // False when det(1 + H) <= 0, or when an equation of the law was not solved: the step has to be
  // shorter. out.refusal then says which, the rest of out is undefined. A law that depends on time,
  // on the grid or on internal variables is a ContextualLaw too, and answers here at once, virgin
  // and with no grid: PointContext{}.
  { law.update(H, state_n, out, A) } -> std::same_as<bool>;
  // A(iJ, kL) == A(kL, iJ) for every state.
  { law.symmetric_tangent() } -> std::same_as<bool>;
  // lambda + 2 mu and mu at zero strain [Pa].
  { law.p_wave_modulus() } -> std::same_as<double>;
  { law.shear_modulus() } -> std::same_as<double>;
  // The stress depends on the present deformation only, not on the path to it.
  requires std::same_as<decltype(Law::is_elastic), const bool>;
};

template <int dim>
using MaterialLaw =
    std::variant<LinearElastic<dim>, NeoHookean<dim>, HenckyElastic<dim>, MohrCoulomb<dim>,
                 Tresca<dim>, DruckerPrager<dim>, HerschelBulkley<dim>, SofteningSoil<dim>,
                 MuI<dim>, CamClay<dim>, Newtonian<dim>, Umat<dim>>;

template <int dim, class... Laws>
constexpr bool are_laws(std::type_identity<std::variant<Laws...>>) {
  return (ConstitutiveLaw<Laws, dim> && ...);
}
static_assert(are_laws<2>(std::type_identity<MaterialLaw<2>>{}));
static_assert(are_laws<3>(std::type_identity<MaterialLaw<3>>{}));

template <int dim>
struct Material {
  std::string law_name;
  double density = 0;  ///< [kg/m^3] > 0, in the stress-free state
  MaterialLaw<dim> law;
};

template <int dim>
bool is_elastic(const MaterialLaw<dim>& law) {
  return std::visit([](const auto& model) { return model.is_elastic; }, law);
}

template <int dim>
bool remembers_internal(const MaterialLaw<dim>& law) {
  return std::visit([]<class Law>(const Law&) { return RemembersInternal<Law>; }, law);
}

/// Stress update of the law of `material`, without a step: see ConstitutiveLaw.
template <int dim>
bool update(const MaterialLaw<dim>& law, const Matrix<dim>& H, const MaterialState<dim>& state_n,
            StressUpdate<dim>& out, Tangent<dim>* A) {
  return std::visit([&](const auto& model) { return model.update(H, state_n, out, A); }, law);
}

/// Stress update in a step; loops over many points dispatch once and call the law.
template <int dim>
bool update(const LawInStep<MaterialLaw<dim>, dim>& material, const Matrix<dim>& H,
            const MaterialState<dim>& state_n, StressUpdate<dim>& out, Tangent<dim>* A) {
  return std::visit(
      [&]<class Law>(const Law& law) {
        return LawInStep<Law, dim>{law, material.context}.update(H, state_n, out, A);
      },
      material.law);
}

/// Names of all laws, and of those for which is_elastic() holds.
extern const std::vector<std::string> material_laws;
extern const std::vector<std::string> elastic_laws;

/// @param laws  those that may be chosen
KeyTable material_keys(const std::vector<std::string>& laws);

/// Read a material: what material_keys() lists; angles in degrees there, in radians here.
template <int dim>
Material<dim> read_material(ConfigReader in);

}  // namespace gabion
