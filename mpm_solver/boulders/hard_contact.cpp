// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/hard_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "common/base/require.hpp"
#include "mpm_solver/boulders/aitken.hpp"
#include "mpm_solver/boulders/hard_contact_parts.hpp"

namespace gabion::mpm {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Of the inverse of a contact's frequency: t_c / 30.
constexpr double substep_share = 0.1;
// Of the way that the bodies' motion at the start leads to.
constexpr double ahead = 1.5;
constexpr double least_ahead = 0.05;  // of the smallest radius
// Of the way in the last substep: what is farther is not looked at again until it may be nearer.
constexpr double far = 20;
// Of the way in a substep by the speeds at its start.
constexpr double near = 1.5;
constexpr int most_iterations = 60, most_halvings = 12;
constexpr int most_looks = 4;
constexpr int most_stalls = 3;
constexpr double same_at_worst = 1e-13;  // where rounding ends the convergence before that:
constexpr double same_place = 1e-17;     // of a radius and a distance from the origin

}  // namespace

HardContact::HardContact(int dim, std::vector<HardBody> bodies, const Vector<3>& gravity)
    : dim_(dim), bodies_(std::move(bodies)), gravity_(gravity) {}

void HardContact::add_pairs(std::int32_t a, std::int32_t b, const Under& under, double reach,
                            std::vector<Pair>& pairs) const {
  const double radius = under.ball_radius(a);
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
  const bool is_ball = radius > 0;
  const auto num_balls =
      static_cast<std::int32_t>(is_ball            ? 1
                                : under.is_body(a) ? bodies_[a].vertices.size()
                                                   : under.obstacle(a).start.size());
  for (std::int32_t k = 0; k < num_balls; ++k) {
    const Vector<3> c = under.ball(a, k, false);
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
        if (bodies_[b].ball > 0) {
          if (a < b && bodies_[a].ball > 0) pairs.push_back({a, 0, b, -1});
          continue;
        }
      }
      add_pairs(a, b, under, reach, pairs);
    }
    if (bodies_[a].ball > 0) continue;
    for (std::int32_t o = num_bodies(); o < total; ++o) add_pairs(o, a, under, reach, pairs);
  }
  return pairs;
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

// Largest way of a point of each body and obstacle in the substep.
std::vector<double> HardContact::ways(const Under& under) const {
  std::vector<double> result;
  for (std::size_t c = 0; c < bodies_.size() + under.step.obstacles.size(); ++c) {
    const auto number = static_cast<std::int32_t>(c);
    if (under.is_body(number)) {
      const BodyMove move = move_of(under.s0[c], under.s1[c], under.h);
      result.push_back(move.shift.norm() + bodies_[c].radius * move.turn.norm());
    } else {
      result.push_back(under.speed(number) * under.h);
    }
  }
  return result;
}

// Squared frequency of a body at a place, the largest in an impact; `now` is that of its depth.
double HardContact::stiffness_over_mass(const Place& place, std::int32_t c, double speed,
                                        double& now) const {
  const HardBody& body = bodies_[c];
  const HardLaw law = law_of(place.pair.a, place.pair.b);
  const double arm = body.radius * body.radius / body.mass.inertia.diagonal().minCoeff();
  const double mobility = 1 / body.mass.mass + arm;
  const double impact = std::cbrt(1.5 * body.mass.mass * speed * speed / law.stiffness);
  const double depth = std::max(-place.g0, 0.0);
  now = 2 * law.stiffness * depth * mobility;
  return now + mobility * (2 * law.stiffness * impact +
                           tangential_stiffness(place.pair.a, place.pair.b, law));
}

// Length of the next substep, by the gaps and depths at its start.
double HardContact::substep(const Under& under, std::vector<Watched>& watched,
                            const HardMemories& memories, double remaining) const {
  double body = 0, obstacle = 0;
  for (std::size_t c = 0; c < bodies_.size() + under.step.obstacles.size(); ++c) {
    double& most = c < bodies_.size() ? body : obstacle;
    most = std::max(most, under.speed(static_cast<std::int32_t>(c)));
  }
  const double closing = 2 * body + obstacle + gravity_.norm() * remaining;
  double nearest = infinity, fastest = 0;
  std::vector<double> rates(bodies_.size(), 0.0);  // of the touching places
  const auto look_at = [&](const Place& place) {
    nearest = std::min(nearest, place.g0);
    for (const std::int32_t c : {place.pair.a, place.pair.b}) {
      if (!under.is_body(c) || under.step.held[c] != 0) continue;
      double now = 0;
      fastest = std::max(fastest, stiffness_over_mass(place, c, closing, now));
      rates[c] += now;
    }
  };
  for (Watched& w : watched) {
    if (w.apart > far * closing * under.h) {
      nearest = std::min(nearest, w.apart);
      continue;
    }
    w.apart = infinity;
    for (const Place& place : places_before(w.pairs, under, memories)) {
      look_at(place);
      w.apart = std::min(w.apart, place.g0);
    }
    if (w.apart == infinity) w.apart = 0;  // it may yet come out of what it is behind
  }
  if (nearest > 1.2 * closing * remaining) return remaining;
  for (const double rate : rates) fastest = std::max(fastest, rate);
  if (fastest == 0 && nearest <= 0) return remaining;
  double h = fastest > 0 ? substep_share / std::sqrt(fastest) : 0;
  if (nearest > 0) h = std::max(h, 0.8 * nearest / closing);
  return std::min(remaining, h);
}

// What loads do to the places of bodies in a substep, over the rounding of these.
std::vector<double> HardContact::effect(const Under& under, const Sums& from,
                                        const Sums& to) const {
  std::vector<double> result;
  for (std::size_t c = 0; c < bodies_.size(); ++c) {
    if (under.step.held[c] != 0) continue;
    const HardBody& body = bodies_[c];
    const double share = 0.5 * under.h * under.h / (body.radius + under.s0[c].x.norm());
    const double turned = 2 * body.radius / body.mass.inertia.diagonal().minCoeff();
    const Vector<3> dx = share / body.mass.mass * (to.loads[c].force - from.loads[c].force);
    const Vector<3> turn = share * turned * (to.loads[c].moment - from.loads[c].moment);
    result.insert(result.end(), dx.begin(), dx.end());
    result.insert(result.end(), turn.begin(), turn.end());
  }
  return result;
}

// The fixed point of the loads at the end of a substep, with Aitken's relaxation; the loads are
// those that led there.
bool HardContact::solve_substep(double h, const HardMemories& memories,
                                const std::vector<Pair>& pairs, Under& under, Sums& sums) const {
  under.h = h;
  under.s1 = under.s0;
  sums = no_sums(under);
  AitkenRelaxation relaxation;
  double least = infinity;
  int stalls = 0;
  for (int k = 0; k < most_iterations; ++k) {
    for (std::size_t c = 0; c < bodies_.size(); ++c) {
      if (under.step.held[c] != 0) continue;
      const BodyLoad& given = under.step.loads[c];
      const Vector<3> weight = under.step.gravity_share * bodies_[c].mass.mass * gravity_;
      under.s1[c] = advance(
          bodies_[c].mass, under.s0[c],
          {given.force + sums.loads[c].force + weight, given.moment + sums.loads[c].moment}, h);
    }
    Sums now = no_sums(under);
    evaluate(under, pairs, memories, now);
    const auto difference = effect(under, sums, now);
    double change = 0;
    for (const double value : difference) change = std::max(change, std::abs(value));
    stalls = change < least ? 0 : stalls + 1;
    if (change <= same_place || (stalls >= most_stalls && least < same_at_worst)) {
      sums.memories = std::move(now.memories);
      return true;
    }
    least = std::min(least, change);
    sums.approach(now, relaxation.next(difference));
  }
  return false;
}

HardContact::Sums HardContact::no_sums(const Under& under) const {
  Sums sums{.loads = std::vector<BodyLoad>(bodies_.size())};
  for (const Obstacle& o : under.step.obstacles) {
    sums.nodal_forces.emplace_back(o.start.size(), Vector<3>::Zero());
  }
  return sums;
}

// A substep with the pairs that may touch in it; with all of them if the bodies go farther.
bool HardContact::solve_near(double h, const HardMemories& memories,
                             const std::vector<Watched>& watched, Under& under, Sums& sums) const {
  double most = infinity;
  for (const bool all : {false, true}) {
    std::vector<Pair> pairs;
    under.h = h;
    under.s1 = under.s0;
    if (!all) {
      most = 0;
      for (std::size_t c = 0; c < bodies_.size() + under.step.obstacles.size(); ++c) {
        most = std::max(most, near * h * under.speed(static_cast<std::int32_t>(c)));
      }
      most += near * h * h * gravity_.norm();
    }
    for (const Watched& w : watched) {
      if (all || w.apart <= 2 * most) pairs.insert(pairs.end(), w.pairs.begin(), w.pairs.end());
    }
    if (!solve_substep(h, memories, pairs, under, sums)) return false;
    if (all || std::ranges::max(ways(under)) <= most) return true;
  }
  return true;
}

bool HardContact::solve_within(double reach, const Start& start, const Step& step, End& end) const {
  const auto pairs = near_pairs(start.states, step, reach);
  std::vector<Watched> watched;
  Under::for_groups(pairs, [&](std::span<const Pair> group) { watched.push_back({group}); });
  Under under{.dim = dim_, .bodies = bodies_, .step = step, .s0 = start.states, .s1 = start.states};
  end = {.memories = start.memories,
         .works = std::vector<double>(bodies_.size(), 0.0),
         .loads = std::vector<BodyLoad>(bodies_.size())};
  for (const Obstacle& o : step.obstacles) {
    end.nodal_forces.emplace_back(o.start.size(), Vector<3>::Zero());
  }
  under.h = step.dt;
  for (double done = 0; done < step.dt; ++end.substeps) {
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
    const auto way = ways(under);
    for (Watched& w : watched) w.apart -= way[w.pairs.front().a] + way[w.pairs.front().b];
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
  for (std::size_t c = 0; c < bodies_.size(); ++c) {
    const BodyMove move = move_of(under.s0[c], under.s1[c], under.h);
    end.works[c] += sums.loads[c].force.dot(move.shift) + sums.loads[c].moment.dot(move.turn);
    end.loads[c].force += share * sums.loads[c].force;
    end.loads[c].moment += share * sums.loads[c].moment;
  }
  for (std::size_t o = 0; o < sums.nodal_forces.size(); ++o) {
    for (std::size_t v = 0; v < sums.nodal_forces[o].size(); ++v) {
      end.nodal_forces[o][v] += share * sums.nodal_forces[o][v];
    }
  }
  end.memories = std::move(sums.memories);
}

// What springs give back may be faster than what the step began with.
HardContact::End HardContact::solve(const Start& start, const Step& step) const {
  double reach = look_ahead(start, step);
  End end;
  for (int k = 0; k < most_looks; ++k, reach *= 4) {
    if (solve_within(reach, start, step, end)) return end;
  }
  throw ConvergenceError("boulders move too far in one step to know what they touch", "boulders");
}

// The nearest place of each surface says on which side a ball is.
HardContact::Overlap HardContact::deepest_overlap(const std::vector<BodyState>& states,
                                                  const std::vector<Obstacle>& obstacles) const {
  const Step step{.dt = 1, .held = std::vector<char>(bodies_.size(), 1), .obstacles = obstacles};
  const Under under{
      .dim = dim_, .bodies = bodies_, .step = step, .s0 = states, .s1 = states, .h = 1};
  double reach = 0;
  for (const HardBody& body : bodies_) reach = std::max(reach, body.radius);
  Overlap found;
  Under::for_groups(near_pairs(states, step, reach), [&](std::span<const Pair> group) {
    const auto& [a, ball, b, facet] = group.front();
    const double radius = under.ball_radius(a);
    double depth = -infinity, least = infinity;
    Vector<3> at = under.ball(a, ball, false);
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
  constexpr std::size_t width = 14;
  std::vector<double> numbers;
  for (const auto& [key, list] : memories) {
    for (const HardMemory& memory : list) {
      for (const std::int32_t k : key) numbers.push_back(k);
      numbers.push_back(memory.gap);
      numbers.push_back(memory.offset);
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
    memory.normal = at(5);
    memory.slip = at(8);
    memory.turn = at(11);
    memories[{static_cast<std::int32_t>(numbers[k]), static_cast<std::int32_t>(numbers[k + 1]),
              static_cast<std::int32_t>(numbers[k + 2])}]
        .push_back(memory);
  }
}

}  // namespace gabion::mpm
