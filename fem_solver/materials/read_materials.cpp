// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "fem_solver/materials/line_material.hpp"

namespace gabion::fem {

template <int dim>
std::pair<std::vector<CellMaterial<dim>>, std::vector<LineMaterial>> read_materials(
    ConfigReader& in) {
  if (in.has("material") == in.has("materials")) {
    in.fail("material", fmt::format("found {}, allowed: either \"material\", of all cells, or "
                                    "\"materials\", each of a group of cells",
                                    in.has("material") ? "both" : "neither"));
  }
  if (in.has("material")) return {{read_cell_material<dim>(in.object("material"), false)}, {}};
  std::vector<CellMaterial<dim>> materials;
  std::vector<LineMaterial> lines;
  std::set<std::string> groups;
  std::size_t count = 0;
  for (auto& item : in.objects("materials")) {
    const std::string group = item.text("group");
    if (std::ranges::find(line_laws, item.choice("law")) != line_laws.end()) {
      lines.push_back(read_line_material(item, dim));
    } else {
      materials.push_back(read_cell_material<dim>(item, true));
    }
    if (!groups.insert(group).second) {
      in.fail(fmt::format("materials/{}/group", count),
              fmt::format("found \"{}\" a second time, allowed: each group once", group));
    }
    ++count;
  }
  if (count == 0) in.fail("materials", "found [], allowed: at least one material");
  return {std::move(materials), std::move(lines)};
}

template std::pair<std::vector<CellMaterial<2>>, std::vector<LineMaterial>> read_materials<2>(
    ConfigReader&);
template std::pair<std::vector<CellMaterial<3>>, std::vector<LineMaterial>> read_materials<3>(
    ConfigReader&);

}  // namespace gabion::fem
