// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>

namespace gabion {

using Json = nlohmann::json;

}  // namespace gabion
