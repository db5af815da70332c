// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deal.II/grid/tria.h>

#include <set>

#include "settings.hpp"

namespace dealii_structure {

template <int dim>
dealii::Point<dim> point_of(const std::vector<double>& x) {
  dealii::Point<dim> point;
  for (int i = 0; i < dim; ++i) point[i] = x[i];
  return point;
}

/// Box or file, and the refinements: neighbours differ by one level, hanging nodes arise.
/// @throws gabion::ConfigError  a file that cannot be read, a refinement without cells
template <int dim>
void make_mesh(const Settings& settings, dealii::Triangulation<dim>& mesh);

/// Numbers of the boundary parts with these names.
/// @throws gabion::ConfigError  a group that the mesh does not have
template <int dim>
std::set<dealii::types::boundary_id> boundary_ids(const Settings& settings,
                                                  const dealii::Triangulation<dim>& mesh,
                                                  const std::vector<std::string>& groups);

}  // namespace dealii_structure
