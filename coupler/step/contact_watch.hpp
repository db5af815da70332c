// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/run/solver.hpp"

namespace gabion {

/// Tells when the contact at the interface changed so much that secants from before are worthless:
/// contact began or ended, or a soil's "contact_signature" changed. A soil may put this number into
/// StepReport::details to have the history dropped by a rule of its own.
class ContactWatch {
 public:
  /// @param reports  of all soils, from the first iteration of a step
  bool changed(const std::vector<StepReport>& reports) const;
  /// Note that the step with these reports was accepted.
  void accept(const std::vector<StepReport>& reports);
  void visit_state(StateVisitor& visitor);

 private:
  bool known_ = false;
  std::vector<bool> active_;
  std::vector<Json> signatures_;  // null where a soil gives none
};

}  // namespace gabion
