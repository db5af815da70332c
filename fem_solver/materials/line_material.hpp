// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/settings/config_reader.hpp"
#include "fem_solver/beams/cross_section.hpp"
#include "fem_solver/materials/brake.hpp"
#include "fem_solver/materials/cell_material.hpp"
#include "fem_solver/materials/failure.hpp"
#include "fem_solver/materials/hardening.hpp"
#include "fem_solver/materials/membrane_material.hpp"

namespace gabion::fem {

/// Material and section of the line cells of a group: forces along the line only, from its length,
/// unless they are beams.
struct LineMaterial {
  std::string group;
  std::string where;  ///< place of the group in the config, for errors
  std::string law_name;
  double density = 0;           ///< [kg/m^3], in the stress-free state
  double young_modulus = 0;     ///< [Pa]
  double area = 0;              ///< stress-free [m^2], in the plane per metre of thickness [m]
  double length_ratio = 1;      ///< stress-free length over the length in the mesh
  bool embedded = false;        ///< its nodes inside cells move with them
  bool in_compression = false;  ///< false: slack where it is shorter than stress-free
  std::optional<Brake> brake;   ///< in series with each cell of the group
  std::optional<Hardening> hardening;  ///< of a bar or beam that yields, over strain of L0
  double kinematic_modulus = 0;        ///< of these [Pa]
  std::optional<BeamData> beam;        ///< they bend, shear and twist, too
  FailureLimits failure;

  double stiffness() const { return young_modulus * area; }  ///< E A [N]
  /// Numbers that a line remembers: the run of its brake; plastic strain and its sum of a bar.
  std::size_t history_size() const { return brake ? 1 : hardening ? 2 : 0; }
};

/// Response of a line cell to its length.
struct LineResponse {
  double force = 0;   ///< along the line, tension positive [N]
  double slope = 0;   ///< d force / d length [N/m]
  double energy = 0;  ///< stored [J]
  double run = 0;     ///< of its brake [m]
};

/// Force over elongation: elastic with the engineering strain, so that the force follows from an
/// energy of the length alone; the run of a brake is subtracted from the elongation.
/// @param run  of the brake in the accepted state [m]
LineResponse respond(const LineMaterial& material, double stress_free_length, double length,
                     double run);

/// Response of a line of any law.
/// @param history_n  accepted, history_size()
/// @param history    at the end of the step
LineResponse respond(const LineMaterial& material, double stress_free_length, double length,
                     std::span<const double> history_n, std::span<double> history);

/// Stress of a bar, or of a fibre of a beam, that yields.
struct BarStress {
  double stress = 0;          ///< [Pa]
  double slope = 0;           ///< d stress / d strain [Pa]
  double elastic_strain = 0;  ///< strain without the plastic one
};

/// Backward Euler from the accepted plastic strain, and the sum of its size.
/// @pre the material has hardening
BarStress bar_stress(const LineMaterial& bar, double strain, std::span<const double> history_n,
                     std::span<double> history);

/// Work of yielding of a bar or fibre, per volume [J/m^3].
double plastic_work(const LineMaterial& bar, std::span<const double> history);

/// Laws of lines: truss, cable, brake, bar, beam.
extern const std::vector<std::string> line_laws;

/// Keys beside group, law, density and young_modulus.
std::vector<Key> line_keys();

/// Read what group_material_keys() list of a line.
/// @param dim  of space
/// @throws ConfigError  a table of a brake that does not rise in run, ...
LineMaterial read_line_material(ConfigReader in, int dim);

/// Materials of a structure: of all cells or each of a group of them, of lines, of membranes.
template <int dim>
struct StructureMaterials {
  std::vector<CellMaterial<dim>> cells;
  std::vector<LineMaterial> lines;
  std::vector<MembraneMaterial> membranes;
};

/// Read "material", of all cells, or "materials", each of a group of cells, lines or membranes.
/// @throws ConfigError  both or neither; a group a second time
template <int dim>
StructureMaterials<dim> read_materials(ConfigReader& in);

}  // namespace gabion::fem
