// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/cores.hpp"

#include <sched.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <thread>
#include <utility>

namespace gabion {

namespace {

constexpr const char* all_cpus = "/sys/devices/system/cpu";

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

/// Path in the line "0::/path" of /proc/self/cgroup; empty: no groups of version 2.
std::string own_group() {
  std::ifstream in("/proc/self/cgroup");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("0::")) return line.substr(3);
  }
  return "";
}

struct Ticks {
  double idle = 0, all = 0;
};

/// Ticks of a processor by its line "cpuN user nice system idle iowait irq softirq steal …"; a
/// machine that waits for its host is not idle.
std::optional<Ticks> ticks_of(const std::string& stat, int cpu) {
  constexpr int num_fields = 8, idle = 3, waiting_for_disk = 4;
  std::istringstream in(stat);
  const std::string name = "cpu" + std::to_string(cpu) + " ";
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(name)) continue;
    std::istringstream fields(line.substr(name.size()));
    Ticks ticks;
    for (int k = 0; k < num_fields; ++k) {
      double value = 0;
      if (!(fields >> value)) return std::nullopt;
      ticks.all += value;
      if (k == idle || k == waiting_for_disk) ticks.idle += value;
    }
    return ticks;
  }
  return std::nullopt;
}

std::string text_of(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
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
                                 : static_cast<int>(cores_of(cpus, all_cpus).size());
  const int quota = quota_of_group("/sys/fs/cgroup", own_group());
  return std::max(1, quota > 0 ? std::min(cores, quota) : cores);
}

std::optional<double> idle_cores(double seconds) {
  const std::string before = text_of("/proc/stat");
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  return idle_between(before, text_of("/proc/stat"), cores_of(allowed_cpus(), all_cpus));
}

std::optional<double> idle_between(const std::string& before, const std::string& after,
                                   const std::vector<std::vector<int>>& cores) {
  double idle = 0;
  for (const auto& threads : cores) {
    double least = 1;
    for (const int cpu : threads) {
      const auto a = ticks_of(before, cpu), b = ticks_of(after, cpu);
      if (!a || !b || b->all <= a->all) return std::nullopt;
      least = std::min(least, (b->idle - a->idle) / (b->all - a->all));
    }
    idle += least;
  }
  return cores.empty() ? std::nullopt : std::optional(idle);
}

std::vector<std::vector<int>> cores_of(const std::vector<int>& cpus, const std::string& folder) {
  std::map<std::string, std::vector<int>> cores;
  for (const int cpu : cpus) {
    const std::string name = "cpu" + std::to_string(cpu);
    std::ifstream in(folder + "/" + name + "/topology/thread_siblings_list");
    std::string siblings;
    cores[in >> siblings ? siblings : name].push_back(cpu);
  }
  std::vector<std::vector<int>> threads;
  for (auto& [siblings, own] : cores) threads.push_back(std::move(own));
  return threads;
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
