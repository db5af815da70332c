// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/report/widest_crack.hpp"

#include <vector>

#include "fem_solver/stress/cell_damage.hpp"

namespace gabion::fem {

template <int dim>
WidestCrack wider_crack(const FemSettings<dim>& settings, const CellIntegrals<dim>& cells,
                        const StructureState& state, double time, const WidestCrack& earlier) {
  const MeshRanks& ranks = settings.ranks;
  const std::vector<CellDamage> damage = cell_damage(cells, *state.history);
  double own = 0;
  std::int32_t cell = -1;
  for (std::size_t c = 0; c < damage.size(); ++c) {
    if (damage[c].crack_width <= own) continue;
    own = damage[c].crack_width;
    cell = static_cast<std::int32_t>(c);
  }
  const double width = ranks.shared().largest(own);
  if (width <= earlier.width) return earlier;
  // Among cells of equal width the one with the largest number in the whole mesh counts.
  const double number = cell >= 0 && own == width ? ranks.cell_of_all(cell) : -1;
  const double last = ranks.shared().largest(number);
  WidestCrack crack{.width = width, .time = time};
  if (number == last) {
    const auto nodes = settings.mesh.cell(cell);
    for (const std::int32_t i : nodes) {
      for (int k = 0; k < dim; ++k) {
        crack.place[k] += settings.mesh.nodes[i][k] / static_cast<double>(nodes.size());
      }
    }
  }
  ranks.shared().total(crack.place);
  return crack;
}

Json describe(const WidestCrack& crack, int dim) {
  return {{"width", crack.width},
          {"time", crack.time},
          {"place", std::vector<double>(crack.place.begin(), crack.place.begin() + dim)}};
}

template WidestCrack wider_crack(const FemSettings<2>&, const CellIntegrals<2>&,
                                 const StructureState&, double, const WidestCrack&);
template WidestCrack wider_crack(const FemSettings<3>&, const CellIntegrals<3>&,
                                 const StructureState&, double, const WidestCrack&);

}  // namespace gabion::fem
