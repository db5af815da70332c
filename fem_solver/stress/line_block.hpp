// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"
#include "common/mechanics/petsc/block_matrix.hpp"
#include "fem_solver/materials/line_material.hpp"
#include "fem_solver/ranks/mesh_ranks.hpp"
#include "fem_solver/stress/beam_cells.hpp"
#include "fem_solver/stress/embedded_nodes.hpp"
#include "fem_solver/stress/failure_numbers.hpp"
#include "fem_solver/stress/stress_integral.hpp"

namespace gabion::fem {

/// Lines of a mesh: their materials, each of a group; the rotations of those that are beams; nodes
/// inside cells (null: none). Refers to its arguments.
template <int dim>
struct LinesOfMesh {
  std::span<const LineMaterial> materials{};
  BeamNodes beam_nodes{};
  const EmbeddedNodes<dim>* embedded = nullptr;

  const EmbeddedNodes<dim>& nodes_inside() const {
    static const EmbeddedNodes<dim> none;
    return embedded ? *embedded : none;
  }
};

/// Line cells of one material: straight between two nodes, one force each. Histories given to its
/// functions are those of its lines, one after the other: the run of the brake, where there is one.
/// Beams have moments at the rotations of their nodes, too.
template <int dim>
class LineBlock {
 public:
  /// @param lines        of the mesh
  /// @param lumped_mass  half of the mass at each end instead of the consistent mass; ropes always
  ///                     have it
  /// @param of           rotations of beams, and ends that move with cells, whose nodes then take
  ///                     their forces and masses
  /// @throws ConfigError  a brake whose force falls more steeply than a line stretches
  LineBlock(const Mesh<dim>& mesh, const LineMaterial& material, std::vector<std::int32_t> lines,
            bool lumped_mass, const LinesOfMesh<dim>& of = {});

  /// f_2 = N e, f_1 = -N e, e the direction of the deformed line, and on demand
  /// K_22 = dN/dl e e^T + N/l (1 - e e^T) = -K_12. See CellIntegrals::add_internal; a fault is of
  /// the element behind the cells of the mesh.
  StressIntegral add_internal(std::span<const double> u, std::span<double> f_int,
                              BlockMatrix<dim>* K, HistoryStep history) const;
  /// Add a share of the stiffness of taut lines, in all directions.
  void add_stiffness(double share, BlockMatrix<dim>& K) const;

  void add_mass_times(std::span<const double> a, std::span<double> f) const;
  void add_mass(double scale, BlockMatrix<dim>& K) const;

  /// Forces along its lines, tension positive [N]. @param history  accepted
  std::vector<double> forces(std::span<const double> u, std::span<const double> history) const;
  /// Strains from the length without stress, less the run of a brake; of beams 0.
  std::vector<double> strains(std::span<const double> u, std::span<const double> history) const;
  double brake_work(std::span<const double> history) const;    ///< [J]
  double plastic_work(std::span<const double> history) const;  ///< of bars and beams [J]
  /// Sum of the size of plastic strains of its lines, of beams the largest; empty: none yields.
  std::vector<double> plastic_strains(std::span<const double> history) const;

  const LineMaterial& material() const { return material_; }
  std::span<const std::int32_t> lines() const { return lines_; }
  /// Null: its lines are no beams.
  const BeamCells<dim>* beams() const { return beams_ ? &*beams_ : nullptr; }
  std::size_t history_width() const {  ///< of a line
    if (beams_) return beams_->history_width();
    return material_.history_size() + (may_fail() ? failure_numbers : 0);
  }
  bool may_fail() const { return material_.failure.any(); }
  /// Share of its force that the k-th line still has: 1 but for one that failed.
  double share_left(std::size_t k, std::span<const double> history) const {
    return may_fail() ? fem::share_left(history.subspan(k * history_width(), history_width())) : 1;
  }
  double free_length(std::size_t k) const { return free_lengths_[k]; }  ///< without stress [m]
  bool yields() const { return material_.hardening.has_value(); }
  std::size_t history_size() const { return history_width() * lines_.size(); }

 private:
  struct Ends {
    Vector<dim> direction;  ///< of the deformed line, length 1
    double length;          ///< deformed [m]
  };
  Ends ends(std::size_t k, std::span<const double> u) const;
  /// A node that a line acts on, with its shares in the displacements of both ends.
  struct Share {
    std::int32_t node;
    double first, second;
  };
  std::span<const Share> shares(std::size_t k) const {
    return std::span(shares_).subspan(starts_[k], starts_[k + 1] - starts_[k]);
  }
  /// Whether its ends are nodes that nothing else moves.
  bool has_plain_ends(std::size_t k) const {
    const auto own = shares(k);
    return own.size() == 2 && own[0].first == 1 && own[0].second == 0 && own[1].first == 0 &&
           own[1].second == 1;
  }
  void add_pair(std::size_t k, const Matrix<dim>& S, BlockMatrix<dim>& K,
                std::vector<double>& memory) const;

  LineMaterial material_;
  std::vector<std::int32_t> lines_;  // of the mesh
  std::int32_t num_cells_ = 0;       // of the mesh
  bool lumped_mass_ = false;
  std::vector<std::size_t> starts_ = {0};  // of each line in shares_
  std::vector<Share> shares_;              // its ends, or the nodes of their hosts
  std::vector<Vector<dim>> chords_;        // from the first node to the second, in the mesh [m]
  std::vector<double> free_lengths_;       // without stress [m]
  std::optional<BeamCells<dim>> beams_;
};

}  // namespace gabion::fem
