// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "mpm_solver/contact/contact_settings.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// A surface where it is at time 0.
template <int dim>
struct StartSurface {
  const ContactSettings<dim>& settings;
  std::vector<Vector<dim>> vertices;  ///< [m]
  bool rigid = false;
  bool moves = false;       ///< rigid, but moves as given
  bool is_boulder = false;  ///< its facets are its shape, not pieces of a curved one
};

/// The surfaces at time 0: interfaces, then rigid walls. Refers to their settings.
template <int dim>
std::vector<StartSurface<dim>> surfaces_at_start(
    const std::vector<ContactSettings<dim>>& interfaces,
    const std::vector<RigidWallSettings<dim>>& walls);

/// Position of this rank's soil relative to a surface at time 0. A material point is a sphere of
/// the radius MaterialPoints::depth. A point behind surfaces counts only for the nearest one, and
/// not beyond the rim of an open one. It is inside the structure when it is no farther from the
/// surface than the size of a point: then the surface cuts the soil, or the structure is thinner
/// than half a point. In front it is when its sphere overlaps the surface and the method measures
/// distances (`facets`).
template <int dim>
struct SoilAtStart {
  double gap = std::numeric_limits<double>::infinity();  ///< smallest of a point in front [m]
  std::int64_t near_front = 0, near_behind = 0;          ///< points within two cells
  std::int64_t inside = 0;  ///< points inside the structure, or too deep in the surface
  double deepest = -std::numeric_limits<double>::infinity();  ///< of those inside [m]
  Vector<dim> deepest_at = Vector<dim>::Zero();
};

/// @param cell_size  mean [m]
template <int dim>
std::vector<SoilAtStart<dim>> soil_at_start(const std::vector<StartSurface<dim>>& surfaces,
                                            const MaterialPoints<dim>& points, double cell_size);

/// Smallest gap between soil and a surface, of all ranks; infinite: none within `farthest` [m].
/// @note Collective.
template <int dim>
double smallest_gap(MPI_Comm comm, const StartSurface<dim>& surface,
                    const MaterialPoints<dim>& points, double cell_size, double farthest);

/// Warning of a surface whose facets are too long for the grid: more than a cell, or half a cell
/// where the surface is curved (triangles: the diagonal of such a square). Flat parts of a rigid
/// wall that meets soil by `facets` may have any length: they do not bend and there is no integral
/// over them.
template <int dim>
std::optional<std::string> coarse_surface(const StartSurface<dim>& surface, double cell_size);

/// Warning of a surface that lies outside the grid by more than a cell: soil cannot meet it.
/// @param grid  box around it [m]
template <int dim>
std::optional<std::string> outside_grid(const StartSurface<dim>& surface,
                                        const Eigen::AlignedBox<double, dim>& grid,
                                        double cell_size);

/// Log the smallest gap of each surface; warn of coarse ones and of those that have to move to come
/// into the grid.
/// @param grid  box around it [m]
/// @throws ConfigError  a surface outside the grid; all soil that is near lies behind a surface, so
///                      that its facets face the wrong side; soil inside the structure. The last
///                      two do not apply to the mode `fixed`, which may lie in soil.
/// @note Collective.
template <int dim>
void check_start(MPI_Comm comm, const std::vector<StartSurface<dim>>& surfaces,
                 const MaterialPoints<dim>& points, double cell_size,
                 const Eigen::AlignedBox<double, dim>& grid);

}  // namespace gabion::mpm
