// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "common/program/program.hpp"
#include "common/program/programs.hpp"

namespace gabion {

/// Read the words of a program's command line into `options`, whose values are the defaults.
/// @returns exit code of a program that ends here: --help, --version, or 2 for wrong words
std::optional<int> read_command_line(int argc, char** argv, const ProgramEntry& program,
                                     ProgramOptions& options);

}  // namespace gabion
