// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <string>

namespace gabion {

/// Keys of CURVE (Curve25519) as 40 characters of Z85 (ZeroMQ RFC 26 and 32). In a file, a line
/// each: `gabion-secret-key KEY` or `gabion-public-key KEY`; empty lines and those after `;` do not
/// count.

inline constexpr std::size_t key_bytes = 32;  ///< of a key, before it is text

/// Keys with which the coupler admits the participants that it knows.
struct ServerKeys {
  std::string secret;
  std::set<std::string> clients;  ///< public keys
};

/// Keys with which a participant recognises its coupler and is recognised.
struct ClientKeys {
  std::string secret;
  std::string own_public;
  std::string coupler_public;
};

/// A new pair: the secret key in `file`, which its owner alone may read, the public one in
/// `file`.pub.
/// @throws ConfigError  one of the files exists, or cannot be written
void make_keys(const std::string& file);

/// @throws ConfigError  the file cannot be read, others may read it, or it does not hold one key
std::string read_secret_key(const std::string& file);
/// @throws ConfigError  the file cannot be read, holds no key, or a line that is none
std::set<std::string> read_public_keys(const std::string& file);

ServerKeys read_server_keys(const std::string& key_file, const std::string& clients_file);

/// Empty names are replaced by the environment: GABION_KEY_FILE, GABION_COUPLER_KEY_FILE.
/// @return nothing when neither file is named
/// @throws ConfigError  as above, or only one of the two is named
std::optional<ClientKeys> read_client_keys(std::string key_file, std::string coupler_key_file);

}  // namespace gabion
