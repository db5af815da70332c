// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <map>
#include <string>
#include <vector>

#include "mpm_solver/contact/start_check.hpp"
#include "mpm_solver/contact/surfaces.hpp"
#include "mpm_solver/contact/thin_pairs.hpp"

namespace gabion::mpm {

/// Finds structures thinner than two cells that have soil on both sides: that soil shares nodes of
/// the grid, so it acts on itself through the structure. Each pair of surfaces (or one surface)
/// with such faces is reported once, unless SideFields cures it. Surfaces of the mode `fixed`, to
/// which soil sticks on all sides, are left out. Refers to the settings of the surfaces.
template <int dim>
class ThinWalls {
 public:
  /// @param pairs      of the faces of the surfaces, without those that SideFields cures
  /// @param cell_size  mean [m]
  ThinWalls(const std::vector<StartSurface<dim>>& surfaces, std::vector<FacePair> pairs,
            double cell_size);
  /// Walls from all thin_pairs().
  ThinWalls(const std::vector<StartSurface<dim>>& surfaces, double cell_size)
      : ThinWalls(surfaces, thin_pairs(Faces<dim>(surfaces), cell_size), cell_size) {}

  // Both functions return warnings, and are collective.

  /// Warnings at the start: soil counts within four cells of a side.
  /// @param surfaces  as the constructor got them
  std::vector<std::string> at_start(MPI_Comm comm, const std::vector<StartSurface<dim>>& surfaces,
                                    const MaterialPoints<dim>& points);
  /// Warnings after a step: soil counts on a facet that it has been in contact with since the
  /// start, or was beside then.
  /// @param surfaces  the same ones, in the state that was accepted at this time [s]
  std::vector<std::string> after_step(MPI_Comm comm, const Surfaces<dim>& surfaces, double time);

 private:
  std::vector<std::string> found(MPI_Comm comm, std::vector<double> marks, const std::string& when);

  double cell_size_;
  std::vector<const ContactSettings<dim>*> settings_;
  std::vector<FacePair> pairs_;       // not told yet; of the simplices below
  std::vector<std::int32_t> which_;   // simplices that are in pairs, of all, ascending
  std::vector<std::size_t> surface_;  // of each of them
  std::vector<double> marks_;         // of each of them: 1 where soil of this rank has been
  std::map<std::size_t, std::vector<std::int32_t>> places_;  // in which_, by simplex of a surface
};

}  // namespace gabion::mpm
