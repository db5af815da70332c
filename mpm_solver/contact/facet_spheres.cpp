// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_spheres.hpp"

#include <algorithm>

namespace gabion::mpm {

namespace {

// Offset along the normal of a contact after the step, with which the gap stays what it was.
// Towards the surface a rigid sphere goes no farther than its radius beyond the place where it was
// laid. Where the contact opens, the sphere goes back as far as it stays free of contact: to its
// point, or up to the surface if it was laid there.
// @param laid  offset with which it was laid [m]
template <int dim>
double offset_after(const ContactCandidate<dim>& c, const ContactPoint<dim>& contact,
                    const Vector<dim>& laid) {
  const Vector<dim>& n = contact.feature.normal;
  const double offset = n.dot(c.offset + contact.motion - c.motion);
  if (c.deforms) return offset + (c.shape * (n + c.H.transpose() * n)).norm() - contact.radius;
  const double nearest = std::min(laid.dot(n), 0.0);
  if (contact.gap < 0) return std::max(offset, nearest - contact.radius);
  return std::max(offset - contact.gap - contact.initial_penetration, nearest);
}

// The deepest contact of a sphere is applied last: it decides where normals are not at right
// angles.
template <int dim>
void accept_offsets(FacetParts<dim>& parts) {
  parts.points.find_opened();
  const ContactPoints<dim>& points = parts.points;
  std::vector<const ContactPoint<dim>*> order;
  for (const auto* contacts : {&points.all(), &points.opened()}) {
    for (const ContactPoint<dim>& contact : *contacts) order.push_back(&contact);
  }
  std::stable_sort(
      order.begin(), order.end(),
      [](const ContactPoint<dim>* a, const ContactPoint<dim>* b) { return a->gap > b->gap; });
  auto& offsets = parts.memory.offsets();
  offsets.clear();
  for (const ContactPoint<dim>* contact : order) {
    const ContactCandidate<dim>& c = points.candidate(*contact);
    const Vector<dim>& n = contact->feature.normal;
    Vector<dim>& offset = offsets.try_emplace(c.id, c.offset).first->second;
    const Vector<dim> laid = parts.memory.laid_offset(c.id);
    offset += (offset_after(c, *contact, laid) - offset.dot(n)) * n;
  }
  std::erase_if(offsets, [](const auto& entry) { return entry.second.isZero(0); });
  std::erase_if(parts.memory.laid_offsets(),
                [&](const auto& entry) { return !offsets.contains(entry.first); });
}

}  // namespace

template <int dim>
void accept_spheres(FacetParts<dim>& parts) {
  accept_offsets(parts);
  auto& shapes = parts.memory.shapes();
  shapes.clear();
  for (const ContactCandidate<dim>& c : parts.search.candidates()) {
    if (c.deforms) shapes[c.id] = c.shape * (Matrix<dim>::Identity() + c.H).transpose();
  }
}

template void accept_spheres<2>(FacetParts<2>&);
template void accept_spheres<3>(FacetParts<3>&);

}  // namespace gabion::mpm
