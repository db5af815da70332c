// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "common/mechanics/mesh/mesh.hpp"
#include "common/mechanics/petsc/linear_method.hpp"
#include "fem_solver/ranks/mesh_ranks.hpp"

namespace gabion::fem {

/// Number of nodes on the widest front on a walk through the mesh from one end to the other, where
/// the neighbours of a front are the next one: some 3 n^2 in a cube of n^3 nodes, 2 n in a sheet of
/// n^2. Collective, as all of these. The cost of a sparse factor grows with it: per row of the
/// matrix, numbers with the unknowns of the front, operations with their square.
template <int dim>
std::int64_t front_width(const Mesh<dim>& mesh, const MeshRanks& ranks = {});

/// Whether the mesh is far from a cube: less than a fifth of as many nodes as a cube that takes as
/// many fronts.
template <int dim>
bool is_slender(const Mesh<dim>& mesh, const MeshRanks& ranks = {});

/// The settings for a matrix that serves over iterations and steps: "auto" becomes the direct
/// method unless its factor in space costs more than Krylov iterations save
/// (docs/measured/solvers.md), which happens at smaller sizes in statics than in a dynamic
/// analysis.
template <int dim>
LinearSolverSettings with_kept_factor(LinearSolverSettings settings, const Mesh<dim>& mesh,
                                      const MeshRanks& ranks, bool dynamic);

}  // namespace gabion::fem
