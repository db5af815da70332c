// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/boulder_ledger.hpp"

#include <fmt/format.h>

namespace gabion::mpm {

void BoulderLedger::add_step(const HardContact& contact, const HardContact::Start& start,
                             const HardContact::Step& step, const HardContact::End& end,
                             const Vector<3>& gravity) {
  for (std::size_t c = 0; c < contact.bodies().size(); ++c) {
    const Vector<3> dx = end.states[c].x - start.states[c].x;
    gravity_work_ += step.gravity_share * contact.bodies()[c].mass.mass * gravity.dot(dx);
    soil_work_ += end.load_works[c];
    contact_work_ += end.works[c];
  }
  for (std::size_t o = 0; o < step.obstacles.size(); ++o) {
    const Obstacle& obstacle = step.obstacles[o];
    const auto& forces = end.nodal_forces[o];
    for (std::size_t v = 0; v < forces.size(); ++v) {
      surface_work_ += forces[v].dot(obstacle.end[v] - obstacle.start[v]);
    }
  }
}

std::vector<std::string> BoulderLedger::names(int dim) {
  std::vector<std::string> names;
  for (const char* part :
       {"kinetic_energy", "gravity_work", "soil_work", "surface_work", "contact_loss"}) {
    names.push_back(fmt::format("boulders_{}", part));
  }
  for (int d = 0; d < dim; ++d) names.push_back(fmt::format("boulders_momentum_{}", "xyz"[d]));
  return names;
}

std::vector<double> BoulderLedger::values(int dim, const HardContact& contact,
                                          const HardContact::Start& now) const {
  double kinetic = 0;
  Vector<3> momentum = Vector<3>::Zero();
  for (std::size_t c = 0; c < contact.bodies().size(); ++c) {
    const BodyMass& mass = contact.bodies()[c].mass;
    kinetic += kinetic_energy(mass, now.states[c]);
    momentum += mass.mass * now.states[c].v;
  }
  const double loss = -contact_work_ - surface_work_ - contact.stored_energy(now.memories);
  std::vector<double> values = {kinetic, gravity_work_, soil_work_, surface_work_, loss};
  values.insert(values.end(), momentum.data(), momentum.data() + dim);
  return values;
}

void BoulderLedger::visit_state(StateVisitor& visitor) {
  visitor.real("boulders.gravity_work", gravity_work_);
  visitor.real("boulders.soil_work", soil_work_);
  visitor.real("boulders.contact_work", contact_work_);
  visitor.real("boulders.surface_work", surface_work_);
}

}  // namespace gabion::mpm
