// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/small_cuts/light_nodes.hpp"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "common/mechanics/ranks/packet.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

// Mass of the points that each active node acts on.
template <int dim>
std::vector<double> mass_within_reach(const MaterialPoints<dim>& points,
                                      const PointWeights<dim>& weights,
                                      const GridNodes<dim>& nodes) {
  std::vector<double> reach(nodes.grid_node.size(), 0);
  for (const CellGroup& group : weights.groups) {
    const auto grid_nodes = weights.nodes_of(group);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::uint8_t* local = weights.local_of(e);
      for (int i = 0; i < weights.num_nodes(e); ++i) {
        reach[nodes.active[grid_nodes[local[i]]]] += points.m[weights.point[e]];
      }
    }
  }
  nodes.shared.sum(reach, 1);
  return reach;
}

// Kind of a grid node, of all ranks together.
enum Weight : std::int32_t { inactive = 0, heavy = 1, light = 2, weak = 3 };

constexpr bool joins(std::int32_t kind) {
  return kind == light || kind == weak;
}

using Kinds = SparseList<std::int32_t>;  // of the grid nodes

// The cells of the light nodes, each once.
template <int dim>
std::vector<std::int32_t> cells_of_light_nodes(const BackgroundGrid<dim>& grid, Kinds& kinds) {
  std::vector<std::int32_t> cells;
  if (grid.box) {
    kinds.for_each([&](std::size_t node, std::int32_t kind) {
      if (!joins(kind)) return;
      const auto around = grid.box->cells_around(static_cast<std::int32_t>(node));
      cells.insert(cells.end(), around.begin(), around.end());
    });
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  } else {
    for (std::int32_t c = 0; c < grid.num_cells(); ++c) {
      const CellList nodes = grid.cell(c);
      if (std::any_of(nodes.begin(), nodes.end(), [&](auto n) { return joins(kinds[n]); })) {
        cells.push_back(c);
      }
    }
  }
  return cells;
}

// Learn the kinds of nodes beside the light ones that are active on other ranks only.
template <int dim>
void ask_other_ranks(MPI_Comm comm, const BackgroundGrid<dim>& grid,
                     std::span<const std::int32_t> cells, Kinds& kinds) {
  if (num_ranks(comm) == 1) return;
  std::set<std::int32_t> unknown;
  for (const std::int32_t c : cells) {
    for (const std::int32_t node : grid.cell(c)) {
      if (kinds[node] == inactive) unknown.insert(node);
    }
  }
  Packets questions, answers;
  for (int rank = 0; rank < num_ranks(comm); ++rank) {
    if (rank == rank_of(comm) || unknown.empty()) continue;
    for (const std::int32_t node : unknown) questions[rank].put(node);
  }
  for (auto& [rank, packet] : send_packets(comm, questions)) {
    while (!packet.empty()) {
      const auto node = packet.template take<std::int32_t>();
      if (kinds[node] == inactive) continue;
      answers[rank].put(node);
      answers[rank].put(kinds[node]);
    }
  }
  for (auto& [rank, packet] : send_packets(comm, answers)) {
    while (!packet.empty()) {
      const auto node = packet.template take<std::int32_t>();
      kinds.at(node) = packet.template take<std::int32_t>();
    }
  }
}

// The nearest heavy node of the cells of each node that joins one, as grid nodes; -1: none.
template <int dim>
std::vector<std::int32_t> nearest_heavy(const LightNodeSearch<dim>& search,
                                        std::span<const std::int32_t> cells,
                                        const GridNodes<dim>& nodes, const Kinds& kinds) {
  const BackgroundGrid<dim>& grid = search.grid;
  std::vector<std::int32_t> partner(nodes.grid_node.size(), -1);
  std::vector<double> distance(partner.size(), std::numeric_limits<double>::infinity());
  for (const std::int32_t c : cells) {
    for (const std::int32_t from : grid.cell(c)) {
      const std::int32_t i = nodes.active[from];
      if (i < 0 || !joins(kinds[from])) continue;
      for (const std::int32_t to : grid.cell(c)) {
        if (kinds[to] != heavy || search.walls.holds(to)) continue;
        const double d = (grid.node(to) - grid.node(from)).norm();
        if (d > distance[i] || (d == distance[i] && to >= partner[i])) continue;
        if (kinds[from] == weak && !search.sights->is_behind(grid.node(from), grid.node(to))) {
          continue;
        }
        distance[i] = d;
        partner[i] = to;
      }
    }
  }
  return partner;
}

// The heavy node that another one is to join, of those found so far.
struct Partners {
  std::vector<std::int32_t> node;  // of each active node, as grid node; -1: none
  std::vector<double> distance;    // [m]

  explicit Partners(std::int32_t num_nodes)
      : node(num_nodes, -1), distance(num_nodes, std::numeric_limits<double>::infinity()) {}
  // Keep the nearest partner of node i; of two equally near ones the one with the lower number.
  void offer(std::int32_t i, std::int32_t to, double d) {
    if (to < 0 || d > distance[i] || (d == distance[i] && to >= node[i])) return;
    distance[i] = d;
    node[i] = to;
  }
};

// Get the partners that other ranks found for the nodes that they hold too.
template <int dim>
void ask_holders(MPI_Comm comm, const GridNodes<dim>& nodes, const Kinds& kinds,
                 Partners& partners) {
  if (nodes.shared.alone()) return;
  Packets out;
  for (int n = 0; n < nodes.shared.num_neighbours(); ++n) {
    Packet& packet = out[nodes.shared.neighbour(n)];
    for (const std::int32_t i : nodes.shared.shared_with(n)) {
      if (partners.node[i] < 0 || !joins(kinds[nodes.grid_node[i]])) continue;
      packet.put(nodes.grid_node[i]);
      packet.put(partners.node[i]);
      packet.put(partners.distance[i]);
    }
  }
  for (auto& [rank, packet] : send_packets(comm, out)) {
    while (!packet.empty()) {
      const std::int32_t i = nodes.active[packet.template take<std::int32_t>()];
      const auto to = packet.template take<std::int32_t>();
      partners.offer(i, to, packet.template take<double>());
    }
  }
}

// Partners where nodes are doubled: they are sought among the nodes that act on one group of
// points, of any rank, which are on one side.
template <int dim>
std::vector<std::int32_t> nearest_heavy_of_groups(MPI_Comm comm, const LightNodeSearch<dim>& search,
                                                  const GridNodes<dim>& nodes, const Kinds& kinds) {
  Partners partners(nodes.size());
  for (const CellGroup& group : search.weights.groups) {
    for (const std::int32_t from : search.weights.nodes_of(group)) {
      if (!joins(kinds[from])) continue;
      const std::int32_t i = nodes.active[from];
      for (const std::int32_t to : search.weights.nodes_of(group)) {
        const std::int32_t j = nodes.active[to];
        if (kinds[to] != heavy || !search.walls.hold_alike(nodes.place(i), nodes.place(j))) continue;
        partners.offer(i, to, (nodes.x[j] - nodes.x[i]).norm());
      }
    }
  }
  ask_holders(comm, nodes, kinds, partners);
  return partners.node;
}

// The partners of the light nodes, see nearest_heavy.
template <int dim>
std::vector<std::int32_t> find_partners(MPI_Comm comm, const LightNodeSearch<dim>& search,
                                        const GridNodes<dim>& nodes, Kinds& kinds) {
  if (nodes.num_fields > 1) return nearest_heavy_of_groups(comm, search, nodes, kinds);
  const auto cells = cells_of_light_nodes(search.grid, kinds);
  ask_other_ranks<dim>(comm, search.grid, cells, kinds);
  return nearest_heavy<dim>(search, cells, nodes, kinds);
}

}  // namespace

template <int dim>
std::int32_t join_light_nodes(MPI_Comm comm, const LightNodeSearch<dim>& search,
                              GridNodes<dim>& nodes) {
  const auto reach = mass_within_reach(search.points, search.weights, nodes);
  const std::vector<char> is_weak =
      search.sights
          ? find_weak_nodes<dim>(*search.sights, search.points, search.weights, nodes, reach)
          : std::vector<char>(nodes.size(), 0);
  Kinds kinds(std::size_t{1} * nodes.num_fields * search.grid.num_nodes_total(), inactive);
  bool any = false;
  for (std::int32_t i = 0; i < nodes.size(); ++i) {
    const std::int32_t node = nodes.grid_node[i];
    const double share =
        nodes.is_doubled(i) ? std::max(search.share, search.doubled_share) : search.share;
    const bool is_light = nodes.m[i] < share * reach[i];
    const bool is_free = !search.walls.holds(nodes.place(i));
    const bool may_join = is_free || nodes.is_doubled(i);
    kinds.at(node) = is_light && may_join ? light : is_weak[i] == 1 && is_free ? weak : heavy;
    any |= joins(kinds[node]);
  }
  if (nodes.shared.all(!any)) return 0;

  const auto partner = find_partners(comm, search, nodes, kinds);
  const std::int64_t num_before = nodes.num_of_all();
  const std::vector<std::int32_t> before = nodes.grid_node;
  std::vector<std::int32_t> rest;
  for (std::size_t i = 0; i < before.size(); ++i) {
    rest.push_back(partner[i] < 0 ? before[i] : partner[i]);
  }
  std::sort(rest.begin(), rest.end());
  rest.erase(std::unique(rest.begin(), rest.end()), rest.end());
  number_nodes(comm, search.grid, std::move(rest), nodes);
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (partner[i] < 0) continue;
    nodes.active.at(before[i]) = std::int32_t{nodes.active[partner[i]]};
  }
  list_groups(search.weights, nodes);
  return static_cast<std::int32_t>(num_before - nodes.num_of_all());
}

template std::int32_t join_light_nodes<2>(MPI_Comm, const LightNodeSearch<2>&, GridNodes<2>&);
template std::int32_t join_light_nodes<3>(MPI_Comm, const LightNodeSearch<3>&, GridNodes<3>&);

}  // namespace gabion::mpm
