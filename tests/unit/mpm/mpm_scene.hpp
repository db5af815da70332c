// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "common/settings/config_reader.hpp"
#include "mpm_solver/mpm_solver.hpp"
#include "mpm_solver/run_mpm.hpp"
#include "tests/support/mpi_main.hpp"
#include "tests/support/temporary_scene.hpp"

namespace gabion::test {

/// Settings from the text of an mpm.json.
template <int dim>
mpm::MpmSettings<dim> mpm_settings(const Json& json) {
  const TemporaryScene folder("mpm.json", json);
  const Scene scene(folder.path(), {});
  ConfigReader in = scene.reader("mpm.json", mpm::mpm_keys());
  in.integer("dimension");
  return mpm::read_mpm_settings<dim>(scene, in, nullptr);
}

/// The solver of an mpm.json, made as the program makes it.
inline std::unique_ptr<Solver> make_mpm(const Json& json, MPI_Comm on = comm(),
                                        const std::string& output_folder = "") {
  const TemporaryScene folder("mpm.json", json);
  const Scene scene(folder.path(), {});
  ConfigReader in = scene.reader("mpm.json", mpm::mpm_keys());
  return make_mpm_solver(scene, in, on, output_folder, nullptr);
}

/// The solver of make_mpm() as the class that shows its material points.
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

/// Every field of the points is equal in every bit.
template <int dim>
testing::AssertionResult same_bits(const mpm::MaterialPoints<dim>& a,
                                   const mpm::MaterialPoints<dim>& b) {
  std::string differing;
  mpm::for_each_field<dim>([&]<class Value>(const char* name,
                                            std::vector<Value> mpm::MaterialPoints<dim>::*field) {
    const std::vector<Value>&x = a.*field, &y = b.*field;
    const bool same = x.size() == y.size() &&
                      (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(Value)) == 0);
    if (!same) differing += std::string(" ") + name;
  });
  if (a.body_starts != b.body_starts) differing += " body_starts";
  if (differing.empty()) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "fields that differ:" << differing;
}

}  // namespace gabion::test
