// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/report/contact_output.hpp"

#include <cmath>
#include <limits>

#include "common/mechanics/mesh/boundary.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/points/flat.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
std::vector<OutputField> output_fields(const ContactFrame<dim>& frame) {
  return {{"pressure", 1, frame.pressure, true},
          {"shear", dim, frame.shear, true},
          {"gap", 1, frame.gap, true},
          {"slip", dim, frame.slip, true},
          {"status", 1, frame.status, true}};
}

template <int dim>
std::vector<const ContactSettings<dim>*> all_surfaces(const MpmSettings<dim>& settings) {
  std::vector<const ContactSettings<dim>*> all;
  for (const auto& interface : settings.interfaces) all.push_back(&interface);
  for (const auto& wall : settings.rigid_walls) all.push_back(&wall.boundary);
  return all;
}

}  // namespace

template <int dim>
ContactFrame<dim> contact_frame(const ContactSurface<dim>& surface,
                                const ContactFields<dim>& fields) {
  const auto geometry =
      facet_geometry<dim>(fields.vertices, surface.facet_type, std::span(surface.facets));
  ContactFrame<dim> frame;
  frame.status = fields.status;
  for (std::size_t f = 0; f < geometry.size(); ++f) {
    const Vector<dim>& n = geometry[f].normal;
    const double push = -fields.force[f].dot(n);
    frame.pressure.push_back(push / geometry[f].area);
    const Vector<dim> shear = (fields.force[f] + push * n) / geometry[f].area;
    frame.shear.insert(frame.shear.end(), shear.begin(), shear.end());
    Vector<dim> slip = Vector<dim>::Zero();
    if (fields.area[f] > 0) slip = fields.slip[f] / fields.area[f];
    frame.slip.insert(frame.slip.end(), slip.begin(), slip.end());
    const bool known = std::isfinite(fields.gap[f]);
    frame.gap.push_back(known ? fields.gap[f] : std::numeric_limits<double>::quiet_NaN());
  }
  return frame;
}

template <int dim>
ContactOutput<dim>::ContactOutput(const SoilModel<dim>& model, const std::string& folder)
    : model_(model), writes_(!folder.empty()) {
  if (!writes_ || rank_of(model.comm) != 0) return;
  for (const auto* surface : all_surfaces(model.settings)) {
    series_.emplace_back(folder, "contact_" + surface->name);
  }
}

template <int dim>
void ContactOutput<dim>::write(double time, const SoilState<dim>& state) {
  if (!writes_) return;
  for (std::size_t k = 0; k < state.surfaces.size(); ++k) {
    const auto fields = state.surfaces.fields(k, state.points, model_.cell_size);
    if (series_.empty()) continue;
    const ContactSurface<dim>& surface = state.surfaces.settings(k).surface;
    const auto frame = contact_frame<dim>(surface, fields);
    series_[k].write({.time = time,
                      .dim = dim,
                      .coordinates = flat(fields.vertices),
                      .cell_type = surface.facet_type,
                      .connectivity = surface.facets,
                      .fields = output_fields<dim>(frame)});
  }
}

template <int dim>
std::int64_t ContactOutput<dim>::frame_bytes(const MpmSettings<dim>& settings) {
  std::int64_t bytes = 0;
  for (const auto* surface : all_surfaces(settings)) {
    const ContactSurface<dim>& of = surface->surface;
    bytes += XdmfSeries::frame_bytes(std::ssize(of.vertices), of.facet_type,
                                     std::ssize(of.facets) / num_nodes(of.facet_type),
                                     output_fields<dim>({}));
  }
  return bytes;
}

template ContactFrame<2> contact_frame<2>(const ContactSurface<2>&, const ContactFields<2>&);
template ContactFrame<3> contact_frame<3>(const ContactSurface<3>&, const ContactFields<3>&);
template class ContactOutput<2>;
template class ContactOutput<3>;

}  // namespace gabion::mpm
