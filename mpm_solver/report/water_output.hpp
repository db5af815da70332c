// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/base/json.hpp"
#include "common/mechanics/output/xdmf_series.hpp"
#include "mpm_solver/step/soil_state.hpp"

namespace gabion::mpm {

/// Fields of frames where a body has pore water, else none: effective_stress (Cauchy),
/// pore_pressure, and excess_pore_pressure over water at rest below the table of the start [Pa].
/// The fields refer to bodies and points.
template <int dim>
std::vector<OutputField> water_fields(const std::vector<Body<dim>>& bodies,
                                      const MaterialPoints<dim>& points);

/// Columns of probes.csv where a body has pore water, else none: of each probe pore_pressure,
/// excess_pore_pressure, and the normal components of stress and effective_stress (Cauchy) [Pa].
template <int dim>
std::vector<std::string> water_probe_names(const MpmSettings<dim>& settings);
/// Values of these columns; none (not a number) of a point that has left. @note Collective.
template <int dim>
std::vector<double> water_probe_values(const SoilModel<dim>& model, const SoilState<dim>& state);

/// Summary of each body with pore water: densities, K_w / (n0 M), undrained wave speed. Null
/// without any.
template <int dim>
Json water_summary(const SoilModel<dim>& model);
/// Log that summary.
template <int dim>
void log_water(const SoilModel<dim>& model);

}  // namespace gabion::mpm
