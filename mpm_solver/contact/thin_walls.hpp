// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <map>
#include <span>
#include <string>
#include <vector>

#include "mpm_solver/contact/body_groups.hpp"
#include "mpm_solver/contact/start_check.hpp"
#include "mpm_solver/contact/surfaces.hpp"
#include "mpm_solver/contact/thin_pairs.hpp"

namespace gabion::mpm {

/// Finds structures thinner than two cells that have soil on both sides: that soil shares nodes of
/// the grid, so it acts on itself through the structure. Each pair of surfaces (or one surface)
/// with such faces is reported once, unless SideFields cures it or the soils of both sides are of
/// different BodyGroups. Surfaces of the mode `fixed`, to which soil sticks on all sides, are left
/// out. Refers to the settings of the surfaces.
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
                                    const MaterialPoints<dim>& points, const BodyGroups& groups);
  /// Warnings after a step: soil counts on a facet that it has been in contact with since the
  /// start, or was beside then; with groups only while soil of one of them is within four cells of
  /// both sides.
  /// @param surfaces, points  in the state that was accepted at this time [s]; the same surfaces
  std::vector<std::string> after_step(MPI_Comm comm, const Surfaces<dim>& surfaces, double time,
                                      const MaterialPoints<dim>& points, const BodyGroups& groups);

 private:
  std::vector<double> marks_by_group(const Faces<dim>& faces, const MaterialPoints<dim>& points,
                                     const BodyGroups& groups) const;
  Faces<dim> faces_now(const Surfaces<dim>& surfaces) const;
  std::vector<std::string> found(std::span<const double> marks, std::span<const double> by_group,
                                 const std::string& when);

  double cell_size_;
  std::vector<const ContactSettings<dim>*> settings_;
  std::vector<FacePair> pairs_;       // not told yet; of the simplices below
  std::vector<std::int32_t> which_;   // simplices that are in pairs, of all, ascending
  std::vector<std::size_t> surface_;  // of each of them
  std::vector<double> marks_;         // of each of them: 1 where soil of this rank has been
  std::map<std::size_t, std::vector<std::int32_t>> places_;  // in which_, by simplex of a surface
};

}  // namespace gabion::mpm
