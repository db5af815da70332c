// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace gabion {

/// Remove the files that the programs and scripts of this project write below a folder of results,
/// told by their names and places, and the folders that this leaves empty. All else stays: files
/// of other names, links, what a participant from outside has written.
/// @returns whether the folder is gone
/// @throws std::filesystem::filesystem_error
bool remove_result_files(const std::filesystem::path& folder);

/// Like remove_result_files(), for one checkpoint, the folder `checkpoints/step_N`.
bool remove_checkpoint_files(const std::filesystem::path& folder);

}  // namespace gabion
