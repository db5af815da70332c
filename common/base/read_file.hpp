// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace gabion {

/// Refuse what is no file of bytes at rest: a folder, and a pipe or a device, which may never end.
/// @param what  of the message, such as "mesh file"
/// @throws ConfigError  names the path and what is there
void require_file(const std::string& path, const std::string& what);

/// All bytes of a file.
/// @throws ConfigError  as above; it cannot be read, or is too large for the memory
std::string read_file(const std::string& path, const std::string& what);

}  // namespace gabion
