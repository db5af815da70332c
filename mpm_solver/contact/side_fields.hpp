// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/mechanics/ranks/shared_nodes.hpp"
#include "mpm_solver/contact/facet_hash.hpp"
#include "mpm_solver/contact/surfaces.hpp"
#include "mpm_solver/contact/thin_pairs.hpp"
#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/sparse_list.hpp"

namespace gabion::mpm {

/// Whether the numbers of doubled nodes fit into an integer: the grid is a box that is not too
/// large.
template <int dim>
bool can_double_nodes(const BackgroundGrid<dim>& grid);

/// Gives soil on the two sides of a thin wall nodes of its own (docs/theory/interface.md, fields by
/// side). A wall is thin where ThinWalls finds it so. A node is doubled where points of both sides
/// weigh on it, by the sight between point and node through the faces of thin walls; nodes at an
/// end of the wall are not. The points on one side keep the node n, those on the other get n +
/// num_nodes_total(). The points of all ranks decide which nodes are doubled. Refers to the grid.
template <int dim>
class SideFields {
 public:
  /// @param pairs  of the faces, both of the method `facets` (Faces::can_have_fields)
  /// @param grid   a box
  SideFields(MPI_Comm comm, Faces<dim> faces, std::vector<FacePair> pairs,
             const BackgroundGrid<dim>& grid);

  /// Double nodes, and part the groups of cells that have points on both sides, or that see a
  /// doubled node in several ways.
  /// @param surfaces         in the accepted state
  /// @param[in,out] weights  of the points, as evaluate_basis left them
  /// @returns numbers of doubled nodes that a rank needs, since it has the other number of each:
  ///          none on one rank
  /// @note Collective.
  std::vector<std::int32_t> split(const Surfaces<dim>& surfaces, const MaterialPoints<dim>& points,
                                  PointWeights<dim>& weights);
  /// Nodes that the last split() doubled, of all ranks.
  std::int32_t num_doubled() const { return num_doubled_; }

 private:
  /// Bit k: the point of an entry is on the far side of the group's node k.
  using Sides = std::uint64_t;
  /// A group near a thin wall, with the sides of its entries.
  struct NearGroup {
    std::int32_t group = 0;
    std::vector<Sides> sides;
  };
  /// Kinds of points that weigh on a node, as bits.
  enum Reached : char { by_near_side = 1, by_far_side = 2, by_end = 4 };

  std::vector<std::int32_t> faces_near(const CellGroup& group) const;
  bool has_two_sides(const MaterialPoints<dim>& points, const PointWeights<dim>& weights) const;
  void follow(const Surfaces<dim>& surfaces);
  void look(const MaterialPoints<dim>& points, const PointWeights<dim>& weights);
  NearGroup look_at(const CellGroup& group, std::span<const std::int32_t> faces,
                    const MaterialPoints<dim>& points, const PointWeights<dim>& weights);
  void reach_from_afar(const PointWeights<dim>& weights);
  Eigen::AlignedBox<double, dim> box_of_reached();
  void list_nodes(const PointWeights<dim>& weights);
  void count_doubled();
  std::vector<std::int32_t> numbers_of_doubled() const;
  bool is_far_side(const Vector<dim>& x, std::int32_t node, std::span<const std::int32_t> faces);
  bool is_at_end(const Vector<dim>& x) const;
  std::int32_t face_of(std::int32_t node);
  bool is_doubled(std::int32_t node) const {
    return reached_[node] == (by_near_side | by_far_side);
  }
  void part_groups(PointWeights<dim>& weights);
  void part(const CellGroup& group, NearGroup& near, PointWeights<dim>& weights,
            PointWeights<dim>& parted) const;

  MPI_Comm comm_;
  const BackgroundGrid<dim>& grid_;
  Faces<dim> faces_;
  std::vector<FacePair> pairs_;             // of faces_
  std::vector<std::int32_t> which_;         // simplices of thin walls, ascending
  std::vector<std::size_t> surfaces_;       // that have some of them
  double reach_ = 0;                        // no point is farther from its nodes [m]
  double tiny_ = 0;                         // faces nearer to a node than this pass through it [m]
  std::vector<Simplex<dim>> acting_;        // of which_, of surfaces that were not dropped
  std::vector<FacePair> acting_pairs_;      // of acting_
  std::optional<FacetHash<dim>> hash_;      // of acting_
  std::vector<SimplexBounds<dim>> bounds_;  // of acting_

  // of the last split
  std::vector<NearGroup> near_;
  SparseList<char> reached_;          // of each grid node
  SparseList<std::int32_t> face_of_;  // of each grid node: the nearest of acting_, or unknown
  std::vector<std::int32_t> listed_;  // grid nodes of this rank that may be doubled, ascending
  SharedNodes shared_;                // of listed_
  std::int32_t num_doubled_ = 0;
};

}  // namespace gabion::mpm
