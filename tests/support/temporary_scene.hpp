// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "common/run/solver.hpp"
#include "common/settings/scene.hpp"

namespace gabion::test {

/// A scene folder that holds one file, such as "mpm.json", and vanishes with this object; one a
/// process and file name.
class TemporaryScene {
 public:
  TemporaryScene(const std::string& file, const Json& content)
      : folder_(std::filesystem::temp_directory_path() /
                ("gabion_scene_" + std::to_string(getpid()) + "_" + file)) {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / file) << content.dump();
  }
  ~TemporaryScene() { std::filesystem::remove_all(folder_); }
  TemporaryScene(const TemporaryScene&) = delete;
  TemporaryScene& operator=(const TemporaryScene&) = delete;
  TemporaryScene(TemporaryScene&&) = delete;
  TemporaryScene& operator=(TemporaryScene&&) = delete;

  std::string path() const { return folder_.string(); }

 private:
  std::filesystem::path folder_;
};

/// Value of a probe column in the accepted state.
inline double probe(const Solver& solver, const std::string& name) {
  const auto names = solver.probe_names();
  const auto values = solver.probes();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return values[i];
  }
  throw Error("no probe " + name);
}

/// Solve and accept `count` steps with free interfaces, from step number `first`.
inline void run_steps(Solver& solver, double dt, int count, int first = 1) {
  for (int n = first; n < first + count; ++n) {
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    InterfaceValues sent;
    solver.solve_step(request, {}, sent);
    solver.accept_step(request, true);
  }
}

}  // namespace gabion::test
