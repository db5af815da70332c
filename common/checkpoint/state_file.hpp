// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/run/state.hpp"

namespace gabion {

/// Write a state as one HDF5 file: dataset "facts" (JSON text), groups "reals" and "integers" with
/// a dataset an array.
/// @throws Error  disk full, folder gone
void write_state(const std::string& path, const State& state);

/// @throws Error  no such file, or not one of write_state()
State read_state(const std::string& path);

}  // namespace gabion
