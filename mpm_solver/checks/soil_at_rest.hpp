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

/// Warnings of bodies that start free of stress under their full weight: they oscillate about their
/// state of rest. Empty: there are none.
template <int dim>
std::string free_of_stress_text(const MpmSettings<dim>& settings);

/// Warnings of interfaces whose penetration makes the thrust of soil that takes its weight too
/// small by more than 5 %. Empty: there are none, or no soil takes weight.
/// @param cell_size  mean [m]
template <int dim>
std::string soft_interfaces_text(const MpmSettings<dim>& settings, double cell_size);

/// Log what each body does under its own weight (log_own_weight), and the warnings above.
template <int dim>
void log_soil_at_rest(const MpmSettings<dim>& settings, double cell_size);

/// Reason why initial stress cannot be in balance: the vertical stresses of two bodies with initial
/// stress, one on top of the other, differ where they meet. The text says with which `surface` of
/// the lower one they would agree. Empty: nothing is found.
/// @param gravity  at the start [m/s^2]
template <int dim>
std::string stress_jump_text(const MpmSettings<dim>& settings, const Vector<dim>& gravity);

}  // namespace gabion::mpm
