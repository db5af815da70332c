// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/locking.hpp"

#include <fmt/format.h>

#include <variant>

namespace gabion::mpm {

namespace {

// Reason why a body of this law would lock; empty: it does not. Plastic flow binds the volume of a
// point to its shear, at constant volume or not: cells have too few degrees of freedom to follow.
template <class Law>
std::string cause_of_locking(const Law& law) {
  if constexpr (!Law::is_elastic) return "yields";
  const double mu = law.shear_modulus(), lambda = law.p_wave_modulus() - 2 * mu;
  const double poisson_ratio = lambda / (2 * (lambda + mu));
  if (poisson_ratio <= locking_poisson_ratio) return {};
  return fmt::format("has a Poisson's ratio of {:.4g}", poisson_ratio);
}

}  // namespace

template <int dim>
LockingCure default_locking_cure(const std::vector<Body<dim>>& bodies) {
  for (const auto& body : bodies) {
    if (body.water) return {true, fmt::format("body \"{}\" has pore water", body.name)};
    const std::string cause =
        std::visit([](const auto& law) { return cause_of_locking(law); }, body.material.law);
    if (!cause.empty()) return {true, fmt::format("body \"{}\" {}", body.name, cause)};
  }
  return {false, "no body yields or is nearly incompressible"};
}

template LockingCure default_locking_cure<2>(const std::vector<Body<2>>&);
template LockingCure default_locking_cure<3>(const std::vector<Body<3>>&);

}  // namespace gabion::mpm
