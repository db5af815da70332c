// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/membranes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <map>
#include <string>

#include "common/base/require.hpp"

namespace gabion::fem {

template <int dim>
Membranes<dim>::Membranes(const Mesh<dim>& mesh, std::span<const MembraneMaterial> materials,
                          bool lumped_mass)
    : nodes_(mesh.sheets), width_(static_cast<std::size_t>(num_nodes(facet_type(mesh.cell_type)))) {
  if constexpr (dim == 3) {
    for (const MembraneMaterial& material : materials) {
      blocks_.emplace_back(mesh, material, mesh.sheet_groups.at(material.group), lumped_mass);
    }
  }
}

template <int dim>
double Membranes<dim>::smallest_size() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& block : blocks_) smallest = std::min(smallest, block.smallest_size());
  return smallest;
}

template <int dim>
double Membranes<dim>::wave_speed() const {
  double fastest = 0;
  for (const auto& block : blocks_) fastest = std::max(fastest, block.material().wave_speed());
  return fastest;
}

template <int dim>
void Membranes<dim>::add_to_pattern(std::vector<std::int32_t>& offsets,
                                    std::vector<std::int32_t>& nodes) const {
  nodes.insert(nodes.end(), nodes_.begin(), nodes_.end());
  for (std::int32_t s = 0; s < num_sheets(); ++s) {
    offsets.push_back(offsets.back() + static_cast<std::int32_t>(width_));
  }
}

template <int dim>
double Membranes<dim>::add_internal(std::span<const double> u, std::span<double> f_int,
                                    BlockMatrix<dim>* K, std::int32_t first) const {
  double energy = 0;
  if constexpr (dim == 3) {
    for (const auto& block : blocks_) energy += block.add_internal(u, f_int, K, first);
  }
  return energy;
}

template <int dim>
void Membranes<dim>::add_stiffness(double share, BlockMatrix<dim>& K, std::int32_t first) const {
  if constexpr (dim == 3) {
    for (const auto& block : blocks_) block.add_stiffness(share, K, first);
  }
}

template <int dim>
void Membranes<dim>::add_mass_times(std::span<const double> a, std::span<double> f) const {
  for (const auto& block : blocks_) block.add_mass_times(a, f);
}

template <int dim>
void Membranes<dim>::add_mass(double scale, BlockMatrix<dim>& K, std::int32_t first) const {
  if constexpr (dim == 3) {
    for (const auto& block : blocks_) block.add_mass(scale, K, first);
  }
}

namespace {

template <int dim>
std::string names_of_groups(const Mesh<dim>& mesh) {
  std::vector<std::string> names;
  for (const auto& [name, facets] : mesh.facet_groups) names.push_back(name);
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

template <int dim>
void add_sheets(Mesh<dim>& mesh, std::span<const MembraneMaterial> materials) {
  const auto n = static_cast<std::size_t>(num_nodes(facet_type(mesh.cell_type)));
  std::map<std::vector<std::int32_t>, const MembraneMaterial*> known;
  for (const MembraneMaterial& material : materials) {
    const auto found = mesh.facet_groups.find(material.group);
    require<ConfigError>(found != mesh.facet_groups.end(), [&] {
      return fmt::format(
          "{}: found \"formulation\" \"membrane\" of group \"{}\", which is none of surfaces, "
          "allowed: a physical group of surfaces; {} has: {}",
          material.where, material.group, mesh.file.empty() ? "a box" : mesh.file,
          names_of_groups(mesh));
    });
    auto& members = mesh.sheet_groups[material.group];
    const auto& facets = found->second;
    for (std::size_t f = 0; f < facets.size(); f += n) {
      const auto begin = facets.begin() + static_cast<std::ptrdiff_t>(f);
      std::vector<std::int32_t> corners(begin, begin + static_cast<std::ptrdiff_t>(n));
      std::ranges::sort(corners);
      const auto [other, is_new] = known.try_emplace(std::move(corners), &material);
      require<ConfigError>(is_new, [&] {
        const Vector<dim>& x = mesh.nodes[*begin];
        return fmt::format(
            "{}: found a membrane cell at ({:.6g}) in the groups \"{}\" and \"{}\", allowed: each "
            "cell in one group of \"materials\", and once",
            material.where, fmt::join(x.data(), x.data() + dim, ", "), other->second->group,
            material.group);
      });
      members.push_back(mesh.num_sheets());
      mesh.sheets.insert(mesh.sheets.end(), begin, begin + static_cast<std::ptrdiff_t>(n));
    }
  }
}

template class Membranes<2>;
template class Membranes<3>;
template void add_sheets(Mesh<2>&, std::span<const MembraneMaterial>);
template void add_sheets(Mesh<3>&, std::span<const MembraneMaterial>);

}  // namespace gabion::fem
