// SPDX-License-Identifier: BSD-3-Clause
// Consistent tangents of all laws against central differences.
#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing {
namespace {

constexpr double E = 1e6, nu = 0.3;  // [Pa], -
constexpr double lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
constexpr double size = 0.02;  // of strains, about those at which the soils below yield

/// Every fourth state has two equal principal strains, every third a gap.
template <int dim>
MaterialState<dim> random_state(Random& random, int sample) {
  MaterialState<dim> state;
  state.e = random.elastic_strain<dim>(size / 2, random.uniform(-1.5, 0.2) * size);
  if (sample % 3 == 0) state.gap = random.uniform(0, size);
  if (sample % 4 == 0) {
    state.e.template head<3>().setConstant(random.uniform(-1.5, 0) * size);
    state.e.template tail<symmetric_size<dim> - 3>().setZero();
  }
  return state;
}

/// Differences of two sizes agree, and stay in the region: the law is smooth there.
template <int dim>
bool is_smooth(const auto& law, const Matrix<dim>& H, const MaterialState<dim>& state, double h,
               double allowed) {
  StressUpdate<dim> centre, out;
  if (!law.update(H, state, centre, nullptr)) return false;
  for (int k = 0; k < dim * dim; ++k) {
    for (const double sign : {-2.0, 2.0}) {
      Matrix<dim> moved = H;
      moved(k / dim, k % dim) += sign * h;
      if (!law.update(moved, state, out, nullptr) || out.region != centre.region) return false;
    }
  }
  const auto difference = [&](double width) {
    return difference_tangent<dim>(law, H, state, width);
  };
  return (difference(h) - difference(2 * h)).cwiseAbs().maxCoeff() < allowed;
}

/// Largest difference by the P-wave modulus over random states. At an apex laws add a share of the
/// elastic moduli on purpose; those states count to `apex` alone, as do those of the elastic range.
template <int dim>
void verify_tangent(const std::string& name, const auto& law, const PointContext& context) {
  using Law = std::decay_t<decltype(law)>;
  const LawInStep<Law, dim> soil{law, context};
  Random random(23);
  const double M = law.p_wave_modulus(), h = 1e-6;
  double largest = 0;
  int yielded = 0;
  for (int sample = 0; sample < 600; ++sample) {
    const auto state = random_state<dim>(random, sample);
    const Matrix<dim> H = random.matrix<dim>(random.uniform(0.3, 2.0) * size);
    if (!is_smooth<dim>(soil, H, state, h, 1e-7 * M)) continue;
    const auto region = stress<dim>(soil, H, state).region;
    if (region == YieldRegion::apex) continue;
    yielded += region != YieldRegion::elastic;
    const Tangent<dim> A = tangent<dim>(soil, H, state);
    const Tangent<dim> differences = difference_tangent<dim>(soil, H, state, h);
    largest = std::max(largest, (A - differences).cwiseAbs().maxCoeff() / M);
  }
  EXPECT_GT(yielded, 60) << name;
  test::verify({.id = "VA1",
                .what = name + (dim == 2 ? ", plane strain" : ", 3D") +
                        ": tangent minus central differences, over lambda + 2 mu",
                .exact = 0,
                .computed = largest,
                .measure = test::Measure::absolute_error,
                .bound = 1e-7});
}

Strength strength(double cohesion, double phi, double psi) {
  return {cohesion, std::sin(phi * degree), std::sin(psi * degree)};
}

template <int dim>
void verify_all() {
  const PointContext context{.dt = 0.1, .band_width = 0.5, .internal = {0.02, 0.02}};
  const auto check = [&](const std::string& name, const auto& law) {
    verify_tangent<dim>(name, law, context);
  };
  check("Mohr-Coulomb", MohrCoulomb<dim>(lambda, mu, 30 * degree, 8 * degree, 1e4));
  check("Mohr-Coulomb with a tension cut-off", MohrCoulomb<dim>({.lambda = lambda,
                                                                 .mu = mu,
                                                                 .friction_angle = 30 * degree,
                                                                 .dilation_angle = 8 * degree,
                                                                 .cohesion = 1e4,
                                                                 .tension_cutoff = 5e3}));
  check("Drucker-Prager", DruckerPrager<dim>({.lambda = lambda,
                                              .mu = mu,
                                              .friction_angle = 30 * degree,
                                              .dilation_angle = 8 * degree,
                                              .cohesion = 1e4}));
  check("Tresca", Tresca<dim>({.lambda = lambda, .mu = mu, .cohesion = 1e4}));
  SofteningParameters sand{
      .lambda = lambda,
      .mu = mu,
      .curve = StrengthCurve(ExponentialCurve{
          .peak = strength(1e4, 35, 8), .residual = strength(1e3, 25, 0), .scale = 0.05})};
  check("Mohr-Coulomb that softens", SofteningSoil<dim>(sand));
  SofteningParameters clay{.lambda = lambda,
                           .mu = mu,
                           .curve = StrengthCurve(ExponentialCurve{
                               .peak = {1e4, 0, 0}, .residual = {2e3, 0, 0}, .scale = 0.05})};
  clay.frictional = false;
  check("Tresca that softens", SofteningSoil<dim>(clay));
  clay.rate_gain = {.gain = 0.2, .reference = 1e-3};
  check("Tresca that softens and grows with the rate", SofteningSoil<dim>(clay));
  check("mu(I)", MuI<dim>({.lambda = lambda,
                           .mu = mu,
                           .static_friction = 0.38,
                           .limit_friction = 0.64,
                           .inertial_number = 0.279,
                           .grain_size = 5.3e-4,
                           .grain_density = 2450}));
  check("Herschel-Bulkley", HerschelBulkley<dim>({.lambda = lambda,
                                                  .mu = mu,
                                                  .yield_stress = 2e3,
                                                  .consistency = 2e3,
                                                  .flow_index = 0.5}));
  PointContext remembered = context;
  remembered.internal = {1e5, 5e6};
  verify_tangent<dim>("Cam-Clay",
                      CamClay<dim>({.compression = 0.09,
                                    .swelling = 0.009,
                                    .critical_ratio = 1.2,
                                    .poisson_ratio = 0.3,
                                    .reference_pressure = 1e5,
                                    .attraction = 1e3}),
                      remembered);
}

TEST(VA1_Tangents, of_all_laws_in_the_plane) {
  verify_all<2>();
}
TEST(VA1_Tangents, of_all_laws_in_space) {
  verify_all<3>();
}

}  // namespace
}  // namespace gabion::testing
