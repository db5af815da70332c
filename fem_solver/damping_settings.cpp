// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/require.hpp"
#include "fem_solver/fem_config.hpp"

namespace gabion::fem {

template <int dim>
void check_damping(const FemSettings<dim>& s) {
  const auto check = [&s](const std::string& where) {
    require<ConfigError>(s.dynamic, "{}: has no meaning when \"analysis\" is \"static\"", where);
    // Mean forces of interfaces change velocities that damping must not see, see (T12), (T13).
    require<ConfigError>(!s.coupled() || s.time_integration.step_force_velocity() == 0,
                         "{}: found damping of a structure with \"interfaces\", allowed: with "
                         "\"time_integration\" of scheme \"newmark\"",
                         where);
  };
  for (const auto& material : s.materials) {
    if (!material.rayleigh.where.empty()) check(material.rayleigh.where);
  }
  for (const auto& dashpot : s.dashpots) check(dashpot.where);
}

template void check_damping(const FemSettings<2>&);
template void check_damping(const FemSettings<3>&);

}  // namespace gabion::fem
