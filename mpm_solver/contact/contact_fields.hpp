// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/tensor.hpp"
#include "common/run/state.hpp"
#include "mpm_solver/contact/contact_settings.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// A place where soil and surface were in contact at the end of the last accepted step.
template <int dim>
struct ContactMark {
  std::int32_t facet = 0;
  bool sliding = false;                      ///< the friction limit is reached
  double area = 0;                           ///< that the place stands for [m^2] (2D: m)
  double gap = 0;                            ///< < 0: penetration [m]
  Vector<dim> x = Vector<dim>::Zero();       ///< on the surface [m]
  Vector<dim> normal = Vector<dim>::Zero();  ///< into the soil
  Vector<dim> force = Vector<dim>::Zero();   ///< of the soil on the surface [N]
  Vector<dim> slip = Vector<dim>::Zero();    ///< velocity of the soil along the surface [m/s]
};

/// Save or load marks. Names begin with `prefix`.
template <int dim>
void visit_marks(StateVisitor& visitor, const std::string& prefix, std::size_t num_facets,
                 std::vector<ContactMark<dim>>& marks);

/// Fields of the contact of soil and surface in the accepted state, an entry a facet but for
/// `vertices`.
template <int dim>
struct ContactFields {
  std::vector<Vector<dim>> vertices;  ///< where they are [m]
  std::vector<Vector<dim>> force;     ///< of the soil on the facet [N]
  std::vector<Vector<dim>> slip;      ///< velocity along the surface times the area in contact
  std::vector<double> area;           ///< area in contact [m^2] (2D: m)
  std::vector<double> gap;     ///< smallest, < 0: penetration [m]; infinite where none is known
  std::vector<double> status;  ///< 0 open, 1 sticks, 2 slides at one place at least

  ContactFields(std::vector<Vector<dim>> vertices, std::size_t num_facets);
  /// Add a share of a mark to a facet.
  void add(std::size_t facet, double share, const ContactMark<dim>& mark);
};

/// Add each mark to the facets that the soil around it lies on: a strip (2D) or square (3D) of the
/// mark's area in the plane across its normal, as far as it lies over facets that face the same
/// direction. The pressure of evenly laid points is then even, however facets and points divide the
/// surface.
template <int dim>
void spread_marks(const ContactSurface<dim>& surface, std::span<const ContactMark<dim>> marks,
                  ContactFields<dim>& fields);

/// A contact sphere, at its material point.
template <int dim>
struct ContactSphere {
  Matrix<dim> shape = Matrix<dim>::Identity();  ///< |shape^T n| is the radius in direction n [m]
  Vector<dim> offset = Vector<dim>::Zero();     ///< of its centre from the point [m]

  /// Extent from the point against n [m].
  double reach(const Vector<dim>& n) const { return (shape * n).norm() - offset.dot(n); }
};
template <int dim>
using SphereOfPoint = std::function<ContactSphere<dim>(std::int32_t p)>;

/// Set the gaps to the distances between each facet and the material points that it faces: from
/// points that stand over it along the normal, else from the rim of their areas. Points farther
/// away than `reach` [m] are left out.
template <int dim>
void add_gaps(const ContactSurface<dim>& surface, const MaterialPoints<dim>& points,
              const SphereOfPoint<dim>& sphere_of, double reach, ContactFields<dim>& fields);

}  // namespace gabion::mpm
