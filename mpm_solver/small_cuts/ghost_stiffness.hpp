// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "mpm_solver/grid/cell_owners.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/points/laws_of_points.hpp"

namespace gabion::mpm {

/// Share of its volume below which a cell with points counts as a small cut.
inline constexpr double small_cut_fill = 0.6;

/// Ghost stiffness for cells that hold little soil: their nodes are tied to the smooth continuation
/// of the motion of the neighbour cells. On each facet F between a small cut and any other cell
/// with soil, under gimp the domains of the points,
///
///     f_i = -sum_k k_ik du_k ,   k_ik = factor E h / 3 int_F [[dN_i/dn]] [[dN_k/dn]] dA
///
/// with E Young's modulus of the soil in the two cells and h their mean height over F. The integral
/// of (s [[du/dn]])^2 over a cell of height h, s the distance from F, is h^3 / 3 int_F [[du/dn]]^2
/// dA; a stiffness has two derivatives more, hence the factor 1/h^2 beside it.
///
/// The stiffness acts on the increment du of the step, so it is a viscosity of about factor E dt
/// for gradients that jump. It does not resist deformation of earlier steps, stores no energy, and
/// dissipates du . k du >= 0 in a step. Linear fields have no jump, and k is symmetric and
/// isotropic: linear momentum, and angular momentum about the positions at start and end, are kept.
///
/// @see Burman (2010); Sticko, Ludvigsson, Kreiss (2020); Coombs (2023) for material points
template <int dim>
class GhostStiffness {
 public:
  /// @param grid    must outlive it
  /// @param factor  of Young's modulus, > 0
  GhostStiffness(const BackgroundGrid<dim>& grid, const std::vector<Body<dim>>& bodies,
                 double factor);

  /// Find the facets of this step; a rank has those of the small cuts among its own cells. Cells
  /// with doubled nodes have none.
  /// @param doubled  numbers of doubled nodes besides those of the weights, see SideFields::split
  /// @param laws     of the points, see LawsOfPoints
  /// @returns grid nodes of the facets of this rank, some of them several times
  /// @note Collective.
  std::vector<std::int32_t> find_facets(const CellOwners<dim>& owners,
                                        const MaterialPoints<dim>& points,
                                        const PointWeights<dim>& weights,
                                        std::span<const std::int32_t> doubled = {},
                                        LawsOfPoints<dim> laws = {});
  /// Evaluate the stiffness of the facets. @param nodes  with those of find_facets()
  void begin_step(const GridNodes<dim>& nodes);
  /// Facets with ghost stiffness on all ranks; 0: no cell needs it in this step.
  std::int64_t num_facets() const { return num_facets_; }

  /// Facets of this rank as lists of active nodes (for the matrix pattern).
  void append_cells(std::vector<std::int32_t>& offsets, std::vector<std::int32_t>& nodes) const;
  /// Add the forces of this rank's facets to r and their stiffness to K (may be null).
  void add_forces(std::span<const double> du, std::span<double> r, BlockMatrix<dim>* K) const;

 private:
  bool is_small(std::int32_t cell) const {
    const double volume = soil_[cell].volume;
    return volume > 0 && volume < small_cut_fill * cell_volume(grid_, cell);
  }
  void measure_cells(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
                     LawsOfPoints<dim> laws);
  void mark_doubled(const PointWeights<dim>& weights, std::span<const std::int32_t> doubled);
  void share_cells(const CellOwners<dim>& owners);
  struct CellSoil {
    double volume = 0;
    double stiffness = 0;  // its volume times Young's modulus
    bool doubled = false;  // some of its nodes have several numbers
    bool operator==(const CellSoil&) const = default;
  };
  struct Facet {
    std::int32_t cell;
    int number;  // of the cell's facets
    std::int32_t neighbour;
  };
  void add_facet(const GridNodes<dim>& nodes, const Facet& facet);

  const BackgroundGrid<dim>& grid_;
  double factor_;
  std::vector<double> young_modulus_;  // of each body

  // of the current step
  SparseList<CellSoil> soil_;         // of all ranks, in the cells of this one and beside them
  std::vector<Facet> facets_;         // of this rank
  std::int64_t num_facets_ = 0;       // of all ranks
  std::vector<std::int32_t> starts_;  // of each facet in nodes_, and their number
  std::vector<std::int32_t> nodes_;   // active numbers
  std::vector<double> k_;             // n x n of each facet, one after the other
};

}  // namespace gabion::mpm
