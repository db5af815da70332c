// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/settings/config_reader.hpp"
#include "fem_solver/fem_config.hpp"

namespace gabion::fem {

template <int dim>
Vector<dim> read_vector(ConfigReader& in, const std::string& key) {
  return Eigen::Map<const Vector<dim>>(in.vector(key, dim).data());
}

// Readers of loads, masses and springs at a point or on the nodes of a group.

template <int dim>
PointMassSettings<dim> read_point_mass(ConfigReader in);
template <int dim>
SpringSettings<dim> read_spring(ConfigReader in);
template <int dim>
DashpotSettings<dim> read_dashpot(ConfigReader in);
template <int dim>
LoadSettings<dim> read_load(ConfigReader in);

/// "table", or 1.
TimeFunction read_factor(ConfigReader& in);

RigidLinkSettings read_rigid_link(ConfigReader in);

/// An interface with "beams".
BeamSurfaceSettings read_beam_surface(ConfigReader in);

}  // namespace gabion::fem
