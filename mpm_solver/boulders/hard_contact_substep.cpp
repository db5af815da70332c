// SPDX-License-Identifier: BSD-3-Clause
// Length and solution of a substep.
#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm_solver/boulders/aitken.hpp"
#include "mpm_solver/boulders/hard_contact_parts.hpp"
#include "mpm_solver/boulders/hard_law.hpp"

namespace gabion::mpm {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// A substep is this share of the inverse of a contact's frequency: t_c / 30.
constexpr double substep_share = 0.1;
// A pair that is farther apart than this many times the displacement in the last substep is not
// looked at again until it may be nearer.
constexpr double far = 20;
// Pairs that may come near are nearer than this many times the displacement of a substep by the
// speeds at its start.
constexpr double near = 1.5;
constexpr int most_iterations = 60, most_stalls = 3;
// Changes of places, over a radius and the distance from the origin of solve(), that end a
// solution: the larger one where rounding ends the convergence before the smaller one.
constexpr double same_at_worst = 1e-13;
constexpr double same_place = 1e-17;

}  // namespace

// Largest displacement of a point of each body and obstacle in the substep.
std::vector<double> HardContact::paths(const Under& under) const {
  std::vector<double> result;
  for (std::size_t c = 0; c < bodies_.size() + under.step.obstacles.size(); ++c) {
    const auto number = static_cast<std::int32_t>(c);
    if (under.is_body(number)) {
      const BodyMove move = under.move(number);
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
  const HardLaw law = law_between(bodies_, place.pair.a, place.pair.b);
  const double arm = body.radius * body.radius / body.mass.inertia.diagonal().minCoeff();
  const double mobility = 1 / body.mass.mass + arm;
  const double impact = std::cbrt(1.5 * body.mass.mass * speed * speed / law.stiffness);
  now = 2 * law.stiffness * std::max(-place.g0, 0.0) * mobility;
  const double tangential =
      tangential_at(place.g0, tangential_stiffness(place.pair.a, place.pair.b, law), law);
  return now + mobility * (2 * law.stiffness * impact + tangential);
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
  std::vector<double> rates(bodies_.size(), 0.0);  // of the contact points
  const auto look_at = [&](const Place& place) {
    nearest = std::min(nearest, place.g0);
    for (const std::int32_t c : {place.pair.a, place.pair.b}) {
      if (!under.is_free(c)) continue;
      double now = 0;
      fastest = std::max(fastest, stiffness_over_mass(place, c, closing, now));
      rates[c] += now;
    }
  };
  for (Watched& w : watched) {
    const Pair& pair = w.pairs.front();
    if (!under.is_free(pair.a) && !under.is_free(pair.b)) {
      w.apart = 0;
      continue;
    }
    if (w.apart > far * closing * under.h) {
      nearest = std::min(nearest, w.apart);
      continue;
    }
    w.apart = infinity;
    for (const Place& place : near_places(w.pairs, under, memories)) {
      look_at(place);
      w.apart = std::min(w.apart, place.g0);
    }
    if (w.apart == infinity) w.apart = 0;  // it may yet come out from behind the surface
  }
  if (nearest > 1.2 * closing * remaining) return remaining;
  for (const double rate : rates) fastest = std::max(fastest, rate);
  if (fastest == 0 && nearest <= 0) return remaining;
  double h = fastest > 0 ? substep_share / std::sqrt(fastest) : 0;
  if (nearest > 0) h = std::max(h, 0.8 * nearest / closing);
  return std::min(remaining, h);
}

// Displacements of the bodies by the loads in a substep, over the rounding of their places.
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
  sums = {.loads = std::vector<BodyLoad>(bodies_.size())};
  AitkenRelaxation relaxation;
  double least = infinity;
  int stalls = 0;  // iterations in a row without a new smallest change
  for (int k = 0; k < most_iterations; ++k) {
    for (std::size_t c = 0; c < bodies_.size(); ++c) {
      if (under.step.held[c] != 0) continue;
      const BodyLoad& given = under.step.loads[c];
      const Vector<3> weight = under.step.gravity_share * bodies_[c].mass.mass * gravity_;
      under.s1[c] = advance(
          bodies_[c].mass, under.s0[c],
          {given.force + sums.loads[c].force + weight, given.moment + sums.loads[c].moment}, h);
    }
    Sums now{.loads = std::vector<BodyLoad>(bodies_.size())};
    evaluate(under, pairs, memories, now);
    const auto difference = effect(under, sums, now);
    double change = 0;
    for (const double value : difference) change = std::max(change, std::abs(value));
    stalls = change < least ? 0 : stalls + 1;
    if (change <= same_place || (stalls >= most_stalls && change < same_at_worst)) {
      sums.memories = std::move(now.memories);
      sums.too_deep = now.too_deep;
      return true;
    }
    least = std::min(least, change);
    sums.approach(now, relaxation.next(difference));
  }
  return false;
}

// A substep with the pairs that may come into contact in it; with all of them if the bodies go
// farther.
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
    if (all || std::ranges::max(paths(under)) <= most) return true;
  }
  return true;
}

}  // namespace gabion::mpm
