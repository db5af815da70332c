// SPDX-License-Identifier: BSD-3-Clause
#include "common/checkpoint/file_crc32.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

#include "common/base/require.hpp"

namespace gabion {

std::string file_crc32(const std::string& path) {
  constexpr std::size_t chunk = std::size_t{1} << 20;
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  require(in.is_open(), "{}: cannot open this file: {}", path, std::strerror(errno));
  std::vector<char> bytes(chunk);
  uLong sum = crc32(0, Z_NULL, 0);
  while (in) {
    in.read(bytes.data(), static_cast<std::streamsize>(chunk));
    sum = crc32(sum, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(in.gcount()));
  }
  require(in.eof(), "{}: cannot read this file: {}", path, std::strerror(errno));
  return fmt::format("{:08x}", sum);
}

}  // namespace gabion
