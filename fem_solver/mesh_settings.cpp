// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/mesh_settings.hpp"

#include <fmt/format.h>

#include <set>
#include <string>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "fem_solver/stress/membranes.hpp"

namespace gabion::fem {

template <int dim>
void read_materials_of_all(ConfigReader& in, MPI_Comm comm, FemSettings<dim>& s) {
  StructureMaterials<dim> materials = read_materials<dim>(in);
  s.materials = std::move(materials.cells);
  s.line_materials = std::move(materials.lines);
  s.membranes = std::move(materials.membranes);
  const int ranks = num_ranks(comm);
  require<ConfigError>(s.membranes.empty() || ranks == 1, [&] {
    return fmt::format(
        "{}: found \"formulation\" \"membrane\" on {} ranks of the structure, allowed: one rank",
        s.membranes[0].where, ranks);
  });
}

template <int dim>
void check_membranes_behind(const FemSettings<dim>& s) {
  for (const auto& interface : s.interfaces) {
    for (const std::string& group : interface.groups) {
      require<ConfigError>(interface.behind.empty() || !s.mesh.sheet_groups.contains(group), [&] {
        return fmt::format(
            "{}: found \"behind\" with the membrane \"{}\", allowed: facets of "
            "solid cells alone",
            interface.behind_where, group);
      });
    }
  }
}

template <int dim>
RankedMesh<dim> read_mesh_with_lines(const Scene& scene, ConfigReader& in,
                                     const FemSettings<dim>& s, MPI_Comm comm) {
  std::set<std::string> lines;
  for (const LineMaterial& material : s.line_materials) lines.insert(material.group);
  for (const MembraneMaterial& material : s.membranes) lines.insert(material.group);
  auto ranked = read_mesh_of_rank<dim>(scene, in, comm, lines);
  const std::int32_t num_cells = ranked.ranks.num_cells_of_all(ranked.mesh);
  if (s.materials.empty() && num_cells > 0) {
    in.fail("materials",
            fmt::format(
                "found materials of lines or membranes only, with a mesh of {} cells of type {}, "
                "allowed: a material for each cell",
                num_cells, name(ranked.mesh.cell_type)));
  }
  if (!s.membranes.empty()) {
    add_sheets<dim>(ranked.mesh, s.membranes);
    if (!ranked.mesh.file.empty()) ranked.connection = connection_of(ranked.mesh);
  }
  return ranked;
}

template void read_materials_of_all(ConfigReader&, MPI_Comm, FemSettings<2>&);
template void read_materials_of_all(ConfigReader&, MPI_Comm, FemSettings<3>&);
template void check_membranes_behind(const FemSettings<2>&);
template void check_membranes_behind(const FemSettings<3>&);
template RankedMesh<2> read_mesh_with_lines(const Scene&, ConfigReader&, const FemSettings<2>&,
                                            MPI_Comm);
template RankedMesh<3> read_mesh_with_lines(const Scene&, ConfigReader&, const FemSettings<3>&,
                                            MPI_Comm);

}  // namespace gabion::fem
