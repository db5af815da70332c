// SPDX-License-Identifier: BSD-3-Clause
// The forces of the contact points.
#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm_solver/boulders/hard_contact_parts.hpp"
#include "mpm_solver/boulders/hard_law.hpp"
#include "mpm_solver/boulders/normal_spring.hpp"

namespace gabion::mpm {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double usual_gravity = 9.81;

}  // namespace

// The tangential direction is at least as stiff as the normal one is under the weight.
double HardContact::tangential_stiffness(std::int32_t a, std::int32_t b, const HardLaw& law) const {
  double mass = infinity;
  for (const std::int32_t c : {a, b}) {
    if (c < num_bodies()) mass = std::min(mass, bodies_[c].mass.mass);
  }
  const double g = gravity_.norm() > 0 ? gravity_.norm() : usual_gravity;
  return 2 * std::sqrt(law.stiffness * mass * g);
}

void HardContact::evaluate(const Under& under, const std::vector<Pair>& pairs,
                           const HardMemories& memories, Sums& sums) const {
  Under::for_groups(pairs, [&](std::span<const Pair> group) {
    for (const Place& place : places_of(group, under, memories)) add_place(under, place, sums);
  });
}

bool HardContact::gives(std::int32_t a, std::int32_t b) const {
  const std::int32_t obstacle = std::max(a, b) - num_bodies();
  return obstacle >= 0 && obstacle < giving_;
}

// At surfaces that move under the force: a damped spring that never pulls; its damping takes energy
// at any rate.
double HardContact::normal_force(const Under& under, const Place& place, const HardLaw& law,
                                 HardMemory& memory) const {
  const double rate = (place.g1 - place.g0) / under.h;
  const double elastic = law.stiffness * mean_force(place.g0, place.g1);
  if (!gives(place.pair.a, place.pair.b))
    return restitution_factor(law.restitution, rate) * elastic;
  memory.closing = std::max({memory.closing, under.closing_speed(place), blend_speed});
  const double damping = dampings_[std::min(place.pair.a, place.pair.b)];
  return std::max(0.0, 1 - damping / memory.closing * rate) * elastic;
}

void HardContact::add_place(const Under& under, const Place& place, Sums& sums) const {
  const auto [a, sphere, b, facet] = place.pair;
  const HardLaw law = law_between(bodies_, a, b);
  const Vector<3>& n = place.direction;
  HardMemory memory = place.known;
  const double N = normal_force(under, place, law, memory);
  if (memory.normal.dot(n) < same_normal) memory.slip = memory.turn = Vector<3>::Zero();
  memory.normal = n;
  // A place that was deep when it was first seen loses that depth when it comes out.
  const double gap = place.g1 + place.offset;
  memory.offset = std::min(0.0, std::max(place.offset, gap));
  memory.gap = gap - memory.offset;
  const double least = tangential_stiffness(a, b, law);
  const double stiffness = tangential_at(memory.gap, least, law);
  const double kept_length = length_kept(tangential_at(place.known.gap, least, law), stiffness);
  memory.slip *= kept_length;
  memory.turn *= kept_length;
  memory.slip += under.relative_motion(place);
  memory.slip -= n.dot(memory.slip) * n;
  memory.slip = spring(memory.slip, stiffness, law.friction * N);
  if (memory.offset == 0 && -memory.gap > place.most_depth)
    sums.too_deep = {.body = a, .other = b, .depth = -memory.gap, .most = place.most_depth};
  const Vector<3> force = N * place.normal - stiffness * memory.slip;
  Vector<3> moment = Vector<3>::Zero();
  const double radius = under.sphere_radius(a);
  if (radius > 0 && law.rolling > 0) {
    const double resisting = stiffness * radius * radius;
    memory.turn += under.turn(a) - under.turn(b);
    memory.turn = spring(memory.turn, resisting, law.rolling * radius * N);
    moment = -resisting * memory.turn;
  }
  sums.memories[{a, sphere, b}].push_back(memory);
  for (const std::int32_t c : {a, b}) {
    const double sign = c == a ? 1 : -1;
    if (under.is_body(c)) {
      sums.loads[c].force += sign * force;
      sums.loads[c].moment += sign * (Vector<3>(place.x - under.middle(c)).cross(force) + moment);
      continue;
    }
    const std::size_t obstacle = c - bodies_.size();
    if (c == a) {
      sums.nodal_force(obstacle, sphere) += force;
      continue;
    }
    const HardFacet& vertices = under.facets(b)[facet];
    for (int k = 0; k < dim_; ++k) {
      sums.nodal_force(obstacle, vertices[k]) -= place.foot.weights[k] * force;
    }
  }
}

double HardContact::stored_energy(const HardMemories& memories) const {
  double sum = 0;
  for (const auto& [key, list] : memories) {
    const HardLaw law = law_between(bodies_, key[0], key[2]);
    const double least = tangential_stiffness(key[0], key[2], law);
    const double share = gives(key[0], key[2]) ? 1 : kept(law.restitution);
    const double radius = key[0] < num_bodies() ? bodies_[key[0]].sphere : 0;
    for (const HardMemory& memory : list) {
      const double stiffness = tangential_at(memory.gap, least, law);
      const double depth = std::max(-memory.gap, 0.0);
      sum += share * law.stiffness * depth * depth * depth / 3;
      sum += 0.5 * stiffness * memory.slip.squaredNorm();
      sum += 0.5 * stiffness * radius * radius * memory.turn.squaredNorm();
    }
  }
  return sum;
}

}  // namespace gabion::mpm
