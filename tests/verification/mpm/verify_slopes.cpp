// SPDX-License-Identifier: BSD-3-Clause
// Factor of safety of three slopes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/support/verification_row.hpp"
#include "tests/verification/mpm/slope_scene.hpp"

namespace gabion::test {
namespace {

/// Slopes of 10 m. Bishop's factor by a search over circles with 60 to 400 slices.
const Slope little_cohesion{.cohesion = 3e3, .phi = 19.6}, earth{.cohesion = 1e4, .phi = 20};
const Slope clay{.cotangent = 1,
                 .base = 10,
                 .toe = 20,
                 .crest = 30,
                 .unit_weight = 18e3,
                 .cohesion = 3e4,
                 .phi = 0};
constexpr double bishop_little = 0.985, bishop_earth = 1.378;

double factor(Slope slope, double psi, int cells) {
  slope.psi = psi;
  slope.cells = cells;
  const TemporaryMesh mesh(bank_mesh(slope));
  const Json found = search_of_strength(slope_scene(slope, mesh.path(), 0.6));
  EXPECT_EQ(found.at("verdict"), "failure") << found;
  return found.at("factor_of_safety");
}

void verify_factor(const std::string& id, const std::string& what, double exact, double computed,
                   double bound, const std::string& limitation = {}) {
  verify({.id = id,
          .what = "factor of safety, " + what,
          .exact = exact,
          .computed = computed,
          .bound = bound,
          .limitation = limitation});
}

/// Flow with psi = phi, to which the theorems of limit analysis apply. The error falls with the
/// cells, on the second slope with them, on the first more slowly.
struct Associated {
  std::string name;
  Slope slope;
  double bishop = 0;
  double bound = 0;             ///< with 20 cells
  double last_bound = 0;        ///< extrapolated
  std::string limitation = {};  ///< of the extrapolation
};

void verify_associated(const Associated& of) {
  std::vector<double> F, sizes, errors;
  for (const int n : {5, 10, 20}) {
    F.push_back(factor(of.slope, of.slope.phi, n));
    sizes.push_back(slope_height / n);
    errors.push_back(F.back() / of.bishop - 1);
  }
  draw_curve({.id = "VA17",
              .figure = "error of the factor of safety, psi = phi",
              .x_label = "cell [m]",
              .y_label = "factor by Bishop's, less 1",
              .label = of.name},
             sizes, errors);
  verify_factor("VA17", of.name + ", psi = phi, 20 cells over the height", of.bishop, F[2],
                of.bound,
                "with psi = phi the slope fails late in coarse cells; the error falls with them");
  verify_factor("VA15", of.name + ", psi = phi, 10 and 20 cells extrapolated in h", of.bishop,
                2 * F[2] - F[1], of.last_bound, of.limitation);
}

TEST(VA15_Slopes, slope_of_little_cohesion) {
  verify_associated({.name = "2:1, c 3 kPa, phi 19.6 deg",
                     .slope = little_cohesion,
                     .bishop = bishop_little,
                     .bound = 0.08,
                     .last_bound = 0.035,
                     .limitation =
                         "the order in h is below 1 here, and the factor moves by 1 % with "
                         "the bracket of the search: 3 % are not reached"});
}

TEST(VA15_Slopes, slope_of_earth) {
  verify_associated({.name = "2:1, c 10 kPa, phi 20 deg",
                     .slope = earth,
                     .bishop = bishop_earth,
                     .bound = 0.05,
                     .last_bound = 0.03});
}

/// Flow without dilation, as most soils have it at failure.
TEST(VA17_NonAssociated, slopes_with_constant_volume) {
  verify_factor("VA17", "2:1, c 3 kPa, phi 19.6 deg, psi = 0, 20 cells over the height",
                bishop_little, factor(little_cohesion, 0, 20), 0.03);
  verify_factor("VA17", "2:1, c 10 kPa, phi 20 deg, psi = 0, 20 cells over the height",
                bishop_earth, factor(earth, 0, 20), 0.03);
}

/// 45 deg, undrained, a firm base 10 m below the toe. Circles are an upper bound, N = F gamma H / c
/// = 5.64; mechanisms of any shape (discontinuity layout, lattices of 3, 4, 6 and 8 nodes over H)
/// give the upper bounds 5.589, 5.541, 5.505 and 5.487, in the limit 5.43.
TEST(VA16_Clay, lies_between_the_mechanisms) {
  const double stability = clay.unit_weight * slope_height / clay.cohesion;
  const double limit = 5.43 / stability, circles = 5.64 / stability;
  const double coarse = factor(clay, 0, 10), fine = factor(clay, 0, 20);
  verify_factor("VA16", "45 deg, undrained, 10 cells over the height, by mechanisms of any shape",
                limit, coarse, 0.03);
  verify_factor("VA16", "45 deg, undrained, 20 cells over the height, by mechanisms of any shape",
                limit, fine, 0.03);
  verify_factor("VA15", "45 deg, undrained, 20 cells over the height, by Bishop's circles", circles,
                fine, 0.03);
}

}  // namespace
}  // namespace gabion::test
