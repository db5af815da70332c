// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/read_cam_clay.hpp"

#include <fmt/format.h>

namespace gabion {

std::vector<Key> cam_clay_keys() {
  const std::vector<std::string> clay = {"cam_clay"};
  return {key::number("compression_index", "",
                      "lambda*, slope -d ln v / d ln p' of virgin compression, v the specific "
                      "volume: Cc / (2.303 v).")
              .in(inside(0, 1))
              .when("law", clay),
          key::number("swelling_index", "",
                      "kappa*, the same slope of unloading, below `compression_index`: about "
                      "Cs / (2.303 v).")
              .in(inside(0, 1))
              .when("law", clay),
          key::number("critical_state_ratio", "",
                      "M, q / p' at the critical state: 6 sin(phi) / (3 - sin(phi)) in triaxial "
                      "compression.")
              .in(inside(0, 3))
              .when("law", clay),
          key::number("reference_pressure", "Pa",
                      "Pressure at which `density` is given, typical of the body. Contact and "
                      "checks use the stiffness at this pressure.")
              .in(positive())
              .when("law", clay),
          key::number("attraction", "Pa",
                      "Isotropic tension at the tip of the yield ellipse, c cot(phi) of a cemented "
                      "soil. The soil bears no tension, but its shear strength and stiffness at "
                      "zero pressure grow with this value.")
              .in(positive())
              .or_computed("reference_pressure / 1000")
              .when("law", clay)};
}

CamClayParameters read_cam_clay(ConfigReader& in) {
  const auto by_kirchhoff_stress = [](double slope) { return slope / (1 - slope); };
  const double compression = in.number("compression_index");
  const double swelling =
      in.number("swelling_index",
                in_words(inside(0, compression),
                         fmt::format("0 < swelling_index < compression_index = {}", compression)));
  const double reference = in.number("reference_pressure");
  return {.compression = by_kirchhoff_stress(compression),
          .swelling = by_kirchhoff_stress(swelling),
          .critical_ratio = in.number("critical_state_ratio"),
          .poisson_ratio = in.number("poisson_ratio"),
          .reference_pressure = reference,
          .attraction = in.number_or("attraction", reference / 1000)};
}

}  // namespace gabion
