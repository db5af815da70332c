// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/cores.hpp"

#include <sched.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <thread>

namespace gabion {

namespace {

/// Empty: the machine has more processors than the mask holds.
std::vector<int> allowed_cpus() {
  cpu_set_t mask;
  CPU_ZERO(&mask);
  if (sched_getaffinity(0, sizeof mask, &mask) != 0) return {};
  std::vector<int> cpus;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &mask)) cpus.push_back(cpu);
  }
  return cpus;
}

/// From the line "0::/path" of /proc/self/cgroup; empty: no groups of version 2.
std::string own_group() {
  std::ifstream in("/proc/self/cgroup");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("0::")) return line.substr(3);
  }
  return "";
}

/// Whole processors of a cpu.max ("200000 100000"), at least 1; 0: "max", or no such file.
int quota_in(const std::string& file) {
  std::ifstream in(file);
  double quota = 0, period = 0;
  if (!(in >> quota >> period) || quota <= 0 || period <= 0) return 0;
  return std::max(1, static_cast<int>(quota / period));
}

}  // namespace

int usable_cores() {
  const std::vector<int> cpus = allowed_cpus();
  const int cores = cpus.empty() ? static_cast<int>(std::thread::hardware_concurrency())
                                 : count_cores(cpus, "/sys/devices/system/cpu");
  const int quota = quota_of_group("/sys/fs/cgroup", own_group());
  return std::max(1, quota > 0 ? std::min(cores, quota) : cores);
}

int count_cores(const std::vector<int>& cpus, const std::string& folder) {
  std::set<std::string> cores;
  for (const int cpu : cpus) {
    const std::string name = "cpu" + std::to_string(cpu);
    std::ifstream in(folder + "/" + name + "/topology/thread_siblings_list");
    std::string siblings;
    cores.insert(in >> siblings ? siblings : name);
  }
  return static_cast<int>(cores.size());
}

int quota_of_group(const std::string& root, const std::string& path) {
  int least = 0;
  for (std::string group = path;; group.resize(group.rfind('/'))) {
    const int quota = quota_in(root + group + "/cpu.max");
    if (quota > 0 && (least == 0 || quota < least)) least = quota;
    if (group.find('/') == std::string::npos) return least;
  }
}

}  // namespace gabion
