// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/settings/config_reader.hpp"

namespace gabion {

/// Newmark's family in the displacement increment du of a step, with averaged inertia (Bossak) and
/// averaged forces (generalized-alpha):
///
///     a' = du / (beta dt^2) - v / (beta dt) - (1 / (2 beta) - 1) a
///     v' = v + dt [(1 - gamma) a + gamma a']
///     M [(1 - alpha_m) a' + alpha_m a] = (1 - alpha_f) f' + alpha_f f ,   f = f_ext - f_int
///
/// The balance is solved in the form that is divided by 1 - alpha_f, so that the tangent of the
/// forces needs no factor:
///
///     f' + force_memory f = M inertia(a', a) ,   force_memory = alpha_f / (1 - alpha_f)
///
/// @see Newmark (1959); Wood, Bossak, Zienkiewicz (1980); Chung and Hulbert (1993)
struct NewmarkBossak {
  double alpha_m = 0;  ///< weight of the old acceleration; Bossak's alpha
  double alpha_f = 0;  ///< weight of the old forces, in [0, 1/2]
  double beta = 0.25;
  double gamma = 0.5;

  /// alpha_B in [-1/3, 0): second order with high-frequency damping, gamma = 1/2 - alpha_B,
  /// beta = (1 - alpha_B)^2 / 4. alpha_B = 0: trapezoidal rule.
  /// @throws ConfigError  out of range
  static NewmarkBossak bossak(double alpha);

  /// Second order; rho_inf in [0, 1] is the spectral radius at dt -> infinity. Of all schemes with
  /// this damping of the highest frequencies, the one that damps low frequencies least:
  ///
  ///     alpha_m = (2 rho - 1) / (rho + 1) ,  alpha_f = rho / (rho + 1) ,
  ///     gamma = 1/2 - alpha_m + alpha_f ,  beta = (1 - alpha_m + alpha_f)^2 / 4
  ///
  /// @throws ConfigError  out of range
  /// @see Chung and Hulbert (1993), eqs. (17), (20), (25)
  static NewmarkBossak generalized_alpha(double rho_inf);

  double acceleration(double du, double v, double a, double dt) const {
    return du / (beta * dt * dt) - v / (beta * dt) - (0.5 / beta - 1) * a;
  }
  double velocity(double a_new, double v, double a, double dt) const {
    return v + dt * ((1 - gamma) * a + gamma * a_new);
  }
  /// Acceleration at the instant of the balance, (1 - alpha_m) a' + alpha_m a.
  double mean_acceleration(double a_new, double a) const {
    return (1 - alpha_m) * a_new + alpha_m * a;
  }
  /// Force at the instant of the balance, (1 - alpha_f) f' + alpha_f f.
  double mean_force(double f_new, double f) const { return (1 - alpha_f) * f_new + alpha_f * f; }
  /// Weight of the forces at the start of the step beside those at its end. Zero: they are not
  /// needed.
  double force_memory() const { return alpha_f / (1 - alpha_f); }
  /// Inertia per unit mass beside the forces at the end of the step.
  double inertia(double a_new, double a) const {
    return mean_acceleration(a_new, a) / (1 - alpha_f);
  }
  /// d(inertia)/d(du) per unit mass.
  double inertia_slope(double dt) const { return (1 - alpha_m) / ((1 - alpha_f) * beta * dt * dt); }

  /// A force F that is constant over the step, its mean force, enters with beta = 1/2, gamma = 1,
  /// whatever these are for the other forces. With a = a_i + M^-1 F, a_i of the others:
  ///
  ///     du = dt v + dt^2 [(1/2 - beta) a_i + beta a_i'] + dt^2 / 2 M^-1 F
  ///     v' = v + dt [(1 - gamma) a_i + gamma a_i'] + dt M^-1 F
  ///     M [(1 - alpha_m) a_i' + alpha_m a_i] = f'
  ///
  /// The impulse of F is dt F; with the trapezoidal rule the energy that it adds is exactly F . du.
  /// Written without a_i, with the force F_o of the step before, which is contained in a, and a' =
  /// acceleration(du, v, a, dt):
  ///
  ///     M [(1 - alpha_m) a' + alpha_m a] = f' + c F - (c - 1) F_o ,  c = step_force_weight()
  ///     v' = velocity(a', v, a, dt) + dt step_force_velocity() M^-1 (F - F_o)
  ///     a' <- a' - step_force_acceleration() M^-1 (F - F_o)   at the end of the step
  ///
  /// @pre alpha_f = 0
  /// @see Kane, Repetto, Ortiz, Marsden (1999): contact forces with beta = 1/2, gamma = 1
  double step_force_weight() const { return (1 - alpha_m) / (2 * beta); }
  /// 1 - gamma / (2 beta), the impulse that the formula of the velocity leaves out.
  double step_force_velocity() const { return 1 - gamma / (2 * beta); }
  /// 1 / (2 beta) - 1, what Newmark's a' has of M^-1 (F - F_o) beyond the acceleration of F.
  double step_force_acceleration() const { return 0.5 / beta - 1; }
};

/// Read {"scheme": "newmark"}, the trapezoidal rule, {"scheme": "bossak", "alpha": -0.1} or
/// {"scheme": "generalized_alpha", "rho_inf": 0.8}.
NewmarkBossak read_newmark_bossak(ConfigReader in);
/// @param scheme  the default
KeyTable newmark_keys(const std::string& scheme);

/// Refuse averaged forces where a solver exchanges forces with another one: both sides have to
/// balance them at the same instant, t + dt.
/// @param in  the object that holds "time_integration"
/// @throws ConfigError
void require_balance_at_end_of_step(const ConfigReader& in, const NewmarkBossak& scheme);

}  // namespace gabion
