// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/start_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <span>
#include <utility>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "mpm_solver/contact/near_surfaces.hpp"
#include "mpm_solver/contact/sided_surface.hpp"

namespace gabion::mpm {

namespace {

// Soil within this many cells of a surface is near it.
constexpr double near_cells = 2;

// More boulders than this share one line of the log.
constexpr std::ptrdiff_t most_lines = 10;

// Relative elongation that facets of a cell's length may have where a structure begins displaced.
constexpr double strain_at_start = 1e-3;

// Neighbours that turn by more than 2 degrees are curved, by more than 60 degrees a corner.
constexpr double flat_cosine = 0.99939, corner_cosine = 0.5;

/// Edge of a triangle, or end of a segment, by its vertices in ascending order.
template <int dim>
using Edge = std::array<std::int32_t, dim - 1>;

template <int dim>
Edge<dim> edge_of(const Simplex<dim>& simplex, int k) {
  if constexpr (dim == 2) {
    return {simplex[k]};
  } else {
    return {std::min(simplex[k], simplex[(k + 1) % 3]), std::max(simplex[k], simplex[(k + 1) % 3])};
  }
}

template <int dim>
std::map<Edge<dim>, std::vector<std::int32_t>> edge_owners(
    const std::vector<Simplex<dim>>& simplices) {
  std::map<Edge<dim>, std::vector<std::int32_t>> owners;
  for (std::size_t s = 0; s < simplices.size(); ++s) {
    for (int k = 0; k < dim; ++k) {
      owners[edge_of<dim>(simplices[s], k)].push_back(static_cast<std::int32_t>(s));
    }
  }
  return owners;
}

// Largest edge of a square or cube of a point's volume, which holds its contact sphere.
template <int dim>
double largest_size(const MaterialPoints<dim>& points) {
  const auto widest = std::max_element(points.V0.begin(), points.V0.end());
  return widest == points.V0.end() ? 0 : cube_side<dim>(*widest);
}

// The surface that a point is nearest to; of equally near ones one that it is in front of; -1:
// none is near.
int owner_of(const std::vector<SurfaceSide>& sides) {
  int owner = -1;
  for (std::size_t k = 0; k < sides.size(); ++k) {
    if (!sides[k].known()) continue;
    if (owner >= 0) {
      const double lead = sides[owner].distance - sides[k].distance;
      const double margin = same_distance * sides[k].distance;
      if (lead < -margin || (lead <= margin && !sides[k].in_front())) continue;
    }
    owner = static_cast<int>(k);
  }
  return owner;
}

template <int dim>
void add_point(const StartSphere<dim>& sphere, const SurfaceSide& side, bool measured,
               double near_distance, SoilAtStart<dim>& soil) {
  if (side.in_front()) {
    soil.gap = std::min(soil.gap, side.distance - sphere.radius);
    soil.near_front += side.distance <= near_distance;
  } else {
    soil.near_behind += side.distance <= near_distance;
  }
  const auto depth = depth_inside(sphere, side, measured);
  if (!depth || (!side.in_front() && side.distance > sphere.size)) return;
  ++soil.inside;
  if (*depth <= soil.deepest) return;
  soil.deepest = *depth;
  soil.deepest_at = sphere.x;
}

/// Findings of one surface on all ranks.
template <int dim>
struct Verdict {
  std::int64_t near_front, near_behind, inside;
  std::string deepest;  // "by 0.1 m at (0, 1)"
};

template <int dim>
Verdict<dim> verdict_of(MPI_Comm comm, const SoilAtStart<dim>& own) {
  double sums[] = {static_cast<double>(own.near_front), static_cast<double>(own.near_behind),
                   static_cast<double>(own.inside)};
  sum_over_ranks(comm, std::span<double>(sums));
  const double deepest = max_over_ranks(comm, own.deepest);
  std::string text;
  if (own.inside > 0 && own.deepest == deepest) {
    const double* x = own.deepest_at.data();
    text = fmt::format("the deepest by {:.3g} m at ({:.6g})", deepest, fmt::join(x, x + dim, ", "));
  }
  return {.near_front = static_cast<std::int64_t>(sums[0]),
          .near_behind = static_cast<std::int64_t>(sums[1]),
          .inside = static_cast<std::int64_t>(sums[2]),
          .deepest = first_text(comm, text)};
}

template <int dim>
void refuse(const ContactSettings<dim>& settings, const Verdict<dim>& found) {
  if (settings.mode == ContactMode::fixed) return;
  require<ConfigError>(
      found.near_behind == 0 || found.near_front > 0,
      "{}: all material points within {} cells of the surface of \"{}\", {} of them, lie behind "
      "it, allowed: facets whose normals point into the soil; reverse the order of a polyline (the "
      "soil is to its right), take facets of the structure from a mesh",
      settings.where, near_cells, settings.name, found.near_behind);
  require<ConfigError>(found.inside == 0,
                       "{}: found {} material points inside the structure or too deep in the "
                       "surface of \"{}\", {}; allowed at the start: soil in contact with it, or "
                       "in it by {} of a point's radius with \"method\": \"facets\"",
                       settings.where, found.inside, settings.name, found.deepest, allowed_overlap);
}

// 1 for the simplices that form a curve with a neighbour, else 0.
template <int dim>
std::vector<char> curved_simplices(const std::vector<Simplex<dim>>& simplices,
                                   const std::vector<Vector<dim>>& vertices) {
  std::vector<char> curved(simplices.size(), 0);
  for (const auto& [edge, owners] : edge_owners<dim>(simplices)) {
    if (owners.size() != 2) continue;
    const auto normal = [&](std::int32_t s) {
      return simplex_normal<dim>(corners_of<dim>(simplices[s], vertices));
    };
    const double cosine = normal(owners[0]).dot(normal(owners[1]));
    if (cosine >= flat_cosine || cosine < corner_cosine) continue;
    for (const std::int32_t s : owners) curved[s] = 1;
  }
  return curved;
}

template <int dim>
double longest_edge(const ContactSurface<dim>& surface, const std::vector<Vector<dim>>& vertices,
                    std::size_t facet) {
  const std::size_t n = num_nodes(surface.facet_type);
  double longest = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const Vector<dim>& a = vertices[surface.facets[facet * n + k]];
    const Vector<dim>& b = vertices[surface.facets[facet * n + (k + 1) % n]];
    longest = std::max(longest, (a - b).norm());
  }
  return longest;
}

// @param gap  infinite: no soil is in front of it [m]
void log_gap(const std::string& name, double gap, double cell_size) {
  if (std::isfinite(gap)) {
    log::info("{}: smallest gap to the soil {:.3g} m, {:.3g} cells", name, gap, gap / cell_size);
  } else {
    log::info("{}: no soil in front of it", name);
  }
}

// @param gaps  of all boulders, by their names [m]
void log_gaps(const std::vector<std::pair<std::string, double>>& gaps, double cell_size) {
  if (gaps.empty()) return;
  const auto& [name, least] =
      *std::ranges::min_element(gaps, {}, [](const auto& g) { return g.second; });
  log_gap(fmt::format("{} boulders, nearest \"{}\"", gaps.size(), name), least, cell_size);
}

// The smallest gap that points of this rank have, of those no farther than `reach`; points that are
// nearer to the box around the surface come first.
template <int dim>
double smallest_gap_within(double reach, const StartSurface<dim>& surface,
                           const MaterialPoints<dim>& points, const PointCubes<dim>& cubes) {
  const auto box = box_around<dim>(surface.vertices);
  std::vector<std::pair<double, std::int32_t>> near;  // squared distances from the box
  double thickest = 0;
  cubes.for_near(box, reach, [&](std::int32_t p, const Vector<dim>& x) {
    near.emplace_back(box.squaredExteriorDistance(x), p);
    thickest = std::max(thickest, points.depth[p]);
  });
  double gap = std::numeric_limits<double>::infinity();
  if (near.empty()) return gap;
  std::ranges::sort(near);
  const SidedSurface<dim> sided(surface.settings.surface, surface.vertices, reach);
  for (const auto& [distance, p] : near) {
    const double within = gap + points.depth[p], farthest = gap + thickest;
    if (distance > (1 + same_distance) * farthest * farthest) break;
    if (distance > (1 + same_distance) * within * within) continue;
    const SurfaceSide side = sided.side(points.x[p], within);
    if (side.known() && side.in_front()) gap = std::min(gap, side.distance - points.depth[p]);
  }
  return gap;
}

/// Soil whose points are found by their places.
template <int dim>
struct FoundSoil {
  const MaterialPoints<dim>& points;
  PointCubes<dim> cubes;
  double widest;  // largest_size() of the points of all ranks
};

template <int dim>
FoundSoil<dim> found_soil(MPI_Comm comm, const MaterialPoints<dim>& points, double cell_size) {
  return {points, PointCubes<dim>(points.x, cell_size), max_over_ranks(comm, largest_size(points))};
}

template <int dim>
double smallest_gap(MPI_Comm comm, const StartSurface<dim>& surface, const FoundSoil<dim>& soil,
                    double cell_size, double farthest) {
  for (double reach = near_cells * cell_size;; reach *= 4) {
    const double own =
        smallest_gap_within<dim>(reach + soil.widest, surface, soil.points, soil.cubes);
    const double gap = -max_over_ranks(comm, -own);
    if (gap <= reach || reach > farthest) return gap;
  }
}

}  // namespace

template <int dim>
std::vector<StartSurface<dim>> surfaces_at_start(
    const std::vector<ContactSettings<dim>>& interfaces,
    const std::vector<RigidWallSettings<dim>>& walls) {
  std::vector<StartSurface<dim>> surfaces;
  for (const auto& own : interfaces) surfaces.push_back({own, own.surface.vertices, false});
  for (const auto& wall : walls) {
    const bool moves = wall.is_boulder || wall.motion.moves();
    surfaces.push_back(
        {wall.boundary, wall.boundary.surface.vertices, true, moves, wall.is_boulder});
    auto& vertices = surfaces.back().vertices;
    const auto moved = wall.motion.displacement(vertices, 0);
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      vertices[v] += Eigen::Map<const Vector<dim>>(moved.data() + v * dim);
    }
  }
  return surfaces;
}

template <int dim>
std::vector<SoilAtStart<dim>> soil_at_start(const std::vector<StartSurface<dim>>& surfaces,
                                            const MaterialPoints<dim>& points, double cell_size) {
  const double near_distance = near_cells * cell_size;
  const double reach = std::max(near_distance, largest_size(points));
  std::vector<SidedSurface<dim>> sided;
  for (const auto& surface : surfaces) {
    sided.emplace_back(surface.settings.surface, surface.vertices, reach);
  }
  const NearSurfaces near =
      near_surfaces<dim>(surfaces, PointCubes<dim>(points.x, cell_size), reach);
  std::vector<SoilAtStart<dim>> found(surfaces.size());
  std::vector<std::int32_t> asked;
  std::vector<SurfaceSide> sides;  // of these
  for (std::int32_t p = 0; p < points.size(); ++p) {
    near.of_point(p, asked);
    sides.clear();
    for (const std::int32_t k : asked) sides.push_back(sided[k].side(points.x[p]));
    const int owner = owner_of(sides);
    const StartSphere<dim> sphere = start_sphere(points, p);
    for (std::size_t i = 0; i < asked.size(); ++i) {
      const std::int32_t k = asked[i];
      if (!sides[i].known() || (!sides[i].in_front() && owner != static_cast<int>(i))) continue;
      const bool measured = std::holds_alternative<FacetSettings>(surfaces[k].settings.method);
      add_point<dim>(sphere, sides[i], measured, near_distance, found[k]);
    }
  }
  return found;
}

template <int dim>
double smallest_gap(MPI_Comm comm, const StartSurface<dim>& surface,
                    const MaterialPoints<dim>& points, double cell_size, double farthest) {
  return smallest_gap<dim>(comm, surface, found_soil(comm, points, cell_size), cell_size, farthest);
}

template <int dim>
std::optional<std::string> coarse_surface(const StartSurface<dim>& surface, double cell_size) {
  const ContactSurface<dim>& of = surface.settings.surface;
  const auto cut = simplices(of);
  const auto curved = curved_simplices<dim>(cut, surface.vertices);
  const std::size_t num_facets = of.facets.size() / num_nodes(of.facet_type);
  const std::size_t cuts = cut.size() / num_facets;
  const bool any_flat =
      surface.rigid && std::holds_alternative<FacetSettings>(surface.settings.method);
  const double diagonal = of.facet_type == CellType::tri3 ? std::numbers::sqrt2 : 1;
  std::size_t count = 0;
  double longest = 0;
  for (std::size_t f = 0; f < num_facets; ++f) {
    const bool bent = std::any_of(curved.begin() + f * cuts, curved.begin() + (f + 1) * cuts,
                                  [](char c) { return c != 0; });
    if (any_flat && !bent) continue;
    const double length = longest_edge<dim>(of, surface.vertices, f);
    if (length <= (1 + strain_at_start) * (bent ? 0.5 : 1) * diagonal * cell_size) continue;
    ++count;
    longest = std::max(longest, length);
  }
  if (count == 0) return std::nullopt;
  return fmt::format(
      "{}: found {} of {} facets of \"{}\" too long for the grid, up to {:.3g} m, {:.3g} cells; "
      "advised: at most one cell, half a cell where the surface is curved{}",
      surface.settings.where, count, num_facets, surface.settings.name, longest,
      longest / cell_size, diagonal > 1 ? "; triangles 1.4 times as long" : "");
}

template <int dim>
std::optional<std::string> outside_grid(const StartSurface<dim>& surface,
                                        const Eigen::AlignedBox<double, dim>& grid,
                                        double cell_size) {
  const auto box = box_around<dim>(surface.vertices);
  if (box.squaredExteriorDistance(grid) <= cell_size * cell_size) return std::nullopt;
  const auto text = [](const Eigen::AlignedBox<double, dim>& of) {
    return fmt::format("({:.6g}) to ({:.6g})", fmt::join(of.min(), ", "),
                       fmt::join(of.max(), ", "));
  };
  return fmt::format(
      "{}: found \"{}\" from {}, wholly outside the background grid, which reaches from {}: soil "
      "cannot reach it{}",
      surface.settings.where, surface.settings.name, text(box), text(grid),
      surface.moves ? " unless its motion brings it in"
                    : "; allowed: a surface of which a part is in the grid or within a cell of it, "
                      "in metres and from the same origin");
}

template <int dim>
void check_start(MPI_Comm comm, const std::vector<StartSurface<dim>>& surfaces,
                 const MaterialPoints<dim>& points, double cell_size,
                 const Eigen::AlignedBox<double, dim>& grid) {
  for (const StartSurface<dim>& surface : surfaces) {
    const auto problem = outside_grid<dim>(surface, grid, cell_size);
    require<ConfigError>(!problem || surface.moves, problem.value_or(""));
    if (problem) log::warn("{}", *problem);
  }
  const auto found = soil_at_start(surfaces, points, cell_size);
  const bool together =
      std::ranges::count_if(surfaces, &StartSurface<dim>::is_boulder) > most_lines;
  std::vector<std::pair<std::string, double>> gaps;  // of boulders that share a line
  const FoundSoil<dim> soil = found_soil(comm, points, cell_size);
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    const ContactSettings<dim>& settings = surfaces[k].settings;
    refuse<dim>(settings, verdict_of<dim>(comm, found[k]));
    const double gap =
        smallest_gap<dim>(comm, surfaces[k], soil, cell_size, grid.diagonal().norm());
    if (surfaces[k].is_boulder && together) {
      gaps.emplace_back(settings.name, gap);
    } else {
      log_gap(settings.name, gap, cell_size);
    }
    if (surfaces[k].is_boulder) continue;
    if (const auto warning = coarse_surface<dim>(surfaces[k], cell_size)) log::warn("{}", *warning);
  }
  log_gaps(gaps, cell_size);
}

template struct SoilAtStart<2>;
template struct SoilAtStart<3>;
template std::vector<StartSurface<2>> surfaces_at_start<2>(
    const std::vector<ContactSettings<2>>&, const std::vector<RigidWallSettings<2>>&);
template std::vector<StartSurface<3>> surfaces_at_start<3>(
    const std::vector<ContactSettings<3>>&, const std::vector<RigidWallSettings<3>>&);
template std::vector<SoilAtStart<2>> soil_at_start<2>(const std::vector<StartSurface<2>>&,
                                                      const MaterialPoints<2>&, double);
template std::vector<SoilAtStart<3>> soil_at_start<3>(const std::vector<StartSurface<3>>&,
                                                      const MaterialPoints<3>&, double);
template double smallest_gap<2>(MPI_Comm, const StartSurface<2>&, const MaterialPoints<2>&, double,
                                double);
template double smallest_gap<3>(MPI_Comm, const StartSurface<3>&, const MaterialPoints<3>&, double,
                                double);
template std::optional<std::string> coarse_surface<2>(const StartSurface<2>&, double);
template std::optional<std::string> coarse_surface<3>(const StartSurface<3>&, double);
template std::optional<std::string> outside_grid<2>(const StartSurface<2>&,
                                                    const Eigen::AlignedBox<double, 2>&, double);
template void check_start<2>(MPI_Comm, const std::vector<StartSurface<2>>&,
                             const MaterialPoints<2>&, double, const Eigen::AlignedBox<double, 2>&);
template std::optional<std::string> outside_grid<3>(const StartSurface<3>&,
                                                    const Eigen::AlignedBox<double, 3>&, double);
template void check_start<3>(MPI_Comm, const std::vector<StartSurface<3>>&,
                             const MaterialPoints<3>&, double, const Eigen::AlignedBox<double, 3>&);

}  // namespace gabion::mpm
