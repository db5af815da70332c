// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/mechanics/ranks/shared_nodes.hpp"

namespace gabion::mpm {

/// A value and the mass that has it.
struct MassValue {
  double value = 0;  ///< >= 0
  double mass = 0;   ///< [kg]
};

/// Sum of mass x value over all ranks without the largest values, those of `left_out` [kg]; the
/// last of them counts in part. It is the least sum of a part with the rest of the mass, and hardly
/// depends on how large the largest values are.
/// @param values  of this rank
/// @note Collective.
double sum_without_largest(const SharedNodes& shared, std::vector<MassValue> values,
                           double left_out);

}  // namespace gabion::mpm
