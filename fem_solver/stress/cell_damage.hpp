// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fem_solver/stress/cell_integrals.hpp"

namespace gabion::fem {

/// Damage of a cell of concrete, mean over its quadrature points; zero of other laws.
struct CellDamage {
  double tensile = 0;      ///< 0 to 1
  double compressive = 0;  ///< 0 to 1
  double crack_width = 0;  ///< [m]
};

/// Damage of the cells of a block, in their order; empty: of another law.
/// @param history  accepted, of the block
template <int dim>
std::vector<CellDamage> block_damage(const CellBlock<dim>& block, std::span<const double> history);

/// Damage of all cells of this rank, num_cells.
/// @param history  accepted, of all blocks
template <int dim>
std::vector<CellDamage> cell_damage(const CellIntegrals<dim>& cells,
                                    std::span<const double> history);

/// Energy that cracks and crushing took in the cells of this rank [J].
template <int dim>
double damage_work(const CellIntegrals<dim>& cells, std::span<const double> history);

}  // namespace gabion::fem
