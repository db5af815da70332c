// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/read_softening.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gabion {
namespace {

constexpr double degree = std::numbers::pi / 180;

Key without_tables(const Key& key) {
  return key.without("table").without("strain_table");
}

Key table_of(const std::string& name, const std::string& shear, const std::string& unit,
             bool frictional) {
  const int width = frictional ? 4 : 2;
  return key::rows(
             name, unit + (frictional ? ", Pa, deg, deg" : ", Pa"),
             "Rows [" + shear +
                 (frictional ? ", cohesion, friction_angle, dilation_angle]" : ", cohesion]") +
                 " that follow the strength of the virgin soil, which other keys give. Monotone "
                 "cubics between rows, constant after the last.")
      .wide(width, width)
      .not_empty()
      .or_none();
}

std::vector<Key> rate_keys() {
  return {key::number("rate_gain", "",
                      "Share by which the strength grows with each decade of the shear rate, far "
                      "above `reference_rate`: 0.05 to 0.2 in clay. Without `relaxation_time`.")
              .in(positive())
              .or_none(),
          key::number("reference_rate", "1/s",
                      "Shear rate of the test that measured the strength; a logarithm begins "
                      "there: far below it the strength does not depend on the rate.")
              .in(positive())
              .with("rate_gain")};
}

Strength strength_of(const VirginSoil& soil) {
  return {soil.cohesion, std::sin(soil.friction_angle * degree),
          std::sin(soil.dilation_angle * degree)};
}

// Checks of one row, besides its place.
void check_row(const ConfigReader& in, const std::string& where, const VirginSoil& row,
               bool frictional) {
  if (!(row.cohesion >= 0) || (!frictional && row.cohesion == 0)) {
    in.fail(where, fmt::format("found a cohesion of {} Pa, allowed: {}", row.cohesion,
                               frictional ? "at least 0" : "above 0"));
  }
  if (!frictional) return;
  if (!(row.friction_angle > 0 && row.friction_angle < 90)) {
    in.fail(where, fmt::format("found a friction angle of {} degrees, allowed: 0 < friction_angle "
                               "< 90",
                               row.friction_angle));
  }
  if (!(row.dilation_angle >= 0 && row.dilation_angle <= row.friction_angle)) {
    in.fail(where,
            fmt::format("found a dilation angle of {} degrees, allowed: from 0 to the friction "
                        "angle of the row, {}",
                        row.dilation_angle, row.friction_angle));
  }
}

StrengthCurve read_table(ConfigReader& in, const std::string& name, const VirginSoil& virgin,
                         bool frictional) {
  TabulatedCurve curve{.x = {0}, .values = {strength_of(virgin)}};
  const auto rows = in.rows(name, frictional ? 4 : 2);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string where = fmt::format("{}/{}", name, i);
    const VirginSoil row{rows[i][1], frictional ? rows[i][2] : 0, frictional ? rows[i][3] : 0};
    if (!(rows[i][0] > curve.x.back())) {
      in.fail(where, fmt::format("found {} after {}, allowed: rows that ascend from 0, where the "
                                 "soil is virgin",
                                 rows[i][0], curve.x.back()));
    }
    check_row(in, where, row, frictional);
    curve.x.push_back(rows[i][0]);
    curve.values.push_back(strength_of(row));
  }
  const StrengthCurve result(curve);
  for (const double x : result.samples()) {
    const Strength at = result.at(x).value;
    if (at.sin_dilation <= at.sin_friction * (1 + 1e-12)) continue;
    in.fail(name, fmt::format("found a dilation angle of {:.4g} degrees beside a friction angle of "
                              "{:.4g} at {:.4g}, allowed: dilation_angle <= friction_angle between "
                              "rows too; more rows keep them apart",
                              std::asin(at.sin_dilation) / degree,
                              std::asin(at.sin_friction) / degree, x));
  }
  return result;
}

StrengthCurve read_exponential(ConfigReader& in, const VirginSoil& virgin, bool frictional) {
  ExponentialCurve curve{.peak = strength_of(virgin)};
  const bool by_slip = in.has("slip");
  curve.scale = in.number(by_slip ? "slip" : "strain");
  curve.residual = {in.number_or("residual_cohesion", virgin.cohesion), 0, 0};
  if (!frictional) {
    curve.remoulded_cohesion = curve.residual.cohesion;
    if (!by_slip) return StrengthCurve(curve);
    if (const auto remoulded = in.optional_number("remoulded_cohesion")) {
      if (*remoulded > curve.residual.cohesion) {
        in.fail("remoulded_cohesion",
                fmt::format("found {}, allowed: at most residual_cohesion = {}", *remoulded,
                            curve.residual.cohesion));
      }
      curve.remoulded_cohesion = *remoulded;
      curve.remoulding_scale = in.number("remoulding_slip", at_least(curve.scale));
    }
    return StrengthCurve(curve);
  }
  const double residual = in.number_or("residual_friction_angle", virgin.friction_angle);
  curve.residual.sin_friction = std::sin(residual * degree);
  curve.dilation = in.choice("dilation") == "rowe" ? Dilation::rowe : Dilation::exponential;
  if (curve.dilation == Dilation::rowe && residual > virgin.friction_angle) {
    in.fail("residual_friction_angle",
            fmt::format("found {} degrees with \"dilation\": \"rowe\", allowed: at most the "
                        "friction_angle {}; soil that hardens first has a table",
                        residual, virgin.friction_angle));
  }
  return StrengthCurve(curve);
}

// The cut-off shrinks with the cohesion and has to stay below the apex.
void check_cutoff(const ConfigReader& in, const SofteningParameters& p) {
  if (p.tension_cutoff == no_cutoff || !p.frictional) return;
  double steepest = 0;
  for (const double x : p.curve.samples()) {
    steepest = std::max(steepest, p.curve.at(x).value.sin_friction);
  }
  const double least = p.curve.at(0).value.cohesion / std::tan(std::asin(steepest));
  if (p.tension_cutoff < least) return;
  in.fail("..",
          fmt::format("found \"tension_cutoff\" = {} Pa, allowed: below cohesion / tan(phi) = "
                      "{:.6g} with the largest friction angle of the softening, {:.4g} degrees",
                      p.tension_cutoff, least, std::asin(steepest) / degree));
}

// The key that says how the strength changes.
std::string given_curve(const ConfigReader& in) {
  std::vector<std::string> given;
  for (const char* name : {"slip", "strain", "table", "strain_table"}) {
    if (in.has(name)) given.emplace_back(name);
  }
  if (given.size() != 1) {
    in.fail(given.empty() ? "slip" : given.back(),
            fmt::format("found {}, allowed: exactly one of slip, strain, table, strain_table",
                        given.empty() ? "none" : fmt::format("{}", fmt::join(given, ", "))));
  }
  return given.front();
}

}  // namespace

KeyTable softening_keys(bool frictional) {
  KeyTable table{
      frictional ? "softening" : "tresca_softening",
      "How the strength of a point changes with its accumulated shear. With `slip`, or a `table` "
      "of slips, results do not depend on the grid; with strains they do.",
      {key::number("slip", "m",
                   "Slip of a shear surface over which 1 - 1/e of the change of strength takes "
                   "place; the law is exponential.")
           .in(positive())
           .or_none(),
       key::number("strain", "",
                   "Deviatoric plastic strain over which that change takes place. For tests of "
                   "single elements only: the work of a shear surface shrinks with the cells.")
           .in(positive())
           .or_none(),
       table_of("table", "slip", "m", frictional),
       table_of("strain_table", "deviatoric plastic strain", "-", frictional)}};
  table.one_of = {"slip", "strain", "table", "strain_table"};
  Key residual = key::number("residual_cohesion", "Pa", "Residual cohesion, before remoulding.")
                     .in(frictional ? non_negative() : positive())
                     .or_computed("cohesion");
  table.keys.push_back(without_tables(residual));
  if (frictional) {
    table.keys.push_back(
        without_tables(key::number("residual_friction_angle", "deg", "Residual angle of friction.")
                           .in(inside(0, 90))
                           .or_computed("friction_angle")));
    table.keys.push_back(without_tables(
        key::choice("dilation", {"exponential", "rowe"},
                    "How the dilation decreases. `exponential`: from `dilation_angle`, together "
                    "with the strength; `rowe`: it follows from the friction and is zero at "
                    "`residual_friction_angle`; `dilation_angle` is not used.")
            .or_else("exponential")));
  } else {
    table.keys.push_back(
        key::number("remoulded_cohesion", "Pa",
                    "Strength of the remoulded clay, to which the residual strength falls.")
            .in(positive())
            .or_none()
            .with("slip"));
    table.keys.push_back(
        key::number("remoulding_slip", "m", "Slip over which 1 - 1/e of that fall takes place.")
            .in(positive())
            .with("remoulded_cohesion"));
    for (const Key& key : rate_keys()) table.keys.push_back(key);
  }
  table.keys.push_back(
      key::number(
          "relaxation_time", "s",
          "Time in which the stress relaxes to the strength (Duvaut and Lions); 0: at once.")
          .in(non_negative())
          .or_else(0));
  return table;
}

void read_softening(ConfigReader in, const VirginSoil& virgin, SofteningParameters& parameters) {
  const bool frictional = parameters.frictional;
  const std::string given = given_curve(in);
  if (given == "table" || given == "strain_table") {
    parameters.curve = read_table(in, given, virgin, frictional);
  } else {
    parameters.curve = read_exponential(in, virgin, frictional);
  }
  parameters.by_slip = given == "slip" || given == "table";
  parameters.relaxation_time = in.number("relaxation_time");
  if (!frictional) {
    if (const auto gain = in.optional_number("rate_gain")) {
      parameters.rate_gain = {*gain, in.number("reference_rate")};
      if (parameters.relaxation_time > 0) {
        in.fail("rate_gain",
                fmt::format("found {} beside \"relaxation_time\": {}, allowed: one of the two, the "
                            "rate of a stress that lags behind is not that of the soil",
                            *gain, parameters.relaxation_time));
      }
    }
  }
  const bool has_apex = frictional || parameters.tension_cutoff != no_cutoff;
  if (parameters.relaxation_time > 0 && has_apex && parameters.apex_volume == ApexVolume::gap) {
    in.fail("relaxation_time",
            fmt::format("found {} with \"apex_volume\": \"gap\", allowed: 0, or \"apex_volume\": "
                        "\"forget\": volume that opens has no stress to relax",
                        parameters.relaxation_time));
  }
  check_cutoff(in, parameters);
  in.finish();
}

}  // namespace gabion
