// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/step/damping.hpp"

#include <algorithm>
#include <vector>

#include "common/base/require.hpp"
#include "fem_solver/supports/boundary_conditions.hpp"

namespace gabion::fem {

template <int dim>
bool is_damped(const FemSettings<dim>& settings) {
  return !settings.dashpots.empty() ||
         std::ranges::any_of(settings.materials, [](const auto& material) {
           return material.rayleigh.mass > 0 || material.rayleigh.stiffness > 0;
         });
}

template <int dim>
Damping<dim>::Damping(const FemSettings<dim>& settings, const CellIntegrals<dim>& cells) {
  cells.set_pattern(C_);
  C_.set_zero();
  add_mass(settings);
  add_stiffness(cells);
  add_dashpots(settings, C_);
}

/// The mass of cells is linear in their density.
template <int dim>
void Damping<dim>::add_mass(const FemSettings<dim>& settings) {
  std::vector<CellMaterial<dim>> materials = settings.materials;
  std::vector<LineMaterial> lines = settings.line_materials;
  for (auto& material : materials) material.density *= material.rayleigh.mass;
  for (auto& line : lines) line.density = 0;
  const CellIntegrals<dim> scaled(settings.mesh, materials, settings.lumped_mass, settings.ranks,
                                  {lines, settings.beam_nodes(), &settings.embedded});
  scaled.add_mass(1, C_);
}

template <int dim>
void Damping<dim>::add_stiffness(const CellIntegrals<dim>& cells) {
  const std::vector<double> u(static_cast<std::size_t>(C_.num_nodes()) * dim, 0.0);
  std::vector<double> f(u.size());
  for (const CellBlock<dim>& block : cells.blocks()) {
    const double factor = block.material().rayleigh.stiffness;
    if (factor == 0) continue;
    BlockMatrix<dim> K;
    cells.set_pattern(K);
    K.set_zero();
    const std::vector<double> virgin(block.history_size(), 0.0);
    std::vector<double> trial = virgin;
    block.add_internal(u, f, &K, {.accepted = virgin, .trial = trial});
    const std::span<const double> from = K.values();
    const std::span<double> to = C_.values();
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += factor * from[i];
  }
}

template <int dim>
void Damping<dim>::add_times(std::span<const double> v, std::span<double> f) const {
  std::vector<double> product(f.size());
  C_.multiply(v, product);
  for (std::size_t i = 0; i < f.size(); ++i) f[i] += product[i];
}

template <int dim>
void Damping<dim>::add(double scale, BlockMatrix<dim>& K) const {
  const std::span<const double> from = C_.values();
  const std::span<double> to = K.values();
  require(from.size() == to.size(), "fem_solver: found two patterns, of stiffness and damping");
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += scale * from[i];
}

template class Damping<2>;
template class Damping<3>;
template bool is_damped(const FemSettings<2>&);
template bool is_damped(const FemSettings<3>&);

}  // namespace gabion::fem
