// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace gabion {

/// Checksum CRC-32 of a file (ISO 3309, as in gzip): 8 hexadecimal digits. It differs for sure
/// where up to 32 bits in a row have changed, else with probability 1 - 2^-32.
/// @throws Error  the file cannot be read
std::string file_crc32(const std::string& path);

}  // namespace gabion
