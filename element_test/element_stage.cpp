// SPDX-License-Identifier: BSD-3-Clause
#include "element_test/element_stage.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/require.hpp"

namespace gabion::element {

namespace {

using Matrix7 = Eigen::Matrix<double, 7, 7>;

constexpr int max_iterations = 40;
constexpr int max_halvings = 12;
constexpr int max_backtracks = 6;
// Residual of a stress over the largest stress at hand, beside the rounding of stresses that are
// far below the moduli.
constexpr double stress_tolerance = 1e-12;
constexpr double rounding = 16 * std::numeric_limits<double>::epsilon();

constexpr double sign_of(int component) {
  return component < 3 ? -1 : 1;  // compression is positive in the settings
}

/// Values of the equations, and their derivatives by strains and pore pressure over the stiffness.
struct Equations {
  Vector7 r;
  Matrix7 J;
};

/// The seven equations of a stage: each led quantity is a linear form of strains and stresses.
/// Strains and log J have the unit 1, stresses are divided by a stiffness.
class Controls {
 public:
  Controls(const ElementSettings& settings, const StageSettings& stage, const ElementState& start,
           double stiffness)
      : settings_(settings), stage_(stage), start_(start), stiffness_(stiffness) {
    const Vector6 stress = start.stress();
    for (int k = 0; k < num_components; ++k) {
      strain_end_[k] = stage.strain[k] ? sign_of(k) * *stage.strain[k] : start.strain[k];
      stress_end_[k] = stage.stress[k] ? sign_of(k) * *stage.stress[k] : stress[k];
    }
  }

  /// @param share  of the stage
  Equations at(const Response& found, double share) const {
    const Vector6 stress = found.state.stress();
    Eigen::Matrix<double, 6, 7> slope = found.stress_slope / stiffness_;
    slope.col(6) *= stiffness_;
    Equations equations{.r = Vector7::Zero(), .J = Matrix7::Zero()};
    auto& [r, J] = equations;
    for (int k = 0; k < num_components; ++k) {
      if (is_moved(k)) {
        moved_row(k, stress, slope, share, equations);
      } else if (stage_.stress[k]) {
        r[k] = (stress[k] - led(start_.stress()[k], stress_end_[k], share)) / stiffness_;
        J.row(k) = slope.row(k);
      } else {
        r[k] = found.state.strain[k] - led(start_.strain[k], strain_end_[k], share);
        J(k, k) = 1;
      }
    }
    if (keeps_volume()) {
      r[6] = found.state.log_J - start_.log_J;
      J.row(6) = found.log_J_slope.transpose();
    } else {
      J(6, 6) = 1;
    }
    return equations;
  }

  /// Whether the pore pressure is the one that keeps the volume constant.
  bool keeps_volume() const { return stage_.undrained && !settings_.water; }
  /// Pressure of pores that drain [Pa].
  double drained(double share) const {
    return led(start_.pore_pressure, settings_.back_pressure, share);
  }

  /// Set the led strains to their values.
  void lead(double share, Vector7& x) const {
    for (int k = 0; k < num_components; ++k) {
      if (!is_moved(k) && !stage_.stress[k]) x[k] = led(start_.strain[k], strain_end_[k], share);
    }
  }

  /// Residual that counts as none.
  double tolerance(const ElementState& state) const {
    const double size = std::max({state.stress().cwiseAbs().maxCoeff(),
                                  state.effective_stress().cwiseAbs().maxCoeff(),
                                  led_by_stress() ? stress_end_.cwiseAbs().maxCoeff() : 0.0});
    const double water =
        stage_.undrained && settings_.water ? settings_.water->modulus() / stiffness_ : 0;
    return stress_tolerance * size / stiffness_ +
           rounding * (1 + water) * (1 + state.strain.cwiseAbs().maxCoeff());
  }

  std::string place(double share) const {
    std::string text;
    for (int k = 0; k < num_components; ++k) {
      if (!stage_.strain[k] && !stage_.stress[k]) continue;
      const bool strain = stage_.strain[k].has_value();
      const double from = strain ? start_.strain[k] : start_.stress()[k];
      const double to = strain ? strain_end_[k] : stress_end_[k];
      text += fmt::format(", {} {} {:.6g}", strain ? "strain" : "stress", component_names[k],
                          sign_of(k) * led(from, to, share) + 0.0);
    }
    if (stage_.mean_stress) text += fmt::format(", mean stress {:.6g}", -mean_target(share));
    return fmt::format("stage \"{}\", after {:.4g} % of it{}", stage_.name, 100 * share, text);
  }

 private:
  static double led(double from, double to, double share) { return from + share * (to - from); }

  bool is_moved(int k) const { return std::ranges::find(stage_.moved, k) != stage_.moved.end(); }
  bool led_by_stress() const {
    return stage_.mean_stress ||
           std::ranges::any_of(stage_.stress, &std::optional<double>::has_value);
  }
  double mean_target(double share) const {
    return led(start_.stress().head<3>().mean(), -*stage_.mean_stress, share);
  }

  // Equation of a moved stress: the first of them gives the mean, the others keep their difference
  // to the first.
  void moved_row(int k, const Vector6& stress, const Eigen::Matrix<double, 6, 7>& slope,
                 double share, Equations& equations) const {
    auto& [r, J] = equations;
    const int first = stage_.moved.front();
    if (k == first) {
      r[k] = (stress.head<3>().mean() - mean_target(share)) / stiffness_;
      J.row(k) = slope.topRows<3>().colwise().mean();
    } else {
      const Vector6 before = start_.stress();
      r[k] = (stress[k] - stress[first] - (before[k] - before[first])) / stiffness_;
      J.row(k) = slope.row(k) - slope.row(first);
    }
  }

  const ElementSettings& settings_;
  const StageSettings& stage_;
  const ElementState start_;
  double stiffness_;
  Vector6 strain_end_, stress_end_;
};

/// One step of a stage by Newton's method. Where the equations leave strains open, as on the edge
/// of Mohr-Coulomb's surface those of two directions with the same stress, the smallest change is
/// taken: the same in both.
class Step {
 public:
  Step(const ElementPoint& point, const Controls& controls, const PoreState& pores)
      : point_(point), controls_(controls), pores_(pores) {}

  /// @returns why it was not solved, empty: it was, and `state` is its end
  std::string solve(ElementState& state, double share, double dt, int& iterations) {
    from_ = &state;
    share_ = share;
    dt_ = dt;
    Vector7 x;
    x << state.strain, state.pore_pressure / point_.stiffness();
    std::string refused = look_at(x);
    if (!refused.empty()) return refused;
    for (int pass = 0; pass < max_iterations; ++pass) {
      if (is_solved()) {
        state = response_.state;
        return "";
      }
      const Eigen::CompleteOrthogonalDecomposition<Matrix7> factors(equations_.J);
      is_singular_ = factors.rank() < 7;
      ++iterations;
      refused = go(-factors.solve(equations_.r), x);
      if (!refused.empty()) return refused;
    }
    return fmt::format(
        "no equilibrium in {} iterations of Newton's method, residual {:.2g}, allowed {:.2g}{}",
        max_iterations, norm(), controls_.tolerance(response_.state),
        is_singular_ ? "; the stiffness of the law is singular under the prescribed components, as "
                       "at a limit load: prescribe a strain instead of the stress"
                     : "");
  }

 private:
  double norm() const { return equations_.r.cwiseAbs().maxCoeff(); }
  bool is_solved() const { return norm() <= controls_.tolerance(response_.state); }

  std::string look_at(const Vector7& x) {
    const double pressure =
        controls_.keeps_volume() ? x[6] * point_.stiffness() : controls_.drained(share_);
    const Trial trial{x.head<6>(), pressure, dt_};
    const std::string refused = point_.answer(*from_, pores_, trial, response_);
    if (refused.empty()) equations_ = controls_.at(response_, share_);
    return refused;
  }

  // Take the whole step, or the first part of it that reduces the residual; the shortest part if
  // none does.
  std::string go(const Vector7& path, Vector7& x) {
    const double before = norm();
    std::string refused;
    Vector7 tried = x;
    double part = 1;
    for (int k = 0; k <= max_backtracks; ++k, part /= 2) {
      tried = x + part * path;
      if (k == 0) controls_.lead(share_, tried);
      refused = look_at(tried);
      if (refused.empty() && norm() < before) break;
    }
    x = tried;
    return refused;
  }

  const ElementPoint& point_;
  const Controls& controls_;
  const PoreState& pores_;
  const ElementState* from_ = nullptr;
  double share_ = 0, dt_ = 0;
  bool is_singular_ = false;
  Response response_;
  Equations equations_;
};

}  // namespace

void follow_stage(const ElementSettings& settings, const StageSettings& stage, ElementState& state,
                  const std::function<void(const ElementState&, const Effort&)>& report) {
  const ElementPoint point(settings);
  if (stage.zero_strain) {
    state.strain.setZero();
    state.F.setIdentity();
    state.zero_log_J = state.log_J;
    report(state, {});
  }
  const Controls controls(settings, stage, state, point.stiffness());
  PoreState pores{.undrained = stage.undrained};
  if (stage.undrained && settings.water) {
    require<ConvergenceError>(settings.water->admits(std::exp(state.log_J)),
                              "{}: the pores are closed", controls.place(0));
    pores.content = settings.water->content_at(state.pore_pressure, std::exp(state.log_J));
  }
  Step step(point, controls, pores);
  const double whole = stage.duration.value_or(0);
  const int parts = 1 << max_halvings;  // of an increment
  for (int n = 0; n < stage.increments; ++n) {
    Effort effort;
    for (int done = 0, size = parts; done < parts;) {
      const double share = (n + static_cast<double>(done + size) / parts) / stage.increments;
      const double dt = whole * size / parts / stage.increments;
      const std::string refused = step.solve(state, share, dt, effort.iterations);
      if (refused.empty()) {
        done += size;
        while (done < parts && (size * 2 <= parts) && done % (size * 2) == 0) size *= 2;
        continue;
      }
      ++effort.cuts;
      if (size == 1) {
        const double reached = (n + static_cast<double>(done) / parts) / stage.increments;
        throw ConvergenceError(controls.place(reached) + ": " + refused, "element_test");
      }
      size /= 2;
    }
    report(state, effort);
  }
  if (stage.ocr) point.consolidate(*stage.ocr, state);
}

}  // namespace gabion::element
