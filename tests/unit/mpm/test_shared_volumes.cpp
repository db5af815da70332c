// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <map>

#include "common/mechanics/tensor_functions.hpp"
#include "mpm_solver/stress/shared_volumes.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_shared_volumes {
namespace {

constexpr double lambda = 4e3, mu = 3e3;

template <int dim>
double volumetric_strain(const MaterialState<dim>& state) {
  double J2 = (Matrix<dim>::Identity() + in_plane<dim>(state.e)).determinant();
  if constexpr (dim == 2) J2 *= 1 + state.e[2];
  return 0.5 * std::log(J2) + state.gap;
}

template <int dim>
Symmetric<dim> deviator(Symmetric<dim> tau) {
  tau.template head<3>().array() -= trace<dim>(tau) / 3;
  return tau;
}

/// Soil whose points have strains and volumes of their own.
template <int dim>
struct UnevenSoil {
  SoilPatch<dim> soil;

  UnevenSoil(CellType type, const MaterialLaw<dim>& law, double strain) : soil(type, 2) {
    soil.fill(type == CellType::tri3 ? 3 : type == CellType::hex8 ? 8 : 4);
    prepare(type, law, strain);
  }
  /// Soil under splines in the rows 0 to 2 of 5.
  UnevenSoil(const MaterialLaw<dim>& law, double strain)
      : soil(CellType::quad4, 5, mpm::Basis::bspline) {
    soil.grid.splits_border = true;
    soil.fill(16);
    for (auto& x : soil.points.x) x[dim - 1] = 0.6 * x[dim - 1];
    prepare(CellType::quad4, law, strain);
  }
  void prepare(CellType type, const MaterialLaw<dim>& law, double strain) {
    soil.bodies = {{"soil", {"", 1, law}}};
    if (type == CellType::tri3 || type == CellType::tet4) {
      soil.grid.patches = mpm::join_cells(soil.mesh, soil.grid.stored->locator);
    }
    soil.to_grid();
    auto& points = soil.points;
    for (std::int32_t p = 0; p < points.size(); ++p) {
      points.J[p] = 1 + 0.1 * soil.random();
      MaterialState<dim> state;
      for (auto& e : state.e) e = strain * soil.random();
      set_state(p, state);
    }
  }
  void set_state(std::int32_t p, const MaterialState<dim>& state) {
    auto& points = soil.points;
    StressUpdate<dim> stress;
    std::visit(
        [&](const auto& law) {
          EXPECT_TRUE(law.update(Matrix<dim>::Zero(), state, stress, nullptr));
        },
        soil.bodies[0].material.law);
    points.history[p] = stress.state;
    points.tau[p] = stress.tau;
    points.energy[p] = stress.energy;
  }
  double share() { return mpm::share_volumes<dim>(soil.owners(), soil.bodies, soil.points); }
  /// First cell of the patch, else the cell.
  std::int32_t group_of(std::int32_t p) const {
    const auto& patches = soil.grid.patches;
    for (std::int32_t k = 0; k < patches.size(); ++k) {
      for (std::int32_t c = patches.starts[k]; c < patches.starts[k + 1]; ++c) {
        if (patches.cells[c] == soil.points.cell[p]) return patches.cells[patches.starts[k]];
      }
    }
    return soil.points.cell[p];
  }
  double energy() const {
    double sum = 0;
    for (std::int32_t p = 0; p < soil.points.size(); ++p) {
      sum += soil.points.V0[p] * soil.points.energy[p];
    }
    return sum;
  }
  struct Volumes {
    double present = 0, free = 0;
  };
  std::map<std::int32_t, Volumes> volumes() const {
    std::map<std::int32_t, Volumes> sums;
    for (std::int32_t p = 0; p < soil.points.size(); ++p) {
      const double V = soil.points.V0[p] * soil.points.J[p];
      Volumes& sum = sums[group_of(p)];
      sum.present += V;
      sum.free += V * std::exp(-volumetric_strain(soil.points.history[p]));
    }
    return sums;
  }
};

TEST(SharedVolumes, a_group_gets_one_strain_and_keeps_both_volumes) {
  for_each_cell_type([]<int dim>(CellType type) {
    UnevenSoil<dim> uneven(type, HenckyElastic<dim>{lambda, mu}, 0.02);
    const auto before = uneven.volumes();
    uneven.share();
    for (const auto& [group, after] : uneven.volumes()) {
      EXPECT_NEAR(after.present, before.at(group).present, 1e-14) << name(type);
      EXPECT_NEAR(after.free, before.at(group).free, 1e-14) << name(type);
    }
    const auto& points = uneven.soil.points;
    for (std::int32_t p = 0; p < points.size(); ++p) {
      const auto& sum = before.at(uneven.group_of(p));
      EXPECT_NEAR(volumetric_strain(points.history[p]), std::log(sum.present / sum.free), 1e-13);
    }
  });
}

TEST(SharedVolumes, shape_changes_stay_with_the_points) {
  for_each_cell_type([]<int dim>(CellType type) {
    UnevenSoil<dim> uneven(type, HenckyElastic<dim>{lambda, mu}, 0.02);
    const auto before = uneven.soil.points.tau;
    uneven.share();
    double moved = 0;
    for (std::int32_t p = 0; p < uneven.soil.points.size(); ++p) {
      const Symmetric<dim>& tau = uneven.soil.points.tau[p];
      EXPECT_LT((deviator<dim>(tau) - deviator<dim>(before[p])).norm(), 1e-11 * mu) << name(type);
      moved = std::max(moved, std::abs(trace<dim>(tau) - trace<dim>(before[p])));
    }
    EXPECT_GT(moved, 0.01 * lambda) << name(type);
  });
}

TEST(SharedVolumes, small_strain_shares_its_trace) {
  UnevenSoil<2> uneven(CellType::quad4, LinearElastic<2>{lambda, mu}, 1e-4);
  std::map<std::int32_t, double> shared;
  uneven.share();
  const auto& points = uneven.soil.points;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double strain = trace<2>(points.history[p].e);
    const auto [first, is_first] = shared.emplace(points.cell[p], strain);
    EXPECT_NEAR(strain, first->second, 1e-16);
    EXPECT_NEAR(trace<2>(points.tau[p]), (3 * lambda + 2 * mu) * strain, 1e-11);
  }
}

/// Where its law is convex, a mean state has less energy than its parts.
TEST(SharedVolumes, lost_energy_is_reported_and_not_negative) {
  for_each_cell_type([]<int dim>(CellType type) {
    UnevenSoil<dim> uneven(type, HenckyElastic<dim>{lambda, mu}, 0.02);
    const double before = uneven.energy();
    const double lost = uneven.share();
    EXPECT_NEAR(lost, before - uneven.energy(), 1e-13 * before) << name(type);
    EXPECT_GT(lost, 0.1 * before) << name(type);
  });
}

TEST(SharedVolumes, a_second_time_changes_nothing) {
  for_each_cell_type([]<int dim>(CellType type) {
    UnevenSoil<dim> uneven(type, HenckyElastic<dim>{lambda, mu}, 0.02);
    uneven.share();
    const auto once = uneven.soil.points;
    EXPECT_EQ(uneven.share(), 0) << name(type);
    EXPECT_TRUE(same_bits(once, uneven.soil.points)) << name(type);
  });
}

/// Volume that one point has opened the others of its cell have to close: equal volumes, one opened
/// by g, three squeezed by s, have no pressure while g > 3 s.
TEST(SharedVolumes, what_one_point_opened_is_closed_by_its_group) {
  const double s = 0.01;
  for (const double g : {0.02, 0.06}) {
    UnevenSoil<2> uneven(CellType::quad4, MohrCoulomb<2>{lambda, mu, 0.5, 0.0, 0.0}, 0);
    auto& points = uneven.soil.points;
    for (std::int32_t p = 0; p < points.size(); ++p) {
      const bool is_open = p % 4 == 0;
      MaterialState<2> state;
      if (is_open) {
        state.gap = g;
      } else {
        state.e.head<3>().setConstant(std::expm1(-2 * s / 3));
      }
      uneven.set_state(p, state);
      points.J[p] = std::exp(is_open ? g : -s);
    }
    uneven.share();
    // All points are equally large when free of stress.
    const double theta = std::log((std::exp(g) + 3 * std::exp(-s)) / 4);
    for (std::int32_t p = 0; p < points.size(); ++p) {
      EXPECT_NEAR(points.history[p].gap, std::max(theta, 0.0), 1e-15);
      EXPECT_NEAR(trace<2>(points.tau[p]) / 3, (lambda + 2 * mu / 3) * std::min(theta, 0.0), 1e-10);
      EXPECT_NEAR(points.J[p], std::exp(theta), 1e-15);
    }
  }
}

/// Under splines the halves of cells at the border are groups of their own, whole cells elsewhere.
TEST(SharedVolumes, halves_at_the_border_of_splines) {
  UnevenSoil<2> uneven(HenckyElastic<2>{lambda, mu}, 0.02);
  const auto& soil = uneven.soil;
  uneven.share();
  std::map<std::int32_t, int> parts;
  std::map<std::int32_t, double> last;
  for (const auto& group : soil.weights.groups) {
    const auto strain = [&](std::int32_t e) {
      return volumetric_strain(soil.points.history[soil.weights.point[e]]);
    };
    for (std::int32_t e = group.first; e < group.last; ++e) {
      EXPECT_NEAR(strain(e), strain(group.first), 1e-13);
    }
    if (parts[group.cell]++ > 0) {
      EXPECT_GT(std::abs(strain(group.first) - last[group.cell]), 1e-5);
    }
    last[group.cell] = strain(group.first);
  }
  for (const auto& [cell, number] : parts) EXPECT_EQ(number, cell / 5 == 2 ? 2 : 1) << cell;
}

TEST(SharedVolumes, a_point_outside_the_grid_is_left_alone) {
  UnevenSoil<2> uneven(CellType::quad4, HenckyElastic<2>{lambda, mu}, 0.02);
  auto& points = uneven.soil.points;
  points.cell[3] = -1;
  const double J = points.J[3];
  const Symmetric<2> tau = points.tau[3];
  uneven.share();
  EXPECT_EQ(points.J[3], J);
  EXPECT_EQ(points.tau[3], tau);
}

}  // namespace
}  // namespace gabion::test::test_shared_volumes
