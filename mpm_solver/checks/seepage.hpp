// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/mpm_config.hpp"

namespace gabion::mpm {

/// Whether the pore water of a body drains.
template <int dim>
bool drains(const Body<dim>& body) {
  return body.water && body.water->drains();
}

/// Refuse what soil whose pore water drains cannot do as yet, and walls that are drained without
/// such soil.
/// @throws ConfigError
template <int dim>
void check_seepage(const ConfigReader& in, const MpmSettings<dim>& settings);

/// The first body whose water does not drain; null: there is none.
template <int dim>
const Body<dim>* undrained_body(const std::vector<Body<dim>>& bodies);

}  // namespace gabion::mpm
