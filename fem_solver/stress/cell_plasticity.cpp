// SPDX-License-Identifier: BSD-3-Clause
// Plastic strains and work from the histories of cells that yield.
#include <algorithm>

#include "fem_solver/stress/cell_block.hpp"

namespace gabion::fem {

template <int dim>
void CellBlock<dim>::find_plastic_strains(std::span<const double> history,
                                          std::span<double> strains) const {
  if (!yields()) return;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    double sum = 0, volume = 0;
    for (int q = 0; q < geometry_.points_per_cell; ++q) {
      const double w = geometry_.weights[c * geometry_.points_per_cell + q];
      sum += w * history[c * history_width_ + (q + 1) * history_per_point_ - 1];
      volume += w;
    }
    strains[cells_[c]] = sum / volume;
  }
}

template <int dim>
double CellBlock<dim>::largest_plastic_strain(std::span<const double> history) const {
  double largest = 0;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    largest = std::max(largest, largest_plastic_strain(c, history));
  }
  return largest;
}

template <int dim>
double CellBlock<dim>::largest_plastic_strain(std::size_t c,
                                              std::span<const double> history) const {
  double largest = 0;
  if (!yields()) return largest;
  for (int q = 0; q < geometry_.points_per_cell; ++q) {
    largest = std::max(largest, history[c * history_width_ + (q + 1) * history_per_point_ - 1]);
  }
  return largest;
}

template <int dim>
double CellBlock<dim>::plastic_work(std::span<const double> history) const {
  const auto* law = std::get_if<VonMises<dim>>(&material_.law);
  if (!law) return 0;
  double sum = 0;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const double share = share_left(c, history);
    for (int q = 0; q < geometry_.points_per_cell; ++q) {
      const auto own =
          history.subspan(c * history_width_ + q * history_per_point_, history_per_point_);
      if (own.back() <= 0) continue;
      sum += share * geometry_.weights[c * geometry_.points_per_cell + q] * law->plastic_work(own);
    }
  }
  return sum;
}

template void CellBlock<2>::find_plastic_strains(std::span<const double>, std::span<double>) const;
template double CellBlock<2>::largest_plastic_strain(std::span<const double>) const;
template double CellBlock<2>::largest_plastic_strain(std::size_t, std::span<const double>) const;
template double CellBlock<2>::plastic_work(std::span<const double>) const;
template void CellBlock<3>::find_plastic_strains(std::span<const double>, std::span<double>) const;
template double CellBlock<3>::largest_plastic_strain(std::span<const double>) const;
template double CellBlock<3>::largest_plastic_strain(std::size_t, std::span<const double>) const;
template double CellBlock<3>::plastic_work(std::span<const double>) const;

}  // namespace gabion::fem
