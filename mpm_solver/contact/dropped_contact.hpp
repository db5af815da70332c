// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/contact/contact.hpp"
#include "mpm_solver/contact/moving_surface.hpp"

namespace gabion::mpm {

/// A surface that no longer acts: soil passes it. It keeps the energies of the contact it was; what
/// its springs held is lost.
template <int dim>
class DroppedContact final : public WholeContact<dim> {
 public:
  DroppedContact(const ContactSettings<dim>& settings, const ContactEnergy& energy)
      : surface_(settings.surface),
        energy_{.friction = energy.friction, .loss = energy.loss + energy.stored} {}

  void begin_step(const SoilSurface<dim>&) override {}
  bool can_touch(std::size_t = 0) const override { return false; }
  bool symmetric() const override { return true; }
  void append_cells(std::vector<std::int32_t>&, std::vector<std::int32_t>&) const override {}
  void set_displacement(std::span<const double> displacement, std::size_t = 0) override {
    surface_.set_displacement(displacement);
  }
  void add_forces(std::span<const double>, std::span<double>, BlockMatrix<dim>*) override {}
  std::vector<double> forces_on_structure(std::size_t = 0) const override {
    return std::vector<double>(surface_.num_vertices() * dim, 0.0);
  }
  ContactResultant<dim> resultant(std::size_t = 0) const override { return {}; }
  double work_on_soil(std::span<const double>) const override { return 0; }
  ContactCounts counts(std::size_t = 0) const override { return {}; }
  double approach_step(double, double) const override {
    return std::numeric_limits<double>::infinity();
  }
  void accept() override {}
  ContactEnergy energy() const override { return energy_; }
  ContactFields<dim> fields(const MaterialPoints<dim>&, double, std::size_t = 0) const override {
    return {surface_.positions(), surface_.num_facets()};
  }
  std::span<const ContactMark<dim>> marks(std::size_t = 0) const override { return {}; }
  void visit_state(StateVisitor& visitor, const std::string& prefix) override {
    visitor.share(prefix + "friction", energy_.friction);
    visitor.share(prefix + "loss", energy_.loss);
  }

 private:
  MovingSurface<dim> surface_;
  ContactEnergy energy_;
};

}  // namespace gabion::mpm
