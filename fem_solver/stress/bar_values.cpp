// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/bar_values.hpp"

#include <algorithm>
#include <cmath>

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

template <int dim>
std::array<double, 3> largest_resultants(const BeamCells<dim>& beams, std::span<const double> u,
                                         std::span<const double> history) {
  double shear = 0, bending = 0, torsion = 0;
  std::size_t k = 0;
  for (const auto& beam : beams.resultants(u, history)) {
    const auto& [N, V_2, V_3] = beam.force;
    const auto& [T, M_2, M_3] = beam.moment;
    shear = std::max(shear, std::hypot(V_2, V_3));
    torsion = std::max(torsion, std::abs(T));
    const double half = 0.5 * beams.length(k++);
    for (const double end : {-half, half}) {
      bending = std::max(bending, std::hypot(M_2 + end * V_3, M_3 - end * V_2));
    }
  }
  return {shear, bending, torsion};
}

template std::vector<double> line_stresses(const CellIntegrals<2>&, std::span<const double>,
                                           std::span<const double>);
template std::vector<double> line_stresses(const CellIntegrals<3>&, std::span<const double>,
                                           std::span<const double>);
template std::vector<double> line_plastic_strains(const CellIntegrals<2>&, std::span<const double>);
template std::vector<double> line_plastic_strains(const CellIntegrals<3>&, std::span<const double>);
template std::array<double, 3> largest_resultants(const BeamCells<2>&, std::span<const double>,
                                                  std::span<const double>);
template std::array<double, 3> largest_resultants(const BeamCells<3>&, std::span<const double>,
                                                  std::span<const double>);

}  // namespace gabion::fem
