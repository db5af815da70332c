// SPDX-License-Identifier: BSD-3-Clause
// The search for contact points.
#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm_solver/boulders/hard_contact_parts.hpp"

namespace gabion::mpm {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// A sphere or ellipsoid that is deeper than this share of its radius, or extent there, is on the
// other side of a surface.
constexpr double deepest = 0.25;
// A point that comes from the front may be behind a surface by rounding, up to this share of the
// radius.
constexpr double entry = 1e-6;
// Gaps that differ by more than this share beyond the displacement of a substep belong to two
// places.
constexpr double same_gap = 1e-3;

}  // namespace

double HardContact::size_of(const Pair& pair) const {
  return std::min(pair.a < num_bodies() ? bodies_[pair.a].radius : infinity,
                  pair.b < num_bodies() ? bodies_[pair.b].radius : infinity);
}

bool HardContact::is_point(const Pair& pair, const Under& under) const {
  return pair.facet >= 0 && !under.is_round(pair.a);
}

// A point is in contact at the nearest place of a surface, if it came there from the front.
bool HardContact::point_place(std::span<const Pair> group, const Under& under,
                              const HardMemories& memories, Place& place) const {
  const auto [a, sphere, b, facet] = group.front();
  const std::array<Vector<3>, 2> c = {under.sphere(a, sphere, false),
                                      under.sphere(a, sphere, true)};
  std::vector<HardCorners> start, end;
  for (const Pair& pair : group) {
    start.push_back(under.corners(b, pair.facet, false));
    end.push_back(under.corners(b, pair.facet, true));
  }
  const HardNearest n0 = nearest_of(start, c[0]), n1 = nearest_of(end, c[1]);
  if (n0.facet < 0 || n1.facet < 0) return false;
  const auto known = memories.find({a, sphere, b});
  const bool is_known = known != memories.end();
  const double rounding = entry * size_of(group.front());
  if (!is_known && n0.gap < -rounding) return false;
  const HardNearest& nearest = n0.gap < 0 ? n0 : n1;
  place.pair = group[nearest.facet];
  place.foot = nearest.foot;
  place.g0 = n0.gap;
  place.g1 = n1.gap;
  place.x = 0.5 * (c[0] + c[1]);
  const Vector<3> normal = mean_normal(nearest, start[nearest.facet], end[nearest.facet], c);
  const Vector<3> path = under.relative_motion(place);
  // A gap that changes by more than the displacement belongs to a point that goes round a free
  // border.
  if (!is_known && n0.gap - n1.gap > (1 + entry) * path.norm() + rounding) return false;
  place.direction = normal.normalized();
  place.normal =
      along_motion(normal, path, place.g1 - place.g0, place.x.norm() + size_of(place.pair));
  if (is_known) place.known = known->second.front();
  return true;
}

bool HardContact::sphere_place(const Pair& pair, const Under& under, Place& place) const {
  if (!locate(pair, under, place)) return false;
  place.most_depth = deepest * std::min(size_of(pair), place.extent);
  return std::max(place.g0, place.g1) > -place.most_depth;
}

// The sphere or ellipsoid that has the number a, on a facet or another one.
bool HardContact::locate_ellipsoid(const Pair& pair, const Under& under, Place& place) const {
  const auto [a, sphere, b, facet] = pair;
  const OnPath<Ellipsoid> own = under.ellipsoid(a);
  EllipsoidPlace found;
  if (facet < 0) {
    found = place_between(own, under.ellipsoid(b));
  } else {
    const HardCorners f0 = under.corners(b, facet, false), f1 = under.corners(b, facet, true);
    if (!place_on_facet(own, {.start = f0, .half = middle(f0, f1), .end = f1}, found)) return false;
  }
  place.pair = pair;
  place.foot = found.foot;
  place.g0 = found.g0;
  place.g1 = found.g1;
  place.distance = bodies_[a].radius + 0.5 * (found.g0 + found.g1);
  place.extent = found.extent;
  place.direction = found.direction;
  place.x = found.x;
  follow_gap(found, under.relative_motion(place), under.turn(a) - under.turn(b), bodies_[a].radius);
  place.normal = found.normal;
  place.x = found.x;
  return true;
}

bool HardContact::locate(const Pair& pair, const Under& under, Place& place) const {
  if (under.is_ellipsoid(pair.a) || (pair.facet < 0 && under.is_ellipsoid(pair.b)))
    return locate_ellipsoid(pair, under, place);
  place.pair = pair;
  const Vector<3> c0 = under.sphere(pair.a, pair.sphere, false);
  const Vector<3> c1 = under.sphere(pair.a, pair.sphere, true);
  const double radius = under.sphere_radius(pair.a);
  HardGap gap;
  if (pair.facet < 0) {
    gap = gap_of_points(c0 - under.s0[pair.b].x, c1 - under.s1[pair.b].x);
    gap.g0 -= bodies_[pair.b].sphere;
    gap.g1 -= bodies_[pair.b].sphere;
    place.foot.support = 0;
  } else {
    const HardCorners f0 = under.corners(pair.b, pair.facet, false);
    const HardCorners f1 = under.corners(pair.b, pair.facet, true);
    const HardCorners half = middle(f0, f1);
    place.foot = foot_of(half, 0.5 * (c0 + c1));
    place.distance = (place_of(place.foot, half) - 0.5 * (c0 + c1)).norm();
    if (!gap_of_facet(place.foot, f0, f1, {c0, c1}, gap)) return false;
  }
  place.g0 = gap.g0 - radius;
  place.g1 = gap.g1 - radius;
  place.normal = gap.normal;
  place.direction = gap.normal.normalized();
  place.x = 0.5 * (c0 + c1) - radius * place.direction;
  return true;
}

// A sphere or ellipsoid has contact points on faces, and on edges and corners that are nearer than
// all facets around them and belong to no face in contact.
std::vector<HardContact::Place> HardContact::sphere_places(std::span<const Pair> group,
                                                           const Under& under) const {
  std::vector<Place> found, places, edges;
  LeastDistances least;
  for (const Pair& pair : group) {
    Place place;
    if (!sphere_place(pair, under, place)) continue;
    if (pair.facet >= 0) least.add(under.facets(pair.b)[pair.facet], dim_, place.distance);
    found.push_back(place);
  }
  FootVertices taken;
  for (const Place& place : found) {
    const Pair& pair = place.pair;
    if (pair.facet >= 0 && (!place.foot.is_face() || place.foot.on_border)) {
      const HardFacet& facet = under.facets(pair.b)[pair.facet];
      if (least.is_least(facet, place.foot, place.distance)) edges.push_back(place);
      continue;
    }
    if (pair.facet >= 0) taken.add(under.facets(pair.b)[pair.facet], place.foot);
    places.push_back(place);
  }
  std::ranges::stable_sort(
      edges, [](const Place& p, const Place& q) { return p.foot.support > q.foot.support; });
  for (const Place& edge : edges) {
    const HardFacet& facet = under.facets(edge.pair.b)[edge.pair.facet];
    if (taken.has(facet, edge.foot)) continue;
    places.push_back(edge);
    taken.add(facet, edge.foot);
  }
  return places;
}

// A place keeps the gap that it had, whichever part of the surface is nearest now. A place that is
// first seen when the sphere is inside begins there without a force.
void HardContact::recall(const Under& under, const std::vector<HardMemory>& known,
                         std::vector<Place>& places) const {
  std::vector<char> used(known.size(), 0), done(places.size(), 0);
  for (;;) {
    double best = same_normal;
    std::size_t p = places.size(), m = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      for (std::size_t k = 0; k < known.size(); ++k) {
        const double cosine = known[k].normal.dot(places[i].direction);
        if (done[i] != 0 || used[k] != 0 || cosine < best) continue;
        const double gap = known[k].gap + known[k].offset;
        const double path = under.relative_motion(places[i]).norm();
        if (std::abs(places[i].g0 - gap) > path + same_gap * std::abs(gap)) continue;
        best = cosine;
        p = i;
        m = k;
      }
    }
    if (p == places.size()) break;
    done[p] = used[m] = 1;
    places[p].known = known[m];
    places[p].offset = known[m].offset;
    places[p].g0 = known[m].gap + known[m].offset;
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    Place& place = places[i];
    const double size = size_of(place.pair);
    if (done[i] == 0 && place.g0 < -entry * size) place.offset = place.g0;
    place.g0 -= place.offset;
    place.g1 -= place.offset;
    place.normal = along_motion(place.normal, under.relative_motion(place), place.g1 - place.g0,
                                place.x.norm() + size);
  }
}

// Pairs in contact, and pairs that are not.
std::vector<HardContact::Place> HardContact::near_places(std::span<const Pair> group,
                                                         const Under& under,
                                                         const HardMemories& memories) const {
  std::vector<Place> places;
  Place place;
  if (is_point(group.front(), under)) {
    if (point_place(group, under, memories, place)) places.push_back(place);
    return places;
  }
  return sphere_places(group, under);
}

std::vector<HardContact::Place> HardContact::places_of(std::span<const Pair> group,
                                                       const Under& under,
                                                       const HardMemories& memories) const {
  std::vector<Place> places = near_places(group, under, memories);
  std::erase_if(places, [](const Place& place) { return !place.touches(); });
  if (is_point(group.front(), under)) return places;
  const auto found = memories.find({group.front().a, group.front().sphere, group.front().b});
  recall(under, found == memories.end() ? std::vector<HardMemory>() : found->second, places);
  return places;
}

}  // namespace gabion::mpm
