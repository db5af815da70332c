// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <tuple>

#include "mpm_solver/contact/surface_features.hpp"

namespace gabion::mpm {

namespace {

// Two diagonals whose inward components differ by less than this share point inwards equally.
constexpr double same_way = 1e-9;

// The first corner of a quadrilateral's diagonal that points more to the middle of the surface, 0
// or 1: so that a symmetric surface stays symmetric when cut.
int cut_from(const ContactSurface<3>& surface, const Vector<3>& middle, const std::int32_t* v) {
  const auto& x = surface.vertices;
  const Vector<3> a = x[v[2]] - x[v[0]], b = x[v[3]] - x[v[1]];
  const Vector<3> inwards = middle - 0.25 * (x[v[0]] + x[v[1]] + x[v[2]] + x[v[3]]);
  const double along_a = std::abs(a.dot(inwards)) / a.norm();
  const double along_b = std::abs(b.dot(inwards)) / b.norm();
  return along_b > (1 + same_way) * along_a ? 1 : 0;
}

template <int dim>
Vector<dim> middle_of(const ContactSurface<dim>& surface) {
  Vector<dim> sum = Vector<dim>::Zero();
  for (const Vector<dim>& x : surface.vertices) sum += x;
  return sum / static_cast<double>(surface.vertices.size());
}

}  // namespace

template <int dim>
std::vector<Simplex<dim>> simplices(const ContactSurface<dim>& surface) {
  std::vector<Simplex<dim>> result;
  const std::size_t n = num_nodes(surface.facet_type);
  const Vector<dim> middle = middle_of(surface);
  for (std::size_t f = 0; f < surface.facets.size(); f += n) {
    const std::int32_t* v = surface.facets.data() + f;
    if constexpr (dim == 2) {
      result.push_back({v[0], v[1]});
    } else {
      const int first = n == 4 ? cut_from(surface, middle, v) : 0;
      result.push_back({v[first], v[first + 1], v[first + 2]});
      if (n == 4) result.push_back({v[first], v[first + 2], v[(first + 3) % 4]});
    }
  }
  return result;
}

template <int dim>
std::vector<char> rim_vertices(std::span<const Simplex<dim>> simplices, std::size_t num_vertices) {
  using Edge = std::array<std::int32_t, dim - 1>;
  std::vector<Edge> edges;
  for (const Simplex<dim>& simplex : simplices) {
    for (int k = 0; k < dim; ++k) {
      Edge& edge = edges.emplace_back();
      for (int l = 0; l < dim - 1; ++l) edge[l] = simplex[(k + l) % dim];
      std::sort(edge.begin(), edge.end());
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<char> rim(num_vertices, 0);
  for (std::size_t k = 0; k < edges.size(); ++k) {
    if (k > 0 && edges[k - 1] == edges[k]) continue;
    if (k + 1 < edges.size() && edges[k + 1] == edges[k]) continue;
    for (const std::int32_t v : edges[k]) rim[v] = 1;
  }
  return rim;
}

template <int dim>
std::vector<Neighbours<dim>> neighbours_of(std::span<const Simplex<dim>> simplices) {
  struct Side {
    std::array<std::int32_t, dim - 1> vertices;
    std::int32_t simplex = 0, corner = 0;
  };
  std::vector<Side> sides;
  for (std::size_t s = 0; s < simplices.size(); ++s) {
    for (int k = 0; k < dim; ++k) {
      Side& side = sides.emplace_back();
      for (int l = 1; l < dim; ++l) side.vertices[l - 1] = simplices[s][(k + l) % dim];
      std::sort(side.vertices.begin(), side.vertices.end());
      side.simplex = static_cast<std::int32_t>(s);
      side.corner = k;
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.vertices, a.simplex, a.corner) < std::tie(b.vertices, b.simplex, b.corner);
  });
  std::vector<Neighbours<dim>> result(simplices.size());
  for (auto first = sides.begin(); first != sides.end();) {
    const auto last = std::find_if(
        first, sides.end(), [&](const Side& side) { return side.vertices != first->vertices; });
    const auto count = last - first;
    for (auto side = first; side != last; ++side) {
      std::int32_t next = count == 1 ? no_neighbour : several_neighbours;
      if (count == 2) next = (side == first ? first + 1 : first)->simplex;
      result[static_cast<std::size_t>(side->simplex)][static_cast<std::size_t>(side->corner)] =
          next;
    }
    first = last;
  }
  return result;
}

template std::vector<Neighbours<2>> neighbours_of<2>(std::span<const Simplex<2>>);
template std::vector<Neighbours<3>> neighbours_of<3>(std::span<const Simplex<3>>);
template std::vector<char> rim_vertices<2>(std::span<const Simplex<2>>, std::size_t);
template std::vector<char> rim_vertices<3>(std::span<const Simplex<3>>, std::size_t);
template std::vector<Simplex<2>> simplices<2>(const ContactSurface<2>&);
template std::vector<Simplex<3>> simplices<3>(const ContactSurface<3>&);

}  // namespace gabion::mpm
