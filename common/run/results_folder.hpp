// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/run/folder_lock.hpp"

namespace gabion {

/// The folder to which a new run in `folder` moves the earlier results: "<folder>.previous";
/// "<folder>.failed" if their run was not completed (summary.json) but the one in
/// "<folder>.previous" was. If `folder` is a link, that is beside the folder that it leads to.
std::string place_of_earlier_results(const std::string& folder);

/// Refuse what prepare_results_folder() would refuse now, and change no results.
void check_results_folder(const std::string& name, const std::string& kind);

/// A folder for the results of one run, created with its parents: empty, but for a marker file that
/// makes it ours, and locked for this process. Links are followed.
///
/// Results of an earlier run of the same kind are moved to place_of_earlier_results(). What was
/// there is removed as far as the programs have written it; other files are kept in
/// "<folder>.kept", "<folder>.kept_2", ….
/// @param kind  who writes here: "coupler", "mpm_solver", "fem_solver"
/// @throws ConfigError  the folder is in use, holds something else, or results of another kind
FolderLock prepare_results_folder(const std::string& name, const std::string& kind);

}  // namespace gabion
