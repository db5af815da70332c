// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "common/run/solver.hpp"
#include "coupler/mapping/interface_layout.hpp"

namespace gabion {

/// Put the displacements with which a structure begins in their place in a vector; other entries
/// stay.
void put_start(const Solver& structure, const InterfaceLayout& layout, Eigen::VectorXd& x);

/// Tell a soil where its interfaces begin, if any of them begins displaced. Warns of one that does
/// not take it.
/// @param u  of all soils
void tell_start(Solver& soil, const InterfaceLayout& layout, const Eigen::VectorXd& u);

}  // namespace gabion
