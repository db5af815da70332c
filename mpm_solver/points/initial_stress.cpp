// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/points/initial_stress.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "common/base/require.hpp"
#include "common/mechanics/materials/cam_clay_memory.hpp"
#include "common/mechanics/materials/spectral.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/points/retention.hpp"

namespace gabion::mpm {

template <int dim>
double shear_modulus(const MaterialLaw<dim>& law) {
  return std::visit([](const auto& model) { return model.shear_modulus(); }, law);
}

template <int dim>
double first_lame_constant(const MaterialLaw<dim>& law) {
  const double M = std::visit([](const auto& model) { return model.p_wave_modulus(); }, law);
  return M - 2 * shear_modulus(law);
}

namespace {

// The law has to return the stress for which the strains were computed, to this share.
constexpr double same_stress = 1e-9;

// Coefficients at rest that the law bears under the vertical stress -s, in words.
template <int dim>
std::string borne(const MaterialLaw<dim>& law, double s) {
  return std::visit(
      [s]<class Law>(const Law& soil) -> std::string {
        if constexpr (requires { soil.principal(); }) {
          const PrincipalMohrCoulomb& surface = soil.principal();
          const double k = surface.k, strength = surface.strength / s;
          return fmt::format("k0 in [{:.6g}, {:.6g}]", (1 - strength) / k, k + strength);
        } else {
          return "a stress that the law bears";
        }
      },
      law);
}

/// State of one point at depth d.
template <int dim>
struct Geostatic {
  double s = 0;  // -tau_v of the skeleton [Pa]
  double J = 1;
  double p = 0;        // of the pore water, that the grains feel [Pa]
  double density = 0;  // over V0 [kg/m^3]
  double water = 0;    // content of the pores, 0: dry
  MaterialState<dim> state;
  InternalState internal = InternalState::Zero();
  Symmetric<dim> tau = Symmetric<dim>::Zero();  // of the skeleton [Pa]

  Symmetric<dim> total_tau() const {
    Symmetric<dim> total = tau;
    total.template head<3>().array() -= J * p;
    return total;
  }
};

// Vertical stress that the skeleton carries at depth d [Pa].
template <int dim>
double load_on_skeleton(const InitialStress& stress, const BodyAtRest<dim>& at_rest, double d) {
  const double density = at_rest.body.material.density, g = -at_rest.gravity[dim - 1];
  if (!at_rest.body.water) return density * g * d;
  const PoreWater& water = *at_rest.body.water;
  const double above = std::clamp(stress.surface - *stress.water_table, 0.0, std::max(0.0, d));
  return g * (water.density_above(density, stress.saturation_above) * above +
              (density - water.density) * (d - above));
}

// The vertical stress s of Cam-Clay under a load: Newton's method falls to it from above.
double clay_stress(const CamClayParameters& clay, double k0, double load) {
  const double kappa = clay.swelling, a = clay.attraction, b = (1 + 2 * k0) / 3;
  double s = load;
  for (int pass = 0; pass < 50; ++pass) {
    const double excess = s * (1 + kappa) - kappa * a / b * std::log1p(b * s / a) - load;
    const double change = excess / (1 + kappa * b * s / (b * s + a));
    s -= change;
    if (!(std::abs(change) > 1e-15 * load)) break;
  }
  return s;
}

template <int dim>
Geostatic<dim> clay_at_rest(const CamClayParameters& clay, const InitialStress& stress,
                            double load) {
  Geostatic<dim> result;
  result.s = clay_stress(clay, stress.k0, load);
  const double P = clay.attraction + (1 + 2 * stress.k0) / 3 * result.s;
  const double mu = clay.shear_modulus_at(P), volumetric = clay.strain_at(P);
  for (int i = 0; i < 3; ++i) {
    result.tau[i] = (i == dim - 1 ? -1 : -stress.k0) * result.s;
    const double deviator = result.tau[i] - (clay.attraction - P);
    result.state.e[i] = strain_from_hencky(volumetric / 3 + deviator / (2 * mu));
  }
  result.J = std::exp(volumetric);
  const double before = stress.ocr * result.s, k0 = stress.k0_consolidated;
  const double P_before = clay.attraction + (1 + 2 * k0) / 3 * before;
  result.internal = cam_clay_memory(clay, P, P_before, (1 - k0) * before);
  return result;
}

template <int dim>
Geostatic<dim> skeleton_at_rest(const MaterialLaw<dim>& law, const InitialStress& stress,
                                double load) {
  if (const auto* clay = std::get_if<CamClay<dim>>(&law)) {
    return clay_at_rest<dim>(clay->parameters(), stress, load);
  }
  const double k0 = stress.k0;
  const double lambda = first_lame_constant(law), mu = shear_modulus(law);
  const double C = (3 * lambda + 2 * mu) / (1 + 2 * k0);
  const bool small_strain = std::holds_alternative<LinearElastic<dim>>(law);
  Geostatic<dim> result;
  result.s = small_strain ? load : 2 * load / (1 + std::sqrt(1 + 2 * load / C));
  const double volumetric = -result.s / C;
  for (int i = 0; i < 3; ++i) {
    const bool vertical = i == dim - 1;
    result.tau[i] = vertical ? -result.s : -k0 * result.s;
    const double epsilon =
        mu > 0 ? (result.tau[i] - lambda * volumetric) / (2 * mu) : volumetric / 3;
    result.state.e[i] = small_strain ? epsilon : strain_from_hencky(epsilon);
  }
  if (!small_strain) result.J = std::exp(volumetric);
  return result;
}

/// Under water that flows.
template <int dim>
Geostatic<dim> geostatic(const InitialStress& stress, const BodyAtRest<dim>& at_rest,
                         const MaterialLaw<dim>& law, double d, const FlowingWater& flow) {
  const Body<dim>& body = at_rest.body;
  const PoreWater& water = *body.water;
  const double borne = retention_at(water, flow.p).borne;
  const double total = flow.on_surface - body.material.density * at_rest.gravity[dim - 1] * d;
  auto soil = skeleton_at_rest<dim>(law, stress, total - borne);
  soil.p = borne;
  soil.water = water.content_at(flow.p, soil.J);
  soil.density = water.dry_density(body.material.density) + soil.water * water.density;
  return soil;
}

template <int dim>
Geostatic<dim> geostatic(const InitialStress& stress, const BodyAtRest<dim>& at_rest,
                         const MaterialLaw<dim>& law, double d,
                         const FlowingWater* flow = nullptr) {
  if (flow != nullptr) return geostatic(stress, at_rest, law, d, *flow);
  const Body<dim>& body = at_rest.body;
  auto soil = skeleton_at_rest<dim>(law, stress, load_on_skeleton(stress, at_rest, d));
  soil.density = body.material.density;
  if (!body.water) return soil;
  const PoreWater& water = *body.water;
  const double depth_in_water = *stress.water_table - (stress.surface - d);
  if (depth_in_water <= 0) {
    soil.density = water.density_above(body.material.density, stress.saturation_above);
    return soil;
  }
  soil.p = -water.density * at_rest.gravity[dim - 1] * depth_in_water;
  soil.density = water.dry_density(body.material.density) + water.pores(soil.J) * water.density;
  soil.water = water.content_at(soil.p, soil.J);
  return soil;
}

}  // namespace

// Whether the law gives a stress in the state of a point.
template <int dim>
bool bears(const MaterialLaw<dim>& law, const Geostatic<dim>& soil, StressUpdate<dim>& now) {
  const Matrix<dim> still = Matrix<dim>::Zero();
  if (const auto* clay = std::get_if<CamClay<dim>>(&law)) {
    return clay->update({.internal = soil.internal}, still, soil.state, now, nullptr);
  }
  return update<dim>(law, still, soil.state, now, nullptr);
}

// Whether a user material gives a stress, which its memory then holds.
template <int dim>
bool bears(const Umat<dim>& law, const Geostatic<dim>& soil, StateVariables& variables,
           StressUpdate<dim>& now) {
  Symmetric<dim> log_strain = Symmetric<dim>::Zero();
  for (int i = 0; i < 3; ++i) log_strain[i] = hencky_strain(soil.state.e[i]);
  StateVariables before;
  law.set_start(soil.tau, log_strain, numbers_of(before));
  const PointContext at_rest{.variables = numbers_of(before),
                             .new_variables = numbers_of(variables)};
  const Matrix<dim> still = Matrix<dim>::Zero();
  return law.update(at_rest, still, soil.state, now, nullptr);
}

template <int dim>
void set_initial_stress(MPI_Comm comm, const InitialStress& stress, const BodyAtRest<dim>& at_rest,
                        MaterialPoints<dim>& points, std::span<const FlowingWater> flow) {
  const Body<dim>& body = at_rest.body;
  const Vector<dim>& gravity = at_rest.gravity;
  require<ConfigError>(
      gravity[dim - 1] < 0 && gravity.template head<dim - 1>().isZero(0),
      "{}: found gravity ({:.4g}), allowed: gravity against the last axis, present from the start",
      stress.where, fmt::join(gravity.data(), gravity.data() + dim, ", "));
  std::string problem;
  for (std::int32_t p = points.body_starts[at_rest.number];
       p < points.body_starts[at_rest.number + 1]; ++p) {
    const double d = stress.surface - points.x[p][dim - 1];
    const MaterialLaw<dim>& law = law_of<dim>(at_rest.laws, p, body.material.law);
    const auto soil = geostatic<dim>(stress, at_rest, law, d, flow.empty() ? nullptr : &flow[p]);
    StressUpdate<dim> now;
    const auto* umat = std::get_if<Umat<dim>>(&law);
    const bool has_stress =
        d >= 0 && (umat ? bears(*umat, soil, points.variables[p], now) : bears(law, soil, now));
    const bool borne_by_law =
        has_stress && (now.tau - soil.tau).norm() <= same_stress * soil.tau.norm();
    if (!borne_by_law) {
      const std::string place =
          fmt::format("material point {} at ({:.4g})", points.id[p],
                      fmt::join(points.x[p].data(), points.x[p].data() + dim, ", "));
      problem = d < 0 ? fmt::format("{}: found {}, but {} lies above it", stress.where_surface,
                                    stress.surface, place)
                : soil.s <= 0 && !flow.empty()
                    ? fmt::format(
                          "{}: found a steady flow that lifts {}: the weight above it is "
                          "{:.4g} Pa less than the pressure of the water, allowed: a flow "
                          "that leaves grains their weight, or a law that bears tension",
                          stress.where_pressure, place, -soil.s)
                    : fmt::format("{}: found k0 = {:.6g}, under which {} would yield, allowed: {}",
                                  stress.where, stress.k0, place, borne<dim>(law, soil.s));
      break;
    }
    points.V0[p] = points.V0[p] * points.J[p] / soil.J;
    points.m[p] = soil.density == body.material.density && flow.empty()
                      ? points.m[p] / soil.J
                      : soil.density * points.V0[p];
    points.J[p] = soil.J;
    points.history[p] = soil.state;
    if (std::holds_alternative<CamClay<dim>>(body.material.law)) {
      points.internal[p] = soil.internal;
    }
    points.tau[p] = soil.total_tau();
    points.energy[p] = now.energy;
    points.a[p].setZero();
    if (!body.water) continue;
    points.water[p] = soil.water;
    if (soil.water > 0) points.energy[p] += body.water->at(soil.water, soil.J).energy;
  }
  require<ConfigError>(max_over_ranks(comm, problem.empty() ? 0 : 1) == 0, "{}",
                       problem.empty() ? stress.where + ": refused on another rank" : problem);
}

template <int dim>
Vector<dim> initial_stress_at(const InitialStress& stress, const BodyAtRest<dim>& at_rest,
                              double height, const FlowingWater* flow) {
  const double d = stress.surface - height;
  if (d <= 0) return Vector<dim>::Zero();
  const auto soil = geostatic<dim>(stress, at_rest, at_rest.body.material.law, d, flow);
  return soil.total_tau().template head<dim>() / soil.J;
}

template double shear_modulus<2>(const MaterialLaw<2>&);
template double shear_modulus<3>(const MaterialLaw<3>&);
template double first_lame_constant<2>(const MaterialLaw<2>&);
template double first_lame_constant<3>(const MaterialLaw<3>&);
template void set_initial_stress<2>(MPI_Comm, const InitialStress&, const BodyAtRest<2>&,
                                    MaterialPoints<2>&, std::span<const FlowingWater>);
template void set_initial_stress<3>(MPI_Comm, const InitialStress&, const BodyAtRest<3>&,
                                    MaterialPoints<3>&, std::span<const FlowingWater>);
template Vector<2> initial_stress_at<2>(const InitialStress&, const BodyAtRest<2>&, double,
                                        const FlowingWater*);
template Vector<3> initial_stress_at<3>(const InitialStress&, const BodyAtRest<3>&, double,
                                        const FlowingWater*);

}  // namespace gabion::mpm
