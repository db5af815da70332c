// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/bar_values.hpp"

namespace gabion::fem {

template <int dim>
std::vector<double> line_stresses(const CellIntegrals<dim>& cells, std::span<const double> u,
                                  std::span<const double> history) {
  std::vector<double> result = cells.line_forces(u, history);
  for (const LineBlock<dim>& block : cells.line_blocks()) {
    for (const std::int32_t l : block.lines()) result[l] /= block.material().area;
  }
  return result;
}

template <int dim>
std::vector<double> line_plastic_strains(const CellIntegrals<dim>& cells,
                                         std::span<const double> history) {
  std::vector<double> result = cells.line_runs(history);
  result.assign(result.size(), 0.0);
  for (std::size_t b = 0; b < cells.line_blocks().size(); ++b) {
    const LineBlock<dim>& block = cells.line_blocks()[b];
    const auto strains = block.plastic_strains(cells.of_line_block(history, b));
    for (std::size_t k = 0; k < strains.size(); ++k) result[block.lines()[k]] = strains[k];
  }
  return result;
}

template std::vector<double> line_stresses(const CellIntegrals<2>&, std::span<const double>,
                                           std::span<const double>);
template std::vector<double> line_stresses(const CellIntegrals<3>&, std::span<const double>,
                                           std::span<const double>);
template std::vector<double> line_plastic_strains(const CellIntegrals<2>&, std::span<const double>);
template std::vector<double> line_plastic_strains(const CellIntegrals<3>&, std::span<const double>);

}  // namespace gabion::fem
