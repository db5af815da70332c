// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mpm_solver/grid/background_grid.hpp"

namespace gabion::mpm {

/// Facets of a wall that meet with a smaller bend than this are one smooth piece [deg]. Above 20,
/// so that round-off does not decide about a slope of 20 degrees that runs out on a flat.
inline constexpr double corner_angle = 20.5;

/// Common properties of the facets of a wall around one of its nodes.
template <int dim>
struct WallPiece {
  std::int32_t grid_node = 0;
  Vector<dim> n = Vector<dim>::Zero();     ///< mean normal by area, unit; as its first facet
  Vector<dim> area = Vector<dim>::Zero();  ///< sum of the area vectors [m^(dim-1)]
};

/// Divide the facets around each node of a wall into smooth pieces: two of them are in one piece if
/// a chain of bends below corner_angle joins them, from edge to edge (in 2D, from segment to
/// segment). On a smooth surface the mean normal is that of the node to first order in the size of
/// the facets. It is the integral of N_i n, so soil that moves at right angles to it at each node
/// keeps its volume.
/// @param facets  num_facets x num_nodes(facet_type(cell_type)); between two cells, a normal may
///                point to either side
/// @returns ascending nodes, at a node in the order of their first facets
/// @see Engelman, Sani, Gresho (1982) for the mean normal
template <int dim>
std::vector<WallPiece<dim>> smooth_pieces(const BackgroundGrid<dim>& grid,
                                          std::span<const std::int32_t> facets);

}  // namespace gabion::mpm
