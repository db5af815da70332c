// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/step/kept_factor.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/log.hpp"

namespace gabion::fem {

namespace {

// A factor of n unknowns with a front of w nodes takes some 1e-10 n w^2 s and 9 n w bytes, a
// solution by conjugate gradients 1e-5 to 6e-5 n s. In dynamics a factor serves over many steps: at
// this width it is worth some 30 solutions; in statics over few iterations.
constexpr std::int64_t widest_front_dynamic = 2200;
constexpr std::int64_t widest_front_static = 1000;
constexpr double factor_bytes = 9;                  // of unknowns x front
constexpr double largest_factor = 4.0 * (1 << 30);  // [bytes]

/// Cells of each node, as compressed rows.
template <int dim>
struct CellsOfNodes {
  explicit CellsOfNodes(const Mesh<dim>& mesh) : starts(mesh.nodes.size() + 1, 0) {
    for (const std::int32_t i : mesh.cells) ++starts[i + 1];
    for (std::size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
    cells.resize(mesh.cells.size());
    std::vector<std::int64_t> next(starts.begin(), starts.end() - 1);
    for (std::size_t k = 0; k < mesh.cells.size(); ++k)
      cells[next[mesh.cells[k]]++] = static_cast<std::int32_t>(k / mesh.nodes_per_cell());
  }
  std::vector<std::int64_t> starts;
  std::vector<std::int32_t> cells;
};

/// What a walk from a node to all that hang together with it finds.
struct Walk {
  std::vector<std::int32_t> nodes;  ///< in the order in which they were reached
  std::int64_t widest = 0;
  std::int64_t fronts = 0;
};

constexpr double slender_share = 0.2;

/// @param reached  of all nodes; those of the walk are marked with `mark`
template <int dim>
Walk walk_from(std::int32_t start, const Mesh<dim>& mesh, const CellsOfNodes<dim>& of_nodes,
               std::vector<char>& reached, char mark) {
  Walk walk{.nodes = {start}};
  reached[start] = mark;
  for (std::size_t begin = 0; begin < walk.nodes.size();) {
    const std::size_t end = walk.nodes.size();
    walk.widest = std::max(walk.widest, static_cast<std::int64_t>(end - begin));
    ++walk.fronts;
    for (; begin < end; ++begin) {
      const std::int32_t i = walk.nodes[begin];
      for (std::int64_t k = of_nodes.starts[i]; k < of_nodes.starts[i + 1]; ++k)
        for (const std::int32_t j : mesh.cell(of_nodes.cells[k])) {
          if (reached[j] == mark) continue;
          reached[j] = mark;
          walk.nodes.push_back(j);
        }
    }
  }
  return walk;
}

template <int dim>
std::vector<Walk> walk_through(const Mesh<dim>& mesh) {
  const CellsOfNodes<dim> of_nodes(mesh);
  std::vector<char> reached(mesh.nodes.size(), 0);
  std::vector<Walk> walks;
  for (std::int32_t i = 0; i < mesh.num_nodes_total(); ++i) {
    if (reached[i] != 0) continue;
    // The node that is reached last lies at an end.
    const std::int32_t end = walk_from(i, mesh, of_nodes, reached, 1).nodes.back();
    walks.push_back(walk_from(end, mesh, of_nodes, reached, 2));
  }
  return walks;
}

}  // namespace

template <int dim>
std::int64_t front_width(const Mesh<dim>& mesh) {
  std::int64_t widest = 0;
  for (const Walk& walk : walk_through(mesh)) widest = std::max(widest, walk.widest);
  return widest;
}

template <int dim>
bool is_slender(const Mesh<dim>& mesh) {
  const std::vector<Walk> walks = walk_through(mesh);
  return std::any_of(walks.begin(), walks.end(), [](const Walk& walk) {
    const auto fronts = static_cast<double>(walk.fronts);
    return static_cast<double>(walk.nodes.size()) < slender_share * std::pow(fronts, dim);
  });
}

template <int dim>
LinearSolverSettings with_kept_factor(LinearSolverSettings settings, const Mesh<dim>& mesh,
                                      bool dynamic, int num_ranks) {
  if (settings.method != "auto" || settings.preconditioner != "auto") return settings;
  const auto num_dofs = static_cast<std::int64_t>(mesh.nodes.size()) * dim;
  const std::int64_t width = dim == 3 ? front_width(mesh) : 0;
  const double bytes = factor_bytes * static_cast<double>(num_dofs) * static_cast<double>(width);
  const std::int64_t widest = dynamic ? widest_front_dynamic : widest_front_static;
  const bool direct = width <= widest && bytes <= largest_factor;
  if (dim == 3) {
    log::info("linear solver: {} unknowns, widest front {} nodes, a factor of some {:.2g} GiB: {}",
              num_dofs, width, bytes / (1 << 30), direct ? "direct" : "iterations");
  }
  if (!direct) return settings;
  const bool small = choose_direct_method(dim, num_dofs, num_ranks) == SolutionMethod::lu;
  settings.method = small ? "lu" : "mumps";
  return settings;
}

template std::int64_t front_width<2>(const Mesh<2>&);
template std::int64_t front_width<3>(const Mesh<3>&);
template bool is_slender<2>(const Mesh<2>&);
template bool is_slender<3>(const Mesh<3>&);
template LinearSolverSettings with_kept_factor<2>(LinearSolverSettings, const Mesh<2>&, bool, int);
template LinearSolverSettings with_kept_factor<3>(LinearSolverSettings, const Mesh<3>&, bool, int);

}  // namespace gabion::fem
