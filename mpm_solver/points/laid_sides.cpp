// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/points/laid_sides.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "common/mechanics/elements/cell_facets.hpp"

namespace gabion::mpm {

namespace {

// Points of a cell that are no farther from a side than the nearest one, by this share, are in its
// row.
constexpr double same_row = 0.1;

// Sides meet at right angles to within this cosine; rows to within this share are equally deep.
constexpr double right_angle = 1e-6, same_depth = 1e-9;

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

/// A cell of a body as its points were laid in it.
template <int dim>
struct LaidCell {
  std::vector<Place<dim>> places;  // of its points
  std::vector<Side<dim>> sides;
  std::vector<double> rows;  // depth of the row next to each side [m]
};

template <int dim>
LaidCell<dim> laid_cell(const PointLayout<dim>& layout, std::int32_t number) {
  const CellType type = layout.mesh.cell_type;
  std::vector<Vector<dim>> corners;
  for (const std::int32_t node : layout.mesh.cell(number)) {
    corners.push_back(layout.mesh.nodes[node]);
  }
  LaidCell<dim> cell{.places = places_of(layout, corners), .sides = {}, .rows = {}};
  for (int f = 0; f < num_facets(type); ++f) {
    std::vector<Vector<dim>> of_side;
    for (const int i : facet_nodes(type, f)) of_side.push_back(corners[i]);
    const auto& side = cell.sides.emplace_back(side_of<dim>(of_side, cell.places.front().x));
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& place : cell.places) nearest = std::min(nearest, side.depth(place.x));
    cell.rows.push_back(nearest);
  }
  return cell;
}

template <int dim>
bool is_rectangular(const LaidCell<dim>& cell) {
  for (const auto& one : cell.sides) {
    for (const auto& other : cell.sides) {
      const double cosine = std::abs(one.normal.dot(other.normal));
      if (cosine > right_angle && cosine < 1 - right_angle) return false;
    }
  }
  return true;
}

template <int dim>
std::int64_t points_of_a_cell(const PointLayout<dim>& layout) {
  return static_cast<std::int64_t>(
      point_rule<dim>(layout.mesh.cell_type, layout.points_per_cell, layout.placement).size());
}

template <int dim>
std::vector<LaidSide<dim>> sides_at(const LaidCell<dim>& cell, const Place<dim>& own) {
  std::vector<LaidSide<dim>> sides;
  for (std::size_t f = 0; f < cell.sides.size(); ++f) {
    const Side<dim>& side = cell.sides[f];
    const double in_row = (1 + same_row) * cell.rows[f], depth = side.depth(own.x);
    if (depth > in_row) continue;
    double volume = 0;
    Vector<dim> mean = Vector<dim>::Zero();
    for (const auto& place : cell.places) {
      if (side.depth(place.x) > in_row) continue;
      volume += place.volume;
      mean += place.volume * place.x;
    }
    const Vector<dim> to_middle = side.middle - mean / volume;
    sides.push_back({.normal = side.normal,
                     .depth = depth,
                     .area = side.area * own.volume / volume,
                     .shift = to_middle - side.normal.dot(to_middle) * side.normal});
  }
  return sides;
}

}  // namespace

template <int dim>
std::vector<LaidSide<dim>> laid_sides(const PointLayout<dim>& layout, std::int64_t number,
                                      bool of_rectangles_only) {
  const std::int64_t count = points_of_a_cell(layout);
  const auto cell = laid_cell(layout, static_cast<std::int32_t>(number / count));
  if (of_rectangles_only && !is_rectangular(cell)) return {};
  return sides_at(cell, cell.places[static_cast<std::size_t>(number % count)]);
}

template <int dim>
double deepest_uneven_row(const PointLayout<dim>& layout) {
  double deepest = 0;
  for (std::int32_t c = 0; c < layout.mesh.num_cells(); ++c) {
    const auto cell = laid_cell(layout, c);
    const auto [least, most] = std::ranges::minmax(cell.rows);
    if (most > (1 + same_depth) * least && is_rectangular(cell)) deepest = std::max(deepest, most);
  }
  return deepest;
}

template double deepest_uneven_row<2>(const PointLayout<2>&);
template double deepest_uneven_row<3>(const PointLayout<3>&);
template std::vector<LaidSide<2>> laid_sides<2>(const PointLayout<2>&, std::int64_t, bool);
template std::vector<LaidSide<3>> laid_sides<3>(const PointLayout<3>&, std::int64_t, bool);

}  // namespace gabion::mpm
