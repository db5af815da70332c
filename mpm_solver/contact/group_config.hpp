// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/settings/config_reader.hpp"
#include "mpm_solver/contact/body_groups.hpp"

namespace gabion::mpm {

KeyTable contact_group_keys();

/// Read "contact_groups", none if the key is not there.
/// @param bodies  their names
/// @throws ConfigError  a body in no group or in two, a pair that is missing or given twice
BodyGroups read_body_groups(ConfigReader& in, const std::vector<std::string>& bodies);

}  // namespace gabion::mpm
