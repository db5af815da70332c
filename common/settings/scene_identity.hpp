// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/settings/scene.hpp"

namespace gabion {

/// Identity of a scene, equal for two runs of it: its settings, overrides included, and hashes of
/// the files that they name (meshes).
///
///     {"settings": {"mpm.json": {...}, ...}, "files": {"mpm.json": {"/grid/file": "soil.msh
///     0f…"}}}
Json scene_identity(const Scene& scene);

/// Check that two runs are of one scene. These may differ: "/time/end", "/output", "/checkpoint",
/// "/protocol" and "/$schema" of each file.
/// @param saved   identity of the scene of an earlier run
/// @param now     that of this one, in `folder`
/// @param source  where the earlier run came from, for the message
/// @throws ConfigError  names the first difference: file, JSON pointer, both values
void require_same_scene(const Json& saved, const Json& now, const std::string& folder,
                        const std::string& source);

}  // namespace gabion
