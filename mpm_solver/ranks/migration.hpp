// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "mpm_solver/contact/surfaces.hpp"
#include "mpm_solver/grid/cell_owners.hpp"

namespace gabion::mpm {

/// Send each point of this rank whose cell belongs to another rank to that rank, with all its
/// fields and what the surfaces remember of it. The points of a rank stay ordered by id.
/// @pre  the points are located
/// @returns number of points that moved, of all ranks
/// @note Collective.
template <int dim>
std::int64_t migrate(const CellOwners<dim>& owners, MaterialPoints<dim>& points,
                     Surfaces<dim>& surfaces);

}  // namespace gabion::mpm
