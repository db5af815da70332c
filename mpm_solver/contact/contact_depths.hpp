// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mpm_solver/contact/contact_points.hpp"

namespace gabion::mpm {

/// Set the depths of the contact points of one material point, from number `first` to the last, and
/// their slips in springs of their parts. Where several push, the traction of all is
///
///     penalty g(|u|) u ,   u = sum_k lambda_k n_k the shortest displacement out,
///
/// of which each has its part, penalty g lambda_k; points without a part are removed. The
/// tangential stiffness of all is that of one, too: parts lambda_k delta_k / |u|^2 add up to 1.
/// (docs/theory/interface.md)
template <int dim>
void share_depths(const FacetLaws<dim>& laws, const ContactCandidate<dim>& c, std::size_t first,
                  std::vector<ContactPoint<dim>>& points);

}  // namespace gabion::mpm
