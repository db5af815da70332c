// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "common/settings/config_reader.hpp"

namespace gabion::mpm {

/// Pressure, stiffness and energy of the pore water of a point at a volume ratio.
struct PorePressure {
  double p = 0;          ///< compression positive [Pa]
  double stiffness = 0;  ///< -dp / d ln J, K_w / n; 0 where the water cavitates [Pa]
  double energy = 0;     ///< over V0 [J/m^3]
};

/// Pore water of a saturated body that has no time to drain: it stays with its grains, which are
/// incompressible. With the volume ratio J of a point its pores take up J - 1 + n0 of the
/// stress-free volume V0, and hold the water that would take up `content` without pressure:
///
///     p = max(K_w ln(content / (J - 1 + n0)), -p_cav) ,   n = 1 - (1 - n0) / J
///
/// A function of the volume alone: nothing is integrated over the steps. A point without water
/// (content 0) is dry.
struct PoreWater {
  double porosity = 0;          ///< n0, in the stress-free state
  double bulk_modulus = 0;      ///< K_w [Pa]
  double density = 0;           ///< rho_w [kg/m^3]
  double cavitation = 0;        ///< p_cav, the suction that the water bears [Pa], >= 0
  double specific_weight = 0;   ///< rho_w g [N/m^3]
  double permeability = 0;      ///< hydraulic conductivity k at n0 [m/s]; 0: water does not drain
  bool kozeny_carman = false;   ///< k follows the porosity, else it is constant
  bool seepage_face = true;     ///< drains through the free surface of the soil
  std::optional<double> table;  ///< height of the water table at the start; none: no pressure [m]

  /// Volume of the pores over V0.
  double pores(double J) const { return J - (1 - porosity); }
  /// False where the pores would be all but closed.
  bool admits(double J) const { return pores(J) >= least_pores; }
  /// Content with which the pressure is p.
  double content_at(double p, double J) const;
  /// @pre content > 0, admits(J)
  PorePressure at(double content, double J) const;
  /// Pressure of water at rest at a height, 0 above the table [Pa].
  double hydrostatic(double height) const;
  bool drains() const { return permeability > 0; }
  /// k / (rho_w g) at n0 with the gravity of the earth, in which k is measured [m^2/(Pa s)].
  double mobility() const { return permeability / (density * standard_gravity); }
  /// Mobility at a volume ratio over that at n0; 1 unless `kozeny_carman`. @pre admits(J)
  double mobility_ratio(double J) const;
  /// d ln mobility_ratio / d ln J.
  double mobility_slope(double J) const { return kozeny_carman ? 3 * J / pores(J) - 1 : 0; }
  /// K_w / n in the stress-free state [Pa].
  double modulus() const { return bulk_modulus / porosity; }
  /// Density without water of soil whose density is that of the saturated one [kg/m^3].
  double dry_density(double saturated) const { return saturated - porosity * density; }
  /// Density of that soil with this share of its pores filled [kg/m^3].
  double density_above(double saturated, double share) const {
    return dry_density(saturated) + share * porosity * density;
  }

  /// A state with a smaller share of pores is inadmissible.
  static constexpr double least_pores = 0.02;
  static constexpr double standard_gravity = 9.81;  ///< [m/s^2]
};

/// Ratio of the water's modulus Q to that of the skeleton's P waves, M, below which the
/// compressibility of the water shows: the water carries 1 / (1 + M / Q) of a confined load, here
/// 95 %.
inline constexpr double least_water_stiffness = 20;

KeyTable pore_water_keys();
/// Keys of "water" of a body of mpm.json, which may drain.
KeyTable body_water_keys();

/// Read {"porosity", "bulk_modulus", "density", "cavitation_pressure", "grain_density"}.
/// Warns of water that is not stiff beside the skeleton, and of grains unlike those of soil.
/// @param saturated_density  of the body: its grains have to be heavier than water
/// @param skeleton_modulus   of P waves [Pa]
/// @throws ConfigError
PoreWater read_pore_water(ConfigReader in, double saturated_density, double skeleton_modulus);
/// Read the water of a body of mpm.json, which has "permeability" too. Water that drains bears any
/// suction, except see gives_way().
PoreWater read_body_water(ConfigReader in, double saturated_density, double skeleton_modulus);

}  // namespace gabion::mpm
