// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "element_test/element_point.hpp"

namespace gabion::element {

/// Effort of an increment.
struct Effort {
  int iterations = 0;  ///< of Newton's method, those of shorter steps included
  int cuts = 0;        ///< steps that were halved
};

/// Take the sample through a stage. An increment whose equations Newton's method does not solve is
/// halved, as far as to 1/4096; equilibrium holds at the end of each part.
/// @param state   where the stage begins; at its end, where it ended or could go no farther
/// @param report  called after each increment, and at a start where strains become zero
/// @throws ConvergenceError  with the place and the reason
void follow_stage(const ElementSettings& settings, const StageSettings& stage, ElementState& state,
                  const std::function<void(const ElementState&, const Effort&)>& report);

}  // namespace gabion::element
