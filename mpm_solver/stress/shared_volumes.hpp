// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mpm_solver/grid/cell_owners.hpp"
#include "mpm_solver/points/laws_of_points.hpp"
#include "mpm_solver/stress/softening_average.hpp"

namespace gabion::mpm {

/// Let the points of each group (those of one body in one cell or patch, on all ranks) have one
/// volumetric strain, so that the strains that they bring from other cells do not persist:
///
///     theta_p = tr eps_p + gap_p ,   theta = ln (sum_p V_p / sum_p V_p exp(-theta_p)) ,
///     eps_p <- eps_p + (theta - theta_p) / 3 ,   J_p <- J_p exp(theta - theta_p) ,
///
/// eps Hencky's elastic strain and gap what has opened at the apex. The group keeps its present
/// volume and, sum_p V_p exp(-theta_p), the one at which it is free of stress. The law returns the
/// new strain to its surface. Averaged increments (AveragedForces) keep one strain in a group; only
/// points that enter it, dilate or forget what they opened are changed here.
///
/// Saturated points share the pressure of their water instead, beyond that of water at rest, p_h at
/// their height:
///
///     c_p = content_p exp(-p_h / K_w) ,  m_p = J_p - 1 + n0 ,
///     m_p <- c_p sum_q V0_q m_q / sum_q V0_q c_q
///
/// The group keeps its volume and its water. The skeleton keeps the stress that its points
/// remember: without drainage effective stress belongs to the grains. A gap changes with ln J_p.
/// Water at rest under a level table stays as it is. Groups whose water cavitates share strains as
/// dry points do.
///
/// Points may have entered cells of other ranks: these ranks then exchange the sums of such groups.
///
/// @param laws      of the points, see LawsOfPoints
/// @param averages  of the bodies
/// @pre   the points are located; those outside the grid (cell -1) are left as they are
/// @returns elastic energy of all ranks' points that is lost by it [J]
/// @note  Collective.
template <int dim>
double share_volumes(const CellOwners<dim>& owners, const std::vector<Body<dim>>& bodies,
                     MaterialPoints<dim>& points, LawsOfPoints<dim> laws = {},
                     SofteningAverages averages = {});

}  // namespace gabion::mpm
