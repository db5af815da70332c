// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "mpm_solver/parameters/value_source.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Most constants of a body that vary: as many as MaterialPoints::parameters has room for.
inline constexpr std::size_t most_varying = 4;

/// Keys of a material that may vary in space: strength and Young's modulus.
extern const std::vector<std::string> may_vary;

/// Keys of the material of a body: those of material_keys(), an object in place of each number that
/// may vary, and layers.
KeyTable varying_material_keys(const std::vector<std::string>& laws);

/// A material with constants that vary in space. The law of a place is that which read_material
/// reads with the values of the place as numbers, so every value is checked as one of the settings.
template <int dim>
class VaryingMaterial {
 public:
  const std::vector<std::string>& names() const { return names_; }

  /// Values of the constants at a place, in the order of names(); the others are 0.
  /// @throws ConfigError  a source has no value there
  VaryingParameters at(const Vector<dim>& x) const;
  /// The material with these values. @throws ConfigError  names the first bad one
  Material<dim> with(const VaryingParameters& values) const;

  /// A point that the body will have.
  struct Point {
    std::int64_t id;
    Vector<dim> x;
    VaryingParameters values;
    const Material<dim>& material;
  };
  /// Visit them. @throws ConfigError  with the place of the first bad value
  void for_each_point(const PointLayout<dim>& layout,
                      const std::function<void(const Point&)>& visit) const;
  /// A point in words.
  std::string place_of(std::int64_t id, const Vector<dim>& x) const;

  /// Whether the law has a symmetric tangent at all points; known once it was read.
  bool symmetric() const { return symmetric_; }

 private:
  template <int d>
  friend struct VaryingReader;

  struct Layer {
    HeightSurface<dim> below;
    std::map<std::size_t, ValueSource<dim>> sources;  // by column of names_
    std::string where;
  };
  // The layer that gives each constant at a place, -1: none.
  std::array<int, most_varying> layers_at(const Vector<dim>& x) const;

  std::vector<std::string> names_;
  std::vector<ValueSource<dim>> sources_;  // of names_, above all layers
  std::vector<Layer> layers_;              // the last one that reaches up to a place counts
  Json settings_;                          // of the material, with numbers alone
  std::string file_, body_name_;
  std::size_t body_ = 0;
  bool symmetric_ = true;
};

/// Read the material of a body. Where constants vary, the body gets the law of its stiffest point:
/// stiffness of contacts and stable steps follow from it.
/// @param number  of the body
/// @param layout  mesh and points of the body
/// @returns the constants that vary, null: none
template <int dim>
std::shared_ptr<const VaryingMaterial<dim>> read_body_material(ConfigReader in,
                                                               const SourcePlace<dim>& place,
                                                               std::size_t number,
                                                               const PointLayout<dim>& layout,
                                                               Body<dim>& body);

/// Refuse a Young's modulus that varies in a body whose water drains: the pressure is smoothed by
/// the one stiffness of the body's skeleton. @throws ConfigError  it does
template <int dim>
void require_one_stiffness(const ConfigReader& in, const Body<dim>& body);

}  // namespace gabion::mpm
