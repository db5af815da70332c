// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/cell_damage.hpp"

#include <variant>

namespace gabion::fem {

namespace {

/// Call visit(c, weight, history of the point) for each point of a block of concrete.
template <int dim, class Visit>
void for_each_point(const CellBlock<dim>& block, std::span<const double> history,
                    const Visit& visit) {
  constexpr std::size_t size = Concrete<dim>::history_size;
  for (std::size_t c = 0; c < block.cells().size(); ++c) {
    const auto weights = block.weights(c);
    for (std::size_t q = 0; q < weights.size(); ++q) {
      visit(c, weights[q], history.subspan(c * block.history_width() + q * size, size));
    }
  }
}

}  // namespace

template <int dim>
std::vector<CellDamage> block_damage(const CellBlock<dim>& block, std::span<const double> history) {
  std::vector<CellDamage> damage;
  const auto* law = std::get_if<Concrete<dim>>(&block.material().law);
  if (!law) return damage;
  damage.resize(block.cells().size());
  std::vector<double> volumes(damage.size(), 0.0);
  for_each_point(block, history, [&](std::size_t c, double w, std::span<const double> point) {
    damage[c].tensile += w * law->tensile_damage(point);
    damage[c].compressive += w * law->compressive_damage(point);
    damage[c].crack_width += w * law->crack_width(point);
    volumes[c] += w;
  });
  for (std::size_t c = 0; c < damage.size(); ++c) {
    damage[c].tensile /= volumes[c];
    damage[c].compressive /= volumes[c];
    damage[c].crack_width /= volumes[c];
  }
  return damage;
}

template <int dim>
std::vector<CellDamage> cell_damage(const CellIntegrals<dim>& cells,
                                    std::span<const double> history) {
  std::vector<CellDamage> damage(static_cast<std::size_t>(cells.num_cells()));
  for (std::size_t b = 0; b < cells.blocks().size(); ++b) {
    const CellBlock<dim>& block = cells.blocks()[b];
    if (!block.cracks()) continue;
    const auto own = block_damage(block, cells.of_block(history, b));
    for (std::size_t k = 0; k < own.size(); ++k) damage[block.cells()[k]] = own[k];
  }
  return damage;
}

template <int dim>
double damage_work(const CellIntegrals<dim>& cells, std::span<const double> history) {
  double sum = 0;
  for (std::size_t b = 0; b < cells.blocks().size(); ++b) {
    if (!cells.blocks()[b].cracks()) continue;
    const CellBlock<dim>& block = cells.blocks()[b];
    const auto own = cells.of_block(history, b);
    for_each_point(block, own, [&](std::size_t c, double w, std::span<const double> point) {
      sum += block.share_left(c, own) * w * Concrete<dim>::damage_work(point);
    });
  }
  return sum;
}

template std::vector<CellDamage> block_damage(const CellBlock<2>&, std::span<const double>);
template std::vector<CellDamage> block_damage(const CellBlock<3>&, std::span<const double>);
template std::vector<CellDamage> cell_damage(const CellIntegrals<2>&, std::span<const double>);
template std::vector<CellDamage> cell_damage(const CellIntegrals<3>&, std::span<const double>);
template double damage_work(const CellIntegrals<2>&, std::span<const double>);
template double damage_work(const CellIntegrals<3>&, std::span<const double>);

}  // namespace gabion::fem
