// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/mechanics/materials/own_weight.hpp"
#include "mpm_solver/mpm_config.hpp"

namespace gabion::mpm {

/// A body as a layer under gravity, of its mean depth.
/// @param settings  with the layouts of the bodies, as below
template <int dim>
WeightedColumn column_of(const MpmSettings<dim>& settings, std::size_t body);

/// What to say of bodies that start free of stress, with weight that is there from the start: what
/// lies on a bed swings about its rest. Empty: there are none.
template <int dim>
std::string free_of_stress_text(const MpmSettings<dim>& settings);

/// What to say of interfaces that give more than 5 % of what the soil gives while it takes its
/// weight: its thrust at rest comes out too small. Empty: there are none, or no soil takes weight.
/// @param cell_size  mean [m]
template <int dim>
std::string soft_interfaces_text(const MpmSettings<dim>& settings, double cell_size);

/// Log what each body does under its own weight (log_own_weight), and those texts.
template <int dim>
void log_soil_at_rest(const MpmSettings<dim>& settings, double cell_size);

/// Why initial stress cannot be in balance, empty where nothing is found: of two bodies with
/// initial stress, one on top of the other, the vertical stresses differ where they meet. Says the
/// `surface` of the lower one with which they would not.
/// @param gravity  at the start [m/s^2]
template <int dim>
std::string stress_jump_text(const MpmSettings<dim>& settings, const Vector<dim>& gravity);

}  // namespace gabion::mpm
