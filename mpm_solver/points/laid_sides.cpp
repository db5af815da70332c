// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/points/laid_sides.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "common/mechanics/elements/cell_facets.hpp"
#include "mpm_solver/points/rectangular_cells.hpp"

namespace gabion::mpm {

namespace {

// Points of a cell that are no farther from a side than the nearest one, by this share, are in its
// row.
constexpr double same_row = 0.1;

template <int dim>
struct Place {
  Vector<dim> x = Vector<dim>::Zero();
  double volume = 0;  // by that of the cell
};

/// A side of a cell: its mean plane.
template <int dim>
struct Side {
  Vector<dim> middle = Vector<dim>::Zero();
  Vector<dim> normal = Vector<dim>::Zero();
  double area = 0;

  double depth(const Vector<dim>& x) const { return (x - middle).dot(normal); }
};

template <int dim>
Side<dim> side_of(const std::vector<Vector<dim>>& corners, const Vector<dim>& inside) {
  Side<dim> side;
  for (const auto& corner : corners) side.middle += corner / static_cast<double>(corners.size());
  Vector<dim> across;
  if constexpr (dim == 2) {
    const Vector<2> edge = corners[1] - corners[0];
    across << edge[1], -edge[0];
  } else {
    const bool triangle = corners.size() == 3;
    const Vector<3> first = corners[triangle ? 1 : 2] - corners[0];
    const Vector<3> second = triangle ? corners[2] - corners[0] : corners[3] - corners[1];
    across = 0.5 * first.cross(second);
  }
  side.area = across.norm();
  side.normal = across / side.area;
  if (side.depth(inside) < 0) side.normal = -side.normal;
  return side;
}

template <int dim>
std::vector<Place<dim>> places_of(const PointLayout<dim>& layout,
                                  const std::vector<Vector<dim>>& corners) {
  const CellType type = layout.mesh.cell_type;
  std::vector<Place<dim>> places;
  ShapeValues<dim> shape;
  for (const auto& q : point_rule<dim>(type, layout.points_per_cell, layout.placement)) {
    shape_functions<dim>(type, q.xi, shape);
    const double volume = q.weight * map_gradients<dim>(type, corners.data(), shape);
    places.push_back({place_in_cell<dim>(type, corners, q.xi).x, volume});
  }
  return places;
}

}  // namespace

template <int dim>
std::vector<LaidSide<dim>> laid_sides(const PointLayout<dim>& layout, std::int64_t number) {
  const auto rule_size = static_cast<std::int64_t>(
      point_rule<dim>(layout.mesh.cell_type, layout.points_per_cell, layout.placement).size());
  const auto nodes = layout.mesh.cell(static_cast<std::int32_t>(number / rule_size));
  std::vector<Vector<dim>> corners;
  for (const std::int32_t node : nodes) corners.push_back(layout.mesh.nodes[node]);
  const auto places = places_of(layout, corners);
  const Place<dim>& own = places[static_cast<std::size_t>(number % rule_size)];
  std::vector<LaidSide<dim>> sides;
  for (int f = 0; f < num_facets(layout.mesh.cell_type); ++f) {
    std::vector<Vector<dim>> of_side;
    for (const int i : facet_nodes(layout.mesh.cell_type, f)) of_side.push_back(corners[i]);
    const auto side = side_of<dim>(of_side, own.x);
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& place : places) nearest = std::min(nearest, side.depth(place.x));
    double volume = 0;
    Vector<dim> mean = Vector<dim>::Zero();
    for (const auto& place : places) {
      if (side.depth(place.x) > (1 + same_row) * nearest) continue;
      volume += place.volume;
      mean += place.volume * place.x;
    }
    const double depth = side.depth(own.x);
    if (depth > (1 + same_row) * nearest) continue;
    const Vector<dim> to_middle = side.middle - mean / volume;
    sides.push_back({.normal = side.normal,
                     .depth = depth,
                     .area = side.area * own.volume / volume,
                     .shift = to_middle - side.normal.dot(to_middle) * side.normal});
  }
  return sides;
}

template <int dim>
bool is_rectangular(const PointLayout<dim>& layout, std::int32_t cell) {
  const CellType type = layout.mesh.cell_type;
  if (type != CellType::quad4 && type != CellType::hex8) return false;
  constexpr double round_off = 1e-6;
  std::vector<Vector<dim>> corners;
  Vector<dim> middle = Vector<dim>::Zero();
  for (const std::int32_t node : layout.mesh.cell(cell)) {
    corners.push_back(layout.mesh.nodes[node]);
    middle += corners.back() / num_nodes(type);
  }
  std::vector<Vector<dim>> normals;
  for (int f = 0; f < num_facets(type); ++f) {
    std::vector<Vector<dim>> of_side;
    for (const int i : facet_nodes(type, f)) of_side.push_back(corners[i]);
    normals.push_back(side_of<dim>(of_side, middle).normal);
    for (const auto& other : normals) {
      const double cosine = std::abs(normals.back().dot(other));
      if (cosine > round_off && cosine < 1 - round_off) return false;
    }
  }
  return true;
}

template <int dim>
bool lies_in_rectangle(const PointLayout<dim>& layout, std::int64_t number) {
  const auto rule_size = static_cast<std::int64_t>(
      point_rule<dim>(layout.mesh.cell_type, layout.points_per_cell, layout.placement).size());
  return is_rectangular(layout, static_cast<std::int32_t>(number / rule_size));
}

template <int dim>
double deepest_uneven_row(const PointLayout<dim>& layout) {
  double deepest = 0;
  std::vector<Vector<dim>> corners;
  for (std::int32_t c = 0; c < layout.mesh.num_cells(); ++c) {
    if (!is_rectangular(layout, c)) continue;
    corners.clear();
    for (const std::int32_t node : layout.mesh.cell(c)) corners.push_back(layout.mesh.nodes[node]);
    const auto places = places_of(layout, corners);
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (int f = 0; f < num_facets(layout.mesh.cell_type); ++f) {
      std::vector<Vector<dim>> of_side;
      for (const int i : facet_nodes(layout.mesh.cell_type, f)) of_side.push_back(corners[i]);
      const auto side = side_of<dim>(of_side, places.front().x);
      double nearest = std::numeric_limits<double>::infinity();
      for (const auto& place : places) nearest = std::min(nearest, side.depth(place.x));
      least = std::min(least, nearest);
      most = std::max(most, nearest);
    }
    if (most > (1 + 1e-9) * least) deepest = std::max(deepest, most);
  }
  return deepest;
}

template bool is_rectangular<2>(const PointLayout<2>&, std::int32_t);
template bool is_rectangular<3>(const PointLayout<3>&, std::int32_t);
template bool lies_in_rectangle<2>(const PointLayout<2>&, std::int64_t);
template bool lies_in_rectangle<3>(const PointLayout<3>&, std::int64_t);
template double deepest_uneven_row<2>(const PointLayout<2>&);
template double deepest_uneven_row<3>(const PointLayout<3>&);
template std::vector<LaidSide<2>> laid_sides<2>(const PointLayout<2>&, std::int64_t);
template std::vector<LaidSide<3>> laid_sides<3>(const PointLayout<3>&, std::int64_t);

}  // namespace gabion::mpm
