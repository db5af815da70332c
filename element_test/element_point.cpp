// SPDX-License-Identifier: BSD-3-Clause
#include "element_test/element_point.hpp"

#include <cmath>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/materials/cam_clay_memory.hpp"
#include "common/mechanics/materials/spectral.hpp"
#include "common/mechanics/tensor_functions.hpp"

namespace gabion::element {

namespace {

// Rows and columns of component_names.
constexpr std::array<std::pair<int, int>, num_components> places = {
    {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}}};

Vector6 cauchy(const Symmetric<3>& tau, double log_J, double pore_pressure) {
  Vector6 sigma = std::exp(-log_J) * tau;
  sigma.head<3>().array() -= pore_pressure;
  return sigma;
}

std::string reason(Refusal refusal) {
  if (refusal == Refusal::squeezed) return "the sample would have no volume";
  if (refusal == Refusal::pores_closed) return "the pores would be closed";
  return "the law found no stress for the strain of an increment";
}

}  // namespace

Vector6 ElementState::stress() const {
  return cauchy(tau, log_J, pore_pressure);
}

Vector6 ElementState::effective_stress() const {
  return cauchy(tau, log_J, 0);
}

double ElementPoint::stiffness() const {
  return settings_.p_wave_modulus();
}

// Matrix of these components: angles of shear above the diagonal, or halved on both sides.
Matrix<3> ElementPoint::gradient(const Vector6& strain) const {
  Matrix<3> E = Matrix<3>::Zero();
  for (int k = 0; k < num_components; ++k) {
    const auto [i, j] = places[k];
    const double share = i == j || settings_.simple_shear ? 1 : 0.5;
    E(i, j) = share * strain[k];
    if (!settings_.simple_shear) E(j, i) = E(i, j);
  }
  return E;
}

ElementState ElementPoint::start() const {
  ElementState state;
  StressUpdate<3> update;
  update.internal.setZero();
  const bool answers =
      gabion::update<3>(settings_.material.law, Matrix<3>::Zero(), state.history, update, nullptr);
  require<ConvergenceError>(answers, "start: the law {} has no stress without strain",
                            settings_.material.law_name);
  state.tau = update.tau;
  if (remembers_internal(settings_.material.law)) state.internal = update.internal;
  if (const auto* umat = std::get_if<Umat<3>>(&settings_.material.law)) {
    state.variables.resize(umat_state_size);
    umat->set_start(state.variables);
  }
  state.pore_pressure = settings_.back_pressure;
  return state;
}

void ElementPoint::consolidate(double ocr, ElementState& state) const {
  const auto* law = std::get_if<CamClay<3>>(&settings_.material.law);
  if (law == nullptr) return;
  const CamClayParameters& clay = law->parameters();
  const Eigen::Vector3d tau = state.tau.head<3>();
  const double mean = tau.mean(), P = clay.attraction - mean, mu = clay.shear_modulus_at(P);
  require<ConvergenceError>(state.tau.tail<3>().norm() < 1e-9 * P,
                            "ocr: found shear stresses at the end of the stage, allowed: none");
  const Eigen::Vector3d deviator = tau.array() - mean;
  for (int i = 0; i < 3; ++i) {
    state.history.e[i] = strain_from_hencky(clay.strain_at(P) / 3 + deviator[i] / (2 * mu));
  }
  state.history.e.tail<3>().setZero();
  state.internal = cam_clay_memory(clay, P, clay.attraction - ocr * mean,
                                   ocr * std::sqrt(1.5) * deviator.norm());
}

std::string ElementPoint::add_water(const PoreState& pores, const Trial& trial,
                                    Response& response) const {
  ElementState& state = response.state;
  state.pore_pressure = trial.pore_pressure;
  if (pores.undrained && settings_.water) {
    const double J = std::exp(state.log_J);
    if (!settings_.water->admits(J)) return reason(Refusal::pores_closed);
    const mpm::PorePressure pore = settings_.water->at(pores.content, J);
    state.pore_pressure = pore.p;
    response.stress_slope.topRows<3>().rowwise() +=
        pore.stiffness * response.log_J_slope.transpose();
  } else {
    response.stress_slope.col(6).head<3>().array() -= 1;
  }
  return "";
}

// P = tau (1 + H)^-T, but for the law of small strain, whose P is tau.
void ElementPoint::set_slopes(const ElementState& from, const StressUpdate<3>& update,
                              const Tangent<3>& A, Response& response) const {
  const bool small_strain = std::holds_alternative<LinearElastic<3>>(settings_.material.law);
  const Matrix<3> F_n_inverse = from.F.inverse();
  const Matrix<3> step = response.state.F * F_n_inverse;  // 1 + H
  const Matrix<3> F_inverse = response.state.F.inverse();
  const Symmetric<3> sigma = std::exp(-response.state.log_J) * update.tau;
  response.stress_slope.setZero();
  response.log_J_slope.setZero();
  for (int k = 0; k < num_components; ++k) {
    const Matrix<3> dF = gradient(Vector6::Unit(k));
    const Matrix<3> dH = dF * F_n_inverse;
    Matrix<3> dP = Matrix<3>::Zero();
    for (int aJ = 0; aJ < 9; ++aJ) {
      for (int bL = 0; bL < 9; ++bL) dP(aJ / 3, aJ % 3) += A(aJ, bL) * dH(bL / 3, bL % 3);
    }
    const Matrix<3> dtau =
        small_strain ? dP : Matrix<3>(dP * step.transpose() + update.P * dH.transpose());
    const double volumetric = (dF * F_inverse).trace();
    response.log_J_slope[k] = volumetric;
    response.stress_slope.col(k) =
        std::exp(-response.state.log_J) * symmetric<3>(dtau) - volumetric * sigma;
  }
}

std::string ElementPoint::answer(const ElementState& from, const PoreState& pores,
                                 const Trial& trial, Response& response) const {
  const Matrix<3> H = gradient(trial.strain - from.strain) * from.F.inverse();
  std::vector<double> variables(from.variables.size());
  const PointContext context{.dt = trial.dt,
                             .band_width = settings_.band_width,
                             .internal = from.internal,
                             .variables = from.variables,
                             .new_variables = variables};
  StressUpdate<3> found;
  Tangent<3> A;
  found.internal = from.internal;
  const LawInStep<MaterialLaw<3>, 3> law{settings_.material.law, context};
  if (!gabion::update<3>(law, H, from.history, found, &A)) return reason(found.refusal);
  ElementState& state = response.state;
  state = {.time = from.time + trial.dt,
           .strain = trial.strain,
           .F = Matrix<3>::Identity() + gradient(trial.strain),
           .log_J = from.log_J + std::log1p(determinant_minus_one<3>(H)),
           .zero_log_J = from.zero_log_J,
           .tau = found.tau,
           .pore_pressure = 0,
           .history = found.state,
           .internal = found.internal,
           .variables = std::move(variables),
           .region = found.region};
  set_slopes(from, found, A, response);
  const std::string refused = add_water(pores, trial, response);
  if (!refused.empty()) return refused;
  const bool finite = state.stress().allFinite() && response.stress_slope.allFinite();
  return finite ? "" : "the law gave a stress or stiffness that is no number";
}

}  // namespace gabion::element
