// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/mechanics/tensor.hpp"
#include "fem_solver/beams/cross_section.hpp"

namespace gabion::fem {

/// Axes 1, 2, 3 of a beam in space, as columns.
/// @param chord  along it
/// @param where  place of its material in the config, for errors
/// @throws ConfigError  an orientation along the beam
Matrix<3> beam_axes(const BeamData& beam, const Vector<3>& chord, const std::string& where);

}  // namespace gabion::fem
