// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/thin_pairs.hpp"

#include <algorithm>

#include "mpm_solver/contact/facet_hash.hpp"

namespace gabion::mpm {

namespace {

// Functions of a cell reach over the next one: soil on both sides of a wall that is thinner than
// two cells shares nodes.
constexpr double thin_cells = 2;

// Opposite faces of a wall face away from each other to within 25 degrees, along the line through
// it.
constexpr double opposite_cosine = 0.9;

// Where the other face ends in an inner corner of the wall, the line to it may lean by 70 degrees,
// and be half as long again as the wall is thick.
constexpr double inner_corner_cosine = 0.34, inner_corner_reach = 1.5;
// Faces that bend by less than 45 degrees, as those of rough ground, are no corner.
constexpr double least_bend_cosine = 0.7;
constexpr double same_place = 1e-6;  // share of two cells

/// A box around the normals of some faces.
template <int dim>
struct NormalBox {
  Vector<dim> low = Vector<dim>::Constant(1), high = Vector<dim>::Constant(-1);

  void add(const Vector<dim>& normal) {
    const bool known = normal.allFinite();
    low = low.cwiseMin(known ? normal : Vector<dim>::Constant(-1));
    high = high.cwiseMax(known ? normal : Vector<dim>::Constant(1));
  }
  // Whether a normal in the box may look away from this one.
  bool may_oppose(const Vector<dim>& normal) const {
    const double least = low.cwiseProduct(normal).cwiseMin(high.cwiseProduct(normal)).sum();
    return !(least > 1e-9 - opposite_cosine);
  }
};

// The faces that may have an opposite face; on a slope there are none.
template <int dim>
std::vector<std::int32_t> possible_fronts(const Faces<dim>& faces) {
  std::vector<NormalBox<dim>> boxes(faces.num_simplices.size());
  for (std::int32_t s = 0; s < std::ssize(faces.simplices); ++s) {
    boxes[faces.surface[s]].add(faces.bounds[s].normal);
  }
  std::vector<std::int32_t> fronts;
  for (std::int32_t s = 0; s < std::ssize(faces.simplices); ++s) {
    const Vector<dim>& normal = faces.bounds[s].normal;
    if (std::ranges::any_of(boxes, [&](const auto& box) { return box.may_oppose(normal); })) {
      fronts.push_back(s);
    }
  }
  return fronts;
}

// Whether a face ends at a place in a corner with another one, which is before it.
template <int dim>
bool ends_in_corner(const Faces<dim>& faces, std::int32_t face, const Vector<dim>& place,
                    std::span<const std::int32_t> others, double tiny) {
  const Vector<dim>& normal = faces.bounds[face].normal;
  return std::ranges::any_of(others, [&](std::int32_t u) {
    const SimplexBounds<dim>& other = faces.bounds[u];
    if (other.normal.dot(normal) > least_bend_cosine) return false;
    if ((other.centre - place).dot(normal) <= tiny || other.is_beyond(place, tiny)) return false;
    return (faces.closest(u, place) - place).norm() <= tiny;
  });
}

}  // namespace

template <int dim>
Faces<dim>::Faces(const std::vector<StartSurface<dim>>& surfaces) {
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    first_simplex.push_back(static_cast<std::int32_t>(simplices.size()));
    first_vertex.push_back(static_cast<std::int32_t>(vertices.size()));
    num_simplices.push_back(0);
    if (surfaces[k].settings.mode == ContactMode::fixed) continue;
    for (Simplex<dim> simplex : mpm::simplices(surfaces[k].settings.surface)) {
      for (std::int32_t& vertex : simplex) vertex += first_vertex.back();
      simplices.push_back(simplex);
      surface.push_back(k);
      ++num_simplices.back();
    }
    vertices.insert(vertices.end(), surfaces[k].vertices.begin(), surfaces[k].vertices.end());
  }
  bounds = bounds_of<dim>(simplices, vertices);
}

template <int dim>
bool Faces<dim>::can_have_fields(const FacePair& pair,
                                 const std::vector<StartSurface<dim>>& surfaces) const {
  const auto by_facets = [&](std::int32_t s) {
    return std::holds_alternative<FacetSettings>(surfaces[surface[s]].settings.method);
  };
  return by_facets(pair.front) && by_facets(pair.back);
}

template <int dim>
std::vector<FacePair> thin_pairs(const Faces<dim>& faces, double cell_size) {
  const double limit = thin_cells * cell_size;
  const auto fronts = possible_fronts(faces);
  std::vector<Vector<dim>> places;
  for (const std::int32_t s : fronts) places.push_back(faces.bounds[s].centre);
  const FacetHash<dim> hash(faces.simplices, faces.vertices, inner_corner_reach * limit, places);
  std::vector<FacePair> pairs;
  for (const std::int32_t s : fronts) {
    const SimplexBounds<dim>& front = faces.bounds[s];
    const auto near = hash.near(front.centre);
    for (const std::int32_t t : near) {
      const SimplexBounds<dim>& back = faces.bounds[t];
      if (front.normal.dot(back.normal) > -opposite_cosine) continue;
      if (back.is_beyond(front.centre, inner_corner_reach * limit)) continue;
      const Vector<dim> place = faces.closest(t, front.centre), through = front.centre - place;
      const double distance = through.norm(), thickness = through.dot(front.normal);
      const bool behind = thickness >= opposite_cosine * distance;
      if (behind && distance < (1 - same_place) * limit) pairs.push_back({s, t, distance});
      if (behind || thickness < inner_corner_cosine * distance) continue;
      if (thickness >= (1 - same_place) * limit) continue;
      if (ends_in_corner<dim>(faces, t, place, near, same_place * limit))
        pairs.push_back({s, t, thickness});
    }
  }
  return pairs;
}

std::vector<std::int32_t> members(const std::vector<FacePair>& pairs) {
  std::vector<std::int32_t> all;
  for (const FacePair& pair : pairs) all.insert(all.end(), {pair.front, pair.back});
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

template struct Faces<2>;
template struct Faces<3>;
template std::vector<FacePair> thin_pairs<2>(const Faces<2>&, double);
template std::vector<FacePair> thin_pairs<3>(const Faces<3>&, double);

}  // namespace gabion::mpm
