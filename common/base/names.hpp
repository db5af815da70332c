// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace gabion {

/// Longest name that a config or a message may give.
inline constexpr std::size_t max_name_size = 64;

/// Whether a text is one or more letters, digits, "_" and "-": such names become columns of
/// tables, files, and names in them.
/// @param more  further characters that are allowed
inline bool is_plain_name(std::string_view text, std::string_view more = "") {
  std::string allowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  allowed += more;
  return !text.empty() && text.find_first_not_of(allowed) == std::string_view::npos;
}

}  // namespace gabion
