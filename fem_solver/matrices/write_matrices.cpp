// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/write_matrices.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <fstream>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "fem_solver/matrices/matrix_files.hpp"
#include "fem_solver/step/equilibrium.hpp"

namespace gabion::fem {

namespace {

template <int dim>
SparseMatrix scalar_matrix(const BlockMatrix<dim>& blocks) {
  std::vector<Eigen::Triplet<double>> triplets;
  const auto starts = blocks.row_starts();
  for (int i = 0; i < blocks.num_nodes(); ++i) {
    for (int s = starts[i]; s < starts[i + 1]; ++s) {
      const double* block = blocks.values().data() + static_cast<std::size_t>(s) * dim * dim;
      for (int e = 0; e < dim * dim; ++e) {
        const int row = i * dim + e % dim, column = blocks.columns()[s] * dim + e / dim;
        if (block[e] != 0) triplets.emplace_back(row, column, block[e]);
      }
    }
  }
  const int n = blocks.num_nodes() * dim;
  SparseMatrix A(n, n);
  A.setFromTriplets(triplets.begin(), triplets.end());
  return A;
}

/// A text file, or an error.
class TextFile {
 public:
  explicit TextFile(const std::string& path) : path_(path), out_(path) {}
  void line(const std::string& text) { out_ << text << '\n'; }
  void close() {
    out_.close();
    require(out_.good(), "{}: cannot be written", path_);
  }

 private:
  std::string path_;
  std::ofstream out_;
};

/// Node numbers of the files: from 1 on.
void write_node_rows(const std::string& path, std::span<const std::int32_t> nodes, int width) {
  TextFile file(path);
  for (std::size_t i = 0; i < nodes.size(); i += width) {
    std::vector<std::int32_t> numbers(nodes.begin() + i, nodes.begin() + i + width);
    for (auto& number : numbers) ++number;
    file.line(fmt::format("{}", fmt::join(numbers, ",")));
  }
  file.close();
}

template <int dim>
void write_mesh(const FemSettings<dim>& settings, const std::string& folder) {
  const Mesh<dim>& mesh = settings.mesh;
  TextFile nodes(folder + "/nodes.csv");
  nodes.line(dim == 2 ? "node,x,y" : "node,x,y,z");
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    const auto& x = mesh.nodes[i];
    nodes.line(fmt::format("{},{}", i + 1, fmt::join(x.data(), x.data() + dim, ",")));
  }
  nodes.close();
  write_node_rows(folder + "/cells.csv", mesh.cells, mesh.nodes_per_cell());
  for (const auto& interface : settings.interfaces) {
    std::vector<std::int32_t> facets;
    for (const auto& group : interface.groups) {
      const auto& part = mesh.facets(group, interface.where);
      facets.insert(facets.end(), part.begin(), part.end());
    }
    write_node_rows(fmt::format("{}/{}.csv", folder, interface.name), facets,
                    num_nodes(facet_type(mesh.cell_type)));
  }
}

/// The structure's fem.json with the files in place of its mesh.
template <int dim>
Json scene_file(const FemSettings<dim>& settings, const Json& resolved, bool has_load) {
  Json json = {{"dimension", dim},
               {"matrices",
                {{"stiffness", "K.mtx"},
                 {"mass", "M.mtx"},
                 {"unknowns", "unknowns.csv"},
                 {"held", "held.csv"},
                 {"nodes", "nodes.csv"},
                 {"cells", "cells.csv"}}}};
  if (has_load) json["matrices"]["load"] = "load.mtx";
  for (const char* key : {"analysis", "time_integration", "initial_velocity", "initial_equilibrium",
                          "probes", "time", "output", "checkpoint"}) {
    if (resolved.contains(key)) json[key] = resolved.at(key);
  }
  for (const auto& interface : settings.interfaces) {
    json["interfaces"].push_back({{"name", interface.name}, {"facets", interface.name + ".csv"}});
  }
  return json;
}

template <int dim>
std::vector<int> write_unknowns(const BoundaryConditions<dim>& conditions, std::size_t num_dofs,
                                const std::string& folder) {
  std::vector<char> constrained(num_dofs, 0);
  for (const auto dof : conditions.constrained_dofs()) constrained[dof] = 1;
  std::vector<int> free;
  TextFile unknowns(folder + "/unknowns.csv"), held(folder + "/held.csv");
  for (TextFile* file : {&unknowns, &held}) file->line("node,direction");
  for (std::size_t dof = 0; dof < num_dofs; ++dof) {
    if (!constrained[dof]) free.push_back(static_cast<int>(dof));
    (constrained[dof] ? held : unknowns).line(fmt::format("{},{}", dof / dim + 1, dof % dim + 1));
  }
  unknowns.close();
  held.close();
  return free;
}

/// Gravity and loads, whose values at time 0 hold.
template <int dim>
std::vector<double> constant_loads(const FemSettings<dim>& settings,
                                   const BoundaryConditions<dim>& conditions,
                                   const Equilibrium<dim>& equilibrium) {
  std::vector<double> g(equilibrium.num_dofs());
  for (std::size_t i = 0; i < g.size(); ++i) g[i] = settings.gravity[i % dim];
  std::vector<double> f = equilibrium.mass_times(g);
  conditions.add_loads(0, f);
  return f;
}

}  // namespace

template <int dim>
void write_matrices(const FemSettings<dim>& settings, const Json& resolved, MPI_Comm comm,
                    const std::string& folder) {
  require<ConfigError>(num_ranks(comm) == 1, "--write-matrices: found {} ranks, allowed: 1",
                       num_ranks(comm));
  const BoundaryConditions<dim> conditions(settings);
  require<ConfigError>(settings.prescribed.empty() && conditions.constant_after(0),
                       "--write-matrices: found \"prescribed\" or a \"table\" of a load, allowed: "
                       "supports and constant loads");
  require<ConfigError>(settings.line_materials.empty(),
                       "--write-matrices: found line cells (\"law\" \"{}\"), allowed: a structure "
                       "without lines, because a cable is not linear",
                       settings.line_materials.empty() ? "" : settings.line_materials[0].law_name);
  require<ConfigError>(settings.membranes.empty(),
                       "--write-matrices: found \"formulation\" \"membrane\", allowed: a structure "
                       "without membranes, which are not linear");
  require<ConfigError>(!is_damped(settings),
                       "--write-matrices: found \"rayleigh\" or \"dashpots\", allowed: a structure "
                       "without damping; \"rayleigh\" may be given beside the matrices");
  std::filesystem::create_directories(folder);
  Equilibrium<dim> equilibrium(settings, conditions, comm);
  const std::size_t num_dofs = equilibrium.num_dofs();
  const std::vector<int> free = write_unknowns(conditions, num_dofs, folder);

  BlockMatrix<dim> K, M;
  equilibrium.set_pattern(K);
  equilibrium.set_pattern(M);
  equilibrium.assemble_tangent(std::vector<double>(num_dofs, 0.0), 1, /*with_inertia=*/false, K);
  M.set_zero();
  equilibrium.cells().add_mass(1, M);
  write_symmetric_matrix(folder + "/K.mtx", part_of(scalar_matrix(K), free, free));
  write_symmetric_matrix(folder + "/M.mtx", part_of(scalar_matrix(M), free, free));

  const std::vector<double> f = constant_loads(settings, conditions, equilibrium);
  const Eigen::VectorXd load = Eigen::Map<const Eigen::VectorXd>(f.data(), f.size())(free);
  if (!load.isZero(0)) write_vector(folder + "/load.mtx", load);
  write_mesh(settings, folder);
  TextFile file(folder + "/fem.json");
  file.line(scene_file(settings, resolved, !load.isZero(0)).dump(2));
  file.close();
}

template void write_matrices<2>(const FemSettings<2>&, const Json&, MPI_Comm, const std::string&);
template void write_matrices<3>(const FemSettings<3>&, const Json&, MPI_Comm, const std::string&);

}  // namespace gabion::fem
