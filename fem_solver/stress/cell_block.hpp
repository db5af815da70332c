// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"
#include "common/mechanics/petsc/block_matrix.hpp"
#include "fem_solver/materials/cell_material.hpp"
#include "fem_solver/ranks/mesh_ranks.hpp"
#include "fem_solver/stress/cell_geometry.hpp"
#include "fem_solver/stress/failure_numbers.hpp"
#include "fem_solver/stress/stress_integral.hpp"

namespace gabion::fem {

/// Cells of one material and formulation. Gradients and weights are computed once. Histories given
/// to its functions are those of its cells, num_cells x history_width.
template <int dim>
class CellBlock {
 public:
  /// @param cells  of the mesh
  /// @param ranks  for the number of a cell in messages
  /// @throws ConfigError  a cell with a Jacobian <= 0 at a quadrature point; see crack_bands()
  CellBlock(const Mesh<dim>& mesh, const CellMaterial<dim>& material,
            std::vector<std::int32_t> cells, const MeshRanks& ranks);

  /// See CellIntegrals::add_internal.
  StressIntegral add_internal(std::span<const double> u, std::span<double> f_int,
                              BlockMatrix<dim>* K, HistoryStep history) const;

  /// Cauchy stress, mean over the quadrature points, into the rows of its cells [Pa].
  /// @param history  accepted
  void find_stresses(std::span<const double> u, std::span<const double> history,
                     std::span<double> stresses) const;
  /// Equivalent plastic strain, mean over the quadrature points, into the rows of its cells.
  void find_plastic_strains(std::span<const double> history, std::span<double> strains) const;
  double largest_plastic_strain(std::span<const double> history) const;
  /// Largest plastic strain of the points of its c-th cell; 0 where none yields.
  double largest_plastic_strain(std::size_t c, std::span<const double> history) const;
  double plastic_work(std::span<const double> history) const;  ///< [J]
  /// See CellIntegrals::largest_rotation; 0 of laws of finite strain.
  double largest_rotation(std::span<const double> u) const;

  const CellMaterial<dim>& material() const { return material_; }
  std::span<const std::int32_t> cells() const { return cells_; }
  std::size_t history_width() const { return history_width_; }  ///< of a cell
  bool may_fail() const { return material_.failure.any(); }
  /// Share of its stress that the c-th cell still has: 1 but for one that failed.
  double share_left(std::size_t c, std::span<const double> history) const {
    return may_fail() ? fem::share_left(history.subspan(c * history_width_, history_width_)) : 1;
  }
  std::size_t history_size() const { return history_width_ * cells_.size(); }
  std::span<const double> weights(std::size_t c) const {  ///< of the points of a cell [m^dim]
    return std::span(geometry_.weights)
        .subspan(c * geometry_.points_per_cell, geometry_.points_per_cell);
  }
  bool yields() const { return std::holds_alternative<VonMises<dim>>(material_.law); }
  bool cracks() const { return std::holds_alternative<Concrete<dim>>(material_.law); }

 private:
  template <int nodes, class Law>
  StressIntegral integrate(const Law& law, std::span<const double> u, std::span<double> f_int,
                           BlockMatrix<dim>* K, HistoryStep history) const;
  /// Call visit(cell), a function of the number of a cell in the block: its EnhancedCell.
  template <class Law, class Visit>
  auto visit_enhanced(const Law& law, const Visit& visit) const;
  template <class CellOf>
  StressIntegral integrate_enhanced(const CellOf& cell_of, std::span<const double> u,
                                    std::span<double> f_int, BlockMatrix<dim>* K,
                                    HistoryStep history) const;
  template <class Law>
  Symmetric<dim> mean_stress(const Law& law, std::int32_t c, std::span<const double> u,
                             std::span<const double> history) const;
  template <class CellOf>
  Symmetric<dim> mean_enhanced_stress(const CellOf& cell_of, std::size_t c,
                                      std::span<const double> u,
                                      std::span<const double> history) const;
  template <class Law>
  decltype(auto) law_in(const Law& law, std::size_t c) const;
  std::span<const std::int32_t> nodes_of(std::int32_t c) const {
    return std::span(cell_nodes_)
        .subspan(static_cast<std::size_t>(c) * nodes_per_cell_, nodes_per_cell_);
  }
  /// Numbers of the law and the modes of a cell; those of its failure follow.
  std::size_t law_width() const { return history_width_ - (may_fail() ? failure_numbers : 0); }
  void keep_failure(std::size_t c, double share, HistoryStep history) const;
  Matrix<dim> gradient_at(std::int32_t c, int q, std::span<const double> u) const;
  /// Strains are enhanced, by modes that are part of the history.
  bool is_enhanced() const { return material_.formulation == Formulation::enhanced || is_shell(); }
  bool is_shell() const { return material_.formulation == Formulation::solid_shell; }

  CellMaterial<dim> material_;
  std::vector<std::int32_t> cells_;  // of the mesh
  int nodes_per_cell_ = 0;
  CellGeometry<dim> geometry_;
  std::size_t history_per_point_ = 0;
  std::size_t history_width_ = 0;
  std::vector<std::int32_t> cell_nodes_;  // cells x nodes
  std::vector<CrackBand<dim>> bands_;     // cells; empty: not of concrete
};

}  // namespace gabion::fem
