// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace gabion {

/// Identity of a process on a machine. A process id alone may be given to another process later;
/// with the start time it is unique as long as the machine runs.
struct ProcessIdentity {
  /// Host name, boot id and pid namespace: when equal to our own, the pid can be looked up here.
  /// Empty = unknown.
  std::string host;
  std::int64_t pid = 0;
  std::int64_t start_time = 0;  ///< clock ticks after boot; proc(5), /proc/PID/stat field 22
};

ProcessIdentity this_process();

enum class ProcessState {
  running,
  stopped,  ///< by SIGSTOP or a debugger
  gone,     ///< no such process, or a zombie
  unknown,  ///< another machine, or no /proc
};

ProcessState look_up(const ProcessIdentity& process);

}  // namespace gabion
