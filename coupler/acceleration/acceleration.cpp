// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/acceleration.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "coupler/acceleration/quasi_newton.hpp"
#include "coupler/acceleration/relaxation.hpp"
#include "coupler/acceleration/scaled_fields.hpp"

namespace gabion {

namespace {

const std::vector<std::string> methods = {"constant", "aitken", "iqn_ils", "mvqn"};

std::unique_ptr<Acceleration> make_method(const AccelerationSettings& settings) {
  if (settings.method == "constant") return std::make_unique<Constant>(settings.relaxation);
  if (settings.method == "aitken") return std::make_unique<Aitken>(settings.relaxation);
  if (settings.method == "iqn_ils" || settings.method == "mvqn") {
    return std::make_unique<QuasiNewton>(settings);
  }
  throw ConfigError(fmt::format("acceleration: found \"{}\", allowed: {}", settings.method,
                                fmt::join(methods, ", ")));
}

}  // namespace

KeyTable acceleration_keys() {
  const AccelerationSettings defaults;
  const std::vector<std::string> with_columns = {"iqn_ils", "mvqn"};
  KeyTable table{
      "acceleration",
      "How the next guess of the displacement follows from the answers to the last ones.",
      {key::choice("method", methods,
                   "`constant` and `aitken`: relaxation; `iqn_ils` and `mvqn`: two names of one "
                   "quasi-Newton method, least squares over columns (differences of iterations) of "
                   "this step and of earlier ones.")
           .or_else(defaults.method),
       key::number("relaxation", "",
                   "Factor omega of the residual: with `constant` in every iteration, else where "
                   "there are no earlier iterations to learn from.")
           .in({.low = 0, .high = 2, .low_open = true, .allowed = "a number > 0 and <= 2"})
           .or_else(defaults.relaxation)}};
  for (const Key& key : filter_keys()) table.keys.push_back(key.when("method", with_columns));
  const std::vector<Key> columns = {
      key::integer("history", "Accepted steps whose columns are kept.")
          .in(non_negative())
          .or_else(defaults.history)
          .when("method", with_columns),
      key::integer("max_columns", "Largest number of columns, of all steps together.")
          .in(at_least(1))
          .or_else(defaults.max_columns)
          .when("method", with_columns),
      key::number("damping", "", "Factor beta of the part of the residual that no column covers.")
          .in({.low = 0, .high = 1, .low_open = true, .allowed = "a number > 0 and <= 1"})
          .or_else(defaults.damping)
          .when("method", with_columns)};
  table.keys.insert(table.keys.end(), columns.begin(), columns.end());
  return table;
}

AccelerationSettings read_acceleration_settings(ConfigReader in) {
  AccelerationSettings s;
  s.method = in.choice("method");
  s.relaxation = in.number("relaxation");
  if (s.method == "iqn_ils" || s.method == "mvqn") {
    s.filter = read_filter(in);
    s.history = in.integer("history");
    s.max_columns = in.integer("max_columns");
    s.damping = in.number("damping");
  }
  in.finish();
  return s;
}

const std::vector<std::string>& acceleration_methods() {
  return methods;
}

std::unique_ptr<Acceleration> make_acceleration(const AccelerationSettings& settings,
                                                const std::vector<Eigen::Index>& fields) {
  auto method = make_method(settings);
  if (fields.size() == 1) return method;
  return std::make_unique<ScaledFields>(std::move(method), std::array{fields.at(0), fields.at(1)});
}

}  // namespace gabion
