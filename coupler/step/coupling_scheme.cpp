// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/step/coupling_scheme.hpp"

#include <exception>

namespace gabion {

namespace {

/// The soil first, then the structure with its force: x -> f -> x_tilde.
class SerialImplicit : public CouplingScheme {
 public:
  bool solve(Sides& sides, Attempt& now) const override {
    sides.solve_soils(now);
    now.f_given = now.f;
    const bool contact = now.request.iteration > 0 || sides.contact_possible(now);
    sides.solve_structures(now, /*may_sleep=*/!contact);
    return contact;
  }
  ConvergenceState check(Convergence& convergence, const Attempt& now) const override {
    return convergence.check(now.x, now.x_tilde, now.f);
  }
  Eigen::VectorXd unknowns(const Eigen::VectorXd& x, const Eigen::VectorXd&) const override {
    return x;
  }
  void set_guess(const Eigen::VectorXd& unknowns, Attempt& now) const override { now.x = unknowns; }
  std::vector<Eigen::Index> fields(Eigen::Index size) const override { return {size}; }
};

/// The serial scheme with one iteration.
class Explicit final : public SerialImplicit {
 public:
  bool repeats() const override { return false; }
};

/// Both sides at once: [x; f_given] -> [x_tilde; f].
class ParallelImplicit final : public CouplingScheme {
 public:
  bool solve(Sides& sides, Attempt& now) const override {
    const bool first = now.request.iteration == 0;
    const bool no_load = now.f_given.isZero(0);
    solve_at_once(sides, now, /*may_sleep=*/first && no_load);  // contact is not known yet
    const bool contact = !first || sides.contact_possible(now);
    if (!contact && !no_load) {  // a force was predicted, and there is none
      now.f_given = now.f;
      sides.solve_structures(now, /*may_sleep=*/true);
    }
    return contact;
  }
  ConvergenceState check(Convergence& convergence, const Attempt& now) const override {
    return convergence.check(now.x, now.x_tilde, now.f_given, now.f);
  }
  Eigen::VectorXd unknowns(const Eigen::VectorXd& x, const Eigen::VectorXd& f) const override {
    Eigen::VectorXd both(x.size() + f.size());
    both << x, f;
    return both;
  }
  void set_guess(const Eigen::VectorXd& unknowns, Attempt& now) const override {
    now.x = unknowns.head(unknowns.size() / 2);
    now.f_given = unknowns.tail(unknowns.size() / 2);
  }
  std::vector<Eigen::Index> fields(Eigen::Index size) const override { return {size, size}; }

 private:
  /// Solve both sides at the same time; when one of them fails the other one is finished all the
  /// same.
  static void solve_at_once(Sides& sides, Attempt& now, bool may_sleep) {
    const Stopwatch watch;
    sides.start_soils(now);
    sides.start_structures(now, may_sleep);
    std::exception_ptr failure;
    try {
      sides.finish_soils(now, watch);
    } catch (const ConvergenceError&) {
      failure = std::current_exception();
    }
    sides.finish_structures(now, watch);
    if (failure) std::rethrow_exception(failure);
  }
};

}  // namespace

std::unique_ptr<CouplingScheme> make_scheme(Scheme scheme) {
  if (scheme == Scheme::parallel_implicit) return std::make_unique<ParallelImplicit>();
  if (scheme == Scheme::explicit_) return std::make_unique<Explicit>();
  return std::make_unique<SerialImplicit>();
}

}  // namespace gabion
