// SPDX-License-Identifier: BSD-3-Clause
// What of the structure later steps depend on.
#include "common/base/require.hpp"
#include "fem_solver/fem_solver.hpp"

namespace gabion::fem {

void FemState::visit_state(StateVisitor& visitor) {
  visitor.real("time", time);
  visitor.reals("u", motion.u);
  visitor.reals("v", motion.v);
  visitor.reals("a", motion.a);
  visitor.reals("f_ext", f_ext);
  visitor.reals("f_int", f_int);
  visitor.reals("reactions", reactions);
  visitor.flag("balanced", balanced);
  visitor.real("elastic_energy", elastic_energy);
  visitor.real("external_work", external_work);

  bool has_tangent = tangent.has_value();
  visitor.flag("has_tangent", has_tangent);
  if (has_tangent) {
    TangentPoint point = tangent.value_or(TangentPoint{motion.u, 0, false});
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
  rescue.reset();
  if (method >= 0) rescue = static_cast<SolutionMethod>(method);
}

template <int dim>
State FemSolver<dim>::save_state() {
  State state;
  StateWriter writer(state);
  state_.visit_state(writer);
  return state;
}

template <int dim>
void FemSolver<dim>::load_state(const State& state) {
  reject_step();
  StateReader reader(state);
  state_.visit_state(reader);
}

template State FemSolver<2>::save_state();
template State FemSolver<3>::save_state();
template void FemSolver<2>::load_state(const State& state);
template void FemSolver<3>::load_state(const State& state);

}  // namespace gabion::fem
