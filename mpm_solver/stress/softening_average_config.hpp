// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

#include "common/mechanics/materials/material.hpp"
#include "common/settings/config_reader.hpp"
#include "mpm_solver/grid/background_grid.hpp"
#include "mpm_solver/stress/softening_average.hpp"

namespace gabion::mpm {

KeyTable softening_average_keys();

/// @param law  of the body
/// @throws ConfigError  the law does not soften by the slip
template <int dim>
SofteningAverage read_softening_average(ConfigReader in, const MaterialLaw<dim>& law);

/// Refuse an average whose length is below what cells of the grid can hold.
/// @param where  place of its body in the settings
template <int dim>
void require_resolved(const SofteningAverage& average, const BackgroundGrid<dim>& grid,
                      const std::string& where);

/// Refuse a strength that rises with the shear: with an average it would fall at the point alone.
/// @param where  of the softening
void require_falling(const StrengthCurve& curve, const std::function<std::string()>& where);

}  // namespace gabion::mpm
