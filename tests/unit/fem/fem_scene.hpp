// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/settings/config_reader.hpp"
#include "fem_solver/fem_solver.hpp"
#include "tests/support/mpi_main.hpp"
#include "tests/support/temporary_scene.hpp"

namespace gabion::test {

/// Settings from the text of a fem.json, with the part of the mesh of this rank.
template <int dim>
fem::FemSettings<dim> fem_settings(const Json& json, MPI_Comm on = MPI_COMM_NULL) {
  const TemporaryScene folder("fem.json", json);
  const Scene scene(folder.path(), {});
  ConfigReader in = scene.reader("fem.json", fem::fem_keys());
  fem::read_dimension(in);
  auto settings = fem::read_fem_settings<dim>(scene, in, on);
  in.finish();
  return settings;
}

template <int dim>
std::unique_ptr<fem::FemSolver<dim>> fem_solver(const Json& json, MPI_Comm on = comm(),
                                                const std::string& folder = "") {
  return std::make_unique<fem::FemSolver<dim>>(on, fem_settings<dim>(json, on), folder);
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

}  // namespace gabion::test
