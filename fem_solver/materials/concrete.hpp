// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <span>
#include <string>

#include "common/mechanics/materials/stress_update.hpp"
#include "fem_solver/materials/crack_band.hpp"
#include "fem_solver/materials/log_strain.hpp"
#include "fem_solver/materials/softening.hpp"

namespace gabion::fem {

/// Concrete that cracks and crushes (d+/d-): Hencky elasticity with a damage of the tensile and one
/// of the compressive part of the elastic stress s = C : E, E the logarithmic strain,
///
///     T = (1 - d+) s+ + (1 - d-) s- ,   s+ : C^-1 : s- = 0
///
/// s- the stress without tension that is nearest to s in the norm of C^-1, so that T is the slope
/// of an energy at constant damage, cracks close stiff, and a crack that is open bears what a body
/// without tension bears. Each damage is that of a bar at the largest equivalent stress r+, r- so
/// far; an explicit function of E and the accepted r. The tangent is not symmetric.
/// @see Del Piero (1989); Freddi and Royer-Carfagni (2010); Wu and Cervera (2018); Faria, Oliver
/// and Cervera (1998); Wu, Li and Faria (2006); docs/theory/structure.md
template <int dim>
struct Concrete {
  static constexpr bool is_elastic = false;
  /// Numbers that a point remembers: r+, r- [Pa]; the widths of the bands of its crack and of
  /// crushing [m], 0 before; the width of its crack [m]; the energy that it took [J/m^3].
  static constexpr int history_size = 6;

  double lambda = 0;  ///< [Pa]
  double mu = 0;      ///< [Pa]
  TensionCurve tension;
  CrushingCurve crushing;
  double biaxial_ratio = 1.16;  ///< strength in equal biaxial over that in uniaxial compression
  /// Distance of cracks, which bounds the width of their bands [m].
  double crack_spacing = std::numeric_limits<double>::infinity();
  std::string where_fracture;  ///< place of the fracture energy in the config, for errors
  std::string where_crushing;  ///< of the crushing energy

  bool symmetric_tangent() const { return false; }
  double p_wave_modulus() const { return lambda + 2 * mu; }
  double shear_modulus() const { return mu; }

  /// Width from which on a bar gives back more energy than its crack takes [m].
  double widest_crack_band() const {
    return tension.widest_band() * crushing.modulus / tension.modulus;
  }

  /// Damage in tension and in compression that a point has.
  double tensile_damage(std::span<const double> history) const;
  double compressive_damage(std::span<const double> history) const;
  static double crack_width(std::span<const double> history) { return history[4]; }  ///< [m]
  /// Strain that opens the crack: its width over that of its band.
  static double opening_strain(std::span<const double> history) {
    return history[2] > 0 ? history[4] / history[2] : 0;
  }
  /// Compressive strain, positive, at which a bar is crushed as far; it never falls.
  double crushing_strain(std::span<const double> history) const {
    return history[1] / crushing.modulus;
  }
  static double damage_work(std::span<const double> history) { return history[5]; }  ///< [J/m^3]
};

/// The law in a cell, with the widths of the cell's bands. Refers to both.
template <int dim>
struct ConcreteOfCell {
  static constexpr int history_size = Concrete<dim>::history_size;

  const Concrete<dim>& law;
  const CrackBand<dim>& band;

  /// See ConstitutiveLaw; H and the stress P refer to the stress-free configuration.
  /// @param history_n  accepted, history_size
  /// @param history    at the end of the step, history_size
  bool update(const Matrix<dim>& H, std::span<const double> history_n, std::span<double> history,
              StressUpdate<dim>& out, Tangent<dim>* A) const;
  /// T and its derivative at the logarithmic strain E; histories as above.
  void log_stress(const Symmetric<dim>& E, std::span<const double> history_n,
                  std::span<double> history, LogStress<dim>& out) const;
};

}  // namespace gabion::fem
