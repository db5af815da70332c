// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/small_cuts/ghost_stiffness.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <variant>

#include "common/mechanics/elements/cell_facets.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
#include "common/mechanics/mesh/boundary.hpp"
#include "common/mechanics/ranks/packet.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/grid/box_basis.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
double young_modulus(const MaterialLaw<dim>& law) {
  return std::visit(
      [](const auto& model) {
        const double mu = model.shear_modulus();
        const double M = model.p_wave_modulus();
        return mu * (3 * M - 4 * mu) / (M - mu);
      },
      law);
}

/// dN/dn of a cell's nodes at x.
template <int dim>
std::array<double, max_cell_nodes> normal_slopes(const BackgroundGrid<dim>& grid, std::int32_t cell,
                                                 const Vector<dim>* corners, const Vector<dim>& x,
                                                 const Vector<dim>& n) {
  ShapeValues<dim> shape;
  shape_functions<dim>(grid.cell_type, grid.local_coordinates(cell, x), shape);
  map_gradients<dim>(grid.cell_type, corners, shape);
  std::array<double, max_cell_nodes> slopes{};
  for (int a = 0; a < grid.nodes_per_cell(); ++a) slopes[a] = shape.dN[a].dot(n);
  return slopes;
}

struct SharedNodes {
  std::vector<std::int32_t> list;                   // of both cells, each once
  std::array<std::size_t, max_cell_nodes> place{};  // of the neighbour's nodes in the list
};

SharedNodes nodes_of_both(const CellList& own, const CellList& neighbour) {
  SharedNodes nodes{.list = {own.begin(), own.end()}};
  auto& list = nodes.list;
  for (std::size_t a = 0; a < neighbour.size(); ++a) {
    const auto found = std::find(list.begin(), list.end(), neighbour[a]);
    nodes.place[a] = static_cast<std::size_t>(found - list.begin());
    if (found == list.end()) list.push_back(neighbour[a]);
  }
  return nodes;
}

}  // namespace

template <int dim>
GhostStiffness<dim>::GhostStiffness(const BackgroundGrid<dim>& grid,
                                    const std::vector<Body<dim>>& bodies, double factor)
    : grid_(grid), factor_(factor), starts_(1, 0) {
  for (const auto& body : bodies) young_modulus_.push_back(young_modulus<dim>(body.material.law));
}

template <int dim>
void GhostStiffness<dim>::measure_cells(const MaterialPoints<dim>& points,
                                        const PointWeights<dim>& weights, LawsOfPoints<dim> laws) {
  soil_.assign(grid_.num_cells(), {});
  const bool has_domains = grid_.basis == Basis::gimp;
  for (const CellGroup& group : weights.groups) {
    double E = young_modulus_[group.body];
    const auto add = [&](std::int32_t cell, double volume) {
      CellSoil& soil = soil_.at(cell);
      soil.volume += volume;
      soil.stiffness += E * volume;
    };
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      if (!laws.empty() && laws[p] != nullptr) E = young_modulus<dim>(*laws[p]);
      const double volume = points.V0[p] * points.J[p];
      if (!has_domains) {
        add(group.cell, volume);
        continue;
      }
      for (const auto& part : cells_of_domain(*grid_.box, points, p)) {
        add(part.cell, part.share * volume);
      }
    }
  }
}

template <int dim>
void GhostStiffness<dim>::mark_doubled(const PointWeights<dim>& weights,
                                       std::span<const std::int32_t> doubled) {
  if (weights.num_fields == 1) return;
  const std::int32_t num_places = grid_.num_nodes_total();
  SparseList<char> is_doubled(num_places, 0);
  const auto add = [&](std::int32_t node) {
    if (node >= num_places) is_doubled.at(node % num_places) = 1;
  };
  std::ranges::for_each(weights.group_nodes, add);
  std::ranges::for_each(doubled, add);
  soil_.for_each([&](std::size_t cell, CellSoil& soil) {
    const CellList nodes = grid_.cell(static_cast<std::int32_t>(cell));
    soil.doubled =
        std::any_of(nodes.begin(), nodes.end(), [&](auto n) { return is_doubled[n] != 0; });
  });
}

// Sum up the soil of each cell on its rank, and send the sum to the ranks of the cells beside it.
template <int dim>
void GhostStiffness<dim>::share_cells(const CellOwners<dim>& owners) {
  const int own = rank_of(owners.comm);
  Packets parts, sums;
  const auto put = [](Packet& packet, std::size_t cell, const CellSoil& soil) {
    packet.put(static_cast<std::int32_t>(cell));
    packet.put(soil.volume);
    packet.put(soil.stiffness);
    packet.put(soil.doubled);
  };
  const auto take = [](Packet& packet) {
    CellSoil soil;
    soil.volume = packet.take<double>();
    soil.stiffness = packet.take<double>();
    soil.doubled = packet.take<bool>();
    return soil;
  };
  soil_.for_each([&](std::size_t cell, const CellSoil& soil) {
    const int rank = owners.of(static_cast<std::int32_t>(cell));
    if (rank != own) put(parts[rank], cell, soil);
  });
  for (auto& [rank, packet] : send_packets(owners.comm, parts)) {
    while (!packet.empty()) {
      CellSoil& soil = soil_.at(packet.template take<std::int32_t>());
      const CellSoil more = take(packet);
      soil.volume += more.volume;
      soil.stiffness += more.stiffness;
      soil.doubled |= more.doubled;
    }
  }
  soil_.for_each([&](std::size_t cell, const CellSoil& soil) {
    const auto c = static_cast<std::int32_t>(cell);
    if (owners.of(c) != own) return;
    std::set<int> beside;
    for (const std::int32_t other : grid_.neighbours(c)) {
      if (other >= 0) beside.insert(owners.of(other));
    }
    beside.erase(own);
    for (const int rank : beside) put(sums[rank], cell, soil);
  });
  for (auto& [rank, packet] : send_packets(owners.comm, sums)) {
    while (!packet.empty()) {
      const auto cell = packet.template take<std::int32_t>();
      soil_.at(cell) = take(packet);
    }
  }
}

template <int dim>
std::vector<std::int32_t> GhostStiffness<dim>::find_facets(const CellOwners<dim>& owners,
                                                           const MaterialPoints<dim>& points,
                                                           const PointWeights<dim>& weights,
                                                           std::span<const std::int32_t> doubled,
                                                           LawsOfPoints<dim> laws) {
  measure_cells(points, weights, laws);
  mark_doubled(weights, doubled);
  if (num_ranks(owners.comm) > 1) share_cells(owners);
  facets_.clear();
  std::vector<std::int32_t> nodes;
  const int own = rank_of(owners.comm);
  soil_.for_each([&](std::size_t place, const CellSoil&) {
    const auto c = static_cast<std::int32_t>(place);
    if (!is_small(c) || owners.of(c) != own || soil_[c].doubled) return;
    const CellList neighbours = grid_.neighbours(c);
    for (std::size_t f = 0; f < neighbours.size(); ++f) {
      const std::int32_t other = neighbours[f];
      if (other < 0 || soil_[other].volume == 0) continue;
      if (soil_[other].doubled) continue;
      if (other < c && is_small(other)) continue;  // visited from the other side
      facets_.push_back({c, static_cast<int>(f), other});
      for (const std::int32_t cell : {c, other}) {
        const CellList of_cell = grid_.cell(cell);
        nodes.insert(nodes.end(), of_cell.begin(), of_cell.end());
      }
    }
  });
  auto count = static_cast<std::int32_t>(facets_.size());
  sum_over_ranks(owners.comm, std::span<std::int32_t>(&count, 1));
  num_facets_ = count;
  return nodes;
}

template <int dim>
void GhostStiffness<dim>::begin_step(const GridNodes<dim>& nodes) {
  starts_.assign(1, 0);
  nodes_.clear();
  k_.clear();
  for (const Facet& facet : facets_) add_facet(nodes, facet);
}

template <int dim>
void GhostStiffness<dim>::add_facet(const GridNodes<dim>& nodes, const Facet& facet) {
  const auto [cell, number, neighbour] = facet;
  const CellType type = facet_type(grid_.cell_type);
  const bool simplex = grid_.is_simplex();
  const auto local = facet_nodes(grid_.cell_type, number);
  const auto geometry = facet_geometry(grid_, grid_.facet(cell, number)).front();
  const double height = (simplex ? dim : 1) *
                        (cell_volume(grid_, cell) + cell_volume(grid_, neighbour)) /
                        (2 * geometry.area);
  const double E = (soil_[cell].stiffness + soil_[neighbour].stiffness) /
                   (soil_[cell].volume + soil_[neighbour].volume);

  const CellList own = grid_.cell(cell);
  const auto [list, place] = nodes_of_both(own, grid_.cell(neighbour));

  const std::size_t n = list.size(), first = k_.size();
  k_.resize(first + n * n, 0.0);
  const auto rule = gauss_rule<dim - 1>(type, simplex ? 0 : 2);
  double total = 0;
  for (const auto& q : rule) total += q.weight;
  Vector<dim> own_x[max_cell_nodes], other_x[max_cell_nodes];
  grid_.corners(cell, own_x);
  grid_.corners(neighbour, other_x);
  ShapeValues<dim - 1> shape;
  for (const auto& q : rule) {
    shape_functions<dim - 1>(type, q.xi, shape);
    Vector<dim> x = Vector<dim>::Zero();
    for (int a = 0; a < num_nodes(type); ++a) x += shape.N[a] * own_x[local[a]];
    std::array<double, 2 * max_cell_nodes> jump{};
    const auto slopes = normal_slopes(grid_, cell, own_x, x, geometry.normal);
    const auto other_slopes = normal_slopes(grid_, neighbour, other_x, x, geometry.normal);
    for (std::size_t a = 0; a < own.size(); ++a) {
      jump[a] += slopes[a];
      jump[place[a]] -= other_slopes[a];
    }
    const double weight = factor_ * E * height / 3 * geometry.area * q.weight / total;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) k_[first + i * n + j] += weight * jump[i] * jump[j];
    }
  }
  for (const std::int32_t node : list) nodes_.push_back(nodes.active[node]);
  starts_.push_back(static_cast<std::int32_t>(nodes_.size()));
}

template <int dim>
void GhostStiffness<dim>::append_cells(std::vector<std::int32_t>& offsets,
                                       std::vector<std::int32_t>& nodes) const {
  for (std::size_t f = 0; f + 1 < starts_.size(); ++f) {
    nodes.insert(nodes.end(), nodes_.begin() + starts_[f], nodes_.begin() + starts_[f + 1]);
    offsets.push_back(static_cast<std::int32_t>(nodes.size()));
  }
}

template <int dim>
void GhostStiffness<dim>::add_forces(std::span<const double> du, std::span<double> r,
                                     BlockMatrix<dim>* K) const {
  const double* k = k_.data();
  for (std::size_t f = 0; f + 1 < starts_.size(); ++f) {
    const std::int32_t n = starts_[f + 1] - starts_[f];
    const std::int32_t* node = nodes_.data() + starts_[f];
    for (std::int32_t i = 0; i < n; ++i) {
      Eigen::Map<Vector<dim>> r_i(r.data() + static_cast<std::ptrdiff_t>(node[i]) * dim);
      for (std::int32_t j = 0; j < n; ++j, ++k) {
        r_i -= *k * Eigen::Map<const Vector<dim>>(du.data() +
                                                  static_cast<std::ptrdiff_t>(node[j]) * dim);
        if (K) K->add_block(node[i], node[j], *k * Matrix<dim>::Identity());
      }
    }
  }
}

template class GhostStiffness<2>;
template class GhostStiffness<3>;

}  // namespace gabion::mpm
