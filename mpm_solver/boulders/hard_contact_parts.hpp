// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <vector>

#include "mpm_solver/boulders/deep_place.hpp"
#include "mpm_solver/boulders/ellipsoid_places.hpp"
#include "mpm_solver/boulders/hard_contact.hpp"
#include "mpm_solver/boulders/hard_places.hpp"
#include "mpm_solver/boulders/tangential_spring.hpp"

namespace gabion::mpm {

/// Cosine of the angle between normals of one place in two substeps.
inline constexpr double same_normal = 0.9;

struct HardContact::Pair {
  std::int32_t a = 0, sphere = 0;  // what has the sphere: a body, or an obstacle with its vertex
  std::int32_t b = 0, facet = 0;   // what has the facet, -1: it is a sphere about the centre
};

// A sphere and a surface; they are no nearer than `apart` at the start of a substep.
struct HardContact::Watched {
  std::span<const Pair> pairs;
  double apart = 0;
};

// A contact point, on its path from the start to the end of a substep.
struct HardContact::Place {
  Pair pair;
  HardFoot foot;
  double g0 = 0, g1 = 0, offset = 0;
  double distance = 0;  // of the middles of the sphere and of the surface there
  double extent = std::numeric_limits<double>::infinity();      // of ellipsoids along the direction
  double most_depth = std::numeric_limits<double>::infinity();  // deeper is on the other side
  Vector<3> direction = Vector<3>::Zero();                      // from b to a, of length 1
  Vector<3> normal = Vector<3>::Zero();  // near to it; n . (relative displacement) is g1 - g0
  Vector<3> x = Vector<3>::Zero();       // in the middle of the substep
  HardMemory known;

  bool touches() const { return std::min(g0, g1) < 0; }
};

struct HardContact::Sums {
  std::vector<BodyLoad> loads;
  DeepPlace too_deep = {};
  /// Forces on vertices of obstacles in contact, by obstacle and vertex [N].
  std::map<std::array<std::int32_t, 2>, Vector<3>> nodal_forces = {};
  HardMemories memories = {};

  Vector<3>& nodal_force(std::size_t obstacle, std::int32_t vertex) {
    const auto o = static_cast<std::int32_t>(obstacle);
    return nodal_forces.try_emplace({o, vertex}, Vector<3>::Zero()).first->second;
  }

  // Move these sums towards others by a share of the difference.
  void approach(const Sums& other, double share) {
    for (std::size_t c = 0; c < loads.size(); ++c) {
      loads[c].force += share * (other.loads[c].force - loads[c].force);
      loads[c].moment += share * (other.loads[c].moment - loads[c].moment);
    }
    for (const auto& [place, f] : other.nodal_forces) nodal_force(place[0], place[1]);
    for (auto& [place, f] : nodal_forces) {
      const auto target = other.nodal_forces.find(place);
      const bool is_none = target == other.nodal_forces.end();
      f += share * ((is_none ? Vector<3>(Vector<3>::Zero()) : target->second) - f);
    }
  }
};

// Bodies and obstacles in a substep.
struct HardContact::Under {
  int dim = 3;
  const std::vector<HardBody>& bodies;
  const Step& step;
  std::vector<BodyState> s0, s1;
  double share0 = 0, share1 = 0, h = 0;
  std::vector<double> obstacle_speeds = speeds_of(step);  // largest of a vertex [m/s]

  bool is_body(std::int32_t c) const { return c < static_cast<std::int32_t>(bodies.size()); }
  bool is_free(std::int32_t c) const { return is_body(c) && step.held[c] == 0; }
  const Obstacle& obstacle(std::int32_t c) const { return step.obstacles[c - bodies.size()]; }
  // Visit the pairs by sphere and surface, whose pairs follow each other.
  template <class Visit>
  static void for_groups(const std::vector<Pair>& pairs, const Visit& visit) {
    for (std::size_t k = 0, end = 0; k < pairs.size(); k = end) {
      const auto& [a, sphere, b, facet] = pairs[k];
      while (end < pairs.size() && pairs[end].a == a && pairs[end].sphere == sphere &&
             pairs[end].b == b) {
        ++end;
      }
      visit(std::span(pairs).subspan(k, end - k));
    }
  }
  const std::vector<HardFacet>& facets(std::int32_t c) const {
    return is_body(c) ? bodies[c].facets : obstacle(c).facets;
  }
  Vector<3> vertex(std::int32_t c, std::int32_t v, bool at_end) const {
    if (is_body(c)) return (at_end ? s1 : s0)[c].at(bodies[c].vertices[v]);
    const Obstacle& o = obstacle(c);
    return o.start[v] + (at_end ? share1 : share0) * (o.end[v] - o.start[v]);
  }
  bool is_round(std::int32_t c) const { return is_body(c) && bodies[c].is_round(); }
  bool is_ellipsoid(std::int32_t c) const { return is_body(c) && bodies[c].is_ellipsoid(); }
  Vector<3> sphere(std::int32_t c, std::int32_t k, bool at_end) const {
    if (is_round(c)) return (at_end ? s1 : s0)[c].x;
    return vertex(c, k, at_end);
  }
  double sphere_radius(std::int32_t c) const { return is_body(c) ? bodies[c].sphere : 0; }
  // Radius of the sphere about the centre that holds a sphere or ellipsoid, 0: has vertices.
  double round_radius(std::int32_t c) const {
    return is_ellipsoid(c) ? bodies[c].radius : sphere_radius(c);
  }
  // A sphere or ellipsoid.
  OnPath<Ellipsoid> ellipsoid(std::int32_t c) const {
    const HardBody& body = bodies[c];
    const Vector<3> axes = body.is_ellipsoid() ? body.axes : Vector<3>::Constant(body.sphere);
    const Eigen::Quaterniond half(Eigen::Vector4d(s0[c].q.coeffs() + s1[c].q.coeffs()));
    return {.start = {s0[c].x, s0[c].q, axes},
            .half = {middle(c), half.normalized(), axes},
            .end = {s1[c].x, s1[c].q, axes}};
  }
  HardCorners corners(std::int32_t c, std::int32_t facet, bool at_end) const {
    HardCorners result{.count = dim};
    for (int k = 0; k < dim; ++k) result.x[k] = vertex(c, facets(c)[facet][k], at_end);
    return result;
  }
  Vector<3> middle(std::int32_t c) const { return 0.5 * (s0[c].x + s1[c].x); }
  BodyMove move(std::int32_t c) const {
    return step.held[c] != 0 ? BodyMove{} : move_of(s0[c], s1[c], h);
  }
  // Displacement in the substep of the point that is at x in its middle [m].
  Vector<3> path(std::int32_t c, const Vector<3>& x, const Place& place) const {
    if (is_body(c)) {
      const BodyMove moved = move(c);
      return moved.shift + moved.turn.cross(x - middle(c));
    }
    if (c == place.pair.a) {
      return vertex(c, place.pair.sphere, true) - vertex(c, place.pair.sphere, false);
    }
    Vector<3> path = Vector<3>::Zero();
    const HardFacet& facet = facets(c)[place.pair.facet];
    for (int k = 0; k < dim; ++k) {
      path += place.foot.weights[k] * (vertex(c, facet[k], true) - vertex(c, facet[k], false));
    }
    return path;
  }
  // Velocity at the start of the substep; surfaces move evenly.
  Vector<3> velocity(std::int32_t c, const Place& place) const {
    if (!is_body(c)) return path(c, place.x, place) / h;
    if (step.held[c] != 0) return Vector<3>::Zero();
    return s0[c].v + s0[c].spin().cross(place.x - s0[c].x);
  }
  // Speed at which the gap becomes smaller.
  double closing_speed(const Place& place) const {
    return place.direction.dot(velocity(place.pair.b, place) - velocity(place.pair.a, place));
  }
  Vector<3> relative_motion(const Place& place) const {
    return path(place.pair.a, place.x, place) - path(place.pair.b, place.x, place);
  }
  Vector<3> turn(std::int32_t c) const {
    return is_body(c) ? move(c).turn : Vector<3>(Vector<3>::Zero());
  }
  // Largest speed of a point.
  double speed(std::int32_t c) const {
    if (is_body(c)) {
      if (step.held[c] != 0) return 0;
      return s0[c].v.norm() + bodies[c].radius * s0[c].W.norm();
    }
    return obstacle_speeds[c - bodies.size()];
  }
  static std::vector<double> speeds_of(const Step& step) {
    std::vector<double> speeds;
    for (const Obstacle& o : step.obstacles) {
      double path = 0;
      for (std::size_t v = 0; v < o.start.size(); ++v) {
        path = std::max(path, (o.end[v] - o.start[v]).norm());
      }
      speeds.push_back(path / step.dt);
    }
    return speeds;
  }
};

}  // namespace gabion::mpm
