// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace gabion {

/// Cores that this process may use: those of its affinity mask, hardware threads of one core
/// counted once, and no more than the quota of its control group (version 2). At least 1.
int usable_cores();

/// Cores of the affinity mask that nobody uses, measured over so many seconds: the sum of their
/// idle shares, where the share of a core is that of its busiest hardware thread. Empty where the
/// system does not say.
std::optional<double> idle_cores(double seconds);

/// Idle cores, as idle_cores(), between two texts of /proc/stat.
/// @param cores  numbers of the hardware threads of each
std::optional<double> idle_between(const std::string& before, const std::string& after,
                                   const std::vector<std::vector<int>>& cores);

/// Numbers of the processors that are the hardware threads of each core.
/// @param cpus    numbers of the system
/// @param folder  with cpuN/topology, as /sys/devices/system/cpu; a processor without is a core
std::vector<std::vector<int>> cores_of(const std::vector<int>& cpus, const std::string& folder);

/// The least quota of a control group and those above it, in whole processors; 0: none is set.
/// @param root  of the groups, as /sys/fs/cgroup
/// @param path  of the group below it, such as "/user.slice/a.scope"
int quota_of_group(const std::string& root, const std::string& path);

}  // namespace gabion
