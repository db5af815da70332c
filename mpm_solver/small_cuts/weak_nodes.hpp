// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "mpm_solver/contact/facet_hash.hpp"
#include "mpm_solver/contact/surfaces.hpp"
#include "mpm_solver/contact/thin_pairs.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/small_cuts/small_cuts.hpp"

namespace gabion::mpm {

/// Whether nodes may be weak (find_weak_nodes) and are to join others: on triangles and tetrahedra,
/// where a body yields, unless the method `none` is named.
template <int dim>
bool may_have_weak_nodes(const SmallCutSettings& settings, const BackgroundGrid<dim>& grid,
                         const std::vector<Body<dim>>& bodies);

/// The surfaces of the method `facets`, to tell grid nodes behind them from those of the soil.
template <int dim>
class FacetSights {
 public:
  FacetSights(const std::vector<StartSurface<dim>>& surfaces, const BackgroundGrid<dim>& grid);

  /// Ignore a surface from now on. @param k  its number
  void leave_out(std::size_t k) { left_out_[k] = 1; }

  /// Take the accepted places of the surfaces. @returns whether any acts
  bool follow(const Surfaces<dim>& surfaces);
  /// Whether a facet with x on its back and y on its front is between them.
  /// @param x  a place of the grid [m]
  /// @param y  no farther from it than the longest edge of a cell [m]
  bool is_behind(const Vector<dim>& x, const Vector<dim>& y) const;

 private:
  Faces<dim> faces_;
  std::size_t num_surfaces_ = 0;
  double reach_ = 0, tiny_ = 0;         // longest edge of a cell, and a small part of it [m]
  std::vector<char> left_out_, acts_;   // of each surface
  std::vector<Simplex<dim>> acting_;    // of surfaces that were not dropped
  std::vector<Vector<dim>> normals_;    // of acting_
  std::optional<FacetHash<dim>> hash_;  // of acting_
};

/// Triangles and tetrahedra that a surface cuts leave nodes behind it on which only the narrow ends
/// of cells weigh. The force of contact on such a node, by the functions of a few points, need not
/// be the one that the stress of these points requires; elastic soil transmits the difference, soil
/// that yields does not bear it. A node is weak where a facet lies between it and the mean place of
/// the points that weigh on it, and
///
///     m_i < 3/4 sum_p m_p / (dim + 1)   over the points with N_ip among their values.
///
/// The nodes of a cell have m_p / (dim + 1) each in the mean, so a node of the surface of soil that
/// fills its cells has its whole share.
/// @param nodes  active, with their mass
/// @param reach  sum_p m_p of each of them [kg]
/// @returns 1 for the weak ones of the active nodes, the same on all ranks
/// @note Collective.
template <int dim>
std::vector<char> find_weak_nodes(const FacetSights<dim>& sights, const MaterialPoints<dim>& points,
                                  const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                                  std::span<const double> reach);

}  // namespace gabion::mpm
