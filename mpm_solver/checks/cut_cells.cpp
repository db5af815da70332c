// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/checks/cut_cells.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/contact/facet_hash.hpp"

namespace gabion::mpm {

namespace {

// Room on either side of a surface that counts, over the size of the cell.
constexpr double on_the_line = 0.01;

/// The place of a surface that is nearest to a point.
template <int dim>
struct NearestPlace {
  double distance = std::numeric_limits<double>::infinity();  ///< [m]
  Vector<dim> x = Vector<dim>::Zero();
  Vector<dim> normal = Vector<dim>::Zero();  ///< of the facet
};

template <int dim>
class SurfaceAtStart {
 public:
  SurfaceAtStart(const StartSurface<dim>& surface, double reach)
      : vertices_(surface.vertices),
        simplices_(simplices(surface.settings.surface)),
        hash_(simplices_, vertices_, reach) {}

  NearestPlace<dim> nearest(const Vector<dim>& x) const {
    NearestPlace<dim> nearest;
    for (const std::int32_t s : hash_.near(x)) {
      const auto corners = corners_of<dim>(simplices_[s], vertices_);
      const Vector<dim> place = closest_place<dim>(corners, x).x;
      const double distance = (x - place).norm();
      if (distance >= nearest.distance) continue;
      nearest = {.distance = distance, .x = place, .normal = simplex_normal<dim>(corners)};
    }
    return nearest;
  }

 private:
  std::vector<Vector<dim>> vertices_;
  std::vector<Simplex<dim>> simplices_;
  FacetHash<dim> hash_;
};

// Whether a cell has room on both sides of the facet at a place, and the place lies in it.
template <int dim>
bool is_cut(const BackgroundGrid<dim>& grid, std::int32_t cell, const NearestPlace<dim>& at) {
  Vector<dim> corners[max_cell_nodes];
  grid.corners(cell, corners);
  const double margin = on_the_line * shortest_edge(grid, cell);
  Eigen::AlignedBox<double, dim> box;
  double lowest = 0, highest = 0;
  for (int i = 0; i < grid.nodes_per_cell(); ++i) {
    const double height = at.normal.dot(corners[i] - at.x);
    lowest = std::min(lowest, height);
    highest = std::max(highest, height);
    box.extend(corners[i]);
  }
  return lowest < -margin && highest > margin && box.exteriorDistance(at.x) <= margin;
}

template <int dim>
bool is_at_rest(const MpmSettings<dim>& settings) {
  return !settings.phases.front().dynamic ||
         std::ranges::any_of(settings.initial_stress,
                             [](const auto& stress) { return stress.has_value(); });
}

std::string text_of(const std::string& where, const std::string& name, const CutCells& found) {
  return fmt::format(
      "{}: the surface of \"{}\" cuts cells of the grid, where soil rests on it ({} of {} material "
      "points there). With \"basis\": \"linear\" the few points in such a cell do not have the "
      "volume of the soil in it: its thrust may be 1 to 10 % too small, on triangles with 6 points "
      "or more up to 2 % (docs/theory/interface.md, soil at rest). This does not occur on a grid "
      "whose cells end at the surface, nor with \"gimp\" on a box of quad4 or hex8",
      where, name, found.in_cut, found.touching);
}

}  // namespace

template <int dim>
std::vector<CutCells> cut_cells_at(const std::vector<StartSurface<dim>>& surfaces,
                                   const BackgroundGrid<dim>& grid,
                                   const MaterialPoints<dim>& points) {
  std::vector<CutCells> found(surfaces.size());
  const auto widest = std::max_element(points.V0.begin(), points.V0.end());
  if (widest == points.V0.end()) return found;
  const double reach = cube_side<dim>(*widest);
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    const SurfaceAtStart<dim> surface(surfaces[k], reach);
    for (std::int32_t p = 0; p < points.size(); ++p) {
      const NearestPlace<dim> at = surface.nearest(points.x[p]);
      if (at.distance > cube_side<dim>(points.V0[p])) continue;
      ++found[k].touching;
      found[k].in_cut += is_cut(grid, points.cell[p], at);
    }
  }
  return found;
}

template <int dim>
std::vector<std::string> cut_cells_texts(MPI_Comm comm, const MpmSettings<dim>& settings,
                                         const std::vector<StartSurface<dim>>& surfaces,
                                         const BackgroundGrid<dim>& grid,
                                         const MaterialPoints<dim>& points) {
  std::vector<std::string> texts;
  if (grid.basis != Basis::linear || !is_at_rest(settings)) return texts;
  const std::vector<CutCells> own = cut_cells_at(surfaces, grid, points);
  for (std::size_t k = 0; k < own.size(); ++k) {
    double sums[] = {static_cast<double>(own[k].touching), static_cast<double>(own[k].in_cut)};
    sum_over_ranks(comm, std::span<double>(sums));
    const CutCells found{.touching = static_cast<std::int64_t>(sums[0]),
                         .in_cut = static_cast<std::int64_t>(sums[1])};
    const auto& of = surfaces[k].settings;
    if (found.in_cut > 0) texts.push_back(text_of(of.where, of.name, found));
  }
  return texts;
}

template std::vector<CutCells> cut_cells_at<2>(const std::vector<StartSurface<2>>&,
                                               const BackgroundGrid<2>&, const MaterialPoints<2>&);
template std::vector<CutCells> cut_cells_at<3>(const std::vector<StartSurface<3>>&,
                                               const BackgroundGrid<3>&, const MaterialPoints<3>&);
template std::vector<std::string> cut_cells_texts<2>(MPI_Comm, const MpmSettings<2>&,
                                                     const std::vector<StartSurface<2>>&,
                                                     const BackgroundGrid<2>&,
                                                     const MaterialPoints<2>&);
template std::vector<std::string> cut_cells_texts<3>(MPI_Comm, const MpmSettings<3>&,
                                                     const std::vector<StartSurface<3>>&,
                                                     const BackgroundGrid<3>&,
                                                     const MaterialPoints<3>&);

}  // namespace gabion::mpm
