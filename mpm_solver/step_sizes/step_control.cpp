// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step_sizes/step_control.hpp"

#include <algorithm>

namespace gabion::mpm {

namespace {

constexpr int easy_iterations = 4;
constexpr double growth = 1.25;

// Step size that a limit, last at `last`, allows after a step of dt that it did not restrict [s].
double grown(double last, double dt) {
  return std::min(growth * std::max(last, dt), 2 * dt);
}

}  // namespace

KeyTable step_control_keys() {
  const Range share{.low = 0, .high = 1, .low_open = true, .allowed = "a number in (0, 1]"};
  const auto limit = [](const std::string& name, const Range& range, double fallback,
                        const std::string& sentence) {
    return key::number(name, "", sentence).in(range).or_null().or_else(fallback);
  };
  return {
      "step_control",
      "Limits from which the soil proposes the next dt; null: that limit does not act.",
      {limit("time_error", share, 1e-3,
             "Estimated error of the displacement in an implicit step, over the largest "
             "displacement of a step so far. It is the root mean square over the mass, without the "
             "hundredth of the mass with the largest error unless that is in contact with an "
             "interface.")
           .only("where a phase is implicit"),
       limit("advective", share, 0.3,
             "Largest displacement of a material point in a step over the cell size."),
       limit("strain", share, 0.02, "Largest strain increment of a material point in a step."),
       limit("newton_target", at_least(1), 8, "Newton iterations beyond which dt shrinks.")
           .only("where a phase is implicit"),
       limit("approach", share, 0.1,
             "Largest displacement of a surface into the soil in a step, beyond the gap, over the "
             "cell size.")}};
}

StepControlSettings read_step_control(ConfigReader in, bool any_implicit) {
  const auto of_implicit_steps = [&](const std::string& key) -> std::optional<double> {
    if (!any_implicit && !in.has(key)) return std::nullopt;
    const std::optional<double> limit = in.number_or_null(key);
    if (!any_implicit && limit) in.fail(key, "has no meaning where all phases are explicit");
    return limit;
  };
  StepControlSettings settings;
  settings.time_error = of_implicit_steps("time_error");
  settings.advective = in.number_or_null("advective");
  settings.strain = in.number_or_null("strain");
  settings.newton_target = of_implicit_steps("newton_target");
  settings.approach = in.number_or_null("approach");
  in.finish();
  return settings;
}

const char* limit_name(DtLimit limit) {
  switch (limit) {
    case DtLimit::phase:
      return "the phase";
    case DtLimit::advective:
      return "the speed of the soil";
    case DtLimit::strain:
      return "the strain of a step";
    case DtLimit::newton:
      return "the number of Newton iterations";
    case DtLimit::failure:
      return "a failed step";
    case DtLimit::approach:
      return "a surface that comes near";
    case DtLimit::time_error:
      return "the error of a step";
    default:
      return "nothing";
  }
}

void StepControl::fail(double dt) {
  newton_dt_ = dt / 2;
  failed_dt_ = dt;
}

void StepControl::visit_state(StateVisitor& visitor) {
  visitor.real("step_control.fastest", fastest_);
  visitor.real("step_control.error_dt", error_dt_);
  visitor.real("step_control.newton_dt", newton_dt_);
  visitor.real("step_control.failed_dt", failed_dt_);
}

void StepControl::follow_error(const StepMeasures& step) {
  fastest_ = std::max(fastest_, step.speed);
  const double allowed = *settings_.time_error * step.dt * fastest_;
  error_dt_ = std::min(step.dt * allowed / step.error, grown(error_dt_, step.dt));
}

void StepControl::follow_newton(double dt, int iterations) {
  const double target = *settings_.newton_target;
  if (iterations > target) {
    newton_dt_ = dt * target / iterations;
  } else if (iterations <= std::min<double>(easy_iterations, target)) {
    newton_dt_ = grown(newton_dt_, dt);
  } else {
    newton_dt_ = dt;
  }
  if (newton_dt_ >= failed_dt_) failed_dt_ = 0;
}

DtProposal StepControl::accept(const StepMeasures& step, double phase_dt) {
  DtProposal result;
  double smallest = std::numeric_limits<double>::infinity();
  const auto bound = [&](double dt, DtLimit limit) {
    if (!(dt < smallest)) return;
    smallest = dt;
    result = {dt, dt < 2 * step.dt ? limit : DtLimit::none};
  };
  if (phase_dt > 0) bound(phase_dt, DtLimit::phase);
  if (settings_.time_error && step.error > 0) {
    follow_error(step);
    bound(error_dt_, DtLimit::time_error);
  }
  if (settings_.advective && step.travel > 0) {
    bound(step.dt * *settings_.advective / step.travel, DtLimit::advective);
  }
  if (settings_.strain && step.strain > 0) {
    bound(step.dt * *settings_.strain / step.strain, DtLimit::strain);
  }
  if (settings_.approach) bound(step.approach_dt, DtLimit::approach);
  if (settings_.newton_target) {
    follow_newton(step.dt, step.newton_iterations);
    bound(newton_dt_, failed_dt_ > 0 ? DtLimit::failure : DtLimit::newton);
  }
  return result;
}

}  // namespace gabion::mpm
