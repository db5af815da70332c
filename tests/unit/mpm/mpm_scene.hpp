// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "mpm_solver/mpm_solver.hpp"
#include "mpm_solver/run_mpm.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test {

/// A scene folder that holds one mpm.json and vanishes with this object; one a process.
class MpmFolder {
 public:
  explicit MpmFolder(const Json& mpm)
      : folder_(std::filesystem::temp_directory_path() /
                ("gabion_mpm_scene_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "mpm.json") << mpm.dump();
  }
  ~MpmFolder() { std::filesystem::remove_all(folder_); }
  MpmFolder(const MpmFolder&) = delete;
  MpmFolder& operator=(const MpmFolder&) = delete;
  MpmFolder(MpmFolder&&) = delete;
  MpmFolder& operator=(MpmFolder&&) = delete;

  std::string path() const { return folder_.string(); }

 private:
  std::filesystem::path folder_;
};

/// The solver of an mpm.json, made as the program makes it.
inline std::unique_ptr<Solver> make_mpm(const Json& json, MPI_Comm on = comm()) {
  const MpmFolder folder(json);
  const Scene scene(folder.path(), {});
  ConfigReader in = scene.reader("mpm.json");
  return make_mpm_solver(scene, in, on, "", nullptr);
}

/// The same with its material points to look at.
template <int dim>
std::unique_ptr<mpm::MpmSolver<dim>> mpm_solver(const Json& json, MPI_Comm on = comm()) {
  auto solver = make_mpm(json, on);
  return std::unique_ptr<mpm::MpmSolver<dim>>(
      &dynamic_cast<mpm::MpmSolver<dim>&>(*solver.release()));
}

inline Json box(const std::vector<double>& low, const std::vector<double>& high,
                const std::vector<int>& cells, const std::string& type) {
  return {{"box", {{"low", low}, {"high", high}, {"cells", cells}, {"type", type}}}};
}

inline Json elastic_soil(const std::string& law, double E, double nu, double density) {
  return {{"law", law}, {"young_modulus", E}, {"poisson_ratio", nu}, {"density", density}};
}

inline Json body(const std::string& name, const Json& mesh, int points_per_cell,
                 const Json& material, const std::vector<double>& velocity = {}) {
  Json result = {
      {"name", name}, {"mesh", mesh}, {"points_per_cell", points_per_cell}, {"material", material}};
  if (!velocity.empty()) result["velocity"] = velocity;
  return result;
}

inline Json wall(const std::string& group, const std::string& condition) {
  return {{"group", group}, {"condition", condition}};
}

inline const Json exact_newton = {{"residual_tolerance", 1e-10}, {"increment_tolerance", 1e-10}};
inline const Json trapezoid = {{"scheme", "newmark"}};

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

/// Everything of the accepted state that another step depends on is equal in every bit.
template <int dim>
bool same_bits(const mpm::MaterialPoints<dim>& a, const mpm::MaterialPoints<dim>& b) {
  bool same = a.x == b.x && a.u == b.u && a.v == b.v && a.a == b.a && a.J == b.J &&
              a.tau == b.tau && a.energy == b.energy && a.grad_v == b.grad_v &&
              a.grad_a == b.grad_a && a.size() == b.size();
  for (std::int32_t p = 0; same && p < a.size(); ++p) {
    same = a.history[p].e == b.history[p].e &&
           a.history[p].plastic_strain == b.history[p].plastic_strain;
  }
  return same;
}

}  // namespace gabion::test
