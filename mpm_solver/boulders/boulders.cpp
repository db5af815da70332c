// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/boulders.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/error.hpp"
#include "mpm_solver/contact/surface_features.hpp"

namespace gabion::mpm {

namespace {

constexpr int most_passes = 25;

template <int dim>
Vector<3> in_space(const Vector<dim>& x) {
  Vector<3> result = Vector<3>::Zero();
  result.template head<dim>() = x;
  return result;
}

template <int dim>
std::vector<HardFacet> hard_facets(const ContactSurface<dim>& surface) {
  std::vector<HardFacet> facets;
  for (const Simplex<dim>& simplex : simplices(surface)) {
    HardFacet& facet = facets.emplace_back(HardFacet{-1, -1, -1});
    std::copy(simplex.begin(), simplex.end(), facet.begin());
  }
  return facets;
}

template <int dim>
std::vector<HardBody> hard_bodies(const BoulderScene<dim>& settings) {
  std::vector<HardBody> bodies;
  for (const auto& boulder : settings.boulders) {
    const auto& shape = boulder.shape;
    HardBody& body = bodies.emplace_back(HardBody{.name = boulder.name,
                                                  .mass = shape.mass,
                                                  .sphere = shape.sphere,
                                                  .radius = shape.radius,
                                                  .axes = in_space<dim>(shape.axes)});
    body.law = boulder.law;
    body.facets = hard_facets(shape.surface);
    for (const auto& X : shape.surface.vertices) body.vertices.push_back(in_space<dim>(X));
  }
  return bodies;
}

template <int dim>
std::vector<Vector<3>> places(const std::vector<Vector<dim>>& vertices,
                              std::span<const double> displacement) {
  std::vector<Vector<3>> result;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    Vector<dim> x = vertices[v];
    if (!displacement.empty()) x += Eigen::Map<const Vector<dim>>(displacement.data() + v * dim);
    result.push_back(in_space<dim>(x));
  }
  return result;
}

}  // namespace

template <int dim>
Boulders<dim>::Boulders(const BoulderScene<dim>& settings)
    : settings_(settings),
      contact_(dim, hard_bodies(settings), in_space<dim>(settings.gravity),
               static_cast<int>(settings.interfaces.size())),
      last_loads_(settings.boulders.size()),
      works_(settings.boulders.size(), 0.0) {
  if (empty()) return;
  grid_ = bounding_box(settings.grid);
  for (const auto& boulder : settings.boulders) accepted_.states.push_back(boulder.start);
  for (const auto& interface : settings.interfaces)
    facets_.push_back(hard_facets(interface.surface));
  for (const auto& wall : settings.rigid_walls) {
    facets_.push_back(hard_facets(wall.boundary.surface));
  }
  for (const auto& interface : settings.interfaces) {
    interface_places_.push_back(places<dim>(interface.surface.vertices, {}));
  }
  const auto boulders =
      std::ranges::count_if(settings.rigid_walls, [](const auto& wall) { return wall.is_boulder; });
  forces_.assign(facets_.size() - static_cast<std::size_t>(boulders), Vector<3>::Zero());
}

// The surfaces that boulders may meet: interfaces, then rigid walls that are no boulders.
template <int dim>
Obstacle Boulders<dim>::obstacle(std::size_t surface) const {
  Obstacle result{.facets = facets_[surface]};
  if (surface < num_interfaces()) {
    result.start = result.end = interface_places_[surface];
    return result;
  }
  const auto& wall = settings_.rigid_walls[surface - num_interfaces()];
  const auto& vertices = wall.boundary.surface.vertices;
  result.start = result.end = places<dim>(vertices, wall.motion.displacement(vertices, 0));
  return result;
}

// An empty surface acts no more.
template <int dim>
Obstacle Boulders<dim>::obstacle_in_step(std::size_t surface, const Request& request) const {
  Obstacle result = obstacle(surface);
  if (surface < num_interfaces()) {
    const auto& settings = settings_.interfaces[surface];
    const auto found = request.received->find(settings.name);
    const bool moves = found != request.received->end();
    result.end =
        places<dim>(settings.surface.vertices,
                    moves ? std::span<const double>(found->second) : std::span<const double>());
    return result;
  }
  const auto& wall = settings_.rigid_walls[surface - num_interfaces()];
  const auto& acting = request.phase->rigid_walls;
  if (acting && std::ranges::find(*acting, wall.name) == acting->end()) return {};
  const auto& vertices = wall.boundary.surface.vertices;
  result.start = places<dim>(vertices, wall.motion.displacement(vertices, request.time));
  result.end = places<dim>(vertices, wall.motion.displacement(vertices, request.time + request.dt));
  return result;
}

template <int dim>
void Boulders<dim>::begin(const Request& request) {
  dt_ = request.dt;
  tolerance_ = request.tolerance;
  passes_ = 0;
  relaxation_ = {};
  step_ = {.dt = dt_,
           .gravity_share = request.phase->gravity_ramp.at(request.time + 0.5 * dt_),
           .loads = last_loads_};
  for (const auto& boulder : settings_.boulders) {
    const bool held = request.time < boulder.free_from - 1e-9 * request.dt;
    step_.held.push_back(held ? 1 : 0);
  }
  for (std::size_t k = 0; k < num_interfaces() + first_wall(); ++k) {
    step_.obstacles.push_back(obstacle_in_step(k, request));
  }
  end_ = contact_.solve(accepted_, step_);
}

template <int dim>
void Boulders<dim>::place(Surfaces<dim>& surfaces) const {
  for (std::size_t b = 0; b < contact_.bodies().size(); ++b) {
    std::vector<double> displacement;
    const auto& vertices = contact_.bodies()[b].vertices;
    const auto& reference = settings_.rigid_walls[first_wall() + b].boundary.surface.vertices;
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      const Vector<dim> u = end_->states[b].at(vertices[v]).template head<dim>() - reference[v];
      displacement.insert(displacement.end(), u.begin(), u.end());
    }
    surfaces.move_wall(first_wall() + b, displacement);
  }
}

// Moments about the centres of mass at the start of the step, which the soil refers to as well.
template <int dim>
std::vector<BodyLoad> Boulders<dim>::soil_loads(std::span<const double> forces) const {
  constexpr std::size_t width = dim == 2 ? 3 : 6;
  std::vector<BodyLoad> loads;
  for (std::size_t b = 0; b < contact_.bodies().size(); ++b) {
    const double* values = forces.data() + (first_wall() + b) * width;
    BodyLoad& load = loads.emplace_back();
    std::copy(values, values + dim, load.force.begin());
    std::copy(values + dim, values + width, load.moment.data() + (dim == 2 ? 2 : 0));
    load.moment -= accepted_.states[b].x.cross(load.force);
  }
  return loads;
}

// Difference of two sets of loads, measured by the displacement that it causes at the end of the
// step [m].
template <int dim>
std::vector<double> Boulders<dim>::difference(const std::vector<BodyLoad>& loads) const {
  std::vector<double> result;
  for (std::size_t b = 0; b < loads.size(); ++b) {
    if (step_.held[b] != 0) continue;
    const HardBody& body = contact_.bodies()[b];
    const double turned = body.radius / body.mass.inertia.diagonal().minCoeff();
    const Vector<3> dx = (loads[b].force - step_.loads[b].force) / body.mass.mass;
    const Vector<3> turn = turned * (loads[b].moment - step_.loads[b].moment);
    for (const Vector<3>& part : {dx, turn}) {
      for (const double value : part) result.push_back(0.5 * dt_ * dt_ * value);
    }
  }
  return result;
}

template <int dim>
bool Boulders<dim>::follow(std::span<const double> forces) {
  const auto loads = soil_loads(forces);
  const auto now = difference(loads);
  double largest = 0;
  for (const double value : now) largest = std::max(largest, std::abs(value));
  const double relaxed = relaxation_.next(now);
  const bool agree = largest <= tolerance_;
  if (!agree && (++passes_ >= most_passes || !std::isfinite(largest))) {
    throw ConvergenceError(
        fmt::format("soil and boulders do not agree on their motion: it differs by {:.3g} m after "
                    "{} iterations, allowed: {:.3g} m; the boulders are too light for the "
                    "stiffness of the soil in a step of {:.4g} s",
                    largest, passes_, tolerance_, dt_),
        "boulders");
  }
  const auto same = [](const BodyLoad& x, const BodyLoad& y) {
    return x.force == y.force && x.moment == y.moment;
  };
  if (std::ranges::equal(loads, step_.loads, same)) return true;  // end_ is of these loads
  for (std::size_t b = 0; b < loads.size(); ++b) {
    const double share = agree ? 1 : relaxed;
    BodyLoad& own = step_.loads[b];
    own.force += share * (loads[b].force - own.force);
    own.moment += share * (loads[b].moment - own.moment);
    if (agree) own = loads[b];
  }
  end_ = contact_.solve(accepted_, step_);
  return agree;
}

template <int dim>
void Boulders<dim>::refuse_exits() const {
  for (std::size_t b = 0; b < contact_.bodies().size(); ++b) {
    const Vector<dim> from = accepted_.states[b].x.template head<dim>();
    const Vector<dim> to = end_->states[b].x.template head<dim>();
    if (!grid_.contains(from) || grid_.contains(to)) continue;
    throw ConvergenceError(
        fmt::format("boulder \"{}\" would leave the background grid, from ({:.6g}) to ({:.6g}); "
                    "walls of the grid do not hold boulders: give it one of \"rigid_walls\" there, "
                    "make the grid larger, or set \"outside\": \"remove\"",
                    contact_.bodies()[b].name, fmt::join(from.data(), from.data() + dim, ", "),
                    fmt::join(to.data(), to.data() + dim, ", ")),
        "outside");
  }
}

template <int dim>
void Boulders<dim>::accept() {
  if (empty()) return;
  for (std::size_t k = 0; k < num_interfaces(); ++k) {
    impacts_.look_at(k, settings_.interfaces[k].name, end_->nodal_forces[k], dt_);
  }
  ledger_.add_step(contact_, accepted_, step_, *end_, in_space<dim>(settings_.gravity));
  accepted_ = {.states = end_->states, .memories = end_->memories};
  last_loads_ = step_.loads;
  for (std::size_t b = 0; b < works_.size(); ++b) works_[b] += end_->works[b];
  for (std::size_t k = 0; k < interface_places_.size(); ++k) {
    interface_places_[k] = step_.obstacles[k].end;
  }
  for (std::size_t k = 0; k < forces_.size(); ++k) {
    const auto& nodal = end_->nodal_forces[k];
    forces_[k] = std::accumulate(nodal.begin(), nodal.end(), Vector<3>(Vector<3>::Zero()));
  }
}

template <int dim>
bool Boulders<dim>::may_touch_interface() const {
  if (empty() || num_interfaces() == 0) return false;
  const auto near = contact_.within_reach(accepted_, step_);
  return std::any_of(near.begin(), near.begin() + num_interfaces(), [](char c) { return c != 0; });
}

template <int dim>
void Boulders<dim>::add_forces(InterfaceValues& forces) const {
  if (empty()) return;
  for (std::size_t k = 0; k < num_interfaces(); ++k) {
    auto& values = forces.at(settings_.interfaces[k].name);
    const auto& own = end_->nodal_forces[k];
    for (std::size_t v = 0; v < own.size(); ++v) {
      for (int d = 0; d < dim; ++d) values[v * dim + d] += own[v][d];
    }
  }
}

template <int dim>
void Boulders<dim>::add_forces(std::span<double> forces) const {
  if (empty()) return;
  constexpr std::size_t width = dim == 2 ? 3 : 6;
  for (std::size_t wall = 0; wall < first_wall(); ++wall) {
    const std::size_t o = num_interfaces() + wall;
    const Vector<3> about = in_space<dim>(settings_.rigid_walls[wall].moment_about);
    double* values = forces.data() + wall * width;
    for (std::size_t v = 0; v < end_->nodal_forces[o].size(); ++v) {
      const Vector<3>& f = end_->nodal_forces[o][v];
      const Vector<3> moment = (step_.obstacles[o].start[v] - about).cross(f);
      for (int d = 0; d < dim; ++d) values[d] += f[d];
      for (int d = dim == 2 ? 2 : 0; d < 3; ++d) values[dim + d - (dim == 2 ? 2 : 0)] += moment[d];
    }
  }
}

template <int dim>
std::vector<std::string> Boulders<dim>::names(const BoulderScene<dim>& settings) {
  std::vector<std::string> names;
  if (settings.boulders.empty()) return names;
  for (const auto& boulder : settings.boulders) {
    for (const char* part : {"", "v"}) {
      for (int d = 0; d < dim; ++d)
        names.push_back(fmt::format("{}.{}{}", boulder.name, part, "xyz"[d]));
    }
    for (int d = dim == 2 ? 2 : 0; d < 3; ++d)
      names.push_back(fmt::format("{}.w{}", boulder.name, "xyz"[d]));
    for (const char* part : {"qw", "qx", "qy", "qz", "kinetic_energy", "hard_contact_work"}) {
      names.push_back(fmt::format("{}.{}", boulder.name, part));
    }
  }
  names.emplace_back("boulder_contact_energy");
  for (const auto& name : BoulderLedger::names(dim)) names.push_back(name);
  const auto add = [&names](const std::string& surface) {
    for (int d = 0; d < dim; ++d)
      names.push_back(fmt::format("{}.boulders_f{}", surface, "xyz"[d]));
  };
  for (const auto& interface : settings.interfaces) add(interface.name);
  for (const auto& wall : settings.rigid_walls) {
    if (!wall.is_boulder) add(wall.name);
  }
  return names;
}

template <int dim>
std::vector<double> Boulders<dim>::values() const {
  std::vector<double> values;
  for (std::size_t b = 0; b < works_.size(); ++b) {
    const BodyState& s = accepted_.states[b];
    const Vector<3> spin = s.spin();
    values.insert(values.end(), s.x.data(), s.x.data() + dim);
    values.insert(values.end(), s.v.data(), s.v.data() + dim);
    values.insert(values.end(), spin.data() + (dim == 2 ? 2 : 0), spin.data() + 3);
    for (const double q : {s.q.w(), s.q.x(), s.q.y(), s.q.z()}) values.push_back(q);
    values.push_back(kinetic_energy(contact_.bodies()[b].mass, s));
    values.push_back(works_[b]);
  }
  if (empty()) return values;
  values.push_back(contact_.stored_energy(accepted_.memories));
  const auto totals = ledger_.values(dim, contact_, accepted_);
  values.insert(values.end(), totals.begin(), totals.end());
  for (const Vector<3>& force : forces_)
    values.insert(values.end(), force.data(), force.data() + dim);
  return values;
}

template <int dim>
HardContact::Overlap Boulders<dim>::overlap_at_start() const {
  std::vector<Obstacle> obstacles;
  for (std::size_t k = 0; k < num_interfaces() + settings_.rigid_walls.size(); ++k) {
    obstacles.push_back(obstacle(k));
  }
  return contact_.deepest_overlap(accepted_.states, obstacles);
}

template <int dim>
std::string Boulders<dim>::name_of_partner(std::int32_t number) const {
  auto k = static_cast<std::size_t>(number);
  if (k < settings_.boulders.size()) return settings_.boulders[k].name;
  k -= settings_.boulders.size();
  if (k < settings_.interfaces.size()) return settings_.interfaces[k].name;
  return settings_.rigid_walls[k - settings_.interfaces.size()].name;
}

template <int dim>
void Boulders<dim>::visit_state(StateVisitor& visitor) {
  if (empty()) return;
  for (std::size_t b = 0; b < works_.size(); ++b) {
    const std::string name = fmt::format("boulder_{}.", b);
    BodyState& s = accepted_.states[b];
    visitor.reals(name + "x", {s.x.data(), 3});
    visitor.reals(name + "q", {s.q.coeffs().data(), 4});
    visitor.reals(name + "v", {s.v.data(), 3});
    visitor.reals(name + "W", {s.W.data(), 3});
    visitor.reals(name + "force", {last_loads_[b].force.data(), 3});
    visitor.reals(name + "moment", {last_loads_[b].moment.data(), 3});
    visitor.real(name + "work", works_[b]);
  }
  for (std::size_t k = 0; k < interface_places_.size(); ++k) {
    visitor.reals(fmt::format("boulders.interface_{}", k),
                  {interface_places_[k].front().data(), 3 * interface_places_[k].size()});
  }
  ledger_.visit_state(visitor);
  for (std::size_t k = 0; k < forces_.size(); ++k) {
    visitor.reals(fmt::format("boulders.force_{}", k), {forces_[k].data(), 3});
  }
  visit_memories(visitor, "boulders.memories", accepted_.memories);
}

template class Boulders<2>;
template class Boulders<3>;

}  // namespace gabion::mpm
