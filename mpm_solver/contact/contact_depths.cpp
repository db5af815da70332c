// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/contact_depths.hpp"

#include <cmath>

#include "mpm_solver/contact/shortest_exit.hpp"

namespace gabion::mpm {

namespace {

// The old slip in springs of the present stiffness. Springs that became softer keep the slip,
// springs that became stiffer keep its force: neither hold more energy than before.
template <int dim>
void follow_part(ContactPoint<dim>& contact) {
  if (contact.part <= contact.old_part) {
    contact.slip += contact.old_slip;
    return;
  }
  const double kept = contact.old_part / contact.part;
  contact.slip += kept * contact.old_slip;
  contact.slip_part_slope = -kept / contact.part * contact.old_slip;
}

}  // namespace

template <int dim>
void share_depths(const FacetLaws<dim>& laws, const ContactCandidate<dim>& c, std::size_t first,
                  std::vector<ContactPoint<dim>>& points) {
  if (points.size() == first) return;
  if (points.size() == first + 1) {
    ContactPoint<dim>& contact = points.back();
    const double depth = -contact.gap;
    const ContactLaw law = laws.law_of(c, contact.owner, 1);
    const double reduced = law.reduced(depth);
    contact.depth = std::sqrt(depth * reduced);
    const bool is_linear = depth > law.linear_from;
    contact.stored_depth = is_linear ? std::cbrt(law.storing(depth) * depth * depth) : depth;
    contact.num_others = 1;
    contact.others[0] = static_cast<std::int32_t>(first);
    contact.shares[0] = (reduced + law.reduced_slope(depth) * depth) / (2 * contact.depth);
    follow_part(contact);
    return;
  }
  std::vector<Vector<dim>> normals;
  std::vector<double> deltas;
  for (std::size_t k = first; k < points.size(); ++k) {
    normals.push_back(points[k].feature.normal);
    deltas.push_back(-points[k].gap);
  }
  const ShortestExit<dim> out = shortest_exit<dim>(normals, deltas);
  for (int k = 0; k < out.size; ++k) {
    ContactPoint<dim> contact = points[first + out.planes[k]];  // planes ascend
    const ContactLaw law = laws.law_of(c, contact.owner, 1);
    const double reduced = law.reduced(out.length), slope = law.reduced_slope(out.length);
    contact.depth = std::sqrt(out.depths[k] * reduced);
    contact.stored_depth = std::cbrt(law.storing(out.length) * out.depths[k] * -contact.gap);
    contact.num_others = out.size;
    const double square = out.length * out.length;
    contact.part = out.depths[k] * -contact.gap / square;
    for (int l = 0; l < out.size; ++l) {
      contact.part_slopes[l] = (out.inverse(k, l) * -contact.gap + (k == l ? out.depths[k] : 0) -
                                2 * contact.part * out.depths[l]) /
                               square;
      contact.others[l] = static_cast<std::int32_t>(first) + l;
      contact.shares[l] =
          (reduced * out.inverse(k, l) + slope * out.depths[k] * out.depths[l] / out.length) /
          (2 * contact.depth);
    }
    follow_part(contact);
    points[first + k] = contact;
  }
  points.resize(first + out.size);
}

template void share_depths<2>(const FacetLaws<2>&, const ContactCandidate<2>&, std::size_t,
                              std::vector<ContactPoint<2>>&);
template void share_depths<3>(const FacetLaws<3>&, const ContactCandidate<3>&, std::size_t,
                              std::vector<ContactPoint<3>>&);

}  // namespace gabion::mpm
