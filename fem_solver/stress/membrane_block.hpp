// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"
#include "common/mechanics/petsc/block_matrix.hpp"
#include "fem_solver/materials/membrane_material.hpp"

namespace gabion::fem {

/// Membranes of one material: sheets of a mesh (tri3, quad4), of any place and turn in space.
class MembraneBlock {
 public:
  /// @param sheets       of the mesh
  /// @param lumped_mass  row sums instead of the consistent mass
  /// @throws ConfigError  a sheet that is degenerate, folded or not convex; a quadratic one
  MembraneBlock(const Mesh<3>& mesh, const MembraneMaterial& material,
                std::vector<std::int32_t> sheets, bool lumped_mass);

  /// f_a = sum_q w F S dN_a, K_ab = sum_q w [(dN_a . S dN_b) 1 + B_a^T D B_b], of the gradient
  /// F = sum_a x_a (x) dN_a by two coordinates of the stress-free plane.
  /// @param first  number of the first sheet among the cells of K
  /// @returns      the energy [J]
  double add_internal(std::span<const double> u, std::span<double> f_int, BlockMatrix<3>* K,
                      std::int32_t first = 0) const;
  /// Add a share of the stiffness of a taut membrane, in all directions.
  void add_stiffness(double share, BlockMatrix<3>& K, std::int32_t first) const;
  void add_mass_times(std::span<const double> a, std::span<double> f) const;
  void add_mass(double scale, BlockMatrix<3>& K, std::int32_t first) const;

  /// What a sheet carries, in its middle.
  struct Values {
    Symmetric<3> force = Symmetric<3>::Zero();  ///< per deformed length [N/m]
    std::array<double, 2> principal{};          ///< the larger first [N/m]
    double strain = 0;  ///< largest, engineering, from the stress-free state
    MembraneState state = MembraneState::taut;
  };
  std::vector<Values> values(std::span<const double> u) const;

  const MembraneMaterial& material() const { return material_; }
  std::span<const std::int32_t> sheets() const { return sheets_; }
  bool lumped_mass() const { return lumped_mass_; }
  double smallest_size() const { return smallest_size_; }  ///< square root of the least area [m]

 private:
  static constexpr int most_nodes = 4;
  using Frame = Eigen::Matrix<double, 3, 2>;

  /// A place of a sheet in the stress-free plane.
  struct Point {
    Frame frame;                                  ///< F of the mesh
    std::array<Vector<2>, most_nodes> gradients;  ///< of shape functions [1/m]
    double weight = 0;                            ///< volume [m^3]
  };
  Point point_at(std::span<const Vector<3>> x, const Vector<2>& xi) const;
  void check(const std::string& file, std::span<const Vector<3>> x) const;
  void add_masses(std::span<const Vector<3>> x);
  StrainVector<2> strain(std::size_t k, const Point& point, std::span<const double> u,
                         Frame& F) const;
  std::span<const std::int32_t> nodes_of(std::size_t k) const {
    return std::span(nodes_).subspan(k * nodes_per_sheet_, nodes_per_sheet_);
  }

  MembraneMaterial material_;
  CellType type_;
  std::size_t nodes_per_sheet_;
  std::size_t points_per_sheet_ = 0;
  std::vector<std::int32_t> sheets_;  // of the mesh
  bool lumped_mass_;
  std::vector<std::int32_t> nodes_;  // sheets x nodes
  std::vector<Point> points_;        // sheets x points
  std::vector<Point> middles_;       // of each sheet
  std::vector<double> masses_;       // sheets x nodes x nodes [kg]
  double smallest_size_;
};

}  // namespace gabion::fem
