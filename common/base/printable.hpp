// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace gabion {

/// Make a text that others wrote, such as a name or an error of another program, fit for a terminal
/// or a log. What a terminal would obey instead of showing (control characters, marks that turn the
/// direction of writing) and what is not UTF-8 becomes \x1b and the like; tabs stay. Lines behind
/// the first are indented, so that none can pass for a line of the log.
std::string printable(std::string_view text);

}  // namespace gabion
