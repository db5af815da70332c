// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/walls/wall_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace gabion::mpm {

namespace {

// A plane whose normals differ by round-off has that of its first facet.
constexpr double same_normal = 1e-6;

enum class Meeting {
  apart,     // no edge in common
  along,     // an edge in common, normals on the same side
  opposite,  // an edge in common, normals on different sides
  same,      // the same facet
};

template <int dim>
class WallFacets {
 public:
  WallFacets(const BackgroundGrid<dim>& grid, std::span<const std::int32_t> nodes)
      : nodes_(nodes),
        width_(num_nodes(facet_type(grid.cell_type))),
        geometry_(facet_geometry(grid, nodes)) {}

  /// Facets of each node, ascending: pairs of node and facet.
  std::vector<std::pair<std::int32_t, std::int32_t>> by_node() const {
    std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
    pairs.reserve(nodes_.size());
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      pairs.emplace_back(nodes_[k], static_cast<std::int32_t>(k / width_));
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  }

  const Vector<dim>& normal(std::int32_t facet) const { return geometry_[facet].normal; }
  double area(std::int32_t facet) const { return geometry_[facet].area; }

  /// Relation of two facets that meet at a node.
  Meeting meet(std::int32_t a, std::int32_t b, std::int32_t node) const {
    const auto of_a = facet(a), of_b = facet(b);
    const auto is_of_a = [&](std::int32_t i) { return std::ranges::find(of_a, i) != of_a.end(); };
    if (std::ranges::all_of(of_b, is_of_a)) return Meeting::same;
    if constexpr (dim == 2) {
      return (of_a[0] == node) != (of_b[0] == node) ? Meeting::along : Meeting::opposite;
    } else {
      // Neighbours whose normals are on the same side go through their edge in opposite directions.
      if (next(of_a, node) == previous(of_b, node) || previous(of_a, node) == next(of_b, node)) {
        return Meeting::along;
      }
      const bool shared =
          next(of_a, node) == next(of_b, node) || previous(of_a, node) == previous(of_b, node);
      return shared ? Meeting::opposite : Meeting::apart;
    }
  }

 private:
  std::span<const std::int32_t> facet(std::int32_t f) const {
    return nodes_.subspan(static_cast<std::size_t>(f) * width_, width_);
  }
  static std::int32_t next(std::span<const std::int32_t> facet, std::int32_t node) {
    const auto at = std::ranges::find(facet, node) - facet.begin();
    return facet[static_cast<std::size_t>(at + 1) % facet.size()];
  }
  static std::int32_t previous(std::span<const std::int32_t> facet, std::int32_t node) {
    const auto at = std::ranges::find(facet, node) - facet.begin();
    return facet[(static_cast<std::size_t>(at) + facet.size() - 1) % facet.size()];
  }

  std::span<const std::int32_t> nodes_;
  std::size_t width_;
  std::vector<FacetGeometry<dim>> geometry_;
};

// The facets around one node.
template <int dim>
class NodePieces {
 public:
  using Pairs = std::span<const std::pair<std::int32_t, std::int32_t>>;

  NodePieces(const WallFacets<dim>& facets, Pairs around)
      : facets_(facets), around_(around), side_(around.size(), 0) {}

  void append_to(std::vector<WallPiece<dim>>& pieces) {
    for (std::size_t first = 0; first < around_.size(); ++first) {
      if (side_[first] == 0) pieces.push_back(grow(first));
    }
  }

 private:
  // The piece of a facet that is in none yet.
  WallPiece<dim> grow(std::size_t first) {
    WallPiece<dim> piece{.grid_node = around_[first].first};
    const Vector<dim> n = facets_.normal(around_[first].second);
    bool plane = true;
    std::vector<std::size_t> front = {first};
    side_[first] = 1;
    while (!front.empty()) {
      const std::size_t k = front.back();
      front.pop_back();
      if (counts(k)) {
        const std::int32_t facet = around_[k].second;
        const Vector<dim> n_k = side_[k] * facets_.normal(facet);
        piece.area += facets_.area(facet) * n_k;
        plane = plane && (n_k - n).norm() < same_normal;
      }
      spread(k, front);
    }
    piece.n = plane ? n : piece.area.normalized();
    return piece;
  }

  // A facet that the group has twice is one.
  bool counts(std::size_t k) const {
    for (std::size_t j = 0; j < k; ++j) {
      if (meet(j, k) == Meeting::same) return false;
    }
    return true;
  }

  // Take the facets that meet facet k smoothly into its piece.
  void spread(std::size_t k, std::vector<std::size_t>& front) {
    static const double least = std::cos(corner_angle * std::numbers::pi / 180);
    for (std::size_t j = 0; j < around_.size(); ++j) {
      if (side_[j] != 0) continue;
      const Meeting meeting = meet(k, j);
      if (meeting == Meeting::apart) continue;
      const double cosine =
          facets_.normal(around_[k].second).dot(facets_.normal(around_[j].second));
      const int side = meeting == Meeting::same    ? (cosine > 0 ? 1 : -1)
                       : meeting == Meeting::along ? 1
                                                   : -1;
      if (side * cosine <= least) continue;
      side_[j] = side * side_[k];
      front.push_back(j);
    }
  }

  Meeting meet(std::size_t a, std::size_t b) const {
    return facets_.meet(around_[a].second, around_[b].second, around_[a].first);
  }

  const WallFacets<dim>& facets_;
  Pairs around_;
  std::vector<int> side_;  // 1: as the first facet of its piece, -1: turned, 0: in none yet
};

}  // namespace

template <int dim>
std::vector<WallPiece<dim>> smooth_pieces(const BackgroundGrid<dim>& grid,
                                          std::span<const std::int32_t> facets) {
  const WallFacets<dim> of_wall(grid, facets);
  const auto pairs = of_wall.by_node();
  std::vector<WallPiece<dim>> pieces;
  for (std::size_t first = 0; first < pairs.size();) {
    std::size_t last = first;
    while (last < pairs.size() && pairs[last].first == pairs[first].first) ++last;
    NodePieces<dim>(of_wall, std::span(pairs).subspan(first, last - first)).append_to(pieces);
    first = last;
  }
  return pieces;
}

template std::vector<WallPiece<2>> smooth_pieces<2>(const BackgroundGrid<2>&,
                                                    std::span<const std::int32_t>);
template std::vector<WallPiece<3>> smooth_pieces<3>(const BackgroundGrid<3>&,
                                                    std::span<const std::int32_t>);

}  // namespace gabion::mpm
