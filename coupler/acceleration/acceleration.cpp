// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/acceleration.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <numeric>

#include "coupler/acceleration/quasi_newton.hpp"
#include "coupler/acceleration/relaxation.hpp"
#include "coupler/acceleration/residual_jacobian.hpp"
#include "coupler/acceleration/scaled_fields.hpp"

namespace gabion {

namespace {

const std::vector<std::string> methods = {"constant", "aitken", "iqn_ils", "mvqn", "mvqn_residual"};

std::unique_ptr<Acceleration> make_method(const AccelerationSettings& settings, Eigen::Index size) {
  if (settings.method == "constant") return std::make_unique<Constant>(settings.relaxation);
  if (settings.method == "aitken") return std::make_unique<Aitken>(settings.relaxation);
  if (settings.method == "iqn_ils" || settings.method == "mvqn") {
    return std::make_unique<QuasiNewton>(settings);
  }
  if (settings.method == "mvqn_residual") {
    return std::make_unique<ResidualJacobian>(settings, size);
  }
  throw ConfigError(fmt::format("acceleration: found \"{}\", allowed: {}", settings.method,
                                fmt::join(methods, ", ")));
}

}  // namespace

AccelerationSettings read_acceleration_settings(ConfigReader in) {
  AccelerationSettings s;
  s.method = in.choice_or("method", methods, s.method);
  const Range omega{[](double x) { return x > 0 && x <= 2; }, "a number > 0 and <= 2"};
  s.relaxation = in.number_or("relaxation", s.relaxation, omega);
  if (s.method == "iqn_ils" || s.method == "mvqn") {
    const Range beta{[](double x) { return x > 0 && x <= 1; }, "a number > 0 and <= 1"};
    s.filter = read_filter(in, "filter", s.filter);
    s.history = in.integer_or("history", s.history, non_negative());
    s.max_columns = in.integer_or("max_columns", s.max_columns, at_least(1));
    s.damping = in.number_or("damping", s.damping, beta);
  }
  if (s.method == "mvqn_residual") {
    s.max_columns = in.integer_or("max_columns", 15, at_least(1));
  }
  in.finish();
  return s;
}

const std::vector<std::string>& acceleration_methods() {
  return methods;
}

std::unique_ptr<Acceleration> make_acceleration(const AccelerationSettings& settings,
                                                const std::vector<Eigen::Index>& fields) {
  const Eigen::Index size = std::accumulate(fields.begin(), fields.end(), Eigen::Index{0});
  auto method = make_method(settings, size);
  if (fields.size() == 1) return method;
  return std::make_unique<ScaledFields>(std::move(method), fields);
}

}  // namespace gabion
