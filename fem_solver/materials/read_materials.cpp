// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>

#include "fem_solver/materials/line_material.hpp"

namespace gabion::fem {

template <int dim>
StructureMaterials<dim> read_materials(ConfigReader& in) {
  if (in.has("material") == in.has("materials")) {
    in.fail("material", fmt::format("found {}, allowed: either \"material\", of all cells, or "
                                    "\"materials\", each of a group of cells",
                                    in.has("material") ? "both" : "neither"));
  }
  StructureMaterials<dim> materials;
  if (in.has("material")) {
    materials.cells = {read_cell_material<dim>(in.object("material"), false)};
    return materials;
  }
  std::set<std::string> groups;
  std::size_t count = 0;
  for (auto& item : in.objects("materials")) {
    const std::string group = item.text("group");
    if (std::ranges::find(line_laws, item.choice("law")) != line_laws.end()) {
      materials.lines.push_back(read_line_material(item, dim));
    } else if (item.choice("formulation") == "membrane") {
      materials.membranes.push_back(read_membrane_material(item, dim));
    } else {
      materials.cells.push_back(read_cell_material<dim>(item, true));
    }
    if (!groups.insert(group).second) {
      in.fail(fmt::format("materials/{}/group", count),
              fmt::format("found \"{}\" a second time, allowed: each group once", group));
    }
    ++count;
  }
  if (count == 0) in.fail("materials", "found [], allowed: at least one material");
  return materials;
}

template StructureMaterials<2> read_materials(ConfigReader&);
template StructureMaterials<3> read_materials(ConfigReader&);

}  // namespace gabion::fem
