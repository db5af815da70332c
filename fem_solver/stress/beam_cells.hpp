// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"
#include "common/mechanics/petsc/block_matrix.hpp"
#include "fem_solver/beams/beam_forces.hpp"
#include "fem_solver/beams/beam_nodes.hpp"
#include "fem_solver/materials/line_material.hpp"
#include "fem_solver/stress/failure_numbers.hpp"
#include "fem_solver/stress/fibre_section.hpp"
#include "fem_solver/stress/stress_integral.hpp"

namespace gabion::fem {

/// Geometrically exact beams of one material, straight without stress between the nodes of a line
/// (docs/theory/structure.md). In space each remembers the rotations of its nodes, as quaternions,
/// and the unknowns at which they were accepted: a step turns nodes by the increments since then.
template <int dim>
class BeamCells {
 public:
  /// Numbers that a beam remembers of its rotations; all zero: not turned.
  static constexpr std::size_t rotation_width = dim == 3 ? 14 : 0;
  /// Numbers that a beam remembers in all: rotations, fibres where the section yields, and failure.
  std::size_t history_width() const {
    return rotation_width + fibre_numbers_ + (material_.failure.any() ? failure_numbers : 0);
  }

  /// @param lines  of the mesh
  /// @throws ConfigError  an orientation along a beam
  BeamCells(const Mesh<dim>& mesh, const LineMaterial& material,
            std::span<const std::int32_t> lines, const BeamNodes& nodes);

  /// Add forces and stiffness, see LineBlock::add_internal(). K has rows of both places, then of
  /// both rotations.
  StressIntegral add_internal(std::span<const double> u, std::span<double> f_int,
                              BlockMatrix<dim>* K, HistoryStep history) const;
  /// Rotary inertia, the same about all axes, half at each node.
  void add_rotary_mass_times(std::span<const double> a, std::span<double> f) const;
  void add_rotary_mass(double scale, BlockMatrix<dim>& K) const;

  /// Resultants in the middle of each beam. @param history  accepted
  std::vector<SectionResultants<double>> resultants(std::span<const double> u,
                                                    std::span<const double> history) const;
  double length(std::size_t k) const { return cells_[k].length; }
  /// Rotations at the ends of the k-th beam.
  std::span<const std::int32_t> rotations(std::size_t k) const {
    return std::span(cells_[k].nodes).last(2);
  }
  /// Plastic work of the k-th beam. @param history  of all beams
  double plastic_work(std::size_t k, std::span<const double> history) const;  ///< [J]
  /// The largest over its fibres of the sum of the size of plastic strains.
  double plastic_strain(std::size_t k, std::span<const double> history) const;

 private:
  static constexpr int num_unknowns = 4 * dim;
  using Own = Dual<num_unknowns>;
  struct Cell {
    std::int32_t element;               // of the mesh, behind its cells
    std::array<std::int32_t, 4> nodes;  // places, then rotations
    double length;                      // without stress [m]
    Vector<dim> chord;                  // before loading [m]
    Turn<double> frame;                 // in space
    double rotary_mass;                 // of a node, over length_^2 [kg]
  };
  void set_frame(const LineMaterial& material, Cell& cell) const;
  template <class S>
  std::array<Turn<S>, 2> turns(const Cell& cell, std::span<const double> u,
                               std::span<const double> history) const;
  template <class S>
  auto forces(const Cell& cell, std::span<const double> u, HistoryStep history) const;
  template <class S, class Section>
  auto forces_with(const Section& section, const Cell& cell, std::span<const double> u,
                   std::span<const double> history) const;
  /// Visit the history of each fibre of the k-th beam, with the fibre's number.
  template <class Visit>
  void for_each_fibre(std::size_t k, std::span<const double> history, const Visit& visit) const;
  const char* remember(const Cell& cell, std::span<const double> u, HistoryStep history) const;
  void add_to(const Cell& cell, std::span<const double> f_cell, std::span<double> f_int) const;

  LineMaterial material_;
  BeamStiffness stiffness_;
  std::size_t fibre_numbers_ = 0;  // 0: elastic
  double length_;                  // of the rotations' unknowns [m]
  std::vector<Cell> cells_;
};

}  // namespace gabion::fem
