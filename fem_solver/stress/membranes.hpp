// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fem_solver/stress/membrane_block.hpp"

namespace gabion::fem {

/// Membranes of a structure, block by block; in the plane there are none.
template <int dim>
class Membranes {
 public:
  Membranes() = default;
  /// @throws ConfigError  see MembraneBlock
  Membranes(const Mesh<dim>& mesh, std::span<const MembraneMaterial> materials, bool lumped_mass);

  bool any() const { return !blocks_.empty(); }
  std::span<const MembraneBlock> blocks() const { return blocks_; }
  std::int32_t num_sheets() const { return static_cast<std::int32_t>(nodes_.size() / width_); }
  double smallest_size() const;  ///< [m]; infinite without any
  double wave_speed() const;     ///< the largest [m/s]; 0 without any

  /// Add the nodes of the sheets, and the end of each, to a pattern of cells.
  void add_to_pattern(std::vector<std::int32_t>& offsets, std::vector<std::int32_t>& nodes) const;
  /// See MembraneBlock. @param first  number of the first sheet in the pattern
  double add_internal(std::span<const double> u, std::span<double> f_int, BlockMatrix<dim>* K,
                      std::int32_t first) const;
  void add_stiffness(double share, BlockMatrix<dim>& K, std::int32_t first) const;
  void add_mass_times(std::span<const double> a, std::span<double> f) const;
  void add_mass(double scale, BlockMatrix<dim>& K, std::int32_t first) const;

 private:
  std::vector<MembraneBlock> blocks_;
  std::vector<std::int32_t> nodes_;  // sheets of the mesh x nodes
  std::size_t width_ = 1;            // nodes of a sheet
};

/// Find the surface cells of the mesh that are membranes: the facets of their groups.
/// @throws ConfigError  a group that the mesh does not have; a facet in two of them
template <int dim>
void add_sheets(Mesh<dim>& mesh, std::span<const MembraneMaterial> materials);

}  // namespace gabion::fem
