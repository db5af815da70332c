// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/shared_volumes.hpp"

#include <Eigen/LU>
#include <cmath>
#include <type_traits>
#include <variant>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/tensor_functions.hpp"

namespace gabion::mpm {

namespace {

// Strains that differ by less are equal but for the rounding of their sums.
constexpr double same_strain = 1e-13;

template <class Law, int dim>
constexpr bool has_small_strain = std::is_same_v<Law, LinearElastic<dim>>;

// Volumetric strain since the point was free of stress, the gap included.
template <class Law, int dim>
double volumetric_strain(const Law&, const MaterialState<dim>& state) {
  if constexpr (has_small_strain<Law, dim>) {
    return trace<dim>(state.e);
  } else {
    double change = std::log1p(determinant_minus_one<dim>(in_plane<dim>(state.e)));
    if constexpr (dim == 2) change += std::log1p(state.e[2]);
    return 0.5 * change + state.gap;
  }
}

template <class Law, int dim>
void add_volumetric_strain(const Law&, double strain, MaterialState<dim>& state) {
  auto normal = state.e.template head<3>().array();
  if constexpr (has_small_strain<Law, dim>) {
    normal += strain / 3;
  } else {
    const double change = std::expm1(2 * strain / 3);
    state.e += change * state.e;
    normal += change;
  }
}

/// Volumes of the groups, by body and first cell of the patch.
template <int dim>
class GroupVolumes {
 public:
  GroupVolumes(const BackgroundGrid<dim>& grid, const MaterialPoints<dim>& points)
      : points_(points), num_cells_(grid.mesh.num_cells()), group_(num_cells_) {
    for (std::int32_t c = 0; c < num_cells_; ++c) group_[c] = c;
    for (std::int32_t k = 0; k < grid.patches.size(); ++k) {
      const std::int32_t first = grid.patches.starts[k];
      for (std::int32_t c = first; c < grid.patches.starts[k + 1]; ++c) {
        group_[grid.patches.cells[c]] = grid.patches.cells[first];
      }
    }
    sums_.assign(2 * static_cast<std::size_t>(num_cells_) * points.num_bodies(), 0.0);
  }

  void add(std::int32_t body, std::int32_t p, double theta) {
    double* const sums = sums_of(body, p);
    const double V = points_.V0[p] * points_.J[p];
    sums[0] += V * std::exp(-theta);
    sums[1] -= V * std::expm1(-theta);
  }
  void sum(MPI_Comm comm) { sum_over_ranks(comm, std::span<double>(sums_)); }
  /// ln (sum V / sum V exp(-theta)) of the point's group.
  double strain(std::int32_t body, std::int32_t p) {
    const double* const sums = sums_of(body, p);
    return std::log1p(sums[1] / sums[0]);
  }

 private:
  double* sums_of(std::int32_t body, std::int32_t p) {
    const std::size_t group = static_cast<std::size_t>(body) * num_cells_ + group_[points_.cell[p]];
    return sums_.data() + 2 * group;
  }

  const MaterialPoints<dim>& points_;
  std::int32_t num_cells_;
  std::vector<std::int32_t> group_;  // of each cell
  std::vector<double> sums_;         // of each group: V free of stress, and how much V exceeds it
};

// Change the volume of one point by the strain d. Returns the elastic energy it loses.
template <class Law, int dim>
double change_volume(const Law& law, double d, std::int32_t p, MaterialPoints<dim>& points) {
  MaterialState<dim> state = points.history[p];
  add_volumetric_strain(law, d, state);
  StressUpdate<dim> stress;
  require(law.update(Matrix<dim>::Zero(), state, stress, nullptr),
          "mpm_solver: a shared volume is inadmissible");
  const double lost = points.V0[p] * (points.energy[p] - stress.energy);
  points.history[p] = stress.state;
  points.tau[p] = stress.tau;
  points.energy[p] = stress.energy;
  points.J[p] *= std::exp(d);
  return lost;
}

}  // namespace

template <int dim>
double share_volumes(MPI_Comm comm, const std::vector<Body<dim>>& bodies,
                     const BackgroundGrid<dim>& grid, MaterialPoints<dim>& points) {
  GroupVolumes<dim> volumes(grid, points);
  std::vector<double> theta(points.size(), 0.0);
  const auto for_each_point = [&](const auto& act) {
    for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
      std::visit(
          [&](const auto& law) {
            for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
              if (points.cell[p] >= 0) act(law, b, p);
            }
          },
          bodies[b].material.law);
    }
  };
  for_each_point([&](const auto& law, std::int32_t b, std::int32_t p) {
    theta[p] = volumetric_strain(law, points.history[p]);
    volumes.add(b, p, theta[p]);
  });
  volumes.sum(comm);
  double lost = 0;
  for_each_point([&](const auto& law, std::int32_t b, std::int32_t p) {
    const double d = volumes.strain(b, p) - theta[p];
    if (std::abs(d) > same_strain) lost += change_volume(law, d, p, points);
  });
  sum_over_ranks(comm, std::span<double>(&lost, 1));
  return lost;
}

template double share_volumes<2>(MPI_Comm, const std::vector<Body<2>>&, const BackgroundGrid<2>&,
                                 MaterialPoints<2>&);
template double share_volumes<3>(MPI_Comm, const std::vector<Body<3>>&, const BackgroundGrid<3>&,
                                 MaterialPoints<3>&);

}  // namespace gabion::mpm
