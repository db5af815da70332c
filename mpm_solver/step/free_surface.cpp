// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/free_surface.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mpm_solver/grid/sparse_list.hpp"
#include "mpm_solver/small_cuts/ghost_stiffness.hpp"
#include "mpm_solver/step/seen_points.hpp"

namespace gabion::mpm {

namespace {

// Sum of the sides of two points within which one is the continuation of the other. Rows of regular
// points are half of it apart. The points of triangles, and those in cells that are taller than
// wide, have a neighbour across their rows within it.
constexpr double reach_of_points = 1.1;
// Distance, in sides of a point, within which other points decide the normal.
constexpr double reach_of_normals = 2;
// Distance, in sides of the largest point, within which points matter to each other.
constexpr double reach_of_sight = std::max(reach_of_normals, 2 * reach_of_points);
// Points straight beside a normal of 45 degrees lie on the cone.
constexpr double rounding = 1e-6;

template <int dim>
class Search {
 public:
  using Index = typename BoxGrid<dim>::Index;

  explicit Search(const SurroundingsOfSoil<dim>& parts)
      : parts_(parts),
        box_(*parts.grid.box),
        seen_(see_points<dim>(
            {.comm = parts.comm, .box = box_, .points = parts.points, .reach = reach_of_sight})),
        first_(box_.num_cells_total(), -1),
        fill_(box_.num_cells_total(), 0.0),
        walled_(box_.num_nodes_total(), 0) {
    list_points();
    list_walls();
  }

  void add_points_of(std::int32_t body, std::vector<OuterPoint<dim>>& found) const {
    const auto& points = parts_.points;
    for (std::int32_t p = points.body_starts[body]; p < points.body_starts[body + 1]; ++p) {
      if (!near_border(points.cell[p])) continue;
      const Vector<dim> n = normal(p);
      if (meets_point(p, n) || meets_wall(p, n)) continue;
      const OuterPoint<dim> point = at_surface(p, n);
      if (!meets_surface(point)) found.push_back(point);
    }
  }

 private:
  // The points of each cell, ascending, and the share of it that they fill.
  void list_points() {
    next_.resize(seen_.x.size());
    for (std::size_t p = seen_.x.size(); p-- > 0;) {
      next_[p] = std::exchange(first_.at(seen_.cell[p]), static_cast<std::int32_t>(p));
    }
    for (std::size_t p = 0; p < seen_.x.size(); ++p) {
      fill_.at(seen_.cell[p]) += seen_.volume[p];
      sides_.push_back(std::pow(seen_.volume[p], 1.0 / dim));
      largest_side_ = std::max(largest_side_, sides_.back());
    }
  }

  Index lattice_index(std::int32_t node) const {
    return box_.lattice_position(box_.node_position(node)).array().round().template cast<int>();
  }

  // Bit 2 d + end of a node: a facet of a wall across axis d has it, at that end of the grid.
  void list_walls() {
    const std::size_t n = num_nodes(facet_type(BoxGrid<dim>::cell_type));
    for (const WallSettings& wall : parts_.walls) {
      const auto& nodes = find_facets(parts_.grid.facet_groups, wall.group, wall.where);
      for (std::size_t first = 0; first < nodes.size(); first += n) {
        int sides = (1 << (2 * dim)) - 1;
        for (std::size_t k = 0; k < n; ++k) sides &= sides_at(lattice_index(nodes[first + k]));
        for (std::size_t k = 0; k < n; ++k) walled_.at(nodes[first + k]) |= sides;
      }
    }
  }
  int sides_at(const Index& at) const {
    int sides = 0;
    for (int d = 0; d < dim; ++d) {
      if (at[d] == 0) sides |= 1 << (2 * d);
      if (at[d] == box_.num_cells[d]) sides |= 2 << (2 * d);
    }
    return sides;
  }

  // Volume over that of a cell.
  double volume(std::int32_t p) const { return seen_.volume[p]; }
  // Side of a cube of that volume, by the spacing of the grid.
  double side(std::int32_t p) const { return sides_[p]; }

  // Act on the points of all bodies within `reach` of a place and, on the images of them in walls,
  // as act(point, vector to it). @param images  whether soil goes on behind walls as its mirror
  // image
  template <class Act>
  void for_points_near(const Vector<dim>& t, double reach, bool images, const Act& act) const {
    Index low, count;
    for (int d = 0; d < dim; ++d) {
      low[d] = std::max(0, static_cast<int>(std::floor(t[d] - reach)));
      const int high = std::min(box_.num_cells[d] - 1, static_cast<int>(std::floor(t[d] + reach)));
      count[d] = high - low[d] + 1;
    }
    for (int k = 0; k < count.prod(); ++k) {
      Index at = low;
      for (int d = 0, rest = k; d < dim; rest /= count[d], ++d) at[d] += rest % count[d];
      std::int32_t cell = 0;
      for (int d = dim; d-- > 0;) cell = cell * box_.num_cells[d] + at[d];
      if (first_[cell] < 0) continue;
      const int mirrors = images ? mirrors_of(at, t, reach) : 0;
      for (std::int32_t q = first_[cell]; q >= 0; q = next_[q]) {
        const Vector<dim> place = box_.lattice_position(seen_.x[q]);
        for (int image = 0; image < 1 << dim; ++image) {
          if ((image & ~mirrors) != 0) continue;
          const Vector<dim> path = mirrored(place, t, image) - t;
          if (path.norm() <= reach) act(q, path);
        }
      }
    }
  }

  // A bit for each axis across which a wall within reach of t mirrors the points of a cell.
  int mirrors_of(const Index& cell, const Vector<dim>& t, double reach) const {
    int mirrors = 0;
    for (int d = 0; d < dim; ++d) {
      const int end = 2 * t[d] > box_.num_cells[d] ? 1 : 0;
      if (std::abs(t[d] - end * box_.num_cells[d]) > reach) continue;
      Index at = cell;
      at[d] = end == 1 ? box_.num_cells[d] - 1 : 0;
      if (is_walled(at, d, end)) mirrors |= 1 << d;
    }
    return mirrors;
  }

  // The image of a place in the walls that are nearest to t across the axes of `image`, a bit each.
  Vector<dim> mirrored(const Vector<dim>& place, const Vector<dim>& t, int image) const {
    Vector<dim> at = place;
    for (int d = 0; d < dim; ++d) {
      const int end = 2 * t[d] > box_.num_cells[d] ? 1 : 0;
      if ((image >> d) % 2 == 1) at[d] = 2.0 * end * box_.num_cells[d] - place[d];
    }
    return at;
  }

  // Whether a wall holds the facet of a cell at an end of the grid.
  bool is_walled(const Index& cell, int d, int end) const {
    for (int corner = 0; corner < 1 << dim; ++corner) {
      if ((corner >> d) % 2 != end) continue;
      Index at = cell;
      for (int c = 0; c < dim; ++c) at[c] += (corner >> c) % 2;
      if ((walled_[box_.node(at)] >> (2 * d + end)) % 2 == 0) return false;
    }
    return true;
  }

  // The direction away from the points around a point, by the spacing of the grid; upwards for a
  // point in the midst of others.
  Vector<dim> normal(std::int32_t p) const {
    const double reach = reach_of_normals * side(p);
    Vector<dim> sum = Vector<dim>::Zero();
    double all = 0;
    for_points_near(box_.lattice_position(parts_.points.x[p]), reach, true,
                    [&](std::int32_t q, const Vector<dim>& path) {
                      const double near = 1 - path.squaredNorm() / (reach * reach);
                      sum -= volume(q) * near * path;
                      all += volume(q) * near * path.norm();
                    });
    const double size = sum.norm();
    if (size > rounding * all) return sum / size;
    return Vector<dim>::Unit(dim - 1);
  }

  // A side of the grid is a border unless a wall holds it.
  bool near_border(std::int32_t cell) const {
    const auto small = [&](std::int32_t c) { return fill_[c] < small_cut_fill; };
    if (small(cell)) return true;
    const auto neighbours = box_.neighbours(cell);
    const Index at = box_.cell_index(cell);
    for (int k = 0; k < 2 * dim; ++k) {
      if (neighbours[k] < 0 ? !is_walled(at, k / 2, k % 2) : small(neighbours[k])) return true;
    }
    return false;
  }

  bool meets_point(std::int32_t p, const Vector<dim>& n) const {
    bool meets = false;
    const double reach = reach_of_points * (side(p) + largest_side_);
    for_points_near(box_.lattice_position(parts_.points.x[p]), reach, false,
                    [&](std::int32_t q, const Vector<dim>& path) {
                      const double size = path.norm();
                      if (q == p || size > reach_of_points * (side(p) + side(q))) return;
                      const double along = (std::numbers::sqrt2 / 2 - rounding) * size;
                      if (path.dot(n) >= along) meets = true;
                    });
    return meets;
  }

  // Whether the line along n out of the grid leads through facets of a wall.
  bool meets_wall(std::int32_t p, const Vector<dim>& n) const {
    const Vector<dim> t = box_.lattice_position(parts_.points.x[p]) + side(p) * n;
    const Index cell = box_.cell_index(parts_.points.cell[p]);
    for (int d = 0; d < dim; ++d) {
      const int end = t[d] > box_.num_cells[d] ? 1 : 0;
      if ((t[d] < 0 || end == 1) && is_walled(cell, d, end)) return true;
    }
    return false;
  }

  OuterPoint<dim> at_surface(std::int32_t p, const Vector<dim>& lattice_normal) const {
    OuterPoint<dim> point{.point = p, .n = lattice_normal.cwiseQuotient(box_.spacing)};
    point.n.normalize();
    const Vector<dim> sides = side(p) * box_.spacing;
    // Points of Gauss's rule lie nearer to the side of their cell than half the length that they
    // represent.
    point.R = std::min(0.5 * sides.cwiseProduct(point.n).norm(), parts_.points.depth[p]);
    int across = 0;
    lattice_normal.cwiseAbs().maxCoeff(&across);
    point.area = sides.prod() / sides[across] / std::abs(point.n[across]);
    return point;
  }

  bool meets_surface(const OuterPoint<dim>& point) const {
    if (!parts_.surfaces) return false;
    const Vector<dim>& x = parts_.points.x[point.point];
    const double along = side(point.point) / point.n.cwiseQuotient(box_.spacing).norm();
    return parts_.surfaces->is_behind(x + std::max(2 * point.R, along) * point.n, x);
  }

  const SurroundingsOfSoil<dim>& parts_;
  const BoxGrid<dim>& box_;
  SeenPoints<dim> seen_;            // those of this rank have their own numbers
  SparseList<std::int32_t> first_;  // point of each cell, -1: none
  SparseList<double> fill_;         // of each cell, share of its volume
  SparseList<int> walled_;          // of each node, see list_walls
  std::vector<std::int32_t> next_;  // of each point in its cell, -1: it is the last one
  std::vector<double> sides_;       // of each point, by the spacing of the grid
  double largest_side_ = 0;
};

}  // namespace

template <int dim>
std::vector<OuterPoint<dim>> find_free_surface(const SurroundingsOfSoil<dim>& parts,
                                               std::span<const std::int32_t> bodies) {
  const Search<dim> search(parts);
  std::vector<OuterPoint<dim>> found;
  for (const std::int32_t body : bodies) search.add_points_of(body, found);
  return found;
}

template std::vector<OuterPoint<2>> find_free_surface<2>(const SurroundingsOfSoil<2>&,
                                                         std::span<const std::int32_t>);
template std::vector<OuterPoint<3>> find_free_surface<3>(const SurroundingsOfSoil<3>&,
                                                         std::span<const std::int32_t>);

}  // namespace gabion::mpm
