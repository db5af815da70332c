// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <common/base/json.hpp>

#include <string>
#include <vector>

namespace dealii_structure {

/// Box of cells along the axes; its sides are left, right, (front, back,) bottom, top.
struct BoxSettings {
  std::vector<double> low, high;  ///< [m]
  std::vector<int> cells;
};

/// Cells with a vertex or the centre within `radius` [m] of `near` are halved in each direction.
struct RefinementSettings {
  std::vector<double> near;  ///< [m]
  double radius = 0;         ///< [m]
  int times = 1;
};

struct SupportSettings {
  std::vector<std::string> groups;
  std::vector<std::string> components;  ///< "x", "y", "z"
};

struct InterfaceSettings {
  std::string name;
  std::vector<std::string> groups;
};

struct ProbeSettings {
  std::string name;
  std::vector<double> point;  ///< [m]
};

struct MaterialSettings {
  double density = 0;        ///< [kg/m^3]
  double young_modulus = 0;  ///< [Pa]
  double poisson_ratio = 0;
};

struct NewtonSettings {
  double tolerance = 1e-10;  ///< of the residual by the largest of load, inner and inertia forces
  int max_iterations = 25;
};

struct Settings {
  int dimension = 2;
  BoxSettings box;        ///< where `mesh_file` is empty
  std::string mesh_file;  ///< of Gmsh; its groups are numbers
  int degree = 2;         ///< of the shape functions
  std::vector<RefinementSettings> refinements;
  MaterialSettings material;
  std::vector<double> gravity;  ///< [m/s^2]
  double alpha = 0;             ///< Bossak's, -1/3 to 0
  bool initial_equilibrium = false;
  std::vector<SupportSettings> supports;
  std::vector<InterfaceSettings> interfaces;
  std::vector<ProbeSettings> probes;
  NewtonSettings newton;
  gabion::Json model;  ///< all of the above with defaults, but for the probes: what a state fits to
};

/// @throws gabion::ConfigError  file, JSON pointer, what was found, what is allowed
Settings read_settings(const std::string& path);

}  // namespace dealii_structure
