// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/settings/keys.hpp"

namespace gabion::mpm {

/// Keys of an entry of "interfaces" and of "rigid_walls" in mpm.json.
KeyTable interface_keys();
KeyTable rigid_wall_keys();

}  // namespace gabion::mpm
