// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <vector>

namespace gabion::fem {

/// Energy dissipator in line with a rope: it runs out under a force that depends on how far it has
/// run, and never back. The force is given by rows of run and force, linear between them and
/// constant after the last, up to a limit of the run.
class Brake {
 public:
  /// The run at which rope and brake are in balance, and the slope of the force over the stretch of
  /// both there; the rope's own stiffness where the brake does not run.
  struct Balance {
    double run;    ///< [m]
    double slope;  ///< [N/m]
  };

  Brake() = default;
  /// @param runs    [m], rising, the first 0
  /// @param forces  of each run [N], > 0
  Brake(std::vector<double> runs, std::vector<double> forces, double run_limit);

  double force(double run) const;  ///< [N]
  /// Integral of the force from run 0 on [J].
  double work(double run) const;
  /// Solve k (stretch - run') = force(run') with run' >= run; run' = run where the force is not
  /// reached.
  /// @param stretch    of rope and brake from the stress-free length [m]
  /// @param stiffness  k of the rope [N/m], more than the steepest fall of the force
  Balance balance(double stretch, double run, double stiffness) const;
  double steepest_fall() const;  ///< of the force over the run, >= 0 [N/m]

 private:
  std::size_t row_of(double run) const;
  double slope_of(std::size_t row) const;  ///< behind the row

  std::vector<double> runs_, forces_;
  double run_limit_ = std::numeric_limits<double>::infinity();
};

}  // namespace gabion::fem
