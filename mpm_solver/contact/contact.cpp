// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/contact.hpp"

#include "mpm_solver/contact/boundary_points.hpp"
#include "mpm_solver/contact/facet_contact.hpp"

namespace gabion::mpm {

void ContactEnergy::add_step(double work, double stored_now, double slid) {
  loss += work - (stored_now - stored) - slid;
  friction += slid;
  stored = stored_now;
}

namespace {

/// One overload a method.
template <int dim>
struct ContactMaker {
  const ContactSettings<dim>& settings;

  std::unique_ptr<Contact<dim>> operator()(const BoundaryPointSettings& method) const {
    return std::make_unique<BoundaryPoints<dim>>(settings, method);
  }
  std::unique_ptr<Contact<dim>> operator()(const FacetSettings&) const {
    return make_joint_contact<dim>({&settings});
  }
};

}  // namespace

template <int dim>
std::unique_ptr<Contact<dim>> make_contact(const ContactSettings<dim>& settings) {
  return std::visit(ContactMaker<dim>{settings}, settings.method);
}

template <int dim>
std::unique_ptr<Contact<dim>> make_joint_contact(
    const std::vector<const ContactSettings<dim>*>& members) {
  return std::make_unique<FacetContact<dim>>(members);
}

template <int dim>
InterfaceMesh interface_mesh(const ContactSettings<dim>& settings) {
  InterfaceMesh mesh;
  mesh.name = settings.name;
  mesh.dim = dim;
  if (std::holds_alternative<FacetSettings>(settings.method)) {
    mesh.force_kind = ForceKind::step_mean;
  }
  mesh.vertices_per_facet = num_nodes(settings.surface.facet_type);
  for (const auto& x : settings.surface.vertices) {
    mesh.coordinates.insert(mesh.coordinates.end(), x.data(), x.data() + dim);
  }
  mesh.facets.assign(settings.surface.facets.begin(), settings.surface.facets.end());
  return mesh;
}

template std::unique_ptr<Contact<2>> make_contact<2>(const ContactSettings<2>&);
template std::unique_ptr<Contact<3>> make_contact<3>(const ContactSettings<3>&);
template std::unique_ptr<Contact<2>> make_joint_contact<2>(
    const std::vector<const ContactSettings<2>*>&);
template std::unique_ptr<Contact<3>> make_joint_contact<3>(
    const std::vector<const ContactSettings<3>*>&);
template InterfaceMesh interface_mesh<2>(const ContactSettings<2>&);
template InterfaceMesh interface_mesh<3>(const ContactSettings<3>&);

}  // namespace gabion::mpm
