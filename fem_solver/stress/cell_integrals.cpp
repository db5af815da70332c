// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/cell_integrals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "common/base/require.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
#include "fem_solver/stress/cells_of_materials.hpp"

namespace gabion::fem {

namespace {

/// Degree that integrates N_a N_b of an undistorted cell exactly.
int mass_degree(CellType type) {
  if (is_quadratic(type)) return is_simplex(type) ? 4 : 5;
  return is_simplex(type) ? 2 : 3;
}

/// Refuse a formulation that cells of this type do not have.
template <int dim>
void check_formulation(const CellMaterial<dim>& material, CellType type) {
  const bool can_be_enhanced = type == CellType::quad4 || type == CellType::hex8;
  const bool can_be_reduced = type == CellType::quad8 || type == CellType::hex20;
  require<ConfigError>(
      material.formulation != Formulation::enhanced || can_be_enhanced,
      "{}: found \"formulation\" \"enhanced\" with cells of type {}, allowed: quad4, hex8",
      material.where, name(type));
  require<ConfigError>(
      material.formulation != Formulation::reduced || can_be_reduced,
      "{}: found \"formulation\" \"reduced\" with cells of type {}, allowed: quad8, hex20",
      material.where, name(type));
  require<ConfigError>(
      material.formulation != Formulation::solid_shell || type == CellType::hex8,
      "{}: found \"formulation\" \"solid_shell\" with cells of type {}, allowed: hex8",
      material.where, name(type));
}

/// The mass of each cell in proportion to the diagonal of its matrix (Hinton, Rock and Zienkiewicz
/// 1976): row sums of quadratic cells are negative or zero at corners.
/// @param cells   nodes of each
/// @param masses  cells x nodes x nodes [kg]
std::vector<double> lump_by_diagonal(std::span<const std::int32_t> cells,
                                     std::span<const double> masses, int n, std::size_t num_nodes) {
  std::vector<double> lumped(num_nodes, 0.0);
  for (std::size_t first = 0; first < cells.size(); first += static_cast<std::size_t>(n)) {
    const double* M = masses.data() + first * static_cast<std::size_t>(n);
    const double whole = std::accumulate(M, M + n * n, 0.0);
    double diagonal = 0;
    for (int a = 0; a < n; ++a) diagonal += M[a * n + a];
    if (diagonal == 0) continue;  // a cell without mass
    for (int a = 0; a < n; ++a) lumped[cells[first + a]] += whole * M[a * n + a] / diagonal;
  }
  return lumped;
}

}  // namespace

template <int dim>
CellIntegrals<dim>::CellIntegrals(const Mesh<dim>& mesh,
                                  std::span<const CellMaterial<dim>> materials, bool lumped_mass,
                                  const MeshRanks& ranks, const LinesOfMesh<dim>& lines)
    : nodes_per_cell_(mesh.nodes_per_cell()),
      num_nodes_(mesh.num_nodes_total()),
      num_cells_(mesh.num_cells()),
      cell_nodes_(mesh.cells) {
  double smallest_volume = std::numeric_limits<double>::infinity();
  for (std::int32_t c = 0; c < num_cells_; ++c) {
    smallest_volume = std::min(smallest_volume, cell_volume(mesh, c));
  }
  smallest_cell_size_ = cube_side<dim>(smallest_volume);
  for (std::int32_t l = 0; l < mesh.num_lines(); ++l) {
    const auto ends = mesh.line(l);
    const double length = (mesh.nodes[ends[1]] - mesh.nodes[ends[0]]).norm();
    smallest_cell_size_ = std::min(smallest_cell_size_, length);
  }
  make_blocks(mesh, materials, ranks);
  make_line_blocks(mesh, lines, lumped_mass, ranks);
  compute_mass(mesh, lumped_mass);
}

template <int dim>
void CellIntegrals<dim>::make_blocks(const Mesh<dim>& mesh,
                                     std::span<const CellMaterial<dim>> materials,
                                     const MeshRanks& ranks) {
  for (const CellMaterial<dim>& material : materials) {
    check_formulation(material, mesh.cell_type);
  }
  auto cells = cells_of_materials<dim>(mesh, materials, ranks);
  for (std::size_t m = 0; m < materials.size(); ++m) {
    blocks_.emplace_back(mesh, materials[m], std::move(cells[m]), ranks);
  }
}

template <int dim>
void CellIntegrals<dim>::make_line_blocks(const Mesh<dim>& mesh, const LinesOfMesh<dim>& lines,
                                          bool lumped, const MeshRanks& ranks) {
  const EmbeddedNodes<dim>& embedded = lines.nodes_inside();
  auto of_materials = lines_of_materials<dim>(mesh, lines.materials, ranks);
  std::vector<char> is_beam(static_cast<std::size_t>(mesh.num_lines()), 0);
  for (std::size_t m = 0; m < lines.materials.size(); ++m) {
    for (const std::int32_t l : of_materials[m]) is_beam[l] = lines.materials[m].beam ? 1 : 0;
  }
  for (std::int32_t l = 0; l < mesh.num_lines(); ++l) {
    auto nodes = embedded.line_nodes(mesh, l);
    if (is_beam[l]) {
      for (const std::int32_t i : mesh.line(l)) nodes.push_back(lines.beam_nodes.of(i));
    }
    line_nodes_.insert(line_nodes_.end(), nodes.begin(), nodes.end());
    line_ends_.push_back(static_cast<std::int32_t>(line_nodes_.size()));
  }
  for (std::size_t m = 0; m < lines.materials.size(); ++m) {
    line_blocks_.emplace_back(mesh, lines.materials[m], std::move(of_materials[m]), lumped, lines);
  }
}

template <int dim>
void CellIntegrals<dim>::set_membranes(Membranes<dim> membranes) {
  membranes_ = std::move(membranes);
  smallest_cell_size_ = std::min(smallest_cell_size_, membranes_.smallest_size());
}

template <int dim>
void CellIntegrals<dim>::compute_mass(const Mesh<dim>& mesh, bool lumped) {
  const auto rule = gauss_rule<dim>(mesh.cell_type, mass_degree(mesh.cell_type));
  const int n = nodes_per_cell_;
  std::vector<double> densities(static_cast<std::size_t>(num_cells_));
  for (const auto& block : blocks_) {
    for (const std::int32_t c : block.cells()) densities[c] = block.material().density;
  }
  const bool row_sums = lumped && !is_quadratic(mesh.cell_type);
  if (row_sums) {
    lumped_masses_.assign(mesh.nodes.size(), 0.0);
  } else {
    cell_masses_.assign(static_cast<std::size_t>(num_cells_) * n * n, 0.0);
  }
  AnyShapeValues<dim> shape;
  Vector<dim> x[max_quadratic_nodes];
  for (std::int32_t c = 0; c < num_cells_; ++c) {
    for (int a = 0; a < n; ++a) x[a] = mesh.nodes[cell(c)[a]];
    for (const auto& q : rule) {
      shape_functions<dim>(mesh.cell_type, q.xi, shape);
      double N[max_quadratic_nodes];
      std::copy(shape.N, shape.N + n, N);
      const double mass = densities[c] * q.weight * map_gradients<dim>(mesh.cell_type, x, shape);
      for (int a = 0; a < n; ++a) {
        if (row_sums) lumped_masses_[cell(c)[a]] += mass * N[a];
        if (row_sums) continue;
        double* row = cell_masses_.data() + (static_cast<std::size_t>(c) * n + a) * n;
        for (int b = 0; b < n; ++b) row[b] += mass * N[a] * N[b];
      }
    }
  }
  if (!lumped || row_sums) return;
  lumped_masses_ = lump_by_diagonal(cell_nodes_, cell_masses_, n, mesh.nodes.size());
  cell_masses_.clear();
}

template <int dim>
void CellIntegrals<dim>::add_mass_times(std::span<const double> a, std::span<double> f) const {
  for (const auto& block : line_blocks_) block.add_mass_times(a, f);
  nodal_parts_.add_mass_times(a, f);
  membranes_.add_mass_times(a, f);
  for (std::size_t i = 0; i < lumped_masses_.size(); ++i) {
    for (int k = 0; k < dim; ++k) f[i * dim + k] += lumped_masses_[i] * a[i * dim + k];
  }
  if (cell_masses_.empty()) return;
  const int n = nodes_per_cell_;
  for (std::int32_t c = 0; c < num_cells_; ++c) {
    const auto node = cell(c);
    const double* M = cell_masses_.data() + static_cast<std::size_t>(c) * n * n;
    for (int i = 0; i < n; ++i) {
      Vector<dim> sum = Vector<dim>::Zero();
      for (int j = 0; j < n; ++j) {
        sum += M[i * n + j] *
               Eigen::Map<const Vector<dim>>(a.data() + static_cast<std::size_t>(node[j]) * dim);
      }
      Eigen::Map<Vector<dim>>(f.data() + static_cast<std::size_t>(node[i]) * dim) += sum;
    }
  }
}

template <int dim>
void CellIntegrals<dim>::add_mass(double scale, BlockMatrix<dim>& K) const {
  for (const auto& block : line_blocks_) block.add_mass(scale, K);
  nodal_parts_.add_mass(scale, K);
  membranes_.add_mass(scale, K, first_sheet());
  for (std::size_t i = 0; i < lumped_masses_.size(); ++i) {
    if (lumped_masses_[i] != 0) {
      K.add_diagonal(static_cast<std::int32_t>(i), scale * lumped_masses_[i]);
    }
  }
  if (cell_masses_.empty()) return;
  const int n = nodes_per_cell_;
  std::vector<double> K_cell(static_cast<std::size_t>(n * dim) * n * dim, 0.0);
  for (std::int32_t c = 0; c < num_cells_; ++c) {
    const double* M = cell_masses_.data() + static_cast<std::size_t>(c) * n * n;
    for (int a = 0; a < n; ++a) {
      for (int b = 0; b < n; ++b) {
        for (int k = 0; k < dim; ++k) {
          K_cell[static_cast<std::size_t>(a * dim + k) * n * dim + b * dim + k] =
              scale * M[a * n + b];
        }
      }
    }
    K.add_cell(c, K_cell.data());
  }
}

template <int dim>
void CellIntegrals<dim>::set_pattern(BlockMatrix<dim>& K) const {
  std::vector<std::int32_t> offsets(static_cast<std::size_t>(num_cells_) + 1);
  for (std::size_t c = 0; c < offsets.size(); ++c) {
    offsets[c] = static_cast<std::int32_t>(c) * nodes_per_cell_;
  }
  std::vector<std::int32_t> nodes = cell_nodes_;
  nodes.insert(nodes.end(), line_nodes_.begin(), line_nodes_.end());
  const std::int32_t first = offsets.back();
  for (const std::int32_t end : line_ends_) offsets.push_back(first + end);
  const std::vector<std::int32_t> of_links = links_.nodes();
  nodes.insert(nodes.end(), of_links.begin(), of_links.end());
  for (std::size_t k = 0; k < links_.num_arms(); ++k) offsets.push_back(offsets.back() + 3);
  membranes_.add_to_pattern(offsets, nodes);
  K.set_pattern(num_nodes_, offsets, nodes);
}

template <int dim>
StressIntegral CellIntegrals<dim>::add_internal(std::span<const double> u, std::span<double> f_int,
                                                BlockMatrix<dim>* K, HistoryStep history) const {
  StressIntegral sum;
  std::size_t first = 0;
  for (const auto& block : blocks_) {
    const HistoryStep own = history.part(first, block.history_size());
    const StressIntegral stresses = block.add_internal(u, f_int, K, own);
    sum = {.inadmissible_cell = stresses.inadmissible_cell,
           .fault = stresses.fault,
           .energy = sum.energy + stresses.energy};
    if (sum.inadmissible_cell >= 0) return sum;
    first += block.history_size();
  }
  for (const auto& block : line_blocks_) {
    const HistoryStep own = history.part(first, block.history_size());
    StressIntegral lines = block.add_internal(u, f_int, K, own);
    lines.energy += sum.energy;
    sum = lines;
    if (sum.inadmissible_cell >= 0) return sum;
    first += block.history_size();
  }
  sum.energy += nodal_parts_.add_internal(u, f_int, K);
  if (membranes_.any()) sum.energy += membranes_.add_internal(u, f_int, K, first_sheet());
  if (links_.num_arms() > 0) {
    sum.energy += links_.add_internal(u, f_int, K, static_cast<std::int32_t>(num_elements()),
                                      link_histories(history.accepted));
  }
  return sum;
}

template <int dim>
void CellIntegrals<dim>::add_line_stiffness(double share, BlockMatrix<dim>& K) const {
  for (const auto& block : line_blocks_) block.add_stiffness(share, K);
  membranes_.add_stiffness(share, K, first_sheet());
}

template <int dim>
std::vector<double> CellIntegrals<dim>::cell_stresses(std::span<const double> u,
                                                      std::span<const double> history) const {
  std::vector<double> result(static_cast<std::size_t>(num_cells_) * symmetric_size<dim>, 0.0);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    blocks_[b].find_stresses(u, of_block(history, b), result);
  }
  return result;
}

template <int dim>
std::vector<double> CellIntegrals<dim>::cell_plastic_strains(
    std::span<const double> history) const {
  std::vector<double> result(static_cast<std::size_t>(num_cells_), 0.0);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    blocks_[b].find_plastic_strains(of_block(history, b), result);
  }
  return result;
}

template <int dim>
double CellIntegrals<dim>::plastic_work(std::span<const double> history) const {
  double sum = 0;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    sum += blocks_[b].plastic_work(of_block(history, b));
  }
  for (std::size_t b = 0; b < line_blocks_.size(); ++b) {
    sum += line_blocks_[b].plastic_work(of_line_block(history, b));
  }
  return sum;
}

template <int dim>
double CellIntegrals<dim>::brake_work(std::span<const double> history) const {
  double sum = 0;
  for (std::size_t b = 0; b < line_blocks_.size(); ++b) {
    sum += line_blocks_[b].brake_work(of_line_block(history, b));
  }
  return sum;
}

template <int dim>
std::vector<double> CellIntegrals<dim>::line_forces(std::span<const double> u,
                                                    std::span<const double> history) const {
  std::vector<double> result(num_lines(), 0.0);
  for (std::size_t b = 0; b < line_blocks_.size(); ++b) {
    const auto lines = line_blocks_[b].lines();
    const auto forces = line_blocks_[b].forces(u, of_line_block(history, b));
    for (std::size_t k = 0; k < lines.size(); ++k) result[lines[k]] = forces[k];
  }
  return result;
}

template <int dim>
std::vector<double> CellIntegrals<dim>::line_runs(std::span<const double> history) const {
  std::vector<double> result(num_lines(), 0.0);
  for (std::size_t b = 0; b < line_blocks_.size(); ++b) {
    if (!line_blocks_[b].material().brake) continue;
    const auto lines = line_blocks_[b].lines();
    const auto runs = of_line_block(history, b);
    const std::size_t width = line_blocks_[b].history_width();
    for (std::size_t k = 0; k < lines.size(); ++k) result[lines[k]] = runs[k * width];
  }
  return result;
}

template <int dim>
double CellIntegrals<dim>::largest_rotation(std::span<const double> u) const {
  double largest = 0;
  for (const auto& block : blocks_) largest = std::max(largest, block.largest_rotation(u));
  return largest;
}

template <int dim>
bool CellIntegrals<dim>::yields() const {
  return std::ranges::any_of(blocks_, [](const auto& block) { return block.yields(); });
}

template <int dim>
bool CellIntegrals<dim>::cracks() const {
  return std::ranges::any_of(blocks_, [](const auto& block) { return block.cracks(); });
}

template class CellIntegrals<2>;
template class CellIntegrals<3>;

}  // namespace gabion::fem
