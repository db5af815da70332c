// SPDX-License-Identifier: BSD-3-Clause
#include "mesh.hpp"

#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/grid_in.h>

#include <common/base/error.hpp>

#include <algorithm>
#include <fstream>

namespace dealii_structure {

namespace {

/// Names of the sides of a box, in the order of the numbers that GridGenerator gives them.
template <int dim>
std::vector<std::string> sides() {
  if constexpr (dim == 2) return {"left", "right", "bottom", "top"};
  return {"left", "right", "front", "back", "bottom", "top"};
}

template <int dim>
void make_box(const BoxSettings& box, dealii::Triangulation<dim>& mesh) {
  const std::vector<unsigned> cells(box.cells.begin(), box.cells.end());
  dealii::GridGenerator::subdivided_hyper_rectangle(mesh, cells, point_of<dim>(box.low),
                                                    point_of<dim>(box.high), /*colorize=*/true);
}

template <int dim>
void read_file(const std::string& path, dealii::Triangulation<dim>& mesh) {
  std::ifstream file(path);
  if (!file) throw gabion::ConfigError(path + ": cannot be read");
  try {
    dealii::GridIn<dim>(mesh).read_msh(file);
  } catch (const std::exception& problem) {
    throw gabion::ConfigError(path + ": " + problem.what());
  }
}

template <int dim, class Cell>
bool is_near(const Cell& cell, const dealii::Point<dim>& point, double radius) {
  if (cell->center().distance(point) <= radius) return true;
  for (const unsigned v : cell->vertex_indices()) {
    if (cell->vertex(v).distance(point) <= radius) return true;
  }
  return false;
}

template <int dim>
void refine(const RefinementSettings& settings, int index, dealii::Triangulation<dim>& mesh) {
  const auto point = point_of<dim>(settings.near);
  for (int round = 0; round < settings.times; ++round) {
    int found = 0;
    for (const auto& cell : mesh.active_cell_iterators()) {
      if (!is_near(cell, point, settings.radius)) continue;
      cell->set_refine_flag();
      ++found;
    }
    if (found == 0) {
      throw gabion::ConfigError("structure: at /refine/" + std::to_string(index) +
                                "/radius: no cell has a vertex or its centre within " +
                                std::to_string(settings.radius) + " m of the point in round " +
                                std::to_string(round + 1) + ", allowed: a larger radius");
    }
    mesh.execute_coarsening_and_refinement();
  }
}

template <int dim>
std::string names_of(const Settings& settings, const dealii::Triangulation<dim>& mesh) {
  std::string all;
  for (const auto id : mesh.get_boundary_ids()) {
    all += (all.empty() ? "" : ", ");
    all += settings.mesh_file.empty() ? sides<dim>()[id] : std::to_string(id);
  }
  return all;
}

}  // namespace

template <int dim>
void make_mesh(const Settings& settings, dealii::Triangulation<dim>& mesh) {
  if (settings.mesh_file.empty()) {
    make_box(settings.box, mesh);
  } else {
    read_file(settings.mesh_file, mesh);
  }
  if (!mesh.all_reference_cells_are_hyper_cube()) {
    throw gabion::ConfigError(
        settings.mesh_file + ": found triangles or tetrahedra, allowed: quadrilaterals, hexahedra");
  }
  for (std::size_t k = 0; k < settings.refinements.size(); ++k) {
    refine(settings.refinements[k], static_cast<int>(k), mesh);
  }
}

template <int dim>
std::set<dealii::types::boundary_id> boundary_ids(const Settings& settings,
                                                  const dealii::Triangulation<dim>& mesh,
                                                  const std::vector<std::string>& groups) {
  std::set<dealii::types::boundary_id> ids;
  const auto all = mesh.get_boundary_ids();
  for (const auto& group : groups) {
    const auto found = std::find_if(all.begin(), all.end(), [&](auto id) {
      return group == (settings.mesh_file.empty() ? sides<dim>()[id] : std::to_string(id));
    });
    if (found == all.end()) {
      throw gabion::ConfigError("structure: found group \"" + group +
                                "\", allowed: " + names_of(settings, mesh));
    }
    ids.insert(*found);
  }
  return ids;
}

template void make_mesh<2>(const Settings&, dealii::Triangulation<2>&);
template void make_mesh<3>(const Settings&, dealii::Triangulation<3>&);
template std::set<dealii::types::boundary_id> boundary_ids<2>(const Settings&,
                                                              const dealii::Triangulation<2>&,
                                                              const std::vector<std::string>&);
template std::set<dealii::types::boundary_id> boundary_ids<3>(const Settings&,
                                                              const dealii::Triangulation<3>&,
                                                              const std::vector<std::string>&);

}  // namespace dealii_structure
