// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/step/start_values.hpp"

#include <algorithm>

namespace gabion::fem {

template <int dim>
std::vector<double> coordinates_of(const FemSettings<dim>& settings) {
  std::vector<double> x;
  x.reserve(settings.mesh.nodes.size() * dim);
  for (const Vector<dim>& node : settings.mesh.nodes) x.insert(x.end(), node.begin(), node.end());
  return settings.ranks.owned(std::move(x), dim);
}

template <int dim>
std::vector<double> gravity_forces(const FemSettings<dim>& settings,
                                   const Equilibrium<dim>& equilibrium) {
  std::vector<double> g(equilibrium.num_dofs());
  const auto places = static_cast<std::size_t>(settings.num_places()) * dim;
  for (std::size_t i = 0; i < places; ++i) g[i] = settings.gravity[i % dim];
  return settings.gravity.isZero(0) ? std::vector<double>(g.size(), 0.0)
                                    : equilibrium.mass_times(g);
}

template <int dim>
bool is_without_forces(const StructureState& reference, Equilibrium<dim>& equilibrium) {
  if (!equilibrium.shared().all(std::ranges::all_of(reference.f_ext, is_zero))) return false;
  const auto internal = equilibrium.internal_forces(reference.motion.u, reference.history).f;
  return equilibrium.shared().all(std::ranges::all_of(internal, is_zero));
}

template std::vector<double> coordinates_of(const FemSettings<2>&);
template std::vector<double> coordinates_of(const FemSettings<3>&);
template std::vector<double> gravity_forces(const FemSettings<2>&, const Equilibrium<2>&);
template std::vector<double> gravity_forces(const FemSettings<3>&, const Equilibrium<3>&);

template bool is_without_forces(const StructureState&, Equilibrium<2>&);
template bool is_without_forces(const StructureState&, Equilibrium<3>&);

}  // namespace gabion::fem
