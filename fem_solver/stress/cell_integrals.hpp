// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/materials/material.hpp"
#include "common/mechanics/mesh/mesh.hpp"
#include "common/mechanics/petsc/block_matrix.hpp"
#include "fem_solver/ranks/mesh_ranks.hpp"

namespace gabion::fem {

/// What the integration of the stresses found.
struct StressIntegral {
  std::int32_t inadmissible_cell = -1;  ///< cell of the mesh with det F <= 0, -1 = none
  double energy = 0;                    ///< elastic energy [J]
};

/// Integrals over the cells of a mesh, or a rank's part of one, in the reference configuration:
/// sums over the cells of this rank alone. Gradients, weights and masses are computed once.
template <int dim>
class CellIntegrals {
 public:
  /// @throws ConfigError  a cell with a Jacobian <= 0 at a quadrature point
  /// @param ranks  for the number of the cell in the message
  CellIntegrals(const Mesh<dim>& mesh, const Material<dim>& material, bool lumped_mass,
                const MeshRanks& ranks = {});

  /// f_int,a = sum_q w_q P(H_q) dN_a/dX, H = sum_a u_a (x) dN_a/dX, and on demand
  /// K_ab = sum_q w_q dN_a/dX . dP/dH . dN_b/dX.
  /// @param[in]     u      displacement [m], num_nodes x dim
  /// @param[in,out] f_int  num_nodes x dim [N]; added to
  /// @param[in,out] K      null, or a matrix whose pattern comes from set_pattern; added to
  StressIntegral add_internal(std::span<const double> u, std::span<double> f_int,
                              BlockMatrix<dim>* K) const;

  /// f += M a. [N]
  void add_mass_times(std::span<const double> a, std::span<double> f) const;
  /// K += scale M
  void add_mass(double scale, BlockMatrix<dim>& K) const;

  /// Pattern of the cells.
  void set_pattern(BlockMatrix<dim>& K) const;

  /// Cauchy stress of each cell, mean over its quadrature points, num_cells x
  /// symmetric_size<dim> [Pa]. @pre det F > 0 everywhere
  std::vector<double> cell_stresses(std::span<const double> u) const;

  /// Largest angle by which a cell has turned, from the polar decomposition of the mean of F over
  /// its quadrature points [rad]; 0 without cells.
  double largest_rotation(std::span<const double> u) const;

  /// V^(1/dim) [m]; infinite without cells.
  double smallest_cell_size() const { return smallest_cell_size_; }

 private:
  template <int nodes, class Law>
  StressIntegral integrate(const Law& law, std::span<const double> u, std::span<double> f_int,
                           BlockMatrix<dim>* K) const;
  template <int nodes>
  Matrix<dim> displacement_gradient(const Vector<dim>* dN, const Vector<dim>* u_cell) const;
  void compute_geometry(const Mesh<dim>& mesh, const MeshRanks& ranks);
  void compute_mass(const Mesh<dim>& mesh, bool lumped);
  std::span<const std::int32_t> cell(std::int32_t c) const {
    return {cell_nodes_.data() + static_cast<std::size_t>(c) * nodes_per_cell_,
            static_cast<std::size_t>(nodes_per_cell_)};
  }

  Material<dim> material_;
  int nodes_per_cell_ = 0;
  std::int32_t num_nodes_ = 0;
  std::int32_t num_cells_ = 0;
  int points_per_cell_ = 0;
  std::vector<std::int32_t> cell_nodes_;  // cells x nodes
  std::vector<Vector<dim>> gradients_;    // cells x points x nodes
  std::vector<double> weights_;           // cells x points [m^dim]
  std::vector<double> cell_masses_;       // cells x nodes x nodes [kg]; empty when lumped
  std::vector<double> lumped_masses_;     // num_nodes [kg]; empty when consistent
  double smallest_cell_size_ = 0;
};

}  // namespace gabion::fem
