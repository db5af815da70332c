// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/settings/config_reader.hpp"
#include "common/settings/scene.hpp"
#include "mpm_solver/parameters/box_field.hpp"
#include "mpm_solver/parameters/random_field.hpp"
#include "mpm_solver/parameters/raster.hpp"

namespace gabion::mpm {

/// The place of a source: data that the sources of one body share.
template <int dim>
struct SourcePlace {
  const Scene& scene;
  std::string body;                          ///< its name
  Eigen::AlignedBox<double, dim> box;        ///< around its mesh [m]
  Vector<dim> origin = Vector<dim>::Zero();  ///< of the scene in coordinates of the world [m]
};

/// A height over each place in plan: of the ground, or of what separates two layers.
template <int dim>
class HeightSurface {
 public:
  /// Read the key "below": a height, or an object of height_surface_keys().
  static HeightSurface read(ConfigReader& in, const SourcePlace<dim>& place);

  /// Height over x [m]. @throws ConfigError  the surface does not reach x
  double at(const Vector<dim>& x) const;

 private:
  struct Line {
    std::string where;
    std::vector<double> x, height;
  };
  std::variant<double, Line, std::shared_ptr<const Raster>> shape_ = 0.0;
};

/// Keys of a surface, and those of what names one.
KeyTable height_surface_keys();
std::vector<Key> below_keys(const std::string& sentence);

/// A value linear between the rows of a table over the depth below a surface.
template <int dim>
struct DepthTable {
  std::string where;  ///< of the table in the settings
  HeightSurface<dim> surface;
  std::vector<double> depth, value;

  double at(const Vector<dim>& x) const;
};

/// A lognormal factor, or a lognormal value, of each place.
template <int dim>
struct RandomValues {
  RandomLattice<dim> lattice;
  Vector<dim> correlation_lengths;
  std::shared_ptr<const std::vector<double>> z;  ///< normal field of the cells
  Lognormal law;

  double at(const Vector<dim>& x) const { return law.at((*z)[lattice.cell_of(x)]); }
};

/// Source of the values of a key.
template <int dim>
struct ValueSource {
  std::variant<double, DepthTable<dim>, std::shared_ptr<const Raster>,
               std::shared_ptr<const BoxField<dim>>>
      mean = 1.0;
  std::optional<RandomValues<dim>> random;  ///< it multiplies the mean

  /// @throws ConfigError  the source has no value there
  double at(const Vector<dim>& x) const;
};

/// Keys of an object in place of a number.
KeyTable value_source_keys();

/// A source that was read before.
template <int dim>
struct NamedSource {
  std::string name;
  ValueSource<dim> source;
};

/// Read what value_source_keys() lists.
/// @param stream  text that no other source of the run has: random fields differ by it
/// @param others  sources of the same object that were read before; a random field may be
///                correlated with one of them
/// @throws ConfigError
template <int dim>
ValueSource<dim> read_value_source(ConfigReader in, const std::string& stream,
                                   const SourcePlace<dim>& place,
                                   const std::vector<NamedSource<dim>>& others);

/// Whether it is a random field that is correlated with one that has to be read before it.
bool is_correlated(ConfigReader in);

}  // namespace gabion::mpm
