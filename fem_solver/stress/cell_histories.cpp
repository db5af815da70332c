// SPDX-License-Identifier: BSD-3-Clause
// Where the cells and lines of CellIntegrals have their histories.
#include <algorithm>
#include <utility>

#include "fem_solver/stress/cell_integrals.hpp"

namespace gabion::fem {

template <int dim>
void CellIntegrals<dim>::set_links(RigidLinks<dim> links) {
  links_ = std::move(links);
  std::size_t place = 0;
  std::vector<std::size_t> starts(num_lines());
  for (const auto& block : blocks_) place += block.history_size();
  for (const auto& block : line_blocks_) {
    for (const std::int32_t l : block.lines()) {
      starts[l] = place;
      place += block.history_width();
    }
  }
  link_starts_.clear();
  for (const RigidLink<dim>& link : links_.links()) link_starts_.push_back(starts[link.line]);
}

template <int dim>
std::vector<std::span<const double>> CellIntegrals<dim>::link_histories(
    std::span<const double> history) const {
  std::vector<std::span<const double>> histories;
  for (const std::size_t start : link_starts_) {
    histories.push_back(dim == 2 ? std::span<const double>()
                                 : history.subspan(start, BeamCells<dim>::rotation_width));
  }
  return histories;
}

template <int dim>
std::span<const double> CellIntegrals<dim>::of_block(std::span<const double> history,
                                                     std::size_t block) const {
  std::size_t first = 0;
  for (std::size_t b = 0; b < block; ++b) first += blocks_[b].history_size();
  return history.subspan(first, blocks_[block].history_size());
}

template <int dim>
std::span<const double> CellIntegrals<dim>::of_line_block(std::span<const double> history,
                                                          std::size_t block) const {
  std::size_t first = 0;
  for (const auto& cells : blocks_) first += cells.history_size();
  for (std::size_t b = 0; b < block; ++b) first += line_blocks_[b].history_size();
  return history.subspan(first, line_blocks_[block].history_size());
}

template <int dim>
std::size_t CellIntegrals<dim>::history_size() const {
  std::size_t sum = 0;
  for (const auto& block : blocks_) sum += block.history_size();
  for (const auto& block : line_blocks_) sum += block.history_size();
  return sum;
}

template <int dim>
std::size_t CellIntegrals<dim>::history_width() const {
  std::size_t widest = 0;
  for (const auto& block : blocks_) widest = std::max(widest, block.history_width());
  for (const auto& block : line_blocks_) widest = std::max(widest, block.history_width());
  return widest;
}

/// Call visit(place in a history, place in rows, number of values) for each cell and line.
template <int dim>
template <class Visit>
void CellIntegrals<dim>::for_each_cell_history(const Visit& visit) const {
  std::size_t place = 0;
  for (const auto& block : blocks_) {
    for (const std::int32_t c : block.cells()) {
      visit(place, static_cast<std::size_t>(c) * history_width(), block.history_width());
      place += block.history_width();
    }
  }
  for (const auto& block : line_blocks_) {
    for (const std::int32_t l : block.lines()) {
      visit(place, static_cast<std::size_t>(num_cells_ + l) * history_width(),
            block.history_width());
      place += block.history_width();
    }
  }
}

template <int dim>
std::vector<double> CellIntegrals<dim>::history_rows(std::span<const double> history) const {
  std::vector<double> rows(num_elements() * history_width(), 0.0);
  for_each_cell_history([&](std::size_t place, std::size_t row, std::size_t size) {
    std::ranges::copy(history.subspan(place, size), rows.begin() + row);
  });
  return rows;
}

template <int dim>
std::vector<double> CellIntegrals<dim>::history_of_rows(std::span<const double> rows) const {
  std::vector<double> history(history_size());
  for_each_cell_history([&](std::size_t place, std::size_t row, std::size_t size) {
    std::ranges::copy(rows.subspan(row, size), history.begin() + place);
  });
  return history;
}

template void CellIntegrals<2>::set_links(RigidLinks<2>);
template std::vector<std::span<const double>> CellIntegrals<2>::link_histories(
    std::span<const double>) const;
template std::span<const double> CellIntegrals<2>::of_block(std::span<const double>,
                                                            std::size_t) const;
template std::span<const double> CellIntegrals<2>::of_line_block(std::span<const double>,
                                                                 std::size_t) const;
template std::size_t CellIntegrals<2>::history_size() const;
template std::size_t CellIntegrals<2>::history_width() const;
template std::vector<double> CellIntegrals<2>::history_rows(std::span<const double>) const;
template std::vector<double> CellIntegrals<2>::history_of_rows(std::span<const double>) const;

template void CellIntegrals<3>::set_links(RigidLinks<3>);
template std::vector<std::span<const double>> CellIntegrals<3>::link_histories(
    std::span<const double>) const;
template std::span<const double> CellIntegrals<3>::of_block(std::span<const double>,
                                                            std::size_t) const;
template std::span<const double> CellIntegrals<3>::of_line_block(std::span<const double>,
                                                                 std::size_t) const;
template std::size_t CellIntegrals<3>::history_size() const;
template std::size_t CellIntegrals<3>::history_width() const;
template std::vector<double> CellIntegrals<3>::history_rows(std::span<const double>) const;
template std::vector<double> CellIntegrals<3>::history_of_rows(std::span<const double>) const;

}  // namespace gabion::fem
