// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/mechanics/tensor.hpp"
#include "common/settings/config_reader.hpp"
#include "fem_solver/beams/beam_forces.hpp"
#include "fem_solver/beams/fibres.hpp"

namespace gabion::fem {

/// Section of a beam, axes 2 and 3 in it; in the plane per metre of thickness, 3 across the plane.
struct CrossSection {
  double area = 0;                      ///< [m^2]
  std::array<double, 2> shear_areas{};  ///< for forces along 2 and 3 [m^2]
  std::array<double, 2> moments{};      ///< second moments about 2 and 3 [m^4]
  double torsion_constant = 0;          ///< [m^4]
  /// Corners, in axes 2 and 3 and counterclockwise about axis 1 [m]; empty: no shape.
  std::vector<Vector<2>> outline = {};
  std::vector<Fibre> fibres = {};  ///< of a section that yields; empty: no shape

  /// Whether the section is alike in all directions.
  bool is_round() const;
  CrossSection over(double spacing) const;
};

/// @param height  along axis 2 [m]
/// @param width   along axis 3 [m]
/// @param dim  of space
CrossSection rectangle_section(double height, double width, double poisson_ratio, int dim);
/// @param inner  diameter [m], 0: solid
CrossSection ring_section(double diameter, double inner, double poisson_ratio);

/// Data of a line cell that is a beam.
struct BeamData {
  CrossSection section;
  double shear_modulus = 0;                   ///< [Pa]
  std::optional<Vector<3>> orientation = {};  ///< of axis 2, in space

  BeamStiffness stiffness(double young_modulus) const;
};

KeyTable cross_section_keys();
/// Keys of a beam beside those of other lines.
std::vector<Key> beam_keys();

/// Read what beam_keys() list.
/// @param dim  of space
BeamData read_beam(ConfigReader& in, double young_modulus, int dim);

}  // namespace gabion::fem
