// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/step/kept_factor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "common/base/log.hpp"
#include "common/mechanics/ranks/packet.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion::fem {

namespace {

// A factor of n unknowns with a front of w nodes takes some 1e-10 n w^2 s and 9 n w bytes, a
// solution by conjugate gradients 1e-5 to 6e-5 n s. In dynamics a factor serves over many steps: at
// this width it costs as much as some 30 solutions; in statics it serves over few iterations.
constexpr std::int64_t widest_front_dynamic = 2200;
constexpr std::int64_t widest_front_static = 1000;
constexpr double factor_bytes = 9;                  // of unknowns x front
constexpr double largest_factor = 4.0 * (1 << 30);  // [bytes]

/// Cells, lines and sheets of each node, as compressed rows.
template <int dim>
struct CellsOfNodes {
  explicit CellsOfNodes(const Mesh<dim>& mesh) : starts(mesh.nodes.size() + 1, 0) {
    for (const std::int32_t i : mesh.cells) ++starts[i + 1];
    for (const std::int32_t i : mesh.lines) ++starts[i + 1];
    for (const std::int32_t i : mesh.sheets) ++starts[i + 1];
    for (std::size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
    cells.resize(mesh.cells.size() + mesh.lines.size() + mesh.sheets.size());
    std::vector<std::int64_t> next(starts.begin(), starts.end() - 1);
    for (std::int32_t e = 0; e < mesh.num_elements(); ++e)
      for (const std::int32_t i : mesh.element(e)) cells[next[i]++] = e;
  }
  std::vector<std::int64_t> starts;
  std::vector<std::int32_t> cells;
};

/// Findings of a walk from a node to all nodes connected with it.
struct Walk {
  std::int64_t num_nodes = 0;
  std::int64_t widest = 0;  ///< front
  std::int64_t num_fronts = 0;
  std::int32_t end = 0;  ///< the highest node of the last front
};

constexpr double slender_share = 0.2;

/// Walks through the parts of a mesh, front by front, on all ranks together. All holders of a
/// shared node reach it at once.
template <int dim>
class Walker {
 public:
  Walker(const Mesh<dim>& mesh, const MeshRanks& ranks)
      : mesh_(mesh), ranks_(ranks), of_nodes_(mesh), reached_(mesh.nodes.size(), 0) {}

  /// One walk through each connected part of the mesh, from one of its ends.
  std::vector<Walk> walks() {
    std::vector<Walk> all;
    for (std::int32_t start = lowest_unreached(); start >= 0; start = lowest_unreached()) {
      // The nodes that are reached last lie at an end.
      const std::int32_t end = walk_from(start, 1).end;
      all.push_back(walk_from(end, 2));
    }
    return all;
  }

 private:
  std::int32_t lowest_unreached() {
    while (next_ < mesh_.num_nodes_total() && reached_[next_] != 0) ++next_;
    constexpr double none = std::numeric_limits<double>::infinity();
    const double own = next_ < mesh_.num_nodes_total() ? ranks_.node_of_all(next_) : none;
    const double lowest = -ranks_.shared().largest(-own);
    return lowest == none ? -1 : static_cast<std::int32_t>(lowest);
  }

  /// @param mark  for what it reaches
  Walk walk_from(std::int32_t start, char mark) {
    Walk walk;
    std::vector<std::int32_t> front, last;
    reach(ranks_.held_node(start), mark, front);
    for (std::int64_t size = size_of(front); size > 0; size = size_of(front)) {
      walk.num_nodes += size;
      walk.widest = std::max(walk.widest, size);
      ++walk.num_fronts;
      last = std::exchange(front, {});
      for (const std::int32_t i : last) {
        for (std::int64_t k = of_nodes_.starts[i]; k < of_nodes_.starts[i + 1]; ++k)
          for (const std::int32_t j : mesh_.element(of_nodes_.cells[k])) reach(j, mark, front);
      }
      if (!ranks_.alone()) reach_with_others(mark, front);
    }
    double highest = -1;
    for (const std::int32_t i : last) {
      highest = std::max(highest, static_cast<double>(ranks_.node_of_all(i)));
    }
    walk.end = static_cast<std::int32_t>(ranks_.shared().largest(highest));
    return walk;
  }

  void reach(std::int32_t i, char mark, std::vector<std::int32_t>& front) {
    if (i < 0 || reached_[i] == mark) return;
    reached_[i] = mark;
    front.push_back(i);
  }

  /// Nodes of a front, of all ranks.
  std::int64_t size_of(const std::vector<std::int32_t>& front) const {
    const SharedNodes& shared = ranks_.shared();
    const auto own = std::ranges::count_if(front, [&](std::int32_t i) { return shared.owns(i); });
    return static_cast<std::int64_t>(shared.total(static_cast<double>(own)));
  }

  /// Tell the other holders which nodes this rank reached, by their places in the lists of shared
  /// nodes.
  void reach_with_others(char mark, std::vector<std::int32_t>& front) {
    const SharedNodes& shared = ranks_.shared();
    Packets out;
    std::map<int, std::span<const std::int32_t>> shared_with;
    for (int n = 0; n < shared.num_neighbours(); ++n) {
      const auto nodes = shared.shared_with(n);
      shared_with[shared.neighbour(n)] = nodes;
      for (const std::int32_t i : front) {
        const auto found = std::ranges::lower_bound(nodes, i);
        if (found == nodes.end() || *found != i) continue;
        out[shared.neighbour(n)].put(static_cast<std::int32_t>(found - nodes.begin()));
      }
    }
    for (auto& [rank, packet] : send_packets(ranks_.comm(), out)) {
      while (!packet.empty()) {
        reach(shared_with.at(rank)[packet.template take<std::int32_t>()], mark, front);
      }
    }
  }

  const Mesh<dim>& mesh_;
  const MeshRanks& ranks_;
  CellsOfNodes<dim> of_nodes_;
  std::vector<char> reached_;
  std::int32_t next_ = 0;
};

}  // namespace

template <int dim>
std::int64_t front_width(const Mesh<dim>& mesh, const MeshRanks& ranks) {
  std::int64_t widest = 0;
  for (const Walk& walk : Walker<dim>(mesh, ranks).walks()) widest = std::max(widest, walk.widest);
  return widest;
}

template <int dim>
bool is_slender(const Mesh<dim>& mesh, const MeshRanks& ranks) {
  return std::ranges::any_of(Walker<dim>(mesh, ranks).walks(), [](const Walk& walk) {
    const auto fronts = static_cast<double>(walk.num_fronts);
    return static_cast<double>(walk.num_nodes) < slender_share * std::pow(fronts, dim);
  });
}

template <int dim>
LinearSolverSettings with_kept_factor(LinearSolverSettings settings, const Mesh<dim>& mesh,
                                      const MeshRanks& ranks, bool dynamic) {
  if (settings.method != "auto" || settings.preconditioner != "auto") return settings;
  const std::int64_t num_dofs = std::int64_t{ranks.num_nodes_of_all(mesh)} * dim;
  const std::int64_t width = dim == 3 ? front_width(mesh, ranks) : 0;
  const double bytes = factor_bytes * static_cast<double>(num_dofs) * static_cast<double>(width);
  const std::int64_t widest = dynamic ? widest_front_dynamic : widest_front_static;
  const bool direct = width <= widest && bytes <= largest_factor;
  if (dim == 3) {
    log::info("linear solver: {} unknowns, widest front {} nodes, a factor of some {:.2g} GiB: {}",
              num_dofs, width, bytes / (1 << 30), direct ? "direct" : "iterations");
  }
  if (!direct) return settings;
  const bool small =
      choose_direct_method(dim, num_dofs, num_ranks(ranks.comm())) == SolutionMethod::lu;
  settings.method = small ? "lu" : "mumps";
  return settings;
}

template std::int64_t front_width<2>(const Mesh<2>&, const MeshRanks&);
template std::int64_t front_width<3>(const Mesh<3>&, const MeshRanks&);
template bool is_slender<2>(const Mesh<2>&, const MeshRanks&);
template bool is_slender<3>(const Mesh<3>&, const MeshRanks&);
template LinearSolverSettings with_kept_factor<2>(LinearSolverSettings, const Mesh<2>&,
                                                  const MeshRanks&, bool);
template LinearSolverSettings with_kept_factor<3>(LinearSolverSettings, const Mesh<3>&,
                                                  const MeshRanks&, bool);

}  // namespace gabion::fem
