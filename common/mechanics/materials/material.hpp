// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <variant>

#include "common/mechanics/materials/drucker_prager.hpp"
#include "common/mechanics/materials/elastic.hpp"
#include "common/mechanics/materials/mohr_coulomb.hpp"
#include "common/mechanics/materials/tresca.hpp"
#include "common/settings/config_reader.hpp"

namespace gabion {

template <int dim>
using MaterialLaw = std::variant<LinearElastic<dim>, NeoHookean<dim>, HenckyElastic<dim>,
                                 MohrCoulomb<dim>, Tresca<dim>, DruckerPrager<dim>>;

template <int dim>
struct Material {
  std::string law_name;
  double density = 0;  ///< [kg/m^3] > 0, in the stress-free state
  MaterialLaw<dim> law;
};

/// Whether the stress depends on the present deformation only, not on the way to it.
template <int dim>
bool is_elastic(const MaterialLaw<dim>& law) {
  return std::holds_alternative<LinearElastic<dim>>(law) ||
         std::holds_alternative<NeoHookean<dim>>(law) ||
         std::holds_alternative<HenckyElastic<dim>>(law);
}

/// Stress update of whichever law it is; loops over many points dispatch once and call the law.
template <int dim>
bool update(const MaterialLaw<dim>& law, const Matrix<dim>& H, const MaterialState<dim>& state_n,
            StressUpdate<dim>& out, Tangent<dim>* A) {
  return std::visit([&](const auto& model) { return model.update(H, state_n, out, A); }, law);
}

/// Names of all laws, and of those for which is_elastic() holds.
extern const std::vector<std::string> material_laws;
extern const std::vector<std::string> elastic_laws;

/// @param laws  those that may be chosen
KeyTable material_keys(const std::vector<std::string>& laws);

template <int dim>
Material<dim> read_material(ConfigReader in);

}  // namespace gabion
