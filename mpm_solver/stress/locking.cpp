// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/locking.hpp"

#include <fmt/format.h>

#include <variant>

namespace gabion::mpm {

namespace {

std::string cause_of_elastic_locking(double lambda, double mu) {
  const double poisson_ratio = lambda / (2 * (lambda + mu));
  if (poisson_ratio <= locking_poisson_ratio) return {};
  return fmt::format("has a Poisson's ratio of {:.4g}", poisson_ratio);
}

// Why a body of this law would lock; empty when it does not.
template <class Law>
std::string cause_of_locking(const Law& law) {
  if constexpr (requires { law.parameters().dilation_angle; }) {
    if (law.parameters().dilation_angle == 0) return "yields at constant volume";
    return cause_of_elastic_locking(law.parameters().lambda, law.parameters().mu);
  } else {
    return cause_of_elastic_locking(law.lambda, law.mu);
  }
}

template <int dim>
std::string cause_of_locking(const Tresca<dim>&) {
  return "yields at constant volume";
}

}  // namespace

template <int dim>
LockingCure default_locking_cure(const std::vector<Body<dim>>& bodies) {
  for (const auto& body : bodies) {
    const std::string cause =
        std::visit([](const auto& law) { return cause_of_locking(law); }, body.material.law);
    if (!cause.empty()) return {true, fmt::format("body \"{}\" {}", body.name, cause)};
  }
  return {false, "no body is nearly incompressible"};
}

template LockingCure default_locking_cure<2>(const std::vector<Body<2>>&);
template LockingCure default_locking_cure<3>(const std::vector<Body<3>>&);

}  // namespace gabion::mpm
