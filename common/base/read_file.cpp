// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/read_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <system_error>

#include "common/base/require.hpp"

namespace gabion {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t chunk = std::size_t{1} << 20;

const char* kind_of(fs::file_type type) {
  switch (type) {
    case fs::file_type::directory:
      return "a folder";
    case fs::file_type::fifo:
      return "a pipe";
    case fs::file_type::character:
    case fs::file_type::block:
      return "a device";
    case fs::file_type::socket:
      return "a socket";
    default:
      return "something else";
  }
}

std::uintmax_t memory_bytes() {
  return static_cast<std::uintmax_t>(sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::uintmax_t>(sysconf(_SC_PAGE_SIZE));
}

/// Chunk by chunk: the size that the system reports may be wrong, or change.
std::string read_all(std::ifstream& in, const std::string& path, const std::string& what) {
  std::string text;
  std::size_t size = 0;
  while (in) {
    text.resize(size + chunk);
    in.read(text.data() + size, static_cast<std::streamsize>(chunk));
    size += static_cast<std::size_t>(in.gcount());
  }
  require<ConfigError>(in.eof(), "{}: cannot read this {}: {}", path, what, std::strerror(errno));
  text.resize(size);
  return text;
}

}  // namespace

void require_file(const std::string& path, const std::string& what) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  require<ConfigError>(fs::exists(status), "{}: cannot open this {}: {}", path, what,
                       error ? error.message() : "No such file or directory");
  require<ConfigError>(fs::is_regular_file(status), "{}: found {}, allowed: a {}", path,
                       kind_of(status.type()), what);
}

std::string read_file(const std::string& path, const std::string& what) {
  require_file(path, what);
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  require<ConfigError>(in.is_open(), "{}: cannot open this {}: {}", path, what,
                       std::strerror(errno));
  std::error_code error;
  const auto size = fs::file_size(path, error);
  try {
    if (error || size < memory_bytes()) return read_all(in, path, what);
  } catch (const std::bad_alloc&) {
    // The caller reports the failure.
  }
  throw ConfigError(fmt::format("{}: found a {} of {} bytes, allowed: less than the memory holds",
                                path, what, size));
}

}  // namespace gabion
