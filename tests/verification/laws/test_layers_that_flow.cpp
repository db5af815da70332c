// SPDX-License-Identifier: BSD-3-Clause
// Steady flow of a layer down a plane, integrated over its depth from the rate at which an element
// of the law creeps under the stresses of that depth.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/element_test/followed.hpp"

namespace gabion::testing {
namespace {

using test::verify;

constexpr double g = 9.81;

Json glass() {
  return {{"law", "mu_i"},
          {"density", 0.6 * 2450},
          {"young_modulus", 1e8},
          {"poisson_ratio", 0.3},
          {"static_friction", 0.38},
          {"limit_friction", 0.64},
          {"inertial_number", 0.279},
          {"grain_size", 5.3e-4},
          {"grain_density", 2450}};
}

/// Stresses that are held while time goes by.
Json held(double pressure, double shear, double duration, int increments) {
  Json stress = all_around(pressure);
  stress["xy"] = shear;
  return {
      {"name", "creep"}, {"stress", stress}, {"duration", duration}, {"increments", increments}};
}

/// Rate of shear [1/s] under stresses [Pa], some shear strain of 0.2 after they came. Three
/// directions bear the same pressure, as in steady flow.
double creep_rate(const Json& material, double pressure, double shear, double expected) {
  const double duration = 0.2 / expected;
  Json squeeze = consolidation(pressure);
  squeeze["duration"] = 1e-3 * duration;
  Json stages = {squeeze, held(pressure, shear, 1e-3 * duration, 20),
                 held(pressure, shear, duration, 400)};
  if (pressure == 0) stages.erase(0);
  const auto states =
      follow({{"material", material}, {"rotation", "simple_shear"}, {"stages", stages}});
  const auto &last = states.back(), &before = states[states.size() - 2];
  return (last.strain[3] - before.strain[3]) / (last.time - before.time);
}

/// Gauss' rule of three points in (0, 1).
struct Node {
  double place, weight;
};
const double offset = std::sqrt(0.15);
const std::array<Node, 3> gauss{Node{0.5 - offset, 5. / 18}, Node{0.5, 4. / 9},
                                Node{0.5 + offset, 5. / 18}};

/// Under 1 kPa at 10/s: I = 10 d sqrt(rho_s / P) = 0.00829581 and mu(I) = 0.387508.
TEST(VA11_GranularShear, bears_the_friction_of_its_rate) {
  const double rate = 10, P = 1e3, strain = 0.5;
  Json squeeze = consolidation(P);
  squeeze["duration"] = 1e-3;
  const Json shear = {{"name", "shear"},           {"strain", {{"xy", strain}}},
                      {"mean_stress", P},          {"moved_by", {"xx", "yy", "zz"}},
                      {"duration", strain / rate}, {"increments", 500}};
  const auto states =
      follow({{"material", glass()}, {"rotation", "simple_shear"}, {"stages", {squeeze, shear}}});
  const double I = rate * 5.3e-4 * std::sqrt(2450 / P);
  verify({.id = "VA11",
          .what = "mu(I) of glass beads, shear stress over pressure at 10/s under 1 kPa",
          .exact = 0.38 + (0.64 - 0.38) * I / (0.279 + I),
          .computed = states.back().stress()[3] / P,
          .bound = 1e-5});
}

/// Bagnold's flow: I is the same at each depth y, the rate I sqrt(P / rho_s) / d, and
///
///     u(z) = 2/3 (I / d) sqrt(0.6 g cos theta) (H^(3/2) - (H - z)^(3/2))
///
/// The rule is exact in sqrt(y).
TEST(VA12_BagnoldFlow, has_its_surface_and_mean_velocity) {
  const double theta = 24 * degree, d = 5.3e-4, H = 40 * d, fraction = 0.6;
  const double friction = std::tan(theta);
  const double I = 0.279 * (friction - 0.38) / (0.64 - friction);
  const double scale = I / d * std::sqrt(fraction * g * std::cos(theta));
  double top = 0, mean = 0;
  for (const auto& [place, weight] : gauss) {
    const double root = place * std::sqrt(H), y = root * root;
    const double P = fraction * 2450 * g * std::cos(theta) * y;
    const double rate = creep_rate(glass(), P, friction * P, scale * root);
    const double dy = 2 * root * std::sqrt(H) * weight;
    top += rate * dy;
    mean += rate * dy * y / H;
  }
  const std::string what = "mu(I) of glass beads, layer of 40 grains on a plane of 24 deg: ";
  verify({.id = "VA12",
          .what = what + "velocity of the surface",
          .exact = 2. / 3 * scale * std::pow(H, 1.5),
          .computed = top,
          .bound = 1e-4,
          .unit = "m/s"});
  verify({.id = "VA12",
          .what = what + "mean velocity",
          .exact = 2. / 5 * scale * std::pow(H, 1.5),
          .computed = mean,
          .bound = 1e-4,
          .unit = "m/s"});
}

/// Nothing flows below atan(mu_s) = 20.807 deg, no flow is steady above atan(mu_2) = 32.619 deg:
/// the strain of an element stops, or its rate grows with time.
TEST(VA12_BagnoldFlow, begins_and_ends_at_its_slopes) {
  const double P = 1e3;
  const auto rate = [&](double slope, double expected) {
    return creep_rate(glass(), P, std::tan(slope * degree) * P, expected);
  };
  EXPECT_NEAR(rate(20.7, 1), 0, 1e-6);
  const double I = 0.279 * (std::tan(20.9 * degree) - 0.38) / (0.64 - std::tan(20.9 * degree));
  const double expected = I / 5.3e-4 * std::sqrt(P / 2450);
  verify({.id = "VA12",
          .what = "mu(I) of glass beads, rate of shear just above the slope where flow begins",
          .exact = expected,
          .computed = rate(20.9, expected),
          .bound = 1e-3,
          .unit = "1/s"});
}

/// Plug flow on a plane: the stress rho g sin(theta) y exceeds tau_y below the plug,
///
///     u = n / (n + 1) (rho g sin(theta) / K)^(1/n) z_s^(1 + 1/n) , z_s = H - tau_y / (rho g sin)
TEST(VA13_MudOnAPlane, has_its_plug) {
  const double rho = 1800, H = 0.2, yield_stress = 100, pull = rho * g * std::sin(15 * degree);
  const double sheared = H - yield_stress / pull;
  for (const auto& [n, K] : {std::pair{0.5, 500.}, {1., 100.}}) {
    const Json mud = {{"law", "herschel_bulkley"},
                      {"density", rho},
                      {"young_modulus", 1e7},
                      {"poisson_ratio", 0.3},
                      {"yield_stress", yield_stress},
                      {"consistency", K},
                      {"flow_index", n}};
    double plug = 0;
    for (const auto& [place, weight] : gauss) {
      const double stress = yield_stress + pull * sheared * place;
      const double expected = std::pow((stress - yield_stress) / K, 1 / n);
      plug += creep_rate(mud, 0, stress, expected) * weight * sheared;
    }
    verify({.id = "VA13",
            .what = fmt::format("Herschel-Bulkley, flow index {}, layer of 0.2 m on a plane of 15 "
                                "deg: velocity of the plug",
                                n),
            .exact = n / (n + 1) * std::pow(pull / K, 1 / n) * std::pow(sheared, 1 + 1 / n),
            .computed = plug,
            .bound = 1e-4,
            .unit = "m/s"});
    const double still = creep_rate(mud, 0, 0.99 * yield_stress, 1);
    EXPECT_NEAR(still, 0, 1e-6);
  }
}

}  // namespace
}  // namespace gabion::testing
