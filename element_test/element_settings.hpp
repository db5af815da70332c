// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/mechanics/materials/material.hpp"
#include "common/settings/scene.hpp"
#include "mpm_solver/points/pore_water.hpp"

namespace gabion::element {

/// Components of stress and strain, in the order of Symmetric<3>. Normal components are positive in
/// compression, shears where the side farther along the second axis moves along the first one.
inline const std::array<std::string, 6> component_names = {"xx", "yy", "zz", "xy", "yz", "xz"};
inline constexpr int num_components = 6;

using Components = std::array<std::optional<double>, num_components>;

/// Part of a test: led quantities go linearly from their present values to those at the end.
struct StageSettings {
  std::string name;
  bool zero_strain = false;  ///< strains count from the start of this stage on
  /// Changes of length over the length where strains are zero, angles of shear.
  Components strain;
  Components stress;                  ///< total Cauchy stresses [Pa]
  std::optional<double> mean_stress;  ///< total [Pa]
  /// Normal components whose stresses change by the same amount to give the mean.
  std::vector<int> moved;
  bool undrained = false;
  int increments = 100;
  std::optional<double> duration;  ///< [s]; none: the law knows no time
  /// Over-consolidation ratio that soil with a memory of its consolidation has at the end; none: as
  /// the stages have left it.
  std::optional<double> ocr;
};

/// element.json, with the material of a scene if there is one.
struct ElementSettings {
  Material<3> material;
  std::optional<mpm::PoreWater> water;  ///< none: undrained soil keeps its volume
  double band_width = 0;                ///< of PointContext [m]
  double back_pressure = 0;             ///< of the pores while they drain [Pa]
  bool simple_shear = false;            ///< F is triangular, else symmetric
  std::vector<StageSettings> stages;    ///< at least one

  /// P-wave modulus of the material without water [Pa].
  double p_wave_modulus() const {
    return std::visit([](const auto& law) { return law.p_wave_modulus(); }, material.law);
  }
};

/// Keys of element.json.
KeyTable element_keys();

/// The body of a scene whose material is tested.
struct TestedBody {
  const Scene& scene;
  std::string name;  ///< empty: the only one
};

/// Read element.json. The material is read as the soil's solver reads it, from `body` if given.
/// @throws ConfigError
ElementSettings read_element_settings(ConfigReader& in, const TestedBody* body);

}  // namespace gabion::element
