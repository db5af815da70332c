// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/channel/keys.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <vector>

#include "common/base/read_file.hpp"
#include "common/base/require.hpp"

namespace gabion {
namespace {

constexpr std::size_t key_length = 40;
using KeyText = std::array<char, key_length + 1>;

const std::string secret_tag = "gabion-secret-key ";
const std::string public_tag = "gabion-public-key ";

bool is_key(const std::string& text) {
  std::array<std::uint8_t, key_bytes> bytes{};
  return text.size() == key_length && zmq_z85_decode(bytes.data(), text.c_str()) != nullptr;
}

/// All keys of a file, which must all be of this kind.
std::vector<std::string> read_keys(const std::string& file, const std::string& tag) {
  std::istringstream in(read_file(file, "key file"));
  std::vector<std::string> keys;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos || line.starts_with(';')) continue;
    line.erase(line.find_last_not_of(" \t\r") + 1);
    // The wrong text is not quoted, since it may be a secret.
    require<ConfigError>(line.starts_with(tag) && is_key(line.substr(tag.size())),
                         "{}: line {} is not \"{}KEY\" with {} characters of Z85", file, number,
                         tag, key_length);
    keys.push_back(line.substr(tag.size()));
  }
  require<ConfigError>(!keys.empty(), "{}: holds no line \"{}KEY\"", file, tag);
  return keys;
}

std::string public_key_of(const std::string& secret) {
  KeyText text{};
  require(zmq_curve_public(text.data(), secret.c_str()) == 0, "CURVE: no public key");
  return text.data();
}

void write_new(const std::string& file, const std::string& text, mode_t mode) {
  const int descriptor = open(file.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, mode);
  require<ConfigError>(descriptor >= 0, "{}: cannot be made: {}", file, std::strerror(errno));
  const bool written = write(descriptor, text.data(), text.size()) == std::ssize(text);
  const bool closed = close(descriptor) == 0;
  require<ConfigError>(written && closed, "{}: cannot be written", file);
}

std::string or_environment(const std::string& value, const char* variable) {
  const char* given = std::getenv(variable);
  return value.empty() && given != nullptr ? given : value;
}

}  // namespace

void make_keys(const std::string& file) {
  KeyText public_text{};
  KeyText secret_text{};
  require(zmq_has("curve") == 1 && zmq_curve_keypair(public_text.data(), secret_text.data()) == 0,
          "this ZeroMQ library was built without CURVE");
  const std::string public_file = file + ".pub";
  require<ConfigError>(access(public_file.c_str(), F_OK) != 0, "{}: exists, and is not overwritten",
                       public_file);
  write_new(file, secret_tag + secret_text.data() + "\n", S_IRUSR | S_IWUSR);
  write_new(public_file, public_tag + public_text.data() + "\n", 0644);
}

std::string read_secret_key(const std::string& file) {
  struct stat status = {};
  require<ConfigError>(stat(file.c_str(), &status) == 0, "{}: {}", file, std::strerror(errno));
  require<ConfigError>((status.st_mode & (S_IRWXG | S_IRWXO)) == 0,
                       "{}: found mode {:o}, allowed: 600 (chmod 600), because it holds "
                       "a secret key",
                       file, status.st_mode & 0777);
  const std::vector<std::string> keys = read_keys(file, secret_tag);
  require<ConfigError>(keys.size() == 1, "{}: found {} keys, allowed: 1", file, keys.size());
  return keys.front();
}

std::set<std::string> read_public_keys(const std::string& file) {
  const std::vector<std::string> keys = read_keys(file, public_tag);
  return {keys.begin(), keys.end()};
}

ServerKeys read_server_keys(const std::string& key_file, const std::string& clients_file) {
  return {read_secret_key(key_file), read_public_keys(clients_file)};
}

std::optional<ClientKeys> read_client_keys(std::string key_file, std::string coupler_key_file) {
  key_file = or_environment(key_file, "GABION_KEY_FILE");
  coupler_key_file = or_environment(coupler_key_file, "GABION_COUPLER_KEY_FILE");
  if (key_file.empty() && coupler_key_file.empty()) return std::nullopt;
  require<ConfigError>(
      !key_file.empty() && !coupler_key_file.empty(),
      "keys: found only the {}, allowed: --key-file and --coupler-key-file, or neither",
      key_file.empty() ? "coupler's" : "own");
  ClientKeys keys;
  keys.secret = read_secret_key(key_file);
  keys.own_public = public_key_of(keys.secret);
  const std::set<std::string> coupler = read_public_keys(coupler_key_file);
  require<ConfigError>(coupler.size() == 1, "{}: found {} keys, allowed: 1", coupler_key_file,
                       coupler.size());
  keys.coupler_public = *coupler.begin();
  return keys;
}

}  // namespace gabion
