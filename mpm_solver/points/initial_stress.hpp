// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <optional>
#include <span>
#include <string>

#include "common/settings/config_reader.hpp"
#include "mpm_solver/points/laws_of_points.hpp"
#include "mpm_solver/points/material_points.hpp"
#include "mpm_solver/points/pool.hpp"

namespace gabion::mpm {

/// Elastic constants of a law, of the virgin soil [Pa].
template <int dim>
double shear_modulus(const MaterialLaw<dim>& law);
template <int dim>
double first_lame_constant(const MaterialLaw<dim>& law);

/// Geostatic stress of a body below a level surface: sigma_h = K0 sigma_v.
struct InitialStress {
  double k0 = 0;                   ///< >= 0
  double k0_consolidated = 0;      ///< K0 at ocr = 1
  double ocr = 1;                  ///< over-consolidation ratio, of vertical stresses
  double surface = 0;              ///< [m] height of the surface, without pressure on it
  double max_displacement = 1e-3;  ///< by the cell size: largest displacement that the check of
                                   ///< balance allows
  /// Height of the water table, of a body with pore water [m].
  std::optional<double> water_table = std::nullopt;
  double saturation_above = 0;       ///< share of the pores that is filled above the water table
  bool steady_seepage = false;       ///< the water flows (FlowingWater); false: it is at rest
  std::string where, where_surface;  ///< file and pointer of k0 and of surface, for messages
  std::string where_pressure;        ///< of pore_pressure
};

/// Read {"k0": number | "elastic" | "jaky", "surface", "ocr", "max_displacement"}.
///
///     elastic: K0 = nu / (1 - nu)      jaky: K0 = 1 - sin phi
///
/// With an over-consolidation ratio, unloading is elastic:
/// K0 = OCR K0_nc - (OCR - 1) nu / (1 - nu).
///
/// A body with pore water also has "pore_pressure", "water_table", which it requires where the
/// water is at rest, and "saturation_above".
/// @throws ConfigError  also for a law without Hencky's or linear elasticity, or without phi
/// @see Jaky (1948); Wroth (1975) for the unloading
template <int dim>
InitialStress read_initial_stress(ConfigReader in, const Body<dim>& body);
KeyTable initial_stress_keys();

/// Tell a body with pore water its water table; other bodies ignore it.
/// @param in     of the initial stress
/// @param pools  at the start
/// @throws ConfigError  the table lies above the surface of the body, and there is no pool of that
///                      level
template <int dim>
void take_water_table(const ConfigReader& in, const Mesh<dim>& mesh, const InitialStress& stress,
                      const PoolLevels& pools, Body<dim>& body);

/// A body under gravity.
template <int dim>
struct BodyAtRest {
  const Body<dim>& body;
  std::int32_t number = 0;                    ///< of the body
  Vector<dim> gravity = Vector<dim>::Zero();  ///< downwards along the last axis [m/s^2]
  LawsOfPoints<dim> laws = {};                ///< of the points, see LawsOfPoints
};

/// Pore water of a point that flows steadily, in full pores but for a suction that lets air in.
struct FlowingWater {
  double p = 0;           ///< its pressure [Pa]
  double on_surface = 0;  ///< pressure of a pool on the surface above the point [Pa]
};

/// Put the points of one body under geostatic stress. Their positions are those of the stressed
/// body, so with the volume V that a point was laid out with
///
///     V0 = V / J ,   m = rho V0 ,   s + s^2 / (2 C) = rho g d ,   tau_v = -s ,  tau_h = -K0 s ,
///
/// d the depth, C = (3 lambda + 2 mu) / (1 + 2 K0) and J = exp(-s / C): the exact solution of
/// d sigma_v / dy = rho g / J, sigma = tau / J, for Hencky elasticity. The linear elastic law knows
/// no change of volume: J = 1, s = rho g d. Elastic strains follow from Hooke's law. Where Young's
/// modulus varies, C is that of the point: the stress is then in balance but for the strains.
///
/// With pore water and its table at the depth d_w, w = <d - d_w> below it, this is the stress of
/// the skeleton, and
///
///     s + s^2 / (2 C) = g [rho_above min(d, d_w) + (rho - rho_w) w] ,  p = rho_w g w ,
///     m = V0 [rho_dry + (J - 1 + n0) rho_w] ,  rho_dry = rho - n0 rho_w ,
///     tau = tau' - J p 1
///
/// is exact for water of constant density: sigma' grows by (rho - rho_w) g / J. Above the table
/// points are dry but for their weight, rho_above = rho_dry + n0 saturation_above rho_w.
///
/// Where the pressure p of each point is given, that of water that flows,
///
///     s + s^2 / (2 C) = rho g d + p_surface - S p ,  m = V0 (rho_dry + content rho_w) ,
///
/// with the share S of the pressure that grains feel (gives_way()): the weight above is that of
/// full pores. It is exact for vertical flow; other flow needs a balance besides.
///
/// Cam-Clay has a bulk modulus P / kappa, P = a + (1 + 2 K0) s / 3, and its points get their memory
/// here: mu_0 of P, and P_c of the ellipse through the normally consolidated stress with s_nc = ocr
/// s. Its volumes follow from J = (P_r / P)^kappa, so that
///
///     s (1 + kappa) - kappa a / b ln(1 + b s / a) = rho g d ,  b = (1 + 2 K0) / 3
///
/// @param flow  of all points; empty: the water is at rest
/// @throws ConfigError  point above the surface, other direction of gravity, or stress that the law
///                      does not bear; names the point and what it would bear
/// @note Collective on comm.
template <int dim>
void set_initial_stress(MPI_Comm comm, const InitialStress& stress, const BodyAtRest<dim>& at_rest,
                        MaterialPoints<dim>& points, std::span<const FlowingWater> flow = {});

/// Cauchy stresses along the axes at a height by these formulas, those of the pore water included;
/// none above the surface [Pa].
/// @param flow  of the water at that place; null: it is at rest
template <int dim>
Vector<dim> initial_stress_at(const InitialStress& stress, const BodyAtRest<dim>& at_rest,
                              double height, const FlowingWater* flow = nullptr);

}  // namespace gabion::mpm
