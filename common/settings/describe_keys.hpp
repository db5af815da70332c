// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/settings/keys.hpp"

namespace gabion {

/// The tables of a file, from its root on, as Markdown: a section each.
/// @param file  its name, such as "mpm.json"
std::string keys_as_markdown(const KeyTable& root, const std::string& file);

/// The keys as a JSON Schema, draft 7: for editors, and for other programs that write the file.
/// Rules between keys of different objects are the programs' alone.
Json keys_as_schema(const KeyTable& root, const std::string& file);

/// `--describe-keys`: print them.
/// @param form  "markdown" or "schema"
/// @throws ConfigError  another form
void describe_keys(const KeyTable& root, const std::string& file, const std::string& form);

}  // namespace gabion
