// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/soil_border.hpp"

#include <algorithm>
#include <set>

#include "common/mechanics/ranks/packet.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

template <int dim>
SoilBorder<dim>::SoilBorder(const CellOwners<dim>& owners, SparseList<char> occupied)
    : box_(*owners.grid.box), occupied_(std::move(occupied)) {
  if (num_ranks(owners.comm) > 1) exchange(owners);
}

template <int dim>
void SoilBorder<dim>::exchange(const CellOwners<dim>& owners) {
  const int own = rank_of(owners.comm);
  std::map<int, std::set<std::int32_t>> beside;
  occupied_.for_each([&](std::size_t place, char) {
    const auto c = static_cast<std::int32_t>(place);
    for (const std::int32_t other : box_.neighbours(c)) {
      if (other < 0) continue;
      const int rank = owners.of(other);
      if (rank != own) beside[rank].insert(c);
    }
  });
  Packets out;
  for (const auto& [rank, cells] : beside) {
    for (const std::int32_t c : cells) out[rank].put(c);
  }
  for (auto& [rank, packet] : send_packets(owners.comm, out)) {
    while (!packet.empty()) occupied_.at(packet.template take<std::int32_t>()) = 1;
  }
}

template <int dim>
int SoilBorder<dim>::axes(std::int32_t cell) const {
  const auto beside = box_.neighbours(cell);
  int result = 0;
  for (int k = 0; k < 2 * dim; ++k) {
    if (beside[k] >= 0 && occupied_[beside[k]] == 0) result |= 1 << k / 2;
  }
  return result;
}

template <int dim>
int part_of_cell(const BoxGrid<dim>& box, std::int32_t cell, const Vector<dim>& x) {
  const Vector<dim> t = box.lattice_position(x);
  const auto at = box.cell_index(cell);
  int part = 0;
  for (int d = 0; d < dim; ++d) part |= t[d] - at[d] > 0.5 ? 1 << d : 0;
  return part;
}

template <int dim>
SparseList<char> cells_with_points(const BackgroundGrid<dim>& grid,
                                   const MaterialPoints<dim>& points) {
  SparseList<char> occupied(grid.num_cells(), 0);
  for (const std::int32_t cell : points.cell) occupied.at(cell) = 1;
  return occupied;
}

template <int dim>
void split_groups(const SoilBorder<dim>& border, const BoxGrid<dim>& box,
                  const MaterialPoints<dim>& points, PointWeights<dim>& weights) {
  std::vector<CellGroup> groups;
  std::vector<std::int32_t> body_groups(1, 0);
  for (std::size_t b = 0; b + 1 < weights.body_groups.size(); ++b) {
    for (std::int32_t g = weights.body_groups[b]; g < weights.body_groups[b + 1]; ++g) {
      CellGroup group = weights.groups[g];
      const int axes = border.axes(group.cell);
      const auto part = [&](std::int32_t p) {
        return axes & part_of_cell<dim>(box, group.cell, points.x[p]);
      };
      const auto first = weights.point.begin() + group.first;
      const auto last = weights.point.begin() + group.last;
      if (axes != 0) {
        std::stable_sort(first, last, [&](auto p, auto q) { return part(p) < part(q); });
      }
      for (auto from = first, to = first; from != last; from = to) {
        to = std::find_if(from, last, [&, now = part(*from)](auto p) { return part(p) != now; });
        group.first = static_cast<std::int32_t>(from - weights.point.begin());
        group.last = static_cast<std::int32_t>(to - weights.point.begin());
        groups.push_back(group);
      }
    }
    body_groups.push_back(static_cast<std::int32_t>(groups.size()));
  }
  weights.groups = std::move(groups);
  weights.body_groups = std::move(body_groups);
}

template class SoilBorder<2>;
template class SoilBorder<3>;
template int part_of_cell<2>(const BoxGrid<2>&, std::int32_t, const Vector<2>&);
template int part_of_cell<3>(const BoxGrid<3>&, std::int32_t, const Vector<3>&);
template SparseList<char> cells_with_points<2>(const BackgroundGrid<2>&, const MaterialPoints<2>&);
template SparseList<char> cells_with_points<3>(const BackgroundGrid<3>&, const MaterialPoints<3>&);
template void split_groups<2>(const SoilBorder<2>&, const BoxGrid<2>&, const MaterialPoints<2>&,
                              PointWeights<2>&);
template void split_groups<3>(const SoilBorder<3>&, const BoxGrid<3>&, const MaterialPoints<3>&,
                              PointWeights<3>&);

}  // namespace gabion::mpm
