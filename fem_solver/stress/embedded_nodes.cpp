// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/embedded_nodes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>

#include "common/base/require.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
#include "common/mechanics/mesh/mesh_part.hpp"
#include "fem_solver/stress/cells_of_materials.hpp"

namespace gabion::fem {

namespace {

constexpr double outside = 1e-6;  // of a cell, in its reference coordinates: rounding of files
constexpr double least_weight = 1e-12;  // below: a node on a side of the cell, not inside

/// A place in a cell, and by how much it lies outside in reference coordinates.
template <int dim>
struct Place {
  std::vector<double> N;
  double excess = 0;
};

template <int dim>
double excess_of(CellType type, const Vector<dim>& xi) {
  if (is_simplex(type)) return std::max(-xi.minCoeff(), xi.sum() - 1);
  return xi.cwiseAbs().maxCoeff() - 1;
}

/// Newton's method for x(xi) = x from the centre of the cell; none: it leaves the cell.
template <int dim>
std::optional<Place<dim>> place_in(const Mesh<dim>& mesh, std::int32_t c, const Vector<dim>& x) {
  const auto nodes = mesh.cell(c);
  AnyShapeValues<dim> shape;
  const double centre = is_simplex(mesh.cell_type) ? 1.0 / (dim + 1) : 0.0;
  Vector<dim> xi = Vector<dim>::Constant(centre);
  constexpr int most_iterations = 30;
  for (int n = 0; n < most_iterations; ++n) {
    shape_functions<dim>(mesh.cell_type, xi, shape);
    Vector<dim> missing = x;
    Matrix<dim> J = Matrix<dim>::Zero();
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      missing -= shape.N[a] * mesh.nodes[nodes[a]];
      J += mesh.nodes[nodes[a]] * shape.dN[a].transpose();
    }
    const Vector<dim> step = J.inverse() * missing;
    xi += step;
    if (!(xi.cwiseAbs().maxCoeff() < 10)) return std::nullopt;
    if (step.cwiseAbs().maxCoeff() > 1e-14 && n + 1 < most_iterations) continue;
    if (step.cwiseAbs().maxCoeff() > 1e-9) return std::nullopt;
    break;
  }
  shape_functions<dim>(mesh.cell_type, xi, shape);
  return Place<dim>{.N = {shape.N, shape.N + nodes.size()},
                    .excess = excess_of<dim>(mesh.cell_type, xi)};
}

/// Boxes around cells, in slices along the longest axis of the mesh.
template <int dim>
class CellBoxes {
 public:
  explicit CellBoxes(const Mesh<dim>& mesh) : mesh_(mesh) {
    for (const Vector<dim>& x : mesh.nodes) whole_.extend(x);
    whole_.sizes().maxCoeff(&axis_);
    const auto wanted = static_cast<std::int32_t>(std::cbrt(mesh.num_cells()));
    slices_.resize(static_cast<std::size_t>(std::max(wanted, std::int32_t{1})));
    for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
      Box box;
      for (const std::int32_t i : mesh.cell(c)) box.extend(mesh.nodes[i]);
      const Vector<dim> margin = Vector<dim>::Constant(0.25 * box.sizes().maxCoeff());
      boxes_.emplace_back(box.min() - margin, box.max() + margin);  // curved sides bulge
      const std::size_t last = slice_of(boxes_.back().max());
      for (std::size_t s = slice_of(boxes_.back().min()); s <= last; ++s) slices_[s].push_back(c);
    }
  }

  /// The cell that has this place, or exceeds it least, within the tolerance; -1: none.
  std::int32_t host_of(const Vector<dim>& x, Place<dim>& place) const {
    std::int32_t host = -1;
    for (const std::int32_t c : slices_[slice_of(x)]) {
      if (!boxes_[c].contains(x)) continue;
      const auto found = place_in<dim>(mesh_, c, x);
      if (!found || found->excess > outside) continue;
      if (host >= 0 && found->excess >= place.excess) continue;
      host = c;
      place = *found;
      if (place.excess <= 0) break;
    }
    return host;
  }

 private:
  using Box = Eigen::AlignedBox<double, dim>;
  std::size_t slice_of(const Vector<dim>& x) const {
    const double share = (x[axis_] - whole_.min()[axis_]) / whole_.sizes()[axis_];
    const double last = static_cast<double>(slices_.size()) - 1;
    return static_cast<std::size_t>(
        std::clamp(share * static_cast<double>(slices_.size()), 0.0, last));
  }

  const Mesh<dim>& mesh_;
  Box whole_;
  int axis_ = 0;
  std::vector<Box> boxes_;
  std::vector<std::vector<std::int32_t>> slices_;
};

/// Leave out weights below rounding, and scale the others to the sum 1.
template <int dim>
std::vector<typename EmbeddedNodes<dim>::Share> shares_in(std::span<const std::int32_t> nodes,
                                                          const Place<dim>& place) {
  std::vector<typename EmbeddedNodes<dim>::Share> shares;
  double sum = 0;
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    if (std::abs(place.N[a]) < least_weight) continue;
    shares.push_back({nodes[a], place.N[a]});
    sum += place.N[a];
  }
  for (auto& share : shares) share.weight /= sum;
  return shares;
}

/// The material whose lines have a node: 0 none, 1 + its number else.
template <int dim>
std::vector<std::size_t> materials_of_nodes(const Mesh<dim>& mesh,
                                            std::span<const LineMaterial> materials,
                                            bool embedded) {
  std::vector<std::size_t> of_node(mesh.nodes.size(), 0);
  for (std::size_t m = 0; m < materials.size(); ++m) {
    if (materials[m].embedded != embedded) continue;
    for (const std::int32_t l : lines_of(mesh, materials[m])) {
      for (const std::int32_t i : mesh.line(l)) of_node[i] = m + 1;
    }
  }
  return of_node;
}

}  // namespace

template <int dim>
bool EmbeddedNodes<dim>::contains(std::int32_t node) const {
  return std::ranges::binary_search(nodes, node);
}

template <int dim>
std::vector<typename EmbeddedNodes<dim>::Share> EmbeddedNodes<dim>::shares_of(
    std::int32_t node) const {
  const auto found = std::ranges::lower_bound(nodes, node);
  if (found == nodes.end() || *found != node) return {{.node = node, .weight = 1}};
  return shares[static_cast<std::size_t>(found - nodes.begin())];
}

template <int dim>
double EmbeddedNodes<dim>::weight(std::int32_t node, std::int32_t i) const {
  for (const Share& share : shares_of(node)) {
    if (share.node == i) return share.weight;
  }
  return 0;
}

template <int dim>
void EmbeddedNodes<dim>::follow(std::span<double> y) const {
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    Vector<dim> sum = Vector<dim>::Zero();
    for (const Share& share : shares[k]) {
      const double* of_host = y.data() + static_cast<std::size_t>(share.node) * dim;
      sum += share.weight * Eigen::Map<const Vector<dim>>(of_host);
    }
    Eigen::Map<Vector<dim>>(y.data() + static_cast<std::size_t>(nodes[k]) * dim) = sum;
  }
}

template <int dim>
std::vector<std::int32_t> EmbeddedNodes<dim>::line_nodes(const Mesh<dim>& mesh,
                                                         std::int32_t line) const {
  std::vector<std::int32_t> all;
  for (const std::int32_t end : mesh.line(line)) {
    for (const Share& share : shares_of(end)) {
      if (std::ranges::find(all, share.node) == all.end()) all.push_back(share.node);
    }
  }
  return all;
}

template <int dim>
EmbeddedNodes<dim> find_embedded_nodes(const Mesh<dim>& mesh,
                                       std::span<const LineMaterial> materials,
                                       const MeshRanks& ranks) {
  EmbeddedNodes<dim> embedded;
  const auto first = std::ranges::find_if(materials, &LineMaterial::embedded);
  if (first == materials.end()) return embedded;
  require<ConfigError>(ranks.alone(),
                       "{}: found \"embedded\" with a mesh that is divided among ranks, allowed: "
                       "one rank, or bars on nodes of cells; a host may be on another rank",
                       first->where);
  const auto of_bars = materials_of_nodes(mesh, materials, true);
  const auto of_others = materials_of_nodes(mesh, materials, false);
  std::vector<char> in_cell(mesh.nodes.size(), 0);
  for (const std::int32_t i : mesh.cells) in_cell[i] = 1;
  for (const std::int32_t i : mesh.sheets) in_cell[i] = 1;
  const CellBoxes<dim> boxes(mesh);
  for (std::int32_t i = 0; i < mesh.num_nodes_total(); ++i) {
    if (of_bars[i] == 0 || in_cell[i] != 0) continue;
    const LineMaterial& material = materials[of_bars[i] - 1];
    const Vector<dim>& x = mesh.nodes[i];
    const std::string what =
        fmt::format("{}: found node {} of embedded lines at ({:.6g})", material.where, i,
                    fmt::join(x.data(), x.data() + dim, ", "));
    if (of_others[i] > 0) {
      throw ConfigError(
          fmt::format("{}, which lines of \"{}\" have too, allowed: \"embedded\" for "
                      "both groups",
                      what, materials[of_others[i] - 1].group));
    }
    Place<dim> place;
    const std::int32_t host = boxes.host_of(x, place);
    if (host < 0) {
      throw ConfigError(what +
                        ", outside all cells, allowed: nodes inside cells or on their "
                        "sides");
    }
    embedded.nodes.push_back(i);
    embedded.shares.push_back(shares_in<dim>(mesh.cell(host), place));
  }
  return embedded;
}

template <int dim>
Mesh<dim> without_embedded_lines(const Mesh<dim>& mesh, std::span<const LineMaterial> materials) {
  std::vector<int> part(static_cast<std::size_t>(mesh.num_elements()), 0);
  for (const LineMaterial& material : materials) {
    if (!material.embedded) continue;
    for (const std::int32_t l : lines_of(mesh, material)) {
      part[static_cast<std::size_t>(mesh.num_cells() + l)] = 1;
    }
  }
  return MeshParts<dim>(mesh, std::move(part)).take(0).mesh;
}

template struct EmbeddedNodes<2>;
template struct EmbeddedNodes<3>;
template EmbeddedNodes<2> find_embedded_nodes(const Mesh<2>&, std::span<const LineMaterial>,
                                              const MeshRanks&);
template EmbeddedNodes<3> find_embedded_nodes(const Mesh<3>&, std::span<const LineMaterial>,
                                              const MeshRanks&);
template Mesh<2> without_embedded_lines(const Mesh<2>&, std::span<const LineMaterial>);
template Mesh<3> without_embedded_lines(const Mesh<3>&, std::span<const LineMaterial>);

}  // namespace gabion::fem
