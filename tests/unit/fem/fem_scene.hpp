// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "fem_solver/fem_solver.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test {

/// A scene folder that holds one fem.json and vanishes with this object; one a process.
class TemporaryScene {
 public:
  explicit TemporaryScene(const Json& fem)
      : folder_(std::filesystem::temp_directory_path() /
                ("gabion_fem_scene_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "fem.json") << fem.dump();
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

/// Settings from the text of a fem.json.
template <int dim>
FemSettings<dim> fem_settings(const Json& json) {
  const TemporaryScene folder(json);
  const Scene scene(folder.path(), {});
  ConfigReader in = scene.reader("fem.json");
  fem::read_dimension(in);
  auto settings = fem::read_fem_settings<dim>(scene, in);
  in.finish();
  return settings;
}

template <int dim>
std::unique_ptr<FemSolver<dim>> fem_solver(const Json& json, MPI_Comm on = comm()) {
  return std::make_unique<FemSolver<dim>>(fem_settings<dim>(json), on, "");
}

inline Json box_2d(std::vector<double> high, std::vector<int> cells,
                   const std::string& type = "quad4") {
  return {{"box", {{"low", {0.0, 0.0}}, {"high", high}, {"cells", cells}, {"type", type}}}};
}

inline Json box_3d(std::vector<double> high, std::vector<int> cells,
                   const std::string& type = "hex8") {
  return {{"box", {{"low", {0.0, 0.0, 0.0}}, {"high", high}, {"cells", cells}, {"type", type}}}};
}

inline Json elastic(const std::string& law, double E, double nu, double density) {
  return {{"law", law}, {"young_modulus", E}, {"poisson_ratio", nu}, {"density", density}};
}

/// Value of a probe column in the accepted state.
inline double probe(const Solver& solver, const std::string& name) {
  const auto names = solver.probe_names();
  const auto values = solver.probes();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return values[i];
  }
  throw Error("no probe " + name);
}

/// Solve and accept `count` steps without interface forces, from step number `first`.
inline void run_steps(Solver& solver, double dt, int count, int first = 1) {
  for (int n = first; n < first + count; ++n) {
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    InterfaceValues sent;
    solver.solve_step(request, {}, sent);
    solver.accept_step(request, true);
  }
}

}  // namespace gabion::test
