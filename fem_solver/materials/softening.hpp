// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gabion::fem {

/// Point on the curve of a material: a bar of E = `modulus` is stretched or shortened evenly to the
/// strain r / E, has the stress s, and took some work per volume.
struct CurvePoint {
  double stress = 0;  ///< [Pa]
  double slope = 0;   ///< ds / dr
  double work = 0;    ///< integral of the stress over the strain [J/m^3]
};

/// Damage d of s = (1 - d) r.
struct Damage {
  double value = 0;
  double slope = 0;       ///< dd / dr [1/Pa]
  double dissipated = 0;  ///< work less the energy stored at d, s r / (2 E) [J/m^3]
};

/// Tension of concrete: linear to the strength, then exponential, with the area of the fracture
/// energy over the width of the band in which the crack lies.
struct TensionCurve {
  double modulus = 0;          ///< E [Pa]
  double strength = 0;         ///< [Pa]
  double fracture_energy = 0;  ///< [J/m^2]

  /// Width from which on a band would give back more energy than the crack takes, even where it
  /// cannot contract along the crack [m].
  double widest_band() const;
  /// @pre r >= 0, 0 < width < widest_band()
  CurvePoint at(double r, double width) const;
};

/// Compression of concrete, taken positive: linear to the elastic limit, a parabola to the
/// strength, then exponential with the area of the crushing energy over the width of the band.
struct CrushingCurve {
  double modulus = 0;             ///< E [Pa]
  double elastic_limit = 0;       ///< [Pa]
  double strength = 0;            ///< [Pa]
  double strain_at_strength = 0;  ///< at least least_strain()
  double crushing_energy = 0;     ///< beyond the strength [J/m^2]

  /// Strain at the strength below which the parabola would be steeper than E.
  double least_strain() const;
  double widest_band() const;  ///< [m]
  CurvePoint at(double r, double width) const;
};

/// Damage at the point of a curve; it ends at largest_damage.
/// @pre r > 0
Damage damage_at(const CurvePoint& point, double r, double modulus);

inline constexpr double largest_damage = 1 - 1e-6;  // the rest keeps stiffness matrices regular

}  // namespace gabion::fem
