// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

namespace gabion {

/// Check two lists of a saved state that belong together: `each` values for each of `count` things.
/// @throws Error  there are more or fewer
void require_values_each(const std::string& name, std::size_t num_values, std::size_t count,
                         std::size_t each);

}  // namespace gabion
