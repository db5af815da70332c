// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/noise_damping.hpp"

#include <gtest/gtest.h>

#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test {
namespace {

template <int dim>
void damp(SoilPatch<dim>& soil, double share) {
  const std::vector<double> shares(soil.points.size(), share);
  mpm::damp_noise<dim>(soil.weights, soil.nodes, shares, soil.points);
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
    std::vector<double> share(200, 0.0);
    std::fill(share.begin(), share.begin() + 100, 1.0);
    mpm::damp_noise<dim>(soil.weights, soil.nodes, share, soil.points);
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

/// Of many short steps as of a long one.
TEST(NoiseDamping, share_follows_time) {
  EXPECT_NEAR(mpm::damped_share(0.02, 1), 0.02, 1e-16);
  EXPECT_DOUBLE_EQ(mpm::damped_share(0.5, 2), 0.75);
  EXPECT_NEAR(std::pow(1 - mpm::damped_share(0.02, 0.1), 10), 0.98, 1e-15);
  EXPECT_EQ(mpm::damped_share(1, 0.1), 1);
  EXPECT_EQ(mpm::damped_share(0, 10), 0);
}

}  // namespace
}  // namespace gabion::test
