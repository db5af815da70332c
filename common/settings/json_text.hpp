// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/settings/config_reader.hpp"

namespace gabion {

/// Deepest nesting of settings; what copies or prints a deeper one could exhaust the stack.
inline constexpr std::size_t max_settings_depth = 32;

/// Parse a text of settings; comments are allowed.
/// @param source  file or option that the text is from, for error messages
/// @throws ConfigError  "<source>: ...": no JSON (with line), a byte 0, or with the JSON pointer: a
///                      key twice in one object, nested too deep, a number that no double holds
Json parse_settings(const std::string& text, const std::string& source);

}  // namespace gabion
