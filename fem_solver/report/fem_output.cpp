// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/report/fem_output.hpp"

#include "common/mechanics/ranks/sum.hpp"

namespace gabion::fem {

namespace {

using Values = std::span<const double>;

template <int dim>
std::vector<OutputField> frame_fields(Values u, Values v, Values f_ext, Values stress) {
  return {
      {.name = "displacement", .components = dim, .values = u},
      {.name = "velocity", .components = dim, .values = v},
      {.name = "external_force", .components = dim, .values = f_ext},
      {.name = "stress", .components = symmetric_size<dim>, .values = stress, .on_cells = true}};
}

}  // namespace

template <int dim>
std::int64_t FemOutput<dim>::frame_bytes(const Mesh<dim>& mesh) {
  return XdmfSeries::frame_bytes(mesh.num_nodes_total(), mesh.cell_type, mesh.num_cells(),
                                 frame_fields<dim>({}, {}, {}, {}));
}

template <int dim>
FemOutput<dim>::FemOutput(const Mesh<dim>& mesh, std::string folder, MPI_Comm comm)
    : mesh_(mesh), comm_(comm), folder_(std::move(folder)) {}

template <int dim>
void FemOutput<dim>::write(double time, const StructureState& state,
                           const Equilibrium<dim>& equilibrium) {
  constexpr int size = symmetric_size<dim>;
  const CellRange own = cells_of_rank(mesh_.num_cells(), rank_of(comm_), num_ranks(comm_));
  const auto own_stress = equilibrium.cells().cell_stresses(state.motion.u);
  std::vector<double> stress(static_cast<std::size_t>(mesh_.num_cells()) * size, 0.0);
  std::copy(own_stress.begin(), own_stress.end(),
            stress.begin() + static_cast<std::ptrdiff_t>(own.first) * size);
  sum_over_ranks(comm_, std::span<double>(stress));
  if (rank_of(comm_) != 0) return;
  if (!series_) series_.emplace(folder_, "structure");

  std::vector<double> x(state.motion.u);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += mesh_.nodes[i / dim][i % dim];
  std::vector<double> forces(state.f_ext);
  for (std::size_t i = 0; i < forces.size(); ++i) forces[i] += state.f_step[i];
  series_->write({.time = time,
                  .dim = dim,
                  .coordinates = x,
                  .cell_type = mesh_.cell_type,
                  .connectivity = mesh_.cells,
                  .fields = frame_fields<dim>(state.motion.u, state.motion.v, forces, stress)});
}

template class FemOutput<2>;
template class FemOutput<3>;

}  // namespace gabion::fem
