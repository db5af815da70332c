// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/soil_inside.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/contact/sided_surface.hpp"

namespace gabion::mpm {

namespace {

// More boulders than this share one line of the log.
constexpr std::size_t most_lines = 10;

/// Soil that was left out.
struct LeftOut {
  double points = 0, mass = 0, volume = 0;  ///< mass [kg], volume [m^dim]
  double of = 0;                            ///< volume of the boulders [m^dim]
};

void log_left_out(const std::string& name, const LeftOut& soil, int dim) {
  log::info(
      "{}: {:.0f} material points inside it are left out, {:.6g} kg of soil in {:.4g} times its "
      "volume of {:.4g} m^{}",
      name, soil.points, soil.mass, soil.volume / soil.of, soil.of, dim);
}

// Points whose centre or too much of whose contact sphere is in a boulder.
template <int dim>
std::vector<std::int32_t> points_inside(const BoulderSettings<dim>& boulder,
                                        const ContactSurface<dim>& surface,
                                        const MaterialPoints<dim>& points) {
  const auto deepest = std::max_element(points.depth.begin(), points.depth.end());
  const double largest = deepest == points.depth.end() ? 0 : *deepest;
  const SidedSurface<dim> sided(surface, surface.vertices, 2 * (boulder.shape.radius + largest));
  const Vector<dim> centre = boulder.start.x.template head<dim>();
  std::vector<std::int32_t> inside;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double reach = boulder.shape.radius + points.depth[p];
    if ((points.x[p] - centre).squaredNorm() >= reach * reach) continue;
    const SurfaceSide side = sided.side(points.x[p]);
    if (side.known() && depth_inside(start_sphere(points, p), side, true)) inside.push_back(p);
  }
  return inside;
}

template <int dim>
void require_bodies_left(MPI_Comm comm, const std::string& where,
                         const std::vector<std::int32_t>& inside,
                         const MaterialPoints<dim>& points) {
  for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
    const auto first = points.body_starts[b], end = points.body_starts[b + 1];
    const auto gone = std::lower_bound(inside.begin(), inside.end(), end) -
                      std::lower_bound(inside.begin(), inside.end(), first);
    double counts[] = {static_cast<double>(end - first), static_cast<double>(gone)};
    sum_over_ranks(comm, std::span<double>(counts));
    require<ConfigError>(counts[1] == 0 || counts[1] < counts[0],
                         "{}: found all material points of body {} that are left, {}, inside "
                         "boulders, allowed: a body that extends beyond them",
                         where, b, counts[1]);
  }
}

}  // namespace

template <int dim>
void remove_soil_inside(MPI_Comm comm, const std::vector<BoulderSettings<dim>>& boulders,
                        const std::vector<RigidWallSettings<dim>>& walls,
                        MaterialPoints<dim>& points) {
  const std::size_t first_wall = walls.size() - boulders.size();
  const bool together = boulders.size() > most_lines;
  LeftOut all;
  std::size_t count = 0;
  for (std::size_t k = 0; k < boulders.size(); ++k) {
    if (!boulders[k].removes_soil) continue;
    const auto& boundary = walls[first_wall + k].boundary;
    const auto inside = points_inside(boulders[k], boundary.surface, points);
    require_bodies_left(comm, boundary.where, inside, points);
    double sums[] = {static_cast<double>(inside.size()), 0, 0};
    for (const std::int32_t p : inside) {
      sums[1] += points.m[p];
      sums[2] += points.V0[p];
    }
    sum_over_ranks(comm, std::span<double>(sums));
    remove_points(inside, points);
    const double volume = boulders[k].shape.mass.mass / boulders[k].density;
    if (!together) log_left_out(boundary.name, {sums[0], sums[1], sums[2], volume}, dim);
    all.points += sums[0];
    all.mass += sums[1];
    all.volume += sums[2];
    all.of += volume;
    ++count;
  }
  if (together && count > 0) log_left_out(fmt::format("{} boulders", count), all, dim);
}

template void remove_soil_inside<2>(MPI_Comm, const std::vector<BoulderSettings<2>>&,
                                    const std::vector<RigidWallSettings<2>>&, MaterialPoints<2>&);
template void remove_soil_inside<3>(MPI_Comm, const std::vector<BoulderSettings<3>>&,
                                    const std::vector<RigidWallSettings<3>>&, MaterialPoints<3>&);

}  // namespace gabion::mpm
