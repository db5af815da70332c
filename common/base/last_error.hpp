// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace gabion::log {

/// log::last_error for an error that another program shows at the same terminal: here it is shown
/// at level debug, and last_error() leaves it out.
void last_error_of_another(const std::string& text);

/// log::last_error for an error that another program has shown at the same terminal: it goes to the
/// file of also_to_file() alone.
void last_error_to_file(const std::string& text);

}  // namespace gabion::log
