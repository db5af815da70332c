// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/umat.hpp"

#include <cmath>

#include "common/mechanics/materials/spectral.hpp"
#include "common/mechanics/materials/umat_model.hpp"
#include "common/mechanics/materials/umat_state.hpp"

namespace gabion {
namespace {

using Vector6 = UmatCall::Vector6;
using Eigen::Matrix3d;

// A stress that differs from that of the elastic step by more than this share of it is not elastic.
constexpr double elastic_step = 1e-6;
// Energies below this share of the largest one count as zero.
constexpr double no_work = 1e-14;

Matrix3d tensor(const Vector6& s) {
  Matrix3d m;
  m << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
  return m;
}
Vector6 components(const Matrix3d& m) {
  return {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(1, 2), m(0, 2)};
}

/// 1 + H = V R of an increment.
struct Polar {
  Matrix3d R, axes;  // axes of V in columns
  Eigen::Vector3d stretch;
  Matrix3d log_V;
};

bool decompose(const Matrix3d& H, Polar& polar) {
  const Eigenpairs<3> pairs = eigenpairs<3>(push_forward<3>(H, Symmetric<3>::Zero()));
  std::array<double, 3> log_stretch;
  for (int i = 0; i < 3; ++i) {
    if (!(pairs.value[i] > -1)) return false;
    polar.stretch[i] = std::sqrt(1 + pairs.value[i]);
    log_stretch[i] = hencky_strain(pairs.value[i]);
  }
  polar.axes = pairs.n;
  polar.log_V = tensor(compose<3>(log_stretch, pairs.n));
  const Eigen::Vector3d inverse = polar.stretch.cwiseInverse();
  polar.R = polar.axes * inverse.asDiagonal() * polar.axes.transpose() * (Matrix3d::Identity() + H);
  return true;
}

// Rates on the axes of V for l = d + w: of R, and of ln V as seen by R.
struct Rates {
  Matrix3d spin, stretching;
};
Rates rates_of(const Polar& polar, const Matrix3d& l) {
  const Matrix3d on_axes = polar.axes.transpose() * l * polar.axes;
  Rates rates;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double v_i = polar.stretch[i], v_j = polar.stretch[j];
      const double d = 0.5 * (on_axes(i, j) + on_axes(j, i));
      const double w = 0.5 * (on_axes(i, j) - on_axes(j, i));
      rates.spin(i, j) = w + d * (v_j - v_i) / (v_i + v_j);
      // 2 v_i v_j ln(v_i / v_j) / (v_i^2 - v_j^2), with its limit 1
      rates.stretching(i, j) = d * 2 * v_i * v_j * hencky_slope(v_i * v_i, v_j * v_j);
    }
  }
  rates.spin = polar.axes * rates.spin * polar.axes.transpose();
  rates.stretching = polar.axes * rates.stretching * polar.axes.transpose();
  return rates;
}

// dP/dH: dP = (d tau - tau l^T) (1 + H)^-T, d tau = tr(l) tau + J (spin sigma - sigma spin + D :
// stretching).
template <int dim>
void set_tangent(const UmatAnswer& answer, const Polar& polar, const Matrix3d& F_inverse, double J,
                 Tangent<dim>& A) {
  const Matrix3d sigma = tensor(answer.stress), tau = J * sigma;
  for (int k = 0; k < dim; ++k) {
    for (int L = 0; L < dim; ++L) {
      Matrix3d l = Matrix3d::Zero();
      l.row(k) = F_inverse.row(L);
      const Rates rates = rates_of(polar, l);
      const Matrix3d d_tau =
          l.trace() * tau + J * (rates.spin * sigma - sigma * rates.spin +
                                 tensor(answer.tangent * components(rates.stretching)));
      const Matrix3d dP = (d_tau - tau * l.transpose()) * F_inverse.transpose();
      for (int i = 0; i < dim; ++i) {
        for (int j = 0; j < dim; ++j) A(i * dim + j, k * dim + L) = dP(i, j);
      }
    }
  }
}

template <int dim>
Symmetric<dim> cut(const Vector6& s) {
  return s.head<symmetric_size<dim>>();
}

// The strain whose work is dissipated: SSE is stored, the rest of the work is not.
// @param tau, tau_n  at the end and at the start; change  of the stored energy
template <int dim>
Symmetric<dim> dissipated_strain(const Vector6& tau_n, const Vector6& tau, const Vector6& log_V,
                                 double change) {
  Vector6 mean = 0.5 * (tau_n + tau);
  mean.tail<3>() *= 2;
  const double work = mean.dot(log_V);
  const double scale = mean.norm() * log_V.norm();
  const double share = std::abs(work) > no_work * scale ? (work - change) / work : 0;
  return cut<dim>(share * log_V);
}

template <int dim>
bool advance(const UmatModel& model, const PointContext& context, const Matrix3d& H,
             StressUpdate<dim>& out, Tangent<dim>* A) {
  UmatState state = context.variables.empty() ? UmatState::virgin(model.initial_variables())
                                              : UmatState(context.variables);
  Polar polar;
  const double J_step = 1 + determinant_minus_one<3>(H);
  out.J = J_step;
  out.refusal = Refusal::squeezed;
  if (!(J_step > 0) || !decompose(H, polar)) return false;
  const Matrix3d F_n = Matrix3d::Identity() + state.displacement_gradient();
  const Matrix3d G = state.displacement_gradient() + H * F_n;  // F - 1 at the end
  const double J_n = F_n.determinant(), J = J_n * J_step;
  const auto turn = [&](const Vector6& s) {
    return components(polar.R * tensor(s) * polar.R.transpose());
  };
  const UmatCall call{.stress = turn(state.stress()),
                      .strain = turn(state.strain()),
                      .increment = components(polar.log_V),
                      .rotation = polar.R,
                      .F0 = F_n,
                      .F1 = Matrix3d::Identity() + G,
                      .variables = state.variables(model.num_variables()),
                      .energy = state.energy() / J_n,
                      .time = state.time(),
                      .dt = context.dt,
                      .length = context.band_width > 0 ? context.band_width : 1,
                      .number = state.count() + 1};
  const UmatAnswer answer = model.call(call);
  out.refusal = Refusal::unsolved;
  if (answer.share < 1 || answer.overrun || !answer.finite()) return false;
  const Vector6 tau = J * answer.stress;
  const Vector6 elastic = call.stress + model.stiffness() * call.increment;
  const bool yields =
      (answer.stress - elastic).norm() > elastic_step * (call.stress.norm() + elastic.norm());
  out.region = yields ? YieldRegion::shear : YieldRegion::elastic;
  out.tau = cut<dim>(tau);
  const Matrix3d F_inverse = (Matrix3d::Identity() + H).inverse();
  out.P = (tensor(tau) * F_inverse.transpose()).template topLeftCorner<dim, dim>();
  out.state = {};
  out.state.e = cut<dim>(components(G + G.transpose() + G * G.transpose()));
  out.energy = J * answer.energy;
  out.plastic_increment =
      dissipated_strain<dim>(J_n * call.stress, tau, call.increment, out.energy - state.energy());
  if (A != nullptr) set_tangent<dim>(answer, polar, F_inverse, J, *A);
  if (context.new_variables.empty()) return true;
  state.set({.stress = answer.stress,
             .strain = call.strain + call.increment,
             .displacement_gradient = G,
             .energy = out.energy,
             .dt = context.dt,
             .variables = std::span(answer.variables).first(model.num_variables())});
  state.copy_to(context.new_variables);
  return true;
}

}  // namespace

template <int dim>
bool Umat<dim>::update(const PointContext& context, const Matrix<dim>& H, const MaterialState<dim>&,
                       StressUpdate<dim>& out, Tangent<dim>* A) const {
  Matrix3d whole = Matrix3d::Zero();
  whole.topLeftCorner<dim, dim>() = H;
  return advance<dim>(*model_, context, whole, out, A);
}

template <int dim>
bool Umat<dim>::strain_evenly(const PointContext& context, double strain,
                              StressUpdate<dim>& out) const {
  return advance<dim>(*model_, context, std::expm1(strain / 3) * Matrix3d::Identity(), out,
                      nullptr);
}

template <int dim>
void Umat<dim>::set_start(std::span<double> variables) const {
  UmatState::virgin(model_->initial_variables()).copy_to(variables);
}

template <int dim>
void Umat<dim>::set_start(const Symmetric<dim>& tau, const Symmetric<dim>& log_strain,
                          std::span<double> variables) const {
  UmatState state = UmatState::virgin(model_->initial_variables());
  Vector6 strain = Vector6::Zero(), stress = Vector6::Zero();
  strain.head<symmetric_size<dim>>() = log_strain;
  stress.head<symmetric_size<dim>>() = tau;
  const double J = std::exp(strain.head<3>().sum());
  Matrix3d G = Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) G(i, i) = std::expm1(strain[i]);
  state.set({.stress = stress / J,
             .strain = strain,
             .displacement_gradient = G,
             .variables = model_->initial_variables()});
  state.forget_count();
  state.copy_to(variables);
}

template <int dim>
bool Umat<dim>::symmetric_tangent() const {
  return false;  // not known
}
template <int dim>
double Umat<dim>::p_wave_modulus() const {
  return model_->stiffness().diagonal().head<3>().maxCoeff();
}
template <int dim>
double Umat<dim>::shear_modulus() const {
  return 0.5 * model_->stiffness().diagonal().segment(3, symmetric_size<dim> - 3).maxCoeff();
}
template <int dim>
int Umat<dim>::num_variables() const {
  return model_->num_variables();
}

template class Umat<2>;
template class Umat<3>;

}  // namespace gabion
