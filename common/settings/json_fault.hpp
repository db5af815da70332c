// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/base/json.hpp"

namespace gabion {

/// Fault of a text that is not JSON, without the parser's own words:
///     line 12, column 3: found "}" after a comma, allowed: commas between entries only
/// @param text  that was parsed, comments allowed
std::string fault_of(const std::string& text, const Json::parse_error& error);

/// The words of the parser after its label "[json.exception.…] ".
std::string without_label(const std::string& what);

}  // namespace gabion
