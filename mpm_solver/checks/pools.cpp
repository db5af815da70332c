// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/checks/pools.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "mpm_solver/checks/seepage.hpp"

namespace gabion::mpm {

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
  if (g[dim - 1] < 0 && g.template head<dim - 1>().isZero(0)) return;
  in.fail("gravity", fmt::format("found ({:.4g}) with \"pools\", whose surface is level, allowed: "
                                 "gravity against the last axis",
                                 fmt::join(g.data(), g.data() + dim, ", ")));
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
