// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/rayleigh.hpp"

namespace gabion::fem {

KeyTable rayleigh_keys() {
  return {"rayleigh",
          "Damping `mass` M + `stiffness` K.",
          {key::number("mass", "1/s", "Damps low frequencies.").in(non_negative()).or_else(0),
           key::number("stiffness", "s", "Damps high frequencies.").in(non_negative()).or_else(0)}};
}

RayleighFactors read_rayleigh(ConfigReader& in) {
  if (!in.has("rayleigh")) return {};
  ConfigReader own = in.object("rayleigh");
  const RayleighFactors factors{.mass = own.number("mass"),
                                .stiffness = own.number("stiffness"),
                                .where = in.where("rayleigh")};
  own.finish();
  return factors;
}

}  // namespace gabion::fem
