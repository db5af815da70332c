// SPDX-License-Identifier: BSD-3-Clause
// Mohr-Coulomb and Tresca whose strength changes with shear.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing::test_softening {
namespace {

constexpr double E = 1e6, nu = 0.3;  // [Pa], -
constexpr double lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
constexpr double size = 0.02;  // of strains, about those at which the soils below yield

Strength strength(double cohesion, double phi, double psi) {
  return {cohesion, std::sin(phi * degree), std::sin(psi * degree)};
}

SofteningParameters soil_of(const StrengthCurve& curve) {
  return {.lambda = lambda, .mu = mu, .curve = curve};
}

SofteningParameters sand(Dilation dilation = Dilation::exponential) {
  return soil_of(StrengthCurve(ExponentialCurve{.peak = strength(1e4, 35, 8),
                                                .residual = strength(1e3, 25, 0),
                                                .scale = 0.05,
                                                .dilation = dilation}));
}

SofteningParameters tabulated() {
  auto soil =
      soil_of(StrengthCurve(TabulatedCurve{.x = {0, 0.02, 0.05, 0.1},
                                           .values = {strength(1e4, 25, 0), strength(1e4, 35, 8),
                                                      strength(5e3, 30, 3), strength(0, 28, 0)}}));
  soil.by_slip = false;
  return soil;
}

SofteningParameters clay(double residual = 2e3, double scale = 0.05) {
  auto soil = soil_of(StrengthCurve(
      ExponentialCurve{.peak = {1e4, 0, 0}, .residual = {residual, 0, 0}, .scale = scale}));
  soil.frictional = false;
  return soil;
}

SofteningParameters cut_off(SofteningParameters soil, double tension) {
  soil.tension_cutoff = tension;
  return soil;
}

SofteningParameters viscous(SofteningParameters soil, double relaxation_time) {
  soil.relaxation_time = relaxation_time;
  soil.apex_volume = ApexVolume::forget;
  return soil;
}

SofteningParameters quick(SofteningParameters soil, double gain = 0.2, double reference = 1e-3) {
  soil.rate_gain = {gain, reference};
  return soil;
}

std::vector<SofteningParameters> soils() {
  return {sand(),
          sand(Dilation::rowe),
          tabulated(),
          clay(),
          cut_off(sand(), 5e3),
          cut_off(clay(), 8e3),
          viscous(sand(), 0.2),
          viscous(clay(), 0.2),
          quick(clay()),
          quick(cut_off(clay(), 8e3))};
}

/// The law at a point.
template <int dim>
struct InContext {
  SofteningSoil<dim> law;
  PointContext context{.dt = 0.1, .band_width = 0.5};

  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const {
    return law.update(context, H, state_n, out, A);
  }
};

template <int dim>
struct Step {
  MaterialState<dim> state;
  Matrix<dim> H;
};

/// Every fourth state has two equal principal strains, every third a gap.
template <int dim>
Step<dim> random_step(Random& random, InContext<dim>& soil, int sample) {
  Step<dim> step;
  step.state.e = random.elastic_strain<dim>(size / 2, random.uniform(-1.5, 0.2) * size);
  step.H = random.matrix<dim>(random.uniform(0.3, 2.0) * size);
  if (sample % 3 == 0) step.state.gap = random.uniform(0, size);
  if (sample % 4 == 0) {
    step.state.e.template head<3>().setConstant(random.uniform(-1.5, 0) * size);
    step.state.e.template tail<symmetric_size<dim> - 3>().setZero();
  }
  soil.context.internal = {random.uniform(0, 0.05), random.uniform(0, 0.05)};
  return step;
}

/// Differences of two sizes agree and stay in the region: the law is smooth there.
template <int dim>
bool is_smooth(const InContext<dim>& soil, const Step<dim>& step, YieldRegion region, double h) {
  for (int k = 0; k < dim * dim; ++k) {
    for (const double sign : {-2.0, 2.0}) {
      Matrix<dim> moved = step.H;
      moved(k / dim, k % dim) += sign * h;
      StressUpdate<dim> out;
      if (!soil.update(moved, step.state, out, nullptr) || out.region != region) return false;
    }
  }
  const auto difference = [&](double width) {
    return difference_tangent<dim>(soil, step.H, step.state, width);
  };
  return (difference(h) - difference(2 * h)).cwiseAbs().maxCoeff() <
         1e-6 * soil.law.p_wave_modulus();
}

/// @returns samples of each region
template <int dim>
std::map<YieldRegion, int> compare_tangents(const SofteningParameters& parameters) {
  Random random(11);
  InContext<dim> soil{SofteningSoil<dim>(parameters)};
  std::map<YieldRegion, int> count;
  const double h = 1e-5 * size, M = soil.law.p_wave_modulus();
  for (int sample = 0; sample < 600; ++sample) {
    const Step<dim> step = random_step<dim>(random, soil, sample);
    StressUpdate<dim> out;
    Tangent<dim> A;
    EXPECT_TRUE(soil.update(step.H, step.state, out, &A));
    if (!out.plastic() || !is_smooth<dim>(soil, step, out.region, h)) continue;
    ++count[out.region];
    const Tangent<dim> fine = difference_tangent<dim>(soil, step.H, step.state, h);
    const Tangent<dim> wide = difference_tangent<dim>(soil, step.H, step.state, 2 * h);
    // the apex keeps a share of the elastic moduli
    const double bound = out.region == YieldRegion::apex ? 3e-4 : 1e-7;
    const double error = (A - (4 * fine - wide) / 3).cwiseAbs().maxCoeff();
    EXPECT_LT(error, bound * M) << "sample " << sample << ", " << region_name(out.region);
    if (::testing::Test::HasFailure()) break;
  }
  return count;
}

TEST(Softening, tangent_is_the_derivative) {
  for (const SofteningParameters& parameters : soils()) {
    for (const auto& count : {compare_tangents<2>(parameters), compare_tangents<3>(parameters)}) {
      EXPECT_GT(count.at(YieldRegion::shear), 20);
      if (parameters.tension_cutoff != no_cutoff) {
        EXPECT_GT(count.at(YieldRegion::tension), 5);
        EXPECT_GT(count.at(YieldRegion::shear_and_tension), 5);
      }
    }
  }
}

/// The stress is on the surface of its own shear, and shear is that of the plastic strain.
TEST(Softening, ends_on_the_surface_of_its_end) {
  for (const SofteningParameters& parameters : soils()) {
    if (parameters.relaxation_time > 0) continue;
    Random random(5);
    InContext<3> soil{SofteningSoil<3>(parameters)};
    const double w = soil.context.band_width, root_3 = std::numbers::sqrt3;
    for (int sample = 0; sample < 600; ++sample) {
      const Step<3> step = random_step<3>(random, soil, 3 * sample + 1);  // no gap
      const auto out = stress<3>(soil, step.H, step.state);
      const InternalState added = out.internal - soil.context.internal;
      EXPECT_NEAR(added[1], root_3 * w * added[0], 1e-15);
      Eigen::Matrix3d flow = full<3>(out.plastic_increment);
      flow.diagonal().array() -= flow.trace() / 3;
      EXPECT_NEAR(added[0], std::sqrt(2.0 / 3) * flow.norm(), 1e-13);
      const double x = parameters.by_slip ? out.internal[1] : out.internal[0];
      const ShearSoFar end{.x = x, .rate = 0, .dt = soil.context.dt};
      const SoftenedConstants now = soil.law.surface().in_step(end, added[0]);
      const Eigen::Vector3d tau = principal<3>(out.tau);
      const double f = now.law.k * tau[0] - tau[2] - now.law.strength;
      EXPECT_LT(f, 1e-9 * E * size);
      EXPECT_LT(tau[0] - now.tension_cutoff, 1e-9 * E * size);
      if (out.region == YieldRegion::shear) {
        EXPECT_GT(f, -1e-9 * E * size);
      }
    }
  }
}

/// Strength that does not change: the laws without softening.
TEST(Softening, of_nothing_is_perfect_plasticity) {
  auto constant = soil_of(StrengthCurve(ExponentialCurve{
      .peak = strength(1e4, 35, 0), .residual = strength(1e4, 35, 0), .scale = 0.05}));
  const MohrCoulomb<3> perfect({.lambda = lambda,
                                .mu = mu,
                                .friction_angle = 35 * degree,
                                .dilation_angle = 0,
                                .cohesion = 1e4});
  InContext<3> soil{SofteningSoil<3>(constant)}, stiff{SofteningSoil<3>(clay(1e4))};
  const Tresca<3> tresca({.lambda = lambda, .mu = mu, .cohesion = 1e4});
  Random random(3);
  for (int sample = 0; sample < 500; ++sample) {
    const Step<3> step = random_step<3>(random, soil, sample);
    EXPECT_LT(
        (stress<3>(soil, step.H, step.state).P - stress<3>(perfect, step.H, step.state).P).norm(),
        1e-12 * E);
    EXPECT_LT(
        (stress<3>(stiff, step.H, step.state).P - stress<3>(tresca, step.H, step.state).P).norm(),
        1e-12 * E);
  }
}

/// Simple shear of a band w wide up to a slip d at the residual stress does the work
///
///     c_r d + (c_p - c_r) d_c (1 - exp(-d / d_c))
///
/// on each area, whatever w is.
TEST(Softening, by_slip_does_the_same_work_in_every_band) {
  const double c_p = 4e4, c_r = 2e3, d_c = 0.1, end = 0.5, G = 3e6;
  auto soil = clay();
  soil.curve =
      StrengthCurve(ExponentialCurve{.peak = {c_p, 0, 0}, .residual = {c_r, 0, 0}, .scale = d_c});
  soil.lambda = 5 * G;
  soil.mu = G;
  const double exact = c_r * end + (c_p - c_r) * d_c * (1 - std::exp(-end / d_c));
  for (const double w : {0.2, 0.1, 0.05}) {
    InContext<2> point{SofteningSoil<2>(soil), {.band_width = w}};
    MaterialState<2> state;
    double work = 0, tau = 0;
    const int steps = 20000;
    Matrix<2> H = Matrix<2>::Zero();
    H(0, 1) = (end + 1.2 * c_r * w / G) / w / steps;
    for (int n = 0; n < steps && point.context.internal[1] < end; ++n) {
      const auto out = stress<2>(point, H, state);
      work += 0.5 * (tau + out.tau[3]) * H(0, 1) * w;
      tau = out.tau[3];
      state = out.state;
      point.context.internal = out.internal;
    }
    EXPECT_NEAR(work, exact, 2e-3 * exact) << "w = " << w;
  }
}

/// Strength that falls faster than stress unloads has no stress to give.
TEST(Softening, that_snaps_back_is_told) {
  const double peak = 0.02 * mu, scale = 0.01;
  const double steepest = 1.5 * mu;  // of an edge; sqrt(3) mu on a plane
  const auto steep = [&](double share) {
    auto soil = clay();
    soil.curve = StrengthCurve(ExponentialCurve{
        .peak = {peak, 0, 0}, .residual = {peak - share * steepest * scale, 0, 0}, .scale = scale});
    soil.by_slip = false;
    return SofteningSoil<3>(soil);
  };
  EXPECT_NEAR(snap_back(steep(1).surface(), 1, 0), 1, 1e-12);
  Matrix<3> H = Matrix<3>::Zero();
  H(2, 2) = std::expm1(-1.005 * peak / mu);  // compression along an axis: an edge
  StressUpdate<3> out;
  EXPECT_TRUE(steep(0.97).update(PointContext{}, H, {}, out, nullptr));
  EXPECT_TRUE(out.plastic());
  EXPECT_FALSE(steep(1.03).update(PointContext{}, H, {}, out, nullptr));
  EXPECT_EQ(out.refusal, Refusal::unsolved);
}

TEST(Softening, lags_behind_by_its_relaxation_time) {
  Random random(7);
  InContext<3> inviscid{SofteningSoil<3>(clay())}, slow{SofteningSoil<3>(viscous(clay(), 0.1))};
  for (int sample = 0; sample < 200; ++sample) {
    const Step<3> step = random_step<3>(random, inviscid, 3 * sample + 1);
    slow.context.internal = inviscid.context.internal;
    const auto at_once = stress<3>(inviscid, step.H, step.state);
    const auto lagging = stress<3>(slow, step.H, step.state);
    const auto elastic = stress<3>(HenckyElastic<3>{lambda, mu}, step.H, step.state);
    EXPECT_LT((lagging.tau - (elastic.tau + at_once.tau) / 2).norm(), 1e-9 * E * size);
    const InternalState mean = (inviscid.context.internal + at_once.internal) / 2;
    EXPECT_LT((lagging.internal - mean).norm(), 1e-14);
  }
}

/// Steady simple shear bears c (1 + a / ln 10 asinh(rate / (2 reference))), in steps of any length,
/// so that a decade more of the rate adds the share a.
TEST(Softening, strength_grows_with_the_logarithm_of_the_rate) {
  const double c = 1e4, gain = 0.1, reference = 1e-3;
  const auto stress_at = [&](double rate, double strain) {
    InContext<2> point{SofteningSoil<2>(quick(clay(c), gain, reference)), {.dt = strain / rate}};
    MaterialState<2> state;
    Matrix<2> H = Matrix<2>::Zero();
    H(0, 1) = strain;
    StressUpdate<2> out;
    for (double sheared = 0; sheared < 0.2; sheared += strain) {
      out = stress<2>(point, H, state);
      state = out.state;
      point.context.internal = out.internal;
    }
    const Eigen::Vector3d tau = principal<2>(out.tau);
    return 0.5 * (tau[0] - tau[2]);
  };
  for (const double strain : {1e-4, 1e-3}) {
    const double fast = stress_at(1e3, strain), slower = stress_at(1e2, strain);
    EXPECT_NEAR((fast - slower) / c, gain, 1e-3 * gain) << strain;
    EXPECT_NEAR(stress_at(reference, strain) / c, 1 + gain / std::log(10) * std::asinh(0.5),
                1e-3 * gain)
        << strain;
    EXPECT_NEAR(stress_at(1e-4 * reference, strain) / c, 1, 1e-3 * gain) << strain;
  }
}

/// A batch of four points leaves those that yield; the others are as they are one by one.
template <int dim>
void compare_batch() {
  Random random(17);
  InContext<dim> soil{SofteningSoil<dim>(sand())};
  int elastic = 0, left = 0;
  for (int sample = 0; sample < 200; ++sample) {
    PointBatch<dim> batch;
    std::array<PointContext, num_lanes> contexts;
    std::array<Step<dim>, num_lanes> steps;
    MaterialState<dim> state[num_lanes];
    Symmetric<dim> tau[num_lanes], increment[num_lanes];
    double J[num_lanes], energy[num_lanes];
    YieldRegion region[num_lanes];
    batch.out = {state, tau, J, energy, increment, region};
    for (int l = 0; l < num_lanes; ++l) {
      steps[l] = random_step<dim>(random, soil, num_lanes * sample + l);
      steps[l].H *= 0.3;
      contexts[l] = soil.context;
      batch.set_gradient(l, steps[l].H);
      batch.state_n[l] = &steps[l].state;
    }
    const LaneMask done = soil.law.update_elastic(contexts, batch, true);
    for (int l = 0; l < num_lanes; ++l) {
      soil.context = contexts[l];
      StressUpdate<dim> out;
      Tangent<dim> A;
      ASSERT_TRUE(soil.update(steps[l].H, steps[l].state, out, &A));
      EXPECT_EQ(done[l] == 0, out.plastic());
      left += done[l] == 0;
      if (!done[l]) continue;
      ++elastic;
      EXPECT_LT((batch.stress(l) - out.P).norm(), 1e-13 * E);
      EXPECT_LT((batch.tangent(l) - A).norm(), 1e-12 * E);
      EXPECT_LT((state[l].e - out.state.e).norm(), 1e-15);
      EXPECT_EQ(state[l].gap, out.state.gap);
    }
  }
  EXPECT_GT(elastic, 50);
  EXPECT_GT(left, 50);
}

TEST(Softening, four_points_at_once_are_each_as_alone) {
  compare_batch<2>();
  compare_batch<3>();
}

TEST(StrengthCurve, has_its_slope_and_its_ends) {
  const StrengthCurve remoulded(ExponentialCurve{.peak = {4e4, 0, 0},
                                                 .residual = {2e4, 0, 0},
                                                 .scale = 0.01,
                                                 .remoulded_cohesion = 500,
                                                 .remoulding_scale = 1});
  EXPECT_DOUBLE_EQ(remoulded.at(0).value.cohesion, 4e4);
  EXPECT_NEAR(remoulded.at(0.1).value.cohesion, 500 + 19500 * std::exp(-0.1), 2);
  EXPECT_NEAR(remoulded.at(100).value.cohesion, 500, 1e-9);
  for (const StrengthCurve& curve :
       {remoulded, sand().curve, sand(Dilation::rowe).curve, tabulated().curve}) {
    for (const double x : {0.001, 0.013, 0.02, 0.043, 0.07, 0.2}) {
      const double h = 1e-7;
      const auto up = curve.at(x + h).value, down = curve.at(x - h).value;
      const auto slope = curve.at(x).slope;
      EXPECT_NEAR(slope.cohesion, (up.cohesion - down.cohesion) / (2 * h), 1);
      EXPECT_NEAR(slope.sin_friction, (up.sin_friction - down.sin_friction) / (2 * h), 1e-4);
      EXPECT_NEAR(slope.sin_dilation, (up.sin_dilation - down.sin_dilation) / (2 * h), 1e-4);
    }
  }
  EXPECT_NEAR(sand(Dilation::rowe).curve.at(10).value.sin_dilation, 0, 1e-15);
}

TEST(StrengthCurve, of_a_table_is_monotone_between_its_rows) {
  const StrengthCurve curve = tabulated().curve;
  double before = curve.at(0).value.sin_friction;
  for (double x = 0; x < 0.12; x += 1e-4) {
    const auto [value, slope] = curve.at(x);
    EXPECT_GE(value.cohesion, 0);
    EXPECT_LE(value.cohesion, 1e4);
    if (x < 0.02) {
      EXPECT_GE(value.sin_friction, before - 1e-15);
    } else if (x > 0.0201) {
      EXPECT_LE(value.sin_friction, before + 1e-15);
    }
    before = value.sin_friction;
  }
  EXPECT_DOUBLE_EQ(curve.at(0.05).value.cohesion, 5e3);
  EXPECT_EQ(curve.at(0.1).slope.cohesion, 0);
}

}  // namespace
}  // namespace gabion::testing::test_softening
