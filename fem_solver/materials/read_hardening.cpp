// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/read_hardening.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/base/log.hpp"

namespace gabion::fem {

std::vector<Key> yield_keys(const std::vector<std::string>& laws) {
  return {key::number("yield_stress", "Pa",
                      "Yield stress of uniaxial tension; either this or `yield_table`.")
              .in(positive())
              .or_none()
              .when("law", laws),
          key::number("hardening_modulus", "Pa",
                      "Isotropic hardening: slope of the yield stress over the plastic strain; "
                      "with `yield_stress`.")
              .in(non_negative())
              .or_else(0)
              .when("law", laws)
              .without("yield_table"),
          key::rows("yield_table", "-, Pa",
                    "Isotropic hardening: rows [plastic strain, yield stress], true stress over "
                    "logarithmic strain, the first at strain 0; linear between rows, constant "
                    "after.")
              .wide(2, 2)
              .not_empty()
              .or_none()
              .when("law", laws),
          key::number("kinematic_modulus", "Pa",
                      "Kinematic hardening (Prager): slope of the stress over the plastic strain "
                      "in uniaxial tension.")
              .in(non_negative())
              .or_else(0)
              .when("law", laws)};
}

namespace {

Hardening read_yield_table(ConfigReader& in) {
  std::vector<double> strains, stresses;
  const auto rows = in.rows("yield_table", 2);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double strain = rows[i][0], stress = rows[i][1];
    const std::string row = fmt::format("yield_table/{}", i);
    if (!(stress > 0)) in.fail(row, fmt::format("found yield stress {}, allowed: > 0", stress));
    if (i == 0 && strain != 0) {
      in.fail(row, fmt::format("found plastic strain {}, allowed: 0 in the first row", strain));
    }
    if (i > 0 && !(strain > strains.back())) {
      in.fail(row, fmt::format("found plastic strain {} after {}, allowed: rising strains", strain,
                               strains.back()));
    }
    if (i > 0 && stress < stresses.back()) {
      in.fail(row,
              fmt::format("found yield stress {} after {}, allowed: no fall (softening depends "
                          "on the mesh)",
                          stress, stresses.back()));
    }
    strains.push_back(strain);
    stresses.push_back(stress);
  }
  return Hardening::table(std::move(strains), std::move(stresses));
}

}  // namespace

Hardening read_hardening(ConfigReader& in) {
  if (in.has("yield_stress") == in.has("yield_table")) {
    in.fail("yield_stress", fmt::format("found {}, allowed: either \"yield_stress\" or "
                                        "\"yield_table\"",
                                        in.has("yield_table") ? "both" : "neither"));
  }
  if (!in.has("yield_table")) {
    return Hardening::linear(in.number("yield_stress"), in.number("hardening_modulus"));
  }
  if (in.has("hardening_modulus")) {
    in.fail("hardening_modulus", "has no meaning with \"yield_table\"");
  }
  return read_yield_table(in);
}

void check_yield(const ConfigReader& in, const Hardening& hardening, double E, double H_k) {
  const std::string key = in.has("yield_table") ? "yield_table" : "yield_stress";
  const double first = hardening.yield_stress(0);
  if (first > 0.1 * E) {
    log::warn(
        "{}: found {} Pa, more than a tenth of young_modulus = {} Pa: metals yield at some "
        "thousandth; units?",
        in.where(key), first, E);
  } else if (first < 1e-6 * E) {
    log::warn(
        "{}: found {} Pa, less than a millionth of young_modulus = {} Pa: metals yield at "
        "some thousandth; in MPa?",
        in.where(key), first, E);
  }
  const double slope = hardening.flow(2 * first, 0, E).slope;
  if (std::max(slope, H_k) > E) {
    log::warn("{}: hardens by up to {} Pa, more than young_modulus = {} Pa; units?", in.where(key),
              std::max(slope, H_k), E);
  }
}

}  // namespace gabion::fem
