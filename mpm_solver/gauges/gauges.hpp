// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <span>
#include <string>
#include <vector>

#include "common/run/state.hpp"
#include "mpm_solver/gauges/gauge.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Flow through a gauge, signed by its normal: each material point whose straight path in an
/// accepted step crosses it counts with its mass and its momentum at the end of the step.
template <int dim>
struct Passage {
  double mass = 0;                                  ///< since the start [kg]
  Vector<dim> momentum = Vector<dim>::Zero();       ///< since the start [kg m/s]
  double mass_flux = 0;                             ///< mass of the last step over dt [kg/s]
  Vector<dim> momentum_flux = Vector<dim>::Zero();  ///< momentum of the last step over dt [N]
};

/// The soil in a gauge: in the slab of a given thickness b around its plane, b / 2 on either side.
/// A point whose projection lies in the gauge counts with the share of its volume that lies in the
/// slab, its volume spread evenly along the normal over its extent; averages are over these shares.
/// Zeros where there is no soil.
struct Section {
  double area = 0;              ///< volume over b [m^2]; 2D [m]
  double depth = 0;             ///< area over the width of the gauge [m]
  double top = 0;               ///< highest soil above the foot, along the gauge [m]
  double mass_flux = 0;         ///< sum of m v . n over b [kg/s]
  double normal_speed = 0;      ///< mean of v . n over the mass [m/s]
  double speed = 0;             ///< mean of |v| over the mass [m/s]
  double max_speed = 0;         ///< [m/s]
  double dynamic_pressure = 0;  ///< mean of rho (v . n)^2 over the volume [Pa]
  double pressure = 0;          ///< mean of -n . sigma n over the volume [Pa]
  double max_pressure = 0;      ///< [Pa]
};

/// Section of each gauge. @param thickness  of the slab [m] @note Collective.
template <int dim>
std::vector<Section> gauge_sections(MPI_Comm comm, const std::vector<Gauge<dim>>& gauges,
                                    const MaterialPoints<dim>& points, double thickness);

/// All gauges of a run and what has passed through them. Refers to the gauges.
template <int dim>
class Gauges {
 public:
  /// @param thickness  of the slabs [m]
  Gauges(MPI_Comm comm, const std::vector<Gauge<dim>>& gauges, double thickness);

  /// @param x_n     where the points were at the start of the step [m]; not read without gauges
  /// @param points  at its end; none has been taken out
  /// @note  Collective.
  void add_step(std::span<const Vector<dim>> x_n, const MaterialPoints<dim>& points, double dt);

  const std::vector<Passage<dim>>& passages() const { return passages_; }

  /// Columns of probes.csv.
  static std::vector<std::string> names(const std::vector<Gauge<dim>>& gauges);
  /// @param points  of the accepted state @note Collective.
  std::vector<double> values(const MaterialPoints<dim>& points) const;

  void visit_state(StateVisitor& visitor);

 private:
  MPI_Comm comm_;
  const std::vector<Gauge<dim>>& gauges_;
  double thickness_;
  std::vector<Passage<dim>> passages_;
};

}  // namespace gabion::mpm
