// SPDX-License-Identifier: BSD-3-Clause
// The forces of the places that touch.
#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm_solver/boulders/hard_contact_parts.hpp"

namespace gabion::mpm {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Gap rates below which the factor of the restitution blends from loading to unloading [m/s].
constexpr double blend_speed = 0.02;
// Of the radius: what is deeper is on the other side of a surface.
constexpr double deepest = 0.25;
constexpr double same_normal = 0.9;
constexpr double usual_gravity = 9.81;

// (W(g_0) - W(g_1)) / (g_1 - g_0) over the stiffness, W = |g|^3 / 3 where g < 0.
double mean_force(double g0, double g1) {
  const double a = std::max(-g0, 0.0), b = std::max(-g1, 0.0);
  if (g0 <= 0 && g1 <= 0) return (a * a + a * b + b * b) / 3;
  if (a == 0 && b == 0) return 0;
  return (a * a * a - b * b * b) / (3 * (g1 - g0));
}

double restitution_factor(double e, double rate) {
  return (1 + e * e) / 2 - (1 - e * e) / 2 * std::clamp(rate / blend_speed, -1.0, 1.0);
}

// A spring that gives way at a limit: it takes energy or keeps it.
Vector<3> spring(const Vector<3>& stretched, double stiffness, double limit) {
  const double size = stiffness * stretched.norm();
  return size <= limit ? stretched : Vector<3>(stretched * (limit / size));
}

}  // namespace

HardLaw HardContact::law_of(std::int32_t a, std::int32_t b) const {
  if (a >= num_bodies()) return bodies_[b].law;
  if (b >= num_bodies()) return bodies_[a].law;
  const HardLaw &p = bodies_[a].law, &q = bodies_[b].law;
  return {.friction = std::min(p.friction, q.friction),
          .restitution = std::min(p.restitution, q.restitution),
          .stiffness = p.stiffness * q.stiffness / (p.stiffness + q.stiffness),
          .rolling = std::min(p.rolling, q.rolling)};
}

// As stiff as the normal direction is under the weight.
double HardContact::tangential_stiffness(std::int32_t a, std::int32_t b, const HardLaw& law) const {
  double mass = infinity;
  for (const std::int32_t c : {a, b}) {
    if (c < num_bodies()) mass = std::min(mass, bodies_[c].mass.mass);
  }
  const double g = gravity_.norm() > 0 ? gravity_.norm() : usual_gravity;
  return 2 * std::sqrt(law.stiffness * mass * g);
}

bool HardContact::place_of(const Pair& pair, const Under& under, Place& place) const {
  if (!locate(pair, under, place)) return false;
  const double size = std::min(pair.a < num_bodies() ? bodies_[pair.a].radius : infinity,
                               pair.b < num_bodies() ? bodies_[pair.b].radius : infinity);
  return std::max(place.g0, place.g1) > -deepest * size;
}

bool HardContact::locate(const Pair& pair, const Under& under, Place& place) const {
  place.pair = pair;
  const Vector<3> c0 = under.ball(pair.a, pair.ball, false);
  const Vector<3> c1 = under.ball(pair.a, pair.ball, true);
  const double radius = under.ball_radius(pair.a);
  HardGap gap;
  if (pair.facet < 0) {
    gap = gap_of_points(c0 - under.s0[pair.b].x, c1 - under.s1[pair.b].x);
    gap.g0 -= bodies_[pair.b].ball;
    gap.g1 -= bodies_[pair.b].ball;
    place.foot.support = 0;
  } else {
    const HardCorners f0 = under.corners(pair.b, pair.facet, false);
    const HardCorners f1 = under.corners(pair.b, pair.facet, true);
    place.foot = foot_of(middle(f0, f1), 0.5 * (c0 + c1));
    if (radius == 0 && !place.foot.is_face()) return false;
    if (!gap_of_facet(place.foot, f0, f1, {c0, c1}, gap)) return false;
  }
  place.g0 = gap.g0 - radius;
  place.g1 = gap.g1 - radius;
  place.normal = gap.normal;
  place.x = 0.5 * (c0 + c1) - radius * gap.normal.normalized();
  return true;
}

void HardContact::evaluate(const Under& under, const std::vector<Pair>& pairs,
                           const HardMemories& memories, Sums& sums) const {
  sums.loads.assign(bodies_.size(), {});
  sums.nodal_forces.clear();
  for (const Obstacle& o : under.step.obstacles) {
    sums.nodal_forces.emplace_back(o.start.size(), Vector<3>::Zero());
  }
  sums.memories.clear();
  std::vector<Place> edges;
  FootVertices taken;  // of the ball: vertices of facets and edges that it touches
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Pair& pair = pairs[k];
    Place place;
    if (place_of(pair, under, place) && std::min(place.g0, place.g1) < 0) {
      if (pair.facet < 0) {
        add_place(under, place, memories, sums);
      } else if (place.foot.is_face() && !place.foot.on_border) {
        add_place(under, place, memories, sums);
        taken.add(under.facets(pair.b)[pair.facet], place.foot);
      } else {
        edges.push_back(place);
      }
    }
    const bool last = k + 1 == pairs.size() || pairs[k + 1].a != pair.a ||
                      pairs[k + 1].ball != pair.ball || pairs[k + 1].b != pair.b;
    if (!last) continue;
    // Edges before corners.
    std::ranges::stable_sort(
        edges, [](const Place& p, const Place& q) { return p.foot.support > q.foot.support; });
    for (const Place& edge : edges) {
      const HardFacet& facet = under.facets(edge.pair.b)[edge.pair.facet];
      if (taken.has(facet, edge.foot)) continue;
      add_place(under, edge, memories, sums);
      taken.add(facet, edge.foot);
    }
    edges.clear();
    taken.clear();
  }
}

void HardContact::add_place(const Under& under, const Place& place, const HardMemories& memories,
                            Sums& sums) const {
  const auto [a, ball, b, facet] = place.pair;
  const HardLaw law = law_of(a, b);
  const double rate = (place.g1 - place.g0) / under.h;
  const double N =
      restitution_factor(law.restitution, rate) * law.stiffness * mean_force(place.g0, place.g1);
  const Vector<3> n = place.normal.normalized();
  HardMemory memory{.normal = n};
  if (const auto known = memories.find({a, ball, b}); known != memories.end()) {
    for (const HardMemory& old : known->second) {
      if (old.normal.dot(n) < same_normal) continue;
      memory.slip = old.slip;
      memory.turn = old.turn;
      break;
    }
  }
  const double stiffness = tangential_stiffness(a, b, law);
  memory.slip += under.way(a, place.x, place) - under.way(b, place.x, place);
  memory.slip -= n.dot(memory.slip) * n;
  memory.slip = spring(memory.slip, stiffness, law.friction * N);
  const Vector<3> force = N * place.normal - stiffness * memory.slip;
  Vector<3> moment = Vector<3>::Zero();
  const double radius = under.ball_radius(a);
  if (radius > 0 && law.rolling > 0) {
    const double resisting = stiffness * radius * radius;
    memory.turn += under.turn(a) - under.turn(b);
    memory.turn = spring(memory.turn, resisting, law.rolling * radius * N);
    moment = -resisting * memory.turn;
  }
  sums.memories[{a, ball, b}].push_back(memory);
  for (const std::int32_t c : {a, b}) {
    const double sign = c == a ? 1 : -1;
    if (under.is_body(c)) {
      sums.loads[c].force += sign * force;
      sums.loads[c].moment += sign * (Vector<3>(place.x - under.middle(c)).cross(force) + moment);
      continue;
    }
    auto& nodal = sums.nodal_forces[c - bodies_.size()];
    if (c == a) {
      nodal[ball] += force;
      continue;
    }
    const HardFacet& vertices = under.facets(b)[facet];
    for (int k = 0; k < dim_; ++k) nodal[vertices[k]] -= place.foot.weights[k] * force;
  }
}

}  // namespace gabion::mpm
