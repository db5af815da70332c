// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "mpm_solver/parameters/varying_material.hpp"
#include "mpm_solver/points/laws_of_points.hpp"

namespace gabion::mpm {

/// Constants that vary of all bodies, null where a body has none.
template <int dim>
using VaryingMaterials = std::vector<std::shared_ptr<const VaryingMaterial<dim>>>;

/// Give the points their values of the constants that vary; nothing where no body has any.
template <int dim>
void add_parameters(const VaryingMaterials<dim>& materials, MaterialPoints<dim>& points);

/// Laws of the points of this rank whose constants vary. They follow from
/// MaterialPoints::parameters alone, so from a saved state too, and for points that came from other
/// ranks. Points with the same values share a law.
template <int dim>
class PointLaws {
 public:
  PointLaws() = default;
  explicit PointLaws(VaryingMaterials<dim> materials);
  PointLaws(const PointLaws&) = delete;  // of_points() points into it
  PointLaws& operator=(const PointLaws&) = delete;
  PointLaws(PointLaws&&) = default;
  PointLaws& operator=(PointLaws&&) = default;
  ~PointLaws() = default;

  /// Make the laws those of these points; at little cost where they are.
  void follow(const MaterialPoints<dim>& points);

  /// Law of each point, null: that of its body; empty where no body has constants that vary.
  LawsOfPoints<dim> of_points() const { return of_points_; }

  /// The laws of all points with reduced strength (with_reduced_strength).
  PointLaws reduced(double factor) const;

 private:
  struct Hash {
    std::size_t operator()(const VaryingParameters& values) const;
  };
  struct Equal {
    bool operator()(const VaryingParameters& a, const VaryingParameters& b) const { return a == b; }
  };
  using Laws = std::unordered_map<VaryingParameters, MaterialLaw<dim>, Hash, Equal>;

  VaryingMaterials<dim> materials_;
  std::vector<Laws> laws_;                // of each body
  std::deque<MaterialLaw<dim>> reduced_;  // in their place, see reduced()
  std::vector<const MaterialLaw<dim>*> of_points_;
  std::vector<VaryingParameters> known_;  // those that of_points_ belongs to
  std::vector<std::int32_t> body_starts_;
};

}  // namespace gabion::mpm
