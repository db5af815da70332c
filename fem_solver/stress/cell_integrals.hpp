// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "fem_solver/stress/cell_block.hpp"
#include "fem_solver/stress/line_block.hpp"
#include "fem_solver/stress/membranes.hpp"
#include "fem_solver/stress/nodal_parts.hpp"
#include "fem_solver/stress/rigid_links.hpp"

namespace gabion::fem {

/// Integrals over the cells and lines of a mesh, or a rank's part of one, in the reference
/// configuration: sums over those of this rank alone, block by block, lines behind the others. The
/// history is that of the blocks, one after the other; it is empty where no block has any.
template <int dim>
class CellIntegrals {
 public:
  /// @param materials  of all cells, or each of a group of cells
  /// @param ranks      for the number of a cell in messages
  /// @param lines      their materials, each of a group of lines; rotations; embedded nodes
  /// @throws ConfigError  a cell with a Jacobian <= 0 at a quadrature point; one without material,
  ///                      or with two, as of a line; a formulation that its type does not have
  CellIntegrals(const Mesh<dim>& mesh, std::span<const CellMaterial<dim>> materials,
                bool lumped_mass, const MeshRanks& ranks = {}, const LinesOfMesh<dim>& lines = {});

  /// Include these in all sums below.
  void set_nodal_parts(NodalParts<dim> parts) { nodal_parts_ = std::move(parts); }
  void set_membranes(Membranes<dim> membranes);
  const Membranes<dim>& membranes() const { return membranes_; }
  /// Include links, each at a beam of these cells; call these before set_pattern().
  void set_links(RigidLinks<dim> links);
  const RigidLinks<dim>& links() const { return links_; }
  /// History of the beam at each link; empty in the plane.
  std::vector<std::span<const double>> link_histories(std::span<const double> history) const;

  /// f_int,a = sum_q w_q P(H_q) dN_a/dX, H = sum_a u_a (x) dN_a/dX, and on demand
  /// K_ab = sum_q w_q dN_a/dX . dP/dH . dN_b/dX.
  /// @param[in]     u        displacement [m], num_nodes x dim
  /// @param[in,out] f_int    num_nodes x dim [N]; added to
  /// @param[in,out] K        null, or a matrix whose pattern comes from set_pattern; added to
  /// @param         history  of history_size() values each
  StressIntegral add_internal(std::span<const double> u, std::span<double> f_int,
                              BlockMatrix<dim>* K, HistoryStep history = {}) const;

  /// A share of the stiffness of all lines and membranes when they are taut, in all directions: for
  /// Newton's method where they are slack, or without a force that holds their nodes across.
  void add_line_stiffness(double share, BlockMatrix<dim>& K) const;

  /// f += M a. [N]
  void add_mass_times(std::span<const double> a, std::span<double> f) const;
  /// K += scale M
  void add_mass(double scale, BlockMatrix<dim>& K) const;

  /// Pattern of the cells.
  void set_pattern(BlockMatrix<dim>& K) const;

  /// Cauchy stress of each cell, mean over its quadrature points, num_cells x
  /// symmetric_size<dim> [Pa]. @pre det F > 0 everywhere
  std::vector<double> cell_stresses(std::span<const double> u,
                                    std::span<const double> history = {}) const;
  /// Equivalent plastic strain of each cell, mean over its quadrature points; 0 where none yields.
  std::vector<double> cell_plastic_strains(std::span<const double> history) const;
  double plastic_work(std::span<const double> history) const;  ///< of lines too [J]
  double brake_work(std::span<const double> history) const;    ///< of brakes of lines [J]
  /// Force along each line, tension positive, num_lines [N].
  std::vector<double> line_forces(std::span<const double> u, std::span<const double> history) const;
  /// Length that the brake of each line has run, num_lines [m]; 0 for lines without a brake.
  std::vector<double> line_runs(std::span<const double> history) const;

  /// Largest angle by which a cell of a law of small strain has turned, from the polar
  /// decomposition of the mean of F over its quadrature points [rad]; 0 without such cells.
  double largest_rotation(std::span<const double> u) const;

  std::int32_t num_cells() const { return num_cells_; }  ///< without lines
  /// The least V^(1/dim) of cells, length of lines and A^(1/2) of membranes [m]; infinite without
  /// any.
  double smallest_cell_size() const { return smallest_cell_size_; }

  std::size_t history_size() const;   ///< number of values; those of the virgin state are 0
  std::size_t history_width() const;  ///< the largest of a cell
  bool yields() const;                ///< a block has damage
  bool cracks() const;                ///< a block does
  std::span<const CellBlock<dim>> blocks() const { return blocks_; }
  std::span<const LineBlock<dim>> line_blocks() const { return line_blocks_; }
  /// The part of a history that is of this block.
  std::span<const double> of_block(std::span<const double> history, std::size_t block) const;
  std::span<const double> of_line_block(std::span<const double> history, std::size_t block) const;

  /// Convert between a history and rows: a row a cell of the mesh, then a row a line, of
  /// history_width() numbers each, filled up with zeros.
  std::vector<double> history_rows(std::span<const double> history) const;
  std::vector<double> history_of_rows(std::span<const double> rows) const;

 private:
  void make_blocks(const Mesh<dim>& mesh, std::span<const CellMaterial<dim>> materials,
                   const MeshRanks& ranks);
  void compute_mass(const Mesh<dim>& mesh, bool lumped);
  std::span<const std::int32_t> cell(std::int32_t c) const {
    return {cell_nodes_.data() + static_cast<std::size_t>(c) * nodes_per_cell_,
            static_cast<std::size_t>(nodes_per_cell_)};
  }
  void make_line_blocks(const Mesh<dim>& mesh, const LinesOfMesh<dim>& lines, bool lumped,
                        const MeshRanks& ranks);
  std::size_t num_lines() const { return line_ends_.size(); }
  std::size_t num_elements() const { return static_cast<std::size_t>(num_cells_) + num_lines(); }
  std::int32_t first_sheet() const {  ///< in the pattern, behind cells, lines and links
    return static_cast<std::int32_t>(num_elements() + links_.num_arms());
  }
  template <class Visit>
  void for_each_cell_history(const Visit& visit) const;

  int nodes_per_cell_ = 0;
  std::int32_t num_nodes_ = 0;
  std::int32_t num_cells_ = 0;
  std::vector<std::int32_t> cell_nodes_;  // cells x nodes
  std::vector<CellBlock<dim>> blocks_;
  std::vector<std::int32_t>
      line_nodes_;                       // that lines act on, rotations of beams last, line by line
  std::vector<std::int32_t> line_ends_;  // end of each line in line_nodes_
  std::vector<LineBlock<dim>> line_blocks_;
  NodalParts<dim> nodal_parts_;
  Membranes<dim> membranes_;
  RigidLinks<dim> links_;
  std::vector<std::size_t> link_starts_;  // of the beam at each link in a history
  std::vector<double> cell_masses_;       // cells x nodes x nodes [kg]; empty when lumped
  std::vector<double> lumped_masses_;     // num_nodes [kg]; empty when consistent
  double smallest_cell_size_ = 0;
};

}  // namespace gabion::fem
