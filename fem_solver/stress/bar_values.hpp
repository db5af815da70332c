// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <vector>

#include "fem_solver/stress/cell_integrals.hpp"

namespace gabion::fem {

/// Force along each line of this rank over its area without stress [Pa].
template <int dim>
std::vector<double> line_stresses(const CellIntegrals<dim>& cells, std::span<const double> u,
                                  std::span<const double> history);

/// Sum of the size of plastic strains of each line of this rank; 0 where it does not yield.
template <int dim>
std::vector<double> line_plastic_strains(const CellIntegrals<dim>& cells,
                                         std::span<const double> history);

/// Largest shear force [N], bending moment at the ends of the beams and torque [N m].
template <int dim>
std::array<double, 3> largest_resultants(const BeamCells<dim>& beams, std::span<const double> u,
                                         std::span<const double> history);

}  // namespace gabion::fem
