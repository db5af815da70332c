// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/step/attempt.hpp"

namespace gabion {

std::string status(const Attempt& attempt) {
  if (attempt.outcome == Outcome::one_pass) return "explicit";
  if (attempt.outcome == Outcome::no_contact) return "inactive";
  return name(attempt.row.state.verdict);
}

}  // namespace gabion
