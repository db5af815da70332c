// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/report/water_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "common/base/log.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/checks/seepage.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
bool any_has_water(const std::vector<Body<dim>>& bodies) {
  return std::any_of(bodies.begin(), bodies.end(),
                     [](const Body<dim>& body) { return body.water.has_value(); });
}

template <int dim>
bool any_drains(const std::vector<Body<dim>>& bodies) {
  return std::ranges::any_of(bodies, drains<dim>);
}

/// Cauchy stresses of a point and of its water [Pa].
template <int dim>
struct PointStressParts {
  double pore = 0, excess = 0;
  Symmetric<dim> total = Symmetric<dim>::Zero(), effective = Symmetric<dim>::Zero();
};

template <int dim>
PointStressParts<dim> stress_of(const Body<dim>& body, const MaterialPoints<dim>& points,
                                std::int32_t p) {
  PointStressParts<dim> stress;
  stress.pore = pore_tau<dim>(body, points, p) / points.J[p];
  if (points.is_wet(p)) stress.excess = stress.pore - body.water->hydrostatic(points.x[p][dim - 1]);
  stress.total = points.tau[p] / points.J[p];
  stress.effective = stress.total;
  stress.effective.template head<3>().array() += stress.pore;
  return stress;
}

// Call act(body, point) for all points.
template <int dim, class Act>
void for_each_point(const std::vector<Body<dim>>& bodies, const MaterialPoints<dim>& points,
                    const Act& act) {
  for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
    for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
      act(bodies[b], p);
    }
  }
}

}  // namespace

template <int dim>
std::vector<OutputField> water_fields(const std::vector<Body<dim>>& bodies,
                                      const MaterialPoints<dim>& points) {
  if (!any_has_water(bodies)) return {};
  const auto field = [&bodies, &points](std::string name, int components, auto put) {
    const auto make = [&bodies, &points, put] {
      std::vector<double> values;
      for_each_point<dim>(bodies, points, [&](const Body<dim>& body, std::int32_t p) {
        put(stress_of<dim>(body, points, p), values);
      });
      return values;
    };
    return OutputField{.name = std::move(name), .components = components, .make = make};
  };
  using Stress = PointStressParts<dim>;
  using Values = std::vector<double>;
  return {field("effective_stress", symmetric_size<dim>,
                [](const Stress& s, Values& to) {
                  to.insert(to.end(), s.effective.begin(), s.effective.end());
                }),
          field("pore_pressure", 1, [](const Stress& s, Values& to) { to.push_back(s.pore); }),
          field("excess_pore_pressure", 1,
                [](const Stress& s, Values& to) { to.push_back(s.excess); })};
}

template <int dim>
std::vector<std::string> water_probe_names(const MpmSettings<dim>& settings) {
  std::vector<std::string> names;
  if (!any_has_water(settings.bodies)) return names;
  for (const auto& probe : settings.probes) {
    for (const char* column : {"pore_pressure", "excess_pore_pressure"}) {
      names.push_back(fmt::format("{}.{}", probe.name, column));
    }
    for (const char* column : {"stress", "effective_stress"}) {
      for (int d = 0; d < dim; ++d) {
        names.push_back(fmt::format("{}.{}_{}{}", probe.name, column, "xyz"[d], "xyz"[d]));
      }
    }
  }
  if (any_drains(settings.bodies)) names.push_back("water_out");
  if (settings.rain) {
    names.push_back("rain_in");
    names.push_back("rain_run_off");
  }
  return names;
}

template <int dim>
std::vector<double> water_probe_values(const SoilModel<dim>& model, const SoilState<dim>& state) {
  const auto& bodies = model.settings.bodies;
  if (!any_has_water(bodies)) return {};
  constexpr std::size_t columns = 2 + 2 * dim;
  const MaterialPoints<dim>& points = state.points;
  std::vector<double> values(columns * state.probe_ids.size(), 0.0);
  for (std::size_t k = 0; k < state.probe_ids.size(); ++k) {
    const std::int32_t p = find_point(points, state.probe_ids[k]);
    if (p < 0) continue;
    const auto& starts = points.body_starts;
    const auto next = std::upper_bound(starts.begin(), starts.end(), p);
    const auto stress = stress_of<dim>(bodies[next - starts.begin() - 1], points, p);
    double* const row = &values[columns * k];
    row[0] = stress.pore;
    row[1] = stress.excess;
    for (int d = 0; d < dim; ++d) {
      row[2 + d] = stress.total[d];
      row[2 + dim + d] = stress.effective[d];
    }
  }
  sum_over_ranks(model.comm, std::span<double>(values));
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!std::isfinite(state.probe_ends[k / columns])) continue;
    values[k] = std::numeric_limits<double>::quiet_NaN();
  }
  if (model.drains) {
    const auto body = std::ranges::find_if(bodies, drains<dim>);
    values.push_back(state.water_out * body->water->density);
    if (model.settings.rain) {
      values.push_back(state.rain_in * body->water->density);
      values.push_back(state.rain_run_off * body->water->density);
    }
  }
  return values;
}

template <int dim>
Json water_summary(const SoilModel<dim>& model) {
  Json summary;
  for (std::size_t b = 0; b < model.settings.bodies.size(); ++b) {
    const Body<dim>& body = model.settings.bodies[b];
    if (!body.water) continue;
    const double dry = body.water->dry_density(body.material.density);
    summary[body.name] = {{"saturated_density", body.material.density},
                          {"dry_density", dry},
                          {"grain_density", dry / (1 - body.water->porosity)},
                          {"stiffness_over_skeleton", body.water->modulus() / model.moduli[b]},
                          {"wave_speed", model.wave_speeds[b]}};
    if (!drains(body)) continue;
    summary[body.name]["permeability"] = body.water->permeability;
    summary[body.name]["permeability_law"] =
        body.water->kozeny_carman ? "kozeny_carman" : "constant";
    summary[body.name]["free_surface"] = body.water->seepage_face ? "seepage_face" : "impervious";
    summary[body.name]["consolidation"] = body.water->mobility() * model.moduli[b];
  }
  return summary;
}

template <int dim>
void log_water(const SoilModel<dim>& model) {
  const Json summary = water_summary(model);
  for (const auto& [name, body] : summary.items()) {
    log::info(
        "pore water of \"{}\", {}: density {:.4g} saturated, {:.4g} dry, grains "
        "{:.4g} kg/m^3; water {:.3g} times as stiff as the skeleton, undrained wave speed {:.4g} "
        "m/s",
        name,
        body.contains("permeability")
            ? fmt::format(
                  "permeability {:.3g} m/s, {}, coefficient of consolidation {:.3g} m^2/s, free "
                  "surface: {}",
                  body["permeability"].template get<double>(),
                  body["permeability_law"].template get_ref<const std::string&>(),
                  body["consolidation"].template get<double>(),
                  body["free_surface"].template get_ref<const std::string&>())
            : "without drainage",
        body["saturated_density"].template get<double>(),
        body["dry_density"].template get<double>(), body["grain_density"].template get<double>(),
        body["stiffness_over_skeleton"].template get<double>(),
        body["wave_speed"].template get<double>());
  }
}

template std::vector<OutputField> water_fields<2>(const std::vector<Body<2>>&,
                                                  const MaterialPoints<2>&);
template std::vector<std::string> water_probe_names<2>(const MpmSettings<2>&);
template std::vector<double> water_probe_values<2>(const SoilModel<2>&, const SoilState<2>&);
template Json water_summary<2>(const SoilModel<2>&);
template void log_water<2>(const SoilModel<2>&);
template std::vector<OutputField> water_fields<3>(const std::vector<Body<3>>&,
                                                  const MaterialPoints<3>&);
template std::vector<std::string> water_probe_names<3>(const MpmSettings<3>&);
template std::vector<double> water_probe_values<3>(const SoilModel<3>&, const SoilState<3>&);
template Json water_summary<3>(const SoilModel<3>&);
template void log_water<3>(const SoilModel<3>&);

}  // namespace gabion::mpm
