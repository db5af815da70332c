// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/noise_damping.hpp"

#include <gtest/gtest.h>

#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_noise_damping {
namespace {

constexpr double fast = 1e9;  // [m/s]: beside it nothing flows

/// Stress of these points with sqrt(|tau| / rho) = c.
template <int dim>
void press(mpm::MaterialPoints<dim>& points, std::int32_t first, std::int32_t last, double c) {
  for (std::int32_t p = first; p < last; ++p) {
    points.tau[p].setZero();
    points.tau[p][0] = -c * c * points.m[p] / points.V0[p];
  }
}

/// Every point loses this share of its noise.
template <int dim>
void damp(SoilPatch<dim>& soil, double share) {
  press(soil.points, 0, soil.points.size(), fast);
  const mpm::NoiseDamping rate{-std::log1p(-share) / fast, 1, 1};
  mpm::damp_noise<dim>(soil.weights, soil.nodes, rate, soil.points);
}

template <int dim>
ForceAndMoment<dim> momentum(const mpm::MaterialPoints<dim>& points) {
  ForceAndMoment<dim> sum;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    sum.add(points.x[p], points.m[p] * points.v[p]);
  }
  return sum;
}

template <int dim>
double energy(const mpm::MaterialPoints<dim>& points) {
  double sum = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    sum += 0.5 * points.m[p] * points.v[p].squaredNorm();
  }
  return sum;
}

TEST(NoiseDamping, keeps_momentum_and_takes_energy) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    for (const double share : {0.1, 1.0}) {
      SoilPatch<dim> soil(type, 3, basis);
      soil.scatter(200);
      soil.to_grid();
      const auto before = momentum(soil.points);
      const double energy_before = energy(soil.points);
      damp(soil, share);
      const auto after = momentum(soil.points);
      EXPECT_LT((after.force - before.force).norm(), 1e-13 * before.size) << name(type);
      EXPECT_LT(energy(soil.points), (1 - 0.2 * share) * energy_before) << name(type);
    }
  });
}

/// Points that share cells, half of them undamped: what one loses the other gets, and no energy
/// comes.
TEST(NoiseDamping, keeps_momentum_of_points_of_unequal_share) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    SoilPatch<dim> soil(type, 3, basis);
    soil.scatter(200);
    soil.to_grid();
    const auto before = momentum(soil.points);
    const double energy_before = energy(soil.points);
    press(soil.points, 0, 100, fast);
    press(soil.points, 100, 200, 0);
    mpm::damp_noise<dim>(soil.weights, soil.nodes, {1, 1, 1}, soil.points);
    EXPECT_LT((momentum(soil.points).force - before.force).norm(), 1e-13 * before.size)
        << name(type);
    EXPECT_LT(energy(soil.points), 0.95 * energy_before) << name(type);
  });
}

/// A body that moves as one has no noise, whatever its points weigh and wherever they lie.
TEST(NoiseDamping, leaves_uniform_velocity) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    SoilPatch<dim> soil(type, 3, basis);
    soil.scatter(200);
    soil.add(Vector<dim>::Constant(1.0 / 3));
    const Vector<dim> v = soil.random.template vector<dim>();
    std::fill(soil.points.v.begin(), soil.points.v.end(), v);
    soil.to_grid();
    damp(soil, 1);
    for (const Vector<dim>& v_p : soil.points.v) EXPECT_LT((v_p - v).norm(), 1e-13) << name(type);
  });
}

/// The velocity that no node sees loses the share, no more and no less.
TEST(NoiseDamping, takes_its_share_of_what_alternates_in_a_cell) {
  SoilPatch<2> soil(CellType::quad4, 8);
  soil.fill(4);
  const auto alternates = [](const Vector<2>& x) {
    const Vector<2> place = 16 * x;  // half cells
    return (static_cast<int>(place[0]) + static_cast<int>(place[1])) % 2 == 0 ? 1.0 : -1.0;
  };
  for (std::int32_t p = 0; p < soil.points.size(); ++p) {
    soil.points.v[p] = alternates(soil.points.x[p]) * Vector<2>(1, -2);
  }
  soil.to_grid();
  damp(soil, 0.3);
  for (std::int32_t p = 0; p < soil.points.size(); ++p) {
    const Vector<2>& x = soil.points.x[p];
    if ((x.array() < 0.25).any() || (x.array() > 0.75).any()) continue;  // border
    EXPECT_LT((soil.points.v[p] - 0.7 * alternates(x) * Vector<2>(1, -2)).norm(), 1e-14);
  }
}

/// Away from the border a field of second order is no noise; PIC would smooth it.
TEST(NoiseDamping, leaves_quadratic_fields) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    if (type != CellType::quad4 && type != CellType::hex8) return;  // cells are alike
    SoilPatch<dim> soil(type, 14, basis);
    soil.fill(1 << dim);
    const auto field = [](const Vector<dim>& x) {
      Vector<dim> v = Vector<dim>::Zero();
      v[0] = x[1] - 3 * x[1] * x[1];
      v[1] = x[0] * x[0] - x[0] * x[1];
      return v;
    };
    for (std::int32_t p = 0; p < soil.points.size(); ++p)
      soil.points.v[p] = field(soil.points.x[p]);
    soil.to_grid();
    damp(soil, 1);
    int inner = 0;
    for (std::int32_t p = 0; p < soil.points.size(); ++p) {
      const Vector<dim>& x = soil.points.x[p];
      if ((x.array() < 0.46).any() || (x.array() > 0.54).any()) continue;
      ++inner;
      EXPECT_LT((soil.points.v[p] - field(x)).norm(), 1e-14) << name(type);
    }
    EXPECT_GT(inner, 0);
  });
}

/// The share is the same in many short steps as in a long one, zero without stress, small in soil
/// that flows.
TEST(NoiseDamping, share_follows_time_stress_and_shear) {
  const double h = 0.1;
  const double c = 2;
  const auto share = [&](double dt, double inertial_number) {
    const double grad = inertial_number * c / h;
    return mpm::NoiseDamping{3, dt, h}.share(c * c, grad * grad);
  };
  const double dt = h / c / 3;
  EXPECT_NEAR(share(dt, 0), 1 - std::exp(-1), 1e-15);
  EXPECT_NEAR(std::pow(1 - share(dt / 10, 0), 10), std::exp(-1), 1e-15);
  EXPECT_NEAR(share(dt, mpm::inertial_number_of_flow), 1 - std::exp(-0.5), 1e-15);
  EXPECT_NEAR(share(dt, 3 * mpm::inertial_number_of_flow), 1 - std::exp(-0.1), 1e-15);
  EXPECT_EQ((mpm::NoiseDamping{3, dt, h}.share(0, 0)), 0);
  EXPECT_EQ((mpm::NoiseDamping{3, dt, h}.share(0, 1)), 0);
}

/// Velocity that alternates in cells that shear is damped by their inertial number, the shear is
/// left.
TEST(NoiseDamping, spares_what_flows) {
  const double h = 1.0 / 8;
  const double c = 3;
  for (const double number : {1.0, 3.0}) {
    SoilPatch<2> soil(CellType::quad4, 8);
    soil.fill(4);
    std::vector<Vector<2>> shear(soil.points.size());
    std::vector<Vector<2>> noise(soil.points.size());
    for (std::int32_t p = 0; p < soil.points.size(); ++p) {
      const Vector<2>& x = soil.points.x[p];
      shear[p] = {number * mpm::inertial_number_of_flow * c / h * x[1], 0};
      noise[p] = {static_cast<int>(16 * x[0]) % 2 == 0 ? 1e-3 : -1e-3, 0};
      soil.points.v[p] = shear[p] + noise[p];
    }
    soil.to_grid();
    press(soil.points, 0, soil.points.size(), c);
    mpm::damp_noise<2>(soil.weights, soil.nodes, {1, h / c, h}, soil.points);
    const double left = std::exp(-1 / (1 + number * number));
    for (std::int32_t p = 0; p < soil.points.size(); ++p) {
      const Vector<2>& x = soil.points.x[p];
      if ((x.array() < 0.25).any() || (x.array() > 0.75).any()) continue;  // border
      EXPECT_LT((soil.points.v[p] - shear[p] - left * noise[p]).norm(), 1e-14) << number;
    }
  }
}

}  // namespace
}  // namespace gabion::test::test_noise_damping
