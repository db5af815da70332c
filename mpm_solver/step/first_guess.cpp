// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/first_guess.hpp"

namespace gabion::mpm {

namespace {

// Up to this elastic Courant number free flight is taken as the guess without a trial.
constexpr double flight_courant = 2;

// du holds the displacement of the walls: add that of the soil by the stiffness at the start.
template <int dim>
void spread_wall_step(Equilibrium<dim>& equilibrium, LinearSystem<dim>& system, FirstGuess& guess) {
  std::vector<double> r(guess.du.size()), step(guess.du.size());
  // If the start is inadmissible, Newton's method reports the reason.
  if (!equilibrium.linearise(guess.du, r, system.K()).admissible) return;
  guess.linear_iterations += system.solve(r, step);
  for (std::size_t k = 0; k < step.size(); ++k) guess.du[k] += step[k];
}

}  // namespace

template <int dim>
FirstGuess first_guess(Equilibrium<dim>& equilibrium, LinearSystem<dim>& system, double wave_speed,
                       PhaseTimes& times) {
  const auto& parts = equilibrium.parts();
  const auto& v = equilibrium.start_velocity();
  const auto& a = equilibrium.start_acceleration();
  FirstGuess guess;
  std::vector<double>& du = guess.du;
  du.assign(v.size(), 0.0);
  parts.walls.impose(du, 1);
  if (!parts.with_inertia) {
    if (!parts.walls.move()) return guess;
    const ScopedTimer timer(times, "guess");
    spread_wall_step(equilibrium, system, guess);
    return guess;
  }
  std::vector<double> still = du;
  const double dt = parts.dt;
  for (std::size_t k = 0; k < du.size(); ++k) du[k] = dt * (v[k] + 0.5 * dt * a[k]);
  if (wave_speed * dt <= flight_courant * parts.cell_size) return guess;
  const ScopedTimer timer(times, "guess");
  std::vector<double> r(du.size());
  const Evaluation flight = equilibrium.evaluate(du, r, nullptr);
  const double r_flight = equilibrium.shared().norm(r);
  equilibrium.evaluate(still, r, nullptr);
  if (!flight.admissible || equilibrium.shared().norm(r) < r_flight) du = std::move(still);
  return guess;
}

template FirstGuess first_guess<2>(Equilibrium<2>&, LinearSystem<2>&, double, PhaseTimes&);
template FirstGuess first_guess<3>(Equilibrium<3>&, LinearSystem<3>&, double, PhaseTimes&);

}  // namespace gabion::mpm
