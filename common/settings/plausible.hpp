// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/settings/config_reader.hpp"

namespace gabion {

/// Subject of a file of settings.
enum class Described { soil, structure };

/// Texts on settings whose values are allowed, but look like another unit: one for each, with file,
/// pointer, value and the units in which it would be plausible. Zero is always plausible.
/// @param in  that has read all of them
std::vector<std::string> implausible_settings(const ConfigReader& in, Described described);

/// Log these texts as warnings.
void warn_of_implausible_settings(const ConfigReader& in, Described described);

}  // namespace gabion
