// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

enum class ContactMode {
  fixed,    ///< soil holds to the surface in all directions, in tension too
  contact,  ///< only while the gap is closed; then sticks, or slides when friction is exceeded
  slip,     ///< only while the gap is closed; normal direction only
};

/// Traction of a gap.
template <int dim>
struct ContactTraction {
  Vector<dim> t = Vector<dim>::Zero();  ///< on the soil, normal first [Pa]
  bool closed = false;
  bool sliding = false;  ///< the friction limit is reached
  double elastic = 1;   ///< d |t_t| / d |trial t_t|: 1 as long as it sticks, 0 of Coulomb's sliding
  double by_speed = 0;  ///< d |t_t| / d speed, <= 0: friction that falls with it [Pa s/m]
};

/// Coefficient of friction that falls with the speed of sliding from that of rest:
///
///     mu(v) = friction - fall (1 - exp(-v / speed))
struct FrictionFall {
  double fall = 0;   ///< from rest to great speed, >= 0 and at most the friction; 0: none
  double speed = 0;  ///< at which 1 - 1/e of the fall is reached, > 0 [m/s]
};

/// Normal traction as a function of the penetration d = -g_n.
enum class NormalLaw {
  linear,     ///< penalty d
  quadratic,  ///< penalty d^2: begins without a kink, and is as stiff as the pressure asks for
};

/// Traction of a surface on the soil by the gap g between them, a penalty with Coulomb's friction
/// and the turbulent drag of Voellmy:
///
///     t_n = penalty d or penalty d^2 ,  t_t = -tangential_penalty g_t ,
///     |t_t| <= mu t_g + drag v^2 ,  t_g = (1 - g) chi t_n + g <t_n - p> what grains bear
///
/// with the speed v = s / time of the slip s in the step, which is the part of g_t beyond the
/// limit. The limit is the root of a quadratic equation and has the direction of t_t: it takes
/// energy. mu is the friction; with a fall it depends on the speed of the soil along the surface,
/// elastic or not, so that the springs between them have no part in it and the traction has one
/// value.
/// @see Voellmy (1955); drag = rho g / xi with his coefficient xi [m/s^2]
struct ContactLaw {
  ContactMode mode = ContactMode::contact;
  double friction = -1;           ///< coefficient in mode contact; < 0: unlimited (stick)
  double penalty = 0;             ///< [Pa/m], quadratic: [Pa/m^2]; > 0
  double tangential_penalty = 0;  ///< [Pa/m] > 0
  NormalLaw normal = NormalLaw::linear;
  /// Depth from which the quadratic law goes on along its tangent [m].
  double linear_from = std::numeric_limits<double>::infinity();
  double drag = 0;           ///< [Pa s^2/m^2], >= 0
  double time = 0;           ///< in which the slip came about, with a drag [s]; 0: none can
  FrictionFall weakening{};  ///< of the friction
  double speed = 0;          ///< of the soil along the surface in this time, with a fall [m/s]
  double pore_pressure = 0;  ///< p at the surface [Pa]
  double drained = 1;        ///< g, share of a change of pressure that drains in the step, 0 to 1
  double grain_share = 1;    ///< chi, of the traction that grains bear where none drains, 0 to 1

  /// Whether sliding makes the stiffness unsymmetric.
  bool has_friction() const { return mode == ContactMode::contact && friction > 0; }
  /// t_g [Pa]. @param t_n  >= 0
  double on_grains(double t_n) const;
  double on_grains_slope(double t_n) const;  ///< dt_g/dt_n
  /// Energy that the normal part stores per area at a penetration [J/m^2].
  double stored(double depth) const;
  /// The quadratic law is penalty d g(d): g = d up to d_1 = linear_from, 2 d_1 - d_1^2 / d beyond
  /// [m].
  double reduced(double depth) const;
  /// dg/dd.
  double reduced_slope(double depth) const;
  /// 3 / (penalty d^2) of the work per area to the depth d, d up to linear_from [m].
  double storing(double depth) const;
  /// The depth d with d g(d) = square [m]. @param square  traction over penalty [m^2]
  double depth_of(double square) const;

  /// @param gap    in the frame of the surface, normal first; open when its normal part is >= 0 [m]
  /// @param slope  null, or set to -dt/dg
  template <int dim>
  ContactTraction<dim> traction(const Vector<dim>& gap, Matrix<dim>* slope) const;

 private:
  /// Sliding, where the trial traction exceeds friction.
  struct Slide {
    double slip = 0;     // [m]
    double elastic = 0;  // d |t_t| / d excess
  };
  Slide slide_beyond(double excess) const;
  // The friction at the present speed, and its derivative by the speed.
  double friction_now() const;
  double friction_slope() const;
};

}  // namespace gabion::mpm
