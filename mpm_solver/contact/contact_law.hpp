// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

enum class ContactMode {
  fixed,    ///< soil holds to the surface in all directions, in tension too
  contact,  ///< only while the gap is closed; then sticks, or slides when friction is exceeded
  slip,     ///< only while the gap is closed; normal direction only
};

/// What a gap gives.
template <int dim>
struct ContactTraction {
  Vector<dim> t = Vector<dim>::Zero();  ///< on the soil, normal first [Pa]
  bool closed = false;
  bool sliding = false;  ///< the friction limit is reached
};

/// Traction of a surface on the soil by the gap g between them, a penalty with Coulomb's friction:
///
///     t_n = penalty * { d^2 / (2 onset) , d <= onset ;  d - onset / 2 , d > onset } ,  d = -g_n ,
///     t_t = -penalty share g_t ,  |t_t| <= friction t_n
///
/// With an onset the force begins without a kink.
struct ContactLaw {
  ContactMode mode = ContactMode::contact;
  double penalty = 0;           ///< [Pa/m] > 0
  double onset = 0;             ///< depth over which the penalty grows to its full value [m], >= 0
  double friction = -1;         ///< coefficient in mode contact; < 0: unlimited (stick)
  double tangential_share = 1;  ///< of the penalty in tangential directions, in (0, 1]

  /// Whether sliding makes the stiffness unsymmetric.
  bool has_friction() const { return mode == ContactMode::contact && friction > 0; }
  double tangential_penalty() const { return tangential_share * penalty; }
  /// What the normal part stores in an area at a depth [J/m^2].
  double stored(double depth) const;

  /// @param gap    in the frame of the surface, normal first; open when its normal part is >= 0 [m]
  /// @param slope  null, or set to -dt/dg
  template <int dim>
  ContactTraction<dim> traction(const Vector<dim>& gap, Matrix<dim>* slope) const;

 private:
  struct Normal {
    double traction = 0, slope = 0;
  };
  Normal normal(double gap) const;
};

}  // namespace gabion::mpm
