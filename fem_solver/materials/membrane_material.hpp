// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/settings/config_reader.hpp"
#include "fem_solver/materials/green_stress.hpp"

namespace gabion::fem {

/// Material of a membrane: surface cells of a group of facets in space, with forces in their plane
/// alone. Plane stress, linear in the Green strain (St. Venant-Kirchhoff).
struct MembraneMaterial {
  std::string group;
  std::string where;         ///< place of the group in the config, for errors
  double density = 0;        ///< [kg/m^3], in the stress-free state
  double young_modulus = 0;  ///< [Pa]
  double poisson_ratio = 0;
  double thickness = 0;       ///< stress-free [m]
  double prestress = 0;       ///< in the mesh, force over length and stress-free thickness [Pa]
  bool tension_only = false;  ///< it wrinkles instead of carrying compression

  /// Lengths in the mesh over those without stress.
  double stretch() const;
  double wave_speed() const;  ///< [m/s]
};

/// How much of its stiffness a membrane has.
enum class MembraneState {
  taut,      ///< tension in both directions, or compression where that is carried
  wrinkled,  ///< tension in one direction
  slack      ///< no stress
};

/// Response of a membrane to its Green strain from the stress-free state, on two axes of its plane.
struct MembraneResponse {
  GreenStress<2> stress;  ///< second Piola-Kirchhoff, with its derivative
  double energy = 0;      ///< per stress-free volume [J/m^3]
  MembraneState state = MembraneState::taut;
};

/// With `tension_only` the relaxed energy: its least value over all additional strains >= 0, which
/// wrinkles bring about (Pipkin 1986). It is convex, so its tangent is positive semi-definite.
MembraneResponse respond(const MembraneMaterial& material, const StrainVector<2>& strain);

/// Keys of a group with the formulation `membrane`, beside those of all cells.
std::vector<Key> membrane_keys();

/// Read what group_material_keys() list of a membrane.
/// @param dim  of space
/// @throws ConfigError  a law other than `linear_elastic`, in 2D, with damping, ...
MembraneMaterial read_membrane_material(ConfigReader in, int dim);

}  // namespace gabion::fem
