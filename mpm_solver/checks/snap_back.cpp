// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/checks/snap_back.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <numbers>
#include <variant>

#include "common/base/require.hpp"
#include "mpm_solver/checks/soil_at_rest.hpp"
#include "mpm_solver/stress/softening_average_config.hpp"
#include "mpm_solver/stress/step_context.hpp"

namespace gabion::mpm {

namespace {

// Pressure of all bodies above each other [Pa].
template <int dim>
double largest_pressure(const MpmSettings<dim>& settings) {
  double sum = 0;
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    const WeightedColumn column = column_of(settings, b);
    sum += column.density * column.gravity * column.height;
  }
  return sum;
}

// @param where  of the softening, and of the point where constants vary
template <int dim>
void check_soil(const SofteningSoil<dim>& soil, double widest, double pressure,
                const std::function<std::string()>& where) {
  const bool by_slip = soil.parameters().by_slip;
  const double rate = by_slip ? std::numbers::sqrt3 * widest : 1;
  const double steepness = snap_back(soil.surface(), rate, pressure);
  const double mu = soil.shear_modulus();
  require<ConfigError>(steepness < 1, [&] {
    return fmt::format(
        "{}: found a strength that falls {:.3g} times as fast with shear as the stress of a point "
        "can unload, {}with a shear modulus of {:.3g} Pa, allowed: less than 1; {}a shear modulus "
        "above {:.3g} Pa",
        where(), steepness,
        by_slip ? fmt::format("in shear bands {:.3g} m wide (which the cells of the grid make) ",
                              widest)
                : "",
        mu,
        by_slip ? fmt::format("slips {:.3g} times as long, or cells {:.3g} times as large, or ",
                              steepness, 1 / steepness)
                : fmt::format("strains {:.3g} times as large, or ", steepness),
        mu * steepness);
  });
}

}  // namespace

template <int dim>
void require_no_snap_back(const MpmSettings<dim>& settings) {
  double widest = 0;
  const bool softens = std::ranges::any_of(settings.bodies, [](const Body<dim>& body) {
    return std::holds_alternative<SofteningSoil<dim>>(body.material.law);
  });
  if (!softens) return;
  const auto& averages = settings.softening_averages;
  for (std::int32_t c = 0; c < settings.grid.num_cells(); ++c) {
    widest = std::max(widest, band_width(settings.grid, c));
  }
  const double pressure = largest_pressure(settings);
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    const auto* soil = std::get_if<SofteningSoil<dim>>(&settings.bodies[b].material.law);
    if (soil == nullptr) continue;
    const std::string body = fmt::format("{}/{}", settings.bodies_where, b);
    const std::string where = body + "/material/softening";
    const bool averaged = !averages.empty() && averages[b].acts();
    if (averaged) require_resolved(averages[b], settings.grid, body);
    // With `softening_average` a point hardens within a step.
    const auto check = [&](const SofteningSoil<dim>& law, const auto& place) {
      if (averaged) {
        require_falling(law.parameters().curve, place);
      } else {
        check_soil(law, widest, pressure, place);
      }
    };
    if (b >= settings.varying.size() || !settings.varying[b]) {
      check(*soil, [&] { return where; });
      continue;
    }
    const VaryingMaterial<dim>& varying = *settings.varying[b];
    varying.for_each_point(settings.layouts[b], [&](const auto& point) {
      check(std::get<SofteningSoil<dim>>(point.material.law),
            [&] { return where + ", " + varying.place_of(point.id, point.x); });
    });
  }
}

template void require_no_snap_back<2>(const MpmSettings<2>&);
template void require_no_snap_back<3>(const MpmSettings<3>&);

}  // namespace gabion::mpm
