// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/checks/pools.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "common/base/log.hpp"
#include "mpm_solver/checks/seepage.hpp"
#include "mpm_solver/contact/surface_features.hpp"

namespace gabion::mpm {

namespace {

/// Components of the unit normal of a face that leans over water: it looks down, but it is no base.
constexpr double leans = 0.02, is_no_base = 0.1;

/// Highest level of a pool at any time [m].
double highest_level(const Pool& pool) {
  const auto& levels = pool.level.values();
  return *std::max_element(levels.begin(), levels.end());
}

/// Numbers of the pools that lie over a range of x; those beside a gap that it reaches into count.
std::vector<std::size_t> pools_over(const std::vector<Pool>& pools, double low, double high) {
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < pools.size(); ++k) {
    const double from = k == 0 ? pools[k].from : pools[k - 1].to;
    const double to = k + 1 == pools.size() ? pools[k].to : pools[k + 1].from;
    if (from < high && to > low) found.push_back(k);
  }
  return found;
}

/// A pool is a range of x. Where a wall leans, water of one side stands below it at the x of the
/// other side, and would get the level of that side.
template <int dim>
void warn_of_leaning_face(const std::vector<Pool>& pools, const ContactSettings<dim>& surface) {
  const auto& vertices = surface.surface.vertices;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vector<dim>& x : vertices) {
    low = std::min(low, x[0]);
    high = std::max(high, x[0]);
  }
  const auto over = pools_over(pools, low, high);
  if (over.size() < 2) return;
  double water = -std::numeric_limits<double>::infinity();
  for (const std::size_t k : over) water = std::max(water, highest_level(pools[k]));
  for (const Simplex<dim>& facet : simplices(surface.surface)) {
    const auto corners = corners_of<dim>(facet, vertices);
    const Vector<dim> n = simplex_normal<dim>(corners);
    if (n[dim - 1] > -leans || std::abs(n[0]) < is_no_base) continue;
    Vector<dim> middle = Vector<dim>::Zero();
    for (const Vector<dim>& x : corners) middle += x / static_cast<double>(corners.size());
    if (middle[dim - 1] >= water) continue;
    log::warn(
        "{}: \"{}\" leans over water, first at ({:.4g}), between pools {} and {}; a pool is a "
        "range "
        "of x, so the water below the leaning face has the level of its x and not that of its "
        "side: the thrust is wrong where the two differ; allowed: faces between pools of unequal "
        "levels that are upright or look up",
        surface.where, surface.name, fmt::join(middle.data(), middle.data() + dim, ", "),
        over.front(), over.back());
    return;
  }
}

}  // namespace

template <int dim>
void check_pools(const ConfigReader& in, const MpmSettings<dim>& settings) {
  if (settings.pools.empty()) return;
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    if (drains(settings.bodies[b])) continue;
    in.fail(fmt::format("bodies/{}/water", b),
            fmt::format("found \"{}\" without \"permeability\" beside \"pools\", allowed: bodies "
                        "whose pore water drains; give it a small permeability",
                        settings.bodies[b].name));
  }
  if (!settings.boulders.empty()) {
    in.fail("boulders",
            "found with \"pools\", allowed: none; buoyancy of boulders is not modelled");
  }
  const Vector<dim>& g = settings.gravity;
  if (!(g[dim - 1] < 0) || !g.template head<dim - 1>().isZero(0)) {
    in.fail("gravity",
            fmt::format("found ({:.4g}) with \"pools\", whose surface is level, allowed: "
                        "gravity against the last axis",
                        fmt::join(g.data(), g.data() + dim, ", ")));
  }
  for (const auto& surface : settings.interfaces) {
    warn_of_leaning_face(settings.pools, surface);
  }
  for (const auto& wall : settings.rigid_walls) {
    warn_of_leaning_face(settings.pools, wall.boundary);
  }
}

template <int dim>
PoolLevels pool_levels(const MpmSettings<dim>& settings, double time, const Vector<dim>& gravity) {
  if (settings.pools.empty()) return {};
  return {settings.pools, time, settings.bodies.front().water->density * gravity.norm()};
}

template void check_pools<2>(const ConfigReader&, const MpmSettings<2>&);
template void check_pools<3>(const ConfigReader&, const MpmSettings<3>&);
template PoolLevels pool_levels<2>(const MpmSettings<2>&, double, const Vector<2>&);
template PoolLevels pool_levels<3>(const MpmSettings<3>&, double, const Vector<3>&);

}  // namespace gabion::mpm
