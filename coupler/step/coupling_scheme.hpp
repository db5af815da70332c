// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "coupler/convergence/convergence.hpp"
#include "coupler/coupler_config.hpp"
#include "coupler/step/attempt.hpp"
#include "coupler/step/sides.hpp"

namespace gabion {

/// Order of the solvers within an iteration, and the unknowns of the iteration
/// (docs/theory/coupling.md).
class CouplingScheme {
 public:
  virtual ~CouplingScheme() = default;

  /// Ask both sides once: fills `now` from u to x_tilde. Structures at rest without load may be
  /// skipped while there is no contact.
  /// @returns whether the soils may answer another force to another x
  /// @throws ConvergenceError  a solver could not solve
  virtual bool solve(Sides& sides, Attempt& now) const = 0;
  /// Residuals of `now`, and the verdict on the step.
  virtual ConvergenceState check(Convergence& convergence, const Attempt& now) const = 0;
  /// Whether the step is repeated until both sides agree.
  virtual bool repeats() const { return true; }

  /// Unknowns of the iteration, from the fields that are given to the solvers or that they
  /// answered.
  virtual Eigen::VectorXd unknowns(const Eigen::VectorXd& x, const Eigen::VectorXd& f) const = 0;
  /// The next guess: sets what will be given to the solvers.
  virtual void set_guess(const Eigen::VectorXd& unknowns, Attempt& now) const = 0;
  /// Sizes of the fields that the unknowns consist of, when x has this size.
  virtual std::vector<Eigen::Index> fields(Eigen::Index size) const = 0;
};

std::unique_ptr<CouplingScheme> make_scheme(Scheme scheme);

}  // namespace gabion
