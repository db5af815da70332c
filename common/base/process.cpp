// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/process.hpp"

#include <unistd.h>

#include <array>
#include <climits>
#include <fstream>
#include <optional>
#include <sstream>

namespace gabion {
namespace {

struct Stat {
  char state = '?';
  std::int64_t start_time = 0;
};

/// Fields 3 and 22 of /proc/PID/stat. Field 2 is the program's name in brackets and may hold
/// anything, so counting starts after the last bracket.
std::optional<Stat> read_stat(std::int64_t pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
  std::string line;
  if (!std::getline(in, line)) return std::nullopt;
  const std::size_t end_of_name = line.rfind(')');
  if (end_of_name == std::string::npos) return std::nullopt;
  std::istringstream rest(line.substr(end_of_name + 1));
  Stat stat;
  std::string skipped;
  rest >> stat.state;
  for (int field = 4; field < 22; ++field) rest >> skipped;
  rest >> stat.start_time;
  if (!rest) return std::nullopt;
  return stat;
}

std::string this_host() {
  std::array<char, HOST_NAME_MAX + 1> name{};
  if (gethostname(name.data(), name.size() - 1) != 0) return "";
  std::string boot;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> boot;
  std::array<char, 64> pid_namespace{};
  if (readlink("/proc/self/ns/pid", pid_namespace.data(), pid_namespace.size() - 1) < 0) return "";
  if (boot.empty()) return "";
  return std::string(name.data()) + "/" + boot + "/" + pid_namespace.data();
}

}  // namespace

ProcessIdentity this_process() {
  ProcessIdentity self;
  self.pid = getpid();
  if (const auto stat = read_stat(self.pid)) {
    self.host = this_host();
    self.start_time = stat->start_time;
  }
  return self;
}

ProcessState look_up(const ProcessIdentity& process) {
  static const std::string here = this_host();
  if (here.empty() || process.host != here || process.pid <= 0) return ProcessState::unknown;
  const auto stat = read_stat(process.pid);
  if (!stat || stat->start_time != process.start_time) return ProcessState::gone;
  if (stat->state == 'Z' || stat->state == 'X') return ProcessState::gone;
  if (stat->state == 'T' || stat->state == 't') return ProcessState::stopped;
  return ProcessState::running;
}

}  // namespace gabion
