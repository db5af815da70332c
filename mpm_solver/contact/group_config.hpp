// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/settings/config_reader.hpp"
#include "mpm_solver/contact/body_groups.hpp"
#include "mpm_solver/contact/contact_settings.hpp"
#include "mpm_solver/grid/background_grid.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

KeyTable contact_group_keys();

/// What else of mpm.json decides whether bodies can have fields of their own.
template <int dim>
struct GroupScene {
  const BackgroundGrid<dim>& grid;
  const std::vector<Body<dim>>& bodies;
  const std::vector<ContactSettings<dim>>& interfaces;
  const std::vector<RigidWallSettings<dim>>& rigid_walls;
};

/// Read "contact_groups", none if the key is not there.
/// @throws ConfigError  a body in no group or in two, a pair that is missing or given twice, groups
///                      on a grid that is no box, with boundary points or with water that drains
template <int dim>
BodyGroups read_body_groups(ConfigReader& in, const GroupScene<dim>& scene);

/// @throws ConfigError  groups on several ranks
void require_one_rank_for_groups(int num_ranks, const BodyGroups& groups);

}  // namespace gabion::mpm
