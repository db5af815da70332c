// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/contact/facet_parts.hpp"

namespace gabion::mpm {

/// Offsets of the contact spheres of a step, and the shapes of those that deform, at its end: into
/// the memory. (docs/theory/interface.md)
template <int dim>
void accept_spheres(FacetParts<dim>& parts);

}  // namespace gabion::mpm
