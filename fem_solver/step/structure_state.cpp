// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/step/structure_state.hpp"

#include <algorithm>
#include <cstdint>

#include "common/base/require.hpp"

namespace gabion::fem {

bool StructureMotion::is_still() const {
  const auto zero = [](double x) { return x == 0; };
  return std::all_of(v.begin(), v.end(), zero) && std::all_of(a.begin(), a.end(), zero);
}

void StructureState::visit_state(StateVisitor& visitor) {
  visitor.real("time", time);
  visitor.reals("u", motion.u);
  visitor.reals("v", motion.v);
  visitor.reals("a", motion.a);
  visitor.reals("f_ext", f_ext);
  visitor.reals("f_step", f_step);
  visitor.reals("f_int", f_int);
  visitor.reals("reactions", reactions);
  visitor.flag("balanced", balanced);
  visitor.real("elastic_energy", elastic_energy);
  visitor.real("external_work", external_work);

  bool has_tangent = tangent.has_value();
  visitor.flag("has_tangent", has_tangent);
  if (has_tangent) {
    TangentPoint point = tangent.value_or(TangentPoint{.u = motion.u});
    visitor.reals("tangent.u", point.u);
    visitor.real("tangent.dt", point.dt);
    visitor.flag("tangent.with_inertia", point.with_inertia);
    tangent = std::move(point);
  } else {
    tangent.reset();
  }

  std::int64_t method = rescue ? static_cast<std::int64_t>(*rescue) : -1;
  visitor.integer("rescue", method);
  require(method >= -1 && method <= static_cast<std::int64_t>(SolutionMethod::cg),
          "saved state: \"rescue\" is no method of solution");
  pause.visit_state(visitor);
  rescue.reset();
  if (method >= 0) rescue = static_cast<SolutionMethod>(method);
}

}  // namespace gabion::fem
