// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "mpm_solver/boulders/hard_contact.hpp"

namespace gabion::mpm {

/// Energy and momentum of all boulders. The kinetic energy changes by the works of gravity, soil
/// and hard contact; the last one is stored, done on surfaces that move, or lost.
class BoulderLedger {
 public:
  /// The step of `end` is accepted.
  /// @param gravity  [m/s^2]
  void add_step(const HardContact& contact, const HardContact::Start& start,
                const HardContact::Step& step, const HardContact::End& end,
                const Vector<3>& gravity);

  /// Columns of the tables.
  static std::vector<std::string> names(int dim);
  std::vector<double> values(int dim, const HardContact& contact,
                             const HardContact::Start& now) const;

  void visit_state(StateVisitor& visitor);

 private:
  // Sums since the start [J]: work on all boulders of gravity, soil and hard contact; work of
  // boulders on surfaces.
  double gravity_work_ = 0, soil_work_ = 0, contact_work_ = 0, surface_work_ = 0;
};

}  // namespace gabion::mpm
