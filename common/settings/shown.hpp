// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <string>

#include "common/base/json.hpp"

namespace gabion {

/// A value for an error message: its first 57 characters and its type.
inline std::string shown(const Json& value) {
  std::string text = value.dump();
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return fmt::format("{} ({})", text, value.type_name());
}

}  // namespace gabion
