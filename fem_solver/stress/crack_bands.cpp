// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/crack_bands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include "common/base/require.hpp"
#include "common/mechanics/elements/shape_functions.hpp"

namespace gabion::fem {

namespace {

template <int dim>
CrackBand<dim> band_of(const Mesh<dim>& mesh, std::int32_t c) {
  CrackBand<dim> band;
  const double volume = cell_volume(mesh, c);
  if (is_simplex(mesh.cell_type)) {
    band.mean = std::pow((dim == 2 ? 2 : 6) * volume, 1.0 / dim);
    return band;
  }
  band.mean = std::pow(volume, 1.0 / dim);
  AnyShapeValues<dim> shape;
  shape_functions<dim>(mesh.cell_type, Vector<dim>::Zero(), shape);
  for (int a = 0; a < mesh.nodes_per_cell(); ++a) {  // from -1 to 1 on each axis
    band.edges += 2 * mesh.nodes[mesh.cell(c)[a]] * shape.dN[a].transpose();
  }
  return band;
}

struct Limit {
  double widest;        // [m]
  double energy;        // [J/m^2]
  const char* formula;  // of the widest
  const std::string& where;
};

template <int dim>
void check_width(const Mesh<dim>& mesh, const MeshRanks& ranks, std::int32_t c, double width,
                 const Limit& limit) {
  require<ConfigError>(width < limit.widest, [&] {
    const Vector<dim>& x = mesh.nodes[mesh.cell(c)[0]];
    return fmt::format(
        "{}: found {:.6g} J/m^2 with cell {} near ({:.6g}), {:.6g} m wide; allowed: cells below "
        "{:.6g} m ({}), or more than {:.6g} J/m^2",
        limit.where, limit.energy, ranks.cell_of_all(c), fmt::join(x.data(), x.data() + dim, ", "),
        width, limit.widest, limit.formula, limit.energy * width / limit.widest);
  });
}

}  // namespace

template <int dim>
std::vector<CrackBand<dim>> crack_bands(const Mesh<dim>& mesh, const CellMaterial<dim>& material,
                                        std::span<const std::int32_t> cells,
                                        const MeshRanks& ranks) {
  std::vector<CrackBand<dim>> bands;
  const auto* law = std::get_if<Concrete<dim>>(&material.law);
  if (!law) return bands;
  require<ConfigError>(!is_quadratic(mesh.cell_type),
                       "{}: found \"law\" \"concrete\" with cells of type {}, allowed: linear "
                       "ones; a crack would be "
                       "narrower than its cell, and take less than the fracture energy",
                       material.where, name(mesh.cell_type));
  require<ConfigError>(material.formulation == Formulation::full,
                       "{}: found \"formulation\" \"{}\" with \"law\" \"concrete\", allowed: "
                       "\"full\"; a crack "
                       "would be narrower than its cell, and take less than the fracture energy",
                       material.where,
                       material.formulation == Formulation::enhanced ? "enhanced" : "solid_shell");
  for (const std::int32_t c : cells) {
    bands.push_back(band_of(mesh, c));
    const double width = bands.back().largest();
    check_width(mesh, ranks, c, std::min(width, law->crack_spacing),
                {.widest = law->widest_crack_band(),
                 .energy = law->tension.fracture_energy,
                 .formula = "2 E fracture_energy / tensile_strength^2",
                 .where = law->where_fracture});
    check_width(mesh, ranks, c, width,
                {.widest = law->crushing.widest_band(),
                 .energy = law->crushing.crushing_energy,
                 .formula = "E crushing_energy / compressive_strength^2",
                 .where = law->where_crushing});
  }
  return bands;
}

template std::vector<CrackBand<2>> crack_bands(const Mesh<2>&, const CellMaterial<2>&,
                                               std::span<const std::int32_t>, const MeshRanks&);
template std::vector<CrackBand<3>> crack_bands(const Mesh<3>&, const CellMaterial<3>&,
                                               std::span<const std::int32_t>, const MeshRanks&);

}  // namespace gabion::fem
