// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/ledger.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

using Nodal = std::span<const double>;

template <int dim>
Eigen::Map<const Vector<dim>> at(Nodal field, std::int32_t i) {
  return Eigen::Map<const Vector<dim>>(field.data() + static_cast<std::size_t>(i) * dim);
}

// Body force at the instant of the balance, num_nodes x dim.
template <int dim>
std::vector<double> body_forces(const Equilibrium<dim>& equilibrium) {
  const auto& parts = equilibrium.parts();
  const auto& mass = equilibrium.inertia_mass();
  std::vector<double> f(mass.size() * dim);
  for (std::size_t k = 0; k < f.size(); ++k) {
    f[k] = mass[k / dim] *
           parts.scheme.mean_force(parts.gravity[k % dim], parts.gravity_start[k % dim]);
    if (parts.f_body.empty()) continue;
    const double start = parts.f_body_start.empty() ? parts.f_body[k] : parts.f_body_start[k];
    f[k] += parts.scheme.mean_force(parts.f_body[k], start);
  }
  return f;
}

/// Forces of contacts whose force is constant in a step; num_nodes x dim, on the nodes of this
/// step.
struct StepForces {
  std::vector<double> now, before;  // of this step and of the one before
};

// Add the forces of this rank's contacts. Those that balance at the end of the step are subtracted
// from `forces`, the others go to `constant`.
template <int dim>
void add_contact_terms(const Equilibrium<dim>& equilibrium, Nodal du, StepBalance<dim>& step,
                       std::vector<double>& forces, StepForces& constant) {
  const auto& parts = equilibrium.parts();
  const double extra = parts.with_inertia ? parts.scheme.step_force_weight() - 1 : 0;
  std::vector<double> f(du.size()), change(du.size());
  for (const auto& contact : parts.contacts) {
    std::fill(f.begin(), f.end(), 0.0);
    contact->assembly().add_forces(du, f, nullptr);
    const double work = contact->assembly().work_on_soil(du);
    step.boundary_work += work;
    step.time_damping += work;
    for (std::size_t k = 0; k < du.size(); ++k) step.time_damping -= du[k] * f[k];
    if (!contact->assembly().is_step_force()) {
      for (std::int32_t i = 0; i < parts.nodes.size(); ++i) {
        step.boundary_force += at<dim>(Nodal(f), i);
      }
      for (std::size_t k = 0; k < du.size(); ++k) forces[k] -= f[k];
      continue;
    }
    for (std::size_t k = 0; k < contact->num_members(); ++k) {
      step.step_force -= contact->results().resultant(k).force;
    }
    std::fill(change.begin(), change.end(), 0.0);
    contact->assembly().add_step_force_change(change);
    for (std::size_t k = 0; k < du.size(); ++k) {
      constant.now[k] += f[k] - extra * change[k];
      constant.before[k] += f[k] - (extra + 1) * change[k];
    }
  }
}

// Add the terms of the nodes that this rank owns. `forces` gets inertia - body force, which
// contacts, walls and internal forces have to carry.
template <int dim>
void add_nodal_terms(const Equilibrium<dim>& equilibrium, Nodal du, const NodalMotion<dim>& motion,
                     StepBalance<dim>& step, std::vector<double>& forces) {
  const auto& parts = equilibrium.parts();
  const auto& nodes = parts.nodes;
  const std::vector<double> f_body = body_forces(equilibrium);
  for (std::int32_t i = 0; i < nodes.size(); ++i) {
    if (!nodes.shared.owns(i)) continue;
    const auto v = at<dim>(equilibrium.start_velocity(), i);
    const auto a = at<dim>(equilibrium.start_acceleration(), i);
    const auto body = at<dim>(f_body, i), move = at<dim>(du, i);
    Vector<dim> inertia;
    for (int d = 0; d < dim; ++d) {
      const double a_new = parts.scheme.acceleration(move[d], v[d], a[d], parts.dt);
      inertia[d] = parts.with_inertia
                       ? equilibrium.inertia_mass()[i] * parts.scheme.mean_acceleration(a_new, a[d])
                       : 0;
    }
    const double half_mass = 0.5 * nodes.m[i];
    const double stopped = half_mass * (nodes.v[i].squaredNorm() - v.squaredNorm());
    const double after = half_mass * motion.v_new[i].squaredNorm();
    step.kinetic_before += half_mass * nodes.v[i].squaredNorm();
    step.wall_loss += stopped;
    step.kinetic_after += after;
    step.time_damping += move.dot(inertia) - after + half_mass * v.squaredNorm();
    step.body_work += move.dot(body);
    step.body_force += body;
    step.wall_kick += nodes.m[i] * (v - nodes.v[i]);
    step.wall_hold += nodes.m[i] * (a - nodes.a[i]);
    Eigen::Map<Vector<dim>>(forces.data() + std::ptrdiff_t{i} * dim) = inertia - body;
  }
}

}  // namespace

template <int dim>
void sum_parts(MPI_Comm comm, StepBalance<dim>& step) {
  double* const scalars[] = {&step.kinetic_before, &step.kinetic_after, &step.wall_loss,
                             &step.time_damping,   &step.body_work,     &step.boundary_work};
  Vector<dim>* const vectors[] = {
      &step.body_force, &step.boundary_force, &step.step_force,      &step.wall_force,
      &step.wall_kick,  &step.wall_hold,      &step.wall_step_force, &step.wall_step_force_start};
  std::vector<double> all;
  for (const double* value : scalars) all.push_back(*value);
  for (const Vector<dim>* value : vectors) all.insert(all.end(), value->begin(), value->end());
  sum_over_ranks(comm, std::span<double>(all));
  const double* next = all.data();
  for (double* value : scalars) *value = *next++;
  for (Vector<dim>* value : vectors) {
    *value = Eigen::Map<const Vector<dim>>(next);
    next += dim;
  }
}

template <int dim>
StepBalance<dim> step_balance(const Equilibrium<dim>& equilibrium, std::span<const double> du,
                              const NodalMotion<dim>& motion) {
  const auto& parts = equilibrium.parts();
  StepBalance<dim> step;
  std::vector<double> forces(du.size(), 0.0);
  StepForces constant{.now = forces, .before = forces};
  add_nodal_terms(equilibrium, du, motion, step, forces);
  add_contact_terms(equilibrium, du, step, forces, constant);

  std::vector<double> f_int = equilibrium.internal_forces().forces();
  for (std::size_t k = 0; k < parts.f_pore.size(); ++k) f_int[k] -= parts.f_pore[k];
  const std::vector<double> f_int_start = equilibrium.internal_forces().start_forces();
  std::vector<double> lead(du.size());  // of the balance's internal force over its mean in the step
  for (std::size_t k = 0; k < du.size(); ++k) {
    const double mean = parts.scheme.mean_force(f_int[k], f_int_start[k]);
    lead[k] = mean - 0.5 * (f_int[k] + f_int_start[k]);
    step.time_damping += du[k] * lead[k];
    forces[k] += mean;
  }
  if (parts.ghost != nullptr) {
    std::vector<double> f_ghost(du.size(), 0.0);
    parts.ghost->add_forces(du, f_ghost, nullptr);
    for (std::size_t k = 0; k < du.size(); ++k) {
      step.time_damping -= du[k] * f_ghost[k];
      forces[k] -= f_ghost[k];
    }
  }
  for (std::size_t c = 0; c < parts.walls.constrained().size(); ++c) {
    const std::int32_t i = parts.walls.constrained()[c];
    const Matrix<dim> held = Matrix<dim>::Identity() - parts.walls.projectors()[c];
    const Vector<dim> force = held * at<dim>(forces, i);
    const Vector<dim> constant_force = -held * at<dim>(constant.now, i);
    step.wall_force += force;
    step.wall_step_force += constant_force;
    step.wall_step_force_start -= held * at<dim>(constant.before, i);
    const Vector<dim> move = held * at<dim>(du, i);
    step.boundary_work += (force + constant_force - at<dim>(lead, i)).dot(move);
    step.time_damping -= move.dot(at<dim>(lead, i));
  }
  sum_parts(parts.comm, step);
  return step;
}

template <int dim>
void Ledger<dim>::Force::add_step(const Vector<dim>& mean, const NewmarkBossak& scheme, double dt) {
  for (int d = 0; d < dim; ++d) {
    const double next = (mean[d] - scheme.alpha_m * inertia[d]) / (1 - scheme.alpha_m);
    impulse[d] += scheme.velocity(next, 0, inertia[d], dt);
    inertia[d] = next;
  }
}

template <int dim>
void Ledger<dim>::start(const MaterialPoints<dim>& points) {
  *this = Ledger(comm_);
  totals_ = totals_start_ = point_totals(comm_, points);
  std::vector<double> inertia(dim, 0.0);
  for (std::int32_t p = 0; p < points.size(); ++p) {
    for (int d = 0; d < dim; ++d) inertia[d] += points.m[p] * points.a[p][d];
  }
  sum_over_ranks(comm_, std::span<double>(inertia));
  body_.inertia = Eigen::Map<const Vector<dim>>(inertia.data());
  lowest_energy_ = own_energy();
}

template <int dim>
void Ledger<dim>::add_step(const StepBalance<dim>& step, const NewmarkBossak& scheme, double dt,
                           double dissipated, const MaterialPoints<dim>& points) {
  const PointTotals<dim> before = totals_;
  totals_ = point_totals(comm_, points);
  double of_points[] = {dissipated, step.quadrature_loss};
  sum_over_ranks(comm_, std::span<double>(of_points));
  plastic_ += of_points[0];
  quadrature_loss_ += of_points[1];
  time_damping_ += step.time_damping;
  wall_loss_ += step.wall_loss;
  transfer_loss_ += (before.kinetic_energy - step.kinetic_before) -
                    (totals_.kinetic_energy - step.kinetic_after) + step.sharing_loss;
  body_work_ += step.body_work;
  boundary_work_ += step.boundary_work;
  // The mapped acceleration still contains the part of the previous step's contact force that the
  // walls did not hold; the scheme subtracts that part as projected on the nodes of this step. The
  // difference goes to the walls.
  walls_.inertia += step.wall_hold + wall_step_force_ - step.wall_step_force_start;
  wall_step_force_ = step.wall_step_force;
  walls_.impulse += step.wall_kick;
  boundary_.impulse += dt * step.step_force;
  walls_.impulse += dt * step.wall_step_force;
  body_.add_step(step.body_force, scheme, dt);
  boundary_.add_step(step.boundary_force, scheme, dt);
  walls_.add_step(step.wall_force, scheme, dt);
  lowest_energy_ = std::min(lowest_energy_, own_energy());
  created_ = std::max(created_, own_energy() - lowest_energy_);
}

template <int dim>
void Ledger<dim>::remove(const MaterialPoints<dim>& points, const Vector<dim>& inertia) {
  const PointTotals<dim> before = totals_;
  totals_ = point_totals(comm_, points);
  removed_.mass += before.mass - totals_.mass;
  removed_.kinetic_energy += before.kinetic_energy - totals_.kinetic_energy;
  removed_.elastic_energy += before.elastic_energy - totals_.elastic_energy;
  removed_.momentum += before.momentum - totals_.momentum;
  body_.inertia -= inertia;  // only the sum over the forces counts
}

template <int dim>
double Ledger<dim>::own_energy() const {
  return totals_.kinetic_energy + totals_.elastic_energy + removed_.kinetic_energy +
         removed_.elastic_energy + plastic_ - body_work_ - boundary_work_;
}

template <int dim>
std::vector<std::string> Ledger<dim>::names() {
  std::vector<std::string> names = {
      "plastic_dissipation", "time_damping",  "transfer_loss",  "wall_loss",      "quadrature_loss",
      "gravity_work",        "boundary_work", "energy_balance", "created_energy", "contact_energy",
      "contact_friction",    "contact_loss",  "contact_created"};
  for (int d = 0; d < dim; ++d) names.push_back(fmt::format("momentum_error_{}", "xyz"[d]));
  return names;
}

template <int dim>
std::vector<double> Ledger<dim>::values() const {
  const double energy_start = totals_start_.kinetic_energy + totals_start_.elastic_energy;
  const double balance =
      own_energy() - energy_start + time_damping_ + transfer_loss_ + wall_loss_ + quadrature_loss_;
  std::vector<double> values = {plastic_,         time_damping_,   transfer_loss_,    wall_loss_,
                                quadrature_loss_, body_work_,      boundary_work_,    balance,
                                created_,         contact_.stored, contact_.friction, contact_.loss,
                                contact_created_};
  const Vector<dim> error = totals_.momentum + removed_.momentum - totals_start_.momentum -
                            body_.impulse - boundary_.impulse - walls_.impulse;
  values.insert(values.end(), error.begin(), error.end());
  return values;
}

template <int dim>
void Ledger<dim>::visit_state(StateVisitor& visitor) {
  const std::pair<const char*, PointTotals<dim>*> parts[] = {
      {"totals.", &totals_}, {"start.", &totals_start_}, {"removed.", &removed_}};
  for (const auto& [part, totals] : parts) {
    const std::string name = std::string("ledger.") + part;
    visitor.real(name + "mass", totals->mass);
    visitor.reals(name + "momentum", {totals->momentum.data(), dim});
    visitor.real(name + "kinetic_energy", totals->kinetic_energy);
    visitor.real(name + "elastic_energy", totals->elastic_energy);
    visitor.reals(name + "front", totals->front);
  }
  const std::pair<const char*, Force*> forces[] = {
      {"ledger.body.", &body_}, {"ledger.boundary.", &boundary_}, {"ledger.walls.", &walls_}};
  for (const auto& [name, force] : forces) {
    visitor.reals(std::string(name) + "inertia", {force->inertia.data(), dim});
    visitor.reals(std::string(name) + "impulse", {force->impulse.data(), dim});
  }
  visitor.reals("ledger.walls.step_force", {wall_step_force_.data(), dim});
  const std::pair<const char*, double*> sums[] = {{"plastic", &plastic_},
                                                  {"time_damping", &time_damping_},
                                                  {"transfer_loss", &transfer_loss_},
                                                  {"wall_loss", &wall_loss_},
                                                  {"quadrature_loss", &quadrature_loss_},
                                                  {"body_work", &body_work_},
                                                  {"boundary_work", &boundary_work_},
                                                  {"lowest_energy", &lowest_energy_},
                                                  {"created", &created_},
                                                  {"contact_stored", &contact_.stored},
                                                  {"contact_friction", &contact_.friction},
                                                  {"contact_loss", &contact_.loss},
                                                  {"contact_created", &contact_created_}};
  for (const auto& [name, value] : sums) visitor.real(std::string("ledger.") + name, *value);
}

template void sum_parts<2>(MPI_Comm, StepBalance<2>&);
template void sum_parts<3>(MPI_Comm, StepBalance<3>&);
template StepBalance<2> step_balance<2>(const Equilibrium<2>&, std::span<const double>,
                                        const NodalMotion<2>&);
template StepBalance<3> step_balance<3>(const Equilibrium<3>&, std::span<const double>,
                                        const NodalMotion<3>&);
template class Ledger<2>;
template class Ledger<3>;

}  // namespace gabion::mpm
