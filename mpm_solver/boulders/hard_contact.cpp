// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/hard_contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "common/base/require.hpp"
#include "mpm_solver/boulders/hard_contact_parts.hpp"
#include "mpm_solver/boulders/impact_damping.hpp"

namespace gabion::mpm {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// The search looks ahead by this many times the displacement that the bodies' motion at the start
// gives.
constexpr double ahead = 1.5;
constexpr double least_ahead = 0.05;  // of the smallest radius
// Scenes near the origin keep it: places are referred to multiples of this length, a power of two
// [m].
constexpr double origin_unit = 1024;
constexpr int most_halvings = 12, most_looks = 4, most_substeps = 100000;

// The mean place of bodies in whole units: a difference to it is exact.
Vector<3> origin_near(const std::vector<BodyState>& states) {
  Vector<3> mean = Vector<3>::Zero();
  for (const BodyState& s : states) mean += s.x / static_cast<double>(states.size());
  return origin_unit * (mean / origin_unit).array().round().matrix();
}

}  // namespace

HardContact::HardContact(int dim, std::vector<HardBody> bodies, const Vector<3>& gravity,
                         int giving)
    : dim_(dim), bodies_(std::move(bodies)), gravity_(gravity), giving_(giving) {
  for (const HardBody& body : bodies_) dampings_.push_back(impact_damping(body.law.restitution));
}

void HardContact::add_pairs(std::int32_t a, std::int32_t b, const Under& under, double reach,
                            std::vector<Pair>& pairs) const {
  const double radius = under.round_radius(a);
  const auto num_facets = static_cast<std::int32_t>(under.facets(b).size());
  std::vector<std::int32_t> facets;  // of b near a
  std::vector<HardCorners> corners;
  for (std::int32_t f = 0; f < num_facets; ++f) {
    const HardCorners c = under.corners(b, f, false);
    if (under.is_body(a) && distance_at_least(c, under.s0[a].x) > bodies_[a].radius + reach)
      continue;
    facets.push_back(f);
    corners.push_back(c);
  }
  if (facets.empty()) return;
  const auto num_spheres =
      static_cast<std::int32_t>(radius > 0         ? 1
                                : under.is_body(a) ? bodies_[a].vertices.size()
                                                   : under.obstacle(a).start.size());
  std::vector<char> counts;  // vertices of an obstacle
  if (!under.is_body(a)) {
    const Obstacle& o = under.obstacle(a);
    counts.resize(o.start.size());
    for (std::int32_t k = 0; k < num_spheres; ++k) {
      const double distance = (under.sphere(a, k, false) - under.s0[b].x).norm();
      counts[k] = distance > bodies_[b].radius + reach ? 0 : 1;
    }
    // Where an obstacle does not stick out, the vertices of the shape meet it first.
    counts = sticking_out(o.facets, dim_, o.start, std::move(counts));
  }
  for (std::int32_t k = 0; k < num_spheres; ++k) {
    if (!counts.empty() && counts[k] == 0) continue;
    const Vector<3> c = under.sphere(a, k, false);
    if (under.is_body(b) && (c - under.s0[b].x).norm() > bodies_[b].radius + radius + reach)
      continue;
    for (std::size_t f = 0; f < facets.size(); ++f) {
      if (distance_at_least(corners[f], c) > radius + reach) continue;
      pairs.push_back({a, k, b, facets[f]});
    }
  }
}

std::vector<HardContact::Pair> HardContact::near_pairs(const std::vector<BodyState>& states,
                                                       const Step& step, double reach) const {
  const Under under{.dim = dim_, .bodies = bodies_, .step = step, .s0 = states, .s1 = states};
  const auto total = static_cast<std::int32_t>(bodies_.size() + step.obstacles.size());
  std::vector<Pair> pairs;
  for (std::int32_t a = 0; a < num_bodies(); ++a) {
    for (std::int32_t b = 0; b < total; ++b) {
      if (a == b) continue;
      if (b < num_bodies()) {
        const double apart = (states[a].x - states[b].x).norm();
        if (apart > bodies_[a].radius + bodies_[b].radius + reach) continue;
        if (bodies_[b].is_round()) {
          if (a < b && bodies_[a].is_round()) pairs.push_back({a, 0, b, -1});
          continue;
        }
      }
      add_pairs(a, b, under, reach, pairs);
    }
    if (bodies_[a].is_round()) continue;
    for (std::int32_t o = num_bodies(); o < total; ++o) add_pairs(o, a, under, reach, pairs);
  }
  return pairs;
}

std::vector<char> HardContact::within_reach(const Start& start, const Step& step) const {
  std::vector<char> result(step.obstacles.size(), 0);
  for (const Pair& pair : near_pairs(start.states, step, look_ahead(start, step))) {
    const std::int32_t highest = std::max(pair.a, pair.b);
    if (highest >= num_bodies()) result[highest - num_bodies()] = 1;
  }
  return result;
}

double HardContact::look_ahead(const Start& start, const Step& step) const {
  const Under under{
      .dim = dim_, .bodies = bodies_, .step = step, .s0 = start.states, .s1 = start.states};
  double body = 0, obstacle = 0, least = infinity;
  for (std::int32_t c = 0; c < num_bodies(); ++c) {
    least = std::min(least, bodies_[c].radius);
    if (step.held[c] != 0) continue;
    const double a = step.loads[c].force.norm() / bodies_[c].mass.mass + gravity_.norm();
    body = std::max(body, (under.speed(c) + a * step.dt) * step.dt);
  }
  for (std::size_t o = 0; o < step.obstacles.size(); ++o) {
    obstacle =
        std::max(obstacle, under.speed(static_cast<std::int32_t>(bodies_.size() + o)) * step.dt);
  }
  double depth = 0;
  for (const auto& [key, list] : start.memories) {
    for (const HardMemory& memory : list) depth = std::max(depth, -memory.gap - memory.offset);
  }
  return ahead * (2 * body + obstacle + depth) + least_ahead * least;
}

bool HardContact::solve_within(double reach, const Start& start, const Step& step, End& end) const {
  const auto pairs = near_pairs(start.states, step, reach);
  std::vector<Watched> watched;
  Under::for_groups(pairs, [&](std::span<const Pair> group) { watched.push_back({group}); });
  Under under{.dim = dim_, .bodies = bodies_, .step = step, .s0 = start.states, .s1 = start.states};
  end = {.memories = start.memories,
         .works = std::vector<double>(bodies_.size(), 0.0),
         .load_works = std::vector<double>(bodies_.size(), 0.0),
         .loads = std::vector<BodyLoad>(bodies_.size())};
  for (const Obstacle& o : step.obstacles) {
    end.nodal_forces.emplace_back(o.start.size(), Vector<3>::Zero());
  }
  under.h = step.dt;
  for (double done = 0; done < step.dt; ++end.substeps) {
    if (end.substeps >= most_substeps) {
      throw ConvergenceError(
          fmt::format("boulders need more than {:.0e} substeps in one step", 1. * most_substeps),
          "boulders");
    }
    const double remaining = step.dt - done;
    under.s1 = under.s0;
    under.share0 = under.share1 = done / step.dt;
    double h = substep(under, watched, end.memories, remaining);
    Sums sums;
    for (int halvings = 0;; ++halvings, h *= 0.5) {
      if (halvings > most_halvings) {
        throw ConvergenceError("contact of boulders does not converge", "boulders");
      }
      under.share1 = h == remaining ? 1 : (done + h) / step.dt;
      if (solve_near(h, end.memories, watched, under, sums)) break;
    }
    if (sums.too_deep.body >= 0) refuse(bodies_, sums.too_deep);
    const auto path = paths(under);
    for (Watched& w : watched) w.apart -= path[w.pairs.front().a] + path[w.pairs.front().b];
    add_substep(under, h / step.dt, sums, end);
    under.s0 = under.s1;
    done = h == remaining ? step.dt : done + h;
  }
  end.states = under.s0;
  for (std::size_t c = 0; c < bodies_.size(); ++c) {
    if (2 * (end.states[c].x - start.states[c].x).norm() > reach) return false;
  }
  return true;
}

void HardContact::add_substep(const Under& under, double share, Sums& sums, End& end) const {
  for (std::int32_t c = 0; c < num_bodies(); ++c) {
    const BodyMove move = under.move(c);
    end.works[c] += sums.loads[c].force.dot(move.shift) + sums.loads[c].moment.dot(move.turn);
    const BodyLoad& given = under.step.loads[c];
    end.load_works[c] += given.force.dot(move.shift) + given.moment.dot(move.turn);
    end.loads[c].force += share * sums.loads[c].force;
    end.loads[c].moment += share * sums.loads[c].moment;
  }
  for (const auto& [place, f] : sums.nodal_forces) {
    end.nodal_forces[place[0]][place[1]] += share * f;
  }
  end.memories = std::move(sums.memories);
}

// Far from the origin the rounding of places would enter all that follows from them.
HardContact::End HardContact::solve(const Start& start, const Step& step) const {
  const Vector<3> origin = origin_near(start.states);
  if (!origin.isZero(0)) {
    Start moved = start;
    Step moved_step = step;
    for (BodyState& s : moved.states) s.x -= origin;
    for (Obstacle& o : moved_step.obstacles) {
      for (Vector<3>& x : o.start) x -= origin;
      for (Vector<3>& x : o.end) x -= origin;
    }
    End end = solve_here(moved, moved_step);
    for (BodyState& s : end.states) s.x += origin;
    return end;
  }
  return solve_here(start, step);
}

// Springs may make bodies faster than they were at the start of the step.
HardContact::End HardContact::solve_here(const Start& start, const Step& step) const {
  double reach = look_ahead(start, step);
  End end;
  for (int k = 0; k < most_looks; ++k, reach *= 4) {
    if (solve_within(reach, start, step, end)) return end;
  }
  throw ConvergenceError("boulders move too far in one step for the search of contacts",
                         "boulders");
}

// The nearest place of each surface tells on which side a sphere is.
HardContact::Overlap HardContact::deepest_overlap(const std::vector<BodyState>& states,
                                                  const std::vector<Obstacle>& obstacles) const {
  const Step step{.dt = 1, .held = std::vector<char>(bodies_.size(), 1), .obstacles = obstacles};
  const Under under{
      .dim = dim_, .bodies = bodies_, .step = step, .s0 = states, .s1 = states, .h = 1};
  double reach = 0;
  for (const HardBody& body : bodies_) reach = std::max(reach, body.radius);
  Overlap found;
  Under::for_groups(near_pairs(states, step, reach), [&](std::span<const Pair> group) {
    const auto& [a, sphere, b, facet] = group.front();
    const double radius = under.round_radius(a);
    double depth = -infinity, least = infinity;
    Vector<3> at = under.sphere(a, sphere, false);
    if (is_point(group.front(), under)) {
      std::vector<HardCorners> corners;
      for (const Pair& pair : group) corners.push_back(under.corners(b, pair.facet, false));
      depth = -nearest_of(corners, at).gap;
    } else {
      for (const Pair& pair : group) {
        Place place;
        if (!locate(pair, under, place) || std::abs(place.g0 + radius) >= least) continue;
        least = std::abs(place.g0 + radius);
        depth = -place.g0;
        at = place.x;
      }
    }
    if (depth <= found.depth) return;
    const bool body_first = a < num_bodies();
    found = {.depth = depth, .body = body_first ? a : b, .other = body_first ? b : a, .place = at};
  });
  return found;
}

void visit_memories(StateVisitor& visitor, const std::string& name, HardMemories& memories) {
  constexpr std::size_t width = 15;
  std::vector<double> numbers;
  for (const auto& [key, list] : memories) {
    for (const HardMemory& memory : list) {
      for (const std::int32_t k : key) numbers.push_back(k);
      numbers.push_back(memory.gap);
      numbers.push_back(memory.offset);
      numbers.push_back(memory.closing);
      for (const auto* part : {&memory.normal, &memory.slip, &memory.turn}) {
        numbers.insert(numbers.end(), part->begin(), part->end());
      }
    }
  }
  Json fact = numbers;
  visitor.fact(name, fact);
  numbers = fact.get<std::vector<double>>();
  require(numbers.size() % width == 0, "saved state: \"{}\" has {} values, allowed: {} for a place",
          name, numbers.size(), width);
  memories.clear();
  for (std::size_t k = 0; k < numbers.size(); k += width) {
    HardMemory memory;
    const auto at = [&](std::size_t i) {
      return Vector<3>(numbers[k + i], numbers[k + i + 1], numbers[k + i + 2]);
    };
    memory.gap = numbers[k + 3];
    memory.offset = numbers[k + 4];
    memory.closing = numbers[k + 5];
    memory.normal = at(6);
    memory.slip = at(9);
    memory.turn = at(12);
    memories[{static_cast<std::int32_t>(numbers[k]), static_cast<std::int32_t>(numbers[k + 1]),
              static_cast<std::int32_t>(numbers[k + 2])}]
        .push_back(memory);
  }
}

}  // namespace gabion::mpm
