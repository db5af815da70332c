// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/shared_volumes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <type_traits>
#include <variant>

#include "common/base/require.hpp"
#include "common/mechanics/materials/spectral.hpp"
#include "common/mechanics/ranks/packet.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/tensor_functions.hpp"
#include "mpm_solver/grid/soil_border.hpp"
#include "mpm_solver/points/retention.hpp"
#include "mpm_solver/stress/step_context.hpp"

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
    double change = determinant_minus_one<dim>(in_plane<dim>(state.e));  // det b - 1
    if constexpr (dim == 2) change += state.e[2] + change * state.e[2];
    return hencky_strain(change) + state.gap;
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

/// Sums of volumes over the points of each group, by body and first cell of the patch.
template <int dim>
class GroupVolumes {
 public:
  GroupVolumes(const CellOwners<dim>& owners, const MaterialPoints<dim>& points)
      : owners_(owners),
        points_(points),
        num_cells_(owners.grid.num_cells()),
        num_parts_(owners.grid.splits_border ? SoilBorder<dim>::num_parts : 1),
        sums_(static_cast<std::size_t>(num_cells_) * num_parts_ * points.num_bodies(), {}) {}

  /// Count a point with its volume and the strain theta since it was free of stress.
  void add(std::int32_t body, std::int32_t p, double theta) {
    const double V = points_.V0[p] * points_.J[p];
    const double smaller = strain_from_hencky(-theta / 2);  // exp(-theta) - 1
    add(body, p, V, smaller);
  }
  /// Count a point with any volume V, which is (1 + smaller) V in the state that the group shares.
  void add(std::int32_t body, std::int32_t p, double V, double smaller) {
    if (const std::int64_t group = group_of(body, p); group != last_) {
      last_ = group;
      last_sums_ = &sums_.at(group);
    }
    (*last_sums_)[0] += V * (1 + smaller);
    (*last_sums_)[1] -= V * smaller;
  }
  /// Sum over groups with points of this rank in cells of other ranks: the owner of the cell adds
  /// up and answers.
  void sum() {
    last_ = -1;
    if (num_ranks(owners_.comm) == 1) {
      join_parts();
      return;
    }
    const auto entered = entered_groups();
    Packets parts, answers;
    for (const auto& [rank, groups] : entered) put_sums(groups, parts[rank]);
    std::map<int, std::vector<std::int64_t>> asked;
    for (auto& [rank, packet] : send_packets(owners_.comm, parts)) asked[rank] = add_sums(packet);
    join_parts();
    for (const auto& [rank, groups] : asked) put_sums(groups, answers[rank]);
    for (auto& [rank, packet] : send_packets(owners_.comm, answers)) {
      for (const std::int64_t group : entered.at(rank)) sums_.at(group) = {};
      add_sums(packet);
    }
  }
  /// ln (sum V / sum (1 + smaller) V) of the point's group.
  double strain(std::int32_t body, std::int32_t p) {
    if (const std::int64_t group = group_of(body, p); group != last_) {
      last_ = group;
      const Sums& sums = sums_[group];
      last_strain_ = std::log1p(sums[1] / sums[0]);
    }
    return last_strain_;
  }

 private:
  std::int64_t group_of(std::int32_t body, std::int32_t p) const {
    const std::int32_t cell = points_.cell[p];
    const std::int64_t of_cell =
        (std::int64_t{body} * num_cells_ + owners_.grid.first_of_patch(cell)) * num_parts_;
    return num_parts_ == 1 ? of_cell
                           : of_cell + part_of_cell<dim>(*owners_.grid.box, cell, points_.x[p]);
  }
  std::int32_t cell_of_part(std::size_t group) const {
    return static_cast<std::int32_t>(group / num_parts_ % num_cells_);
  }
  // Give the parts of a cell that are no groups of their own the sum of the cell.
  void join_parts() {
    if (num_parts_ == 1) return;
    SparseList<char> occupied(num_cells_, 0);
    std::vector<std::size_t> firsts;  // parts of the cells of each body
    sums_.for_each([&](std::size_t group, const Sums&) {
      const std::size_t first = group - group % num_parts_;
      if (firsts.empty() || firsts.back() != first) firsts.push_back(first);
      occupied.at(cell_of_part(first)) = 1;
    });
    const SoilBorder<dim> border(owners_, std::move(occupied));
    for (const std::size_t first : firsts) {
      const int axes = border.axes(cell_of_part(first));
      for (int part = 0; part < num_parts_; ++part) {
        const Sums sums = sums_[first + part];
        if ((part & axes) == part) continue;
        for (int k = 0; k < 2; ++k) sums_.at(first + (part & axes))[k] += sums[k];
      }
      for (int part = 0; part < num_parts_; ++part) {
        const Sums joined = sums_[first + (part & axes)];
        sums_.at(first + part) = joined;
      }
    }
  }

  // Groups that points of this rank entered, by the rank that owns them.
  std::map<int, std::set<std::int64_t>> entered_groups() const {
    std::map<int, std::set<std::int64_t>> groups;
    const int own = rank_of(owners_.comm);
    for (std::int32_t b = 0; b < points_.num_bodies(); ++b) {
      for (std::int32_t p = points_.body_starts[b]; p < points_.body_starts[b + 1]; ++p) {
        if (points_.cell[p] < 0) continue;
        const int rank = owners_.of(points_.cell[p]);
        if (rank != own) groups[rank].insert(group_of(b, p));
      }
    }
    return groups;
  }
  template <class Groups>
  void put_sums(const Groups& groups, Packet& packet) {
    packet.put(std::ssize(groups));
    for (const std::int64_t group : groups) {
      packet.put(group);
      for (int k = 0; k < 2; ++k) packet.put(sums_[group][k]);
    }
  }
  std::vector<std::int64_t> add_sums(Packet& packet) {
    std::vector<std::int64_t> groups;
    for (auto count = packet.take<std::ptrdiff_t>(); count > 0; --count) {
      groups.push_back(packet.take<std::int64_t>());
      for (int k = 0; k < 2; ++k) sums_.at(groups.back())[k] += packet.take<double>();
    }
    return groups;
  }

  const CellOwners<dim>& owners_;
  const MaterialPoints<dim>& points_;
  std::int32_t num_cells_;
  int num_parts_;  // of a cell
  using Sums = std::array<double, 2>;
  SparseList<Sums> sums_;  // of each group: (1 + smaller) V, and how much V exceeds it
  // The answers for the group that was asked for last: points of one group follow one another.
  std::int64_t last_ = -1;
  Sums* last_sums_ = nullptr;
  double last_strain_ = 0;
};

// Water that the pores of a point would take up under the pressure of water at rest, over V0.
template <int dim>
double pores_at_rest(const PoreWater& water, const MaterialPoints<dim>& points, std::int32_t p) {
  return points.water[p] * std::exp(-water.hydrostatic(points.x[p][dim - 1]) / water.bulk_modulus);
}

// The strain that brings the pores of a point to exp(strain) of that volume.
template <int dim>
double pore_strain(const PoreWater& water, const MaterialPoints<dim>& points, std::int32_t p,
                   double strain) {
  const double at_rest = pores_at_rest(water, points, p);
  const double change = at_rest - water.pores(points.J[p]) + at_rest * std::expm1(strain);
  return std::log1p(change / points.J[p]);
}

// Change the volume of one point by the strain d. Returns the elastic energy it loses.
template <class Law, int dim>
double change_volume(const LawInStep<Law, dim>& law, double d, std::int32_t p,
                     MaterialPoints<dim>& points) {
  MaterialState<dim> state = points.history[p];
  add_volumetric_strain(law.law, d, state);
  StressUpdate<dim> stress;
  if constexpr (HasVariables<Law>) {
    PointContext context = law.context;
    context.new_variables = numbers_of(points.variables[p]);
    require(law.law.strain_evenly(context, d, stress), [&] {
      const Vector<dim>& x = points.x[p];
      return fmt::format(
          "material point {} at ({:.6g}): its UMAT gives no stress for a volumetric strain of "
          "{:.3g} in zero time (DTIME 0), which F-bar needs where points enter other cells; "
          "\"locking\": {{\"method\": \"none\"}} does not",
          points.id[p], fmt::join(x.data(), x.data() + dim, ", "), d);
    });
  } else {
    require(law.update(Matrix<dim>::Zero(), state, stress, nullptr),
            "mpm_solver: a shared volume is inadmissible");
  }
  const double lost = points.V0[p] * (points.energy[p] - stress.energy);
  points.history[p] = stress.state;
  if constexpr (RemembersInternal<Law>) points.internal[p] = stress.internal;
  if constexpr (requires { law.law.viscosity(); }) {  // a fluid keeps its viscous stress
    Symmetric<dim> shear = points.tau[p];
    shear.template head<3>().array() -= points.tau[p].template head<3>().mean();
    stress.tau += shear;
  }
  points.tau[p] = stress.tau;
  points.energy[p] = stress.energy;
  points.J[p] *= std::exp(d);
  return lost;
}

// Change the volume of one point whose law is given with the part of the pore water. Water that
// drains keeps its pressure; other water cavitates.
template <class Law, int dim>
double change_volume(const Law& law, const PoreWater& water, double d, std::int32_t p,
                     MaterialPoints<dim>& points) {
  const double before = points.energy[p];
  const double pressure = water_pressure(water, points.water[p], points.J[p]);
  change_volume(law, d, p, points);
  require(water.admits(points.J[p]), "mpm_solver: a shared volume closes the pores");
  if (water.drains()) {
    const double content = water.content_at(pressure, points.J[p]);
    points.m[p] += water.density * points.V0[p] * (content - points.water[p]);
    points.water[p] = content;
  }
  const PorePressure pore = water.at(points.water[p], points.J[p]);
  points.tau[p].template head<3>().array() -= points.J[p] * pore.p;
  points.energy[p] += pore.energy;
  return points.V0[p] * (before - points.energy[p]);
}

// Change the volume of the pores of a point by the strain d; the stress of the skeleton stays, but
// a gap opens or closes with them. Returns the energy the water loses.
template <int dim>
double change_pores(const PoreWater& water, double d, std::int32_t p, MaterialPoints<dim>& points) {
  double& J = points.J[p];
  const PorePressure before = water.at(points.water[p], J);
  const double Jp = J * before.p;
  J *= std::exp(d);
  require(water.admits(J), "mpm_solver: shared water closes the pores");
  double& gap = points.history[p].gap;
  if (gap > 0) gap = std::max(0.0, gap + d);
  const PorePressure after = water.at(points.water[p], J);
  points.tau[p].template head<3>().array() += Jp - J * after.p;
  points.energy[p] += after.energy - before.energy;
  return points.V0[p] * (before.energy - after.energy);
}

/// Points with pore water that does not drain: those of a group share its pressure, unless it
/// cavitates.
template <int dim>
class SharedWater {
 public:
  SharedWater(const CellOwners<dim>& owners, const std::vector<Body<dim>>& bodies,
              MaterialPoints<dim>& points)
      : owners_(owners), bodies_(bodies), points_(points) {
    if (!points.water.empty()) drained_.assign(points.size(), 1);
  }

  /// Whether the volume of a point follows from its skeleton: it is dry, or its water cavitates.
  bool is_of_skeleton(std::int32_t p) const { return drained_.empty() || drained_[p]; }

  /// Returns the energy that is lost [J]. @note Collective.
  double share() {
    if (std::ranges::none_of(bodies_, [](const auto& body) { return body.water.has_value(); })) {
      return 0;
    }
    GroupVolumes<dim> volumes(owners_, points_);
    for_each_wet([&](const PoreWater& water, std::int32_t b, std::int32_t p) {
      const double m = water.pores(points_.J[p]);
      volumes.add(b, p, points_.V0[p] * m, pores_at_rest(water, points_, p) / m - 1);
    });
    volumes.sum();
    double lost = 0;
    for_each_wet([&](const PoreWater& water, std::int32_t b, std::int32_t p) {
      const double strain = volumes.strain(b, p);
      const double p_group = water.hydrostatic(height_of_group(p)) - water.bulk_modulus * strain;
      drained_[p] = p_group < -water.cavitation;
      if (drained_[p]) return;
      const double d = pore_strain(water, points_, p, strain);
      if (std::abs(d) > same_strain) lost += change_pores(water, d, p, points_);
    });
    return lost;
  }

 private:
  template <class Act>
  void for_each_wet(const Act& act) {
    for (std::int32_t b = 0; b < points_.num_bodies(); ++b) {
      if (!bodies_[b].water || bodies_[b].water->drains()) continue;
      for (std::int32_t p = points_.body_starts[b]; p < points_.body_starts[b + 1]; ++p) {
        if (points_.cell[p] >= 0 && points_.is_wet(p)) act(*bodies_[b].water, b, p);
      }
    }
  }
  // Height for all points of a group [m].
  double height_of_group(std::int32_t p) const {
    Vector<dim> corners[max_cell_nodes];
    const BackgroundGrid<dim>& grid = owners_.grid;
    grid.corners(grid.first_of_patch(points_.cell[p]), corners);
    const int n = grid.nodes_per_cell();
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += corners[i][dim - 1];
    return sum / n;
  }

  const CellOwners<dim>& owners_;
  const std::vector<Body<dim>>& bodies_;
  MaterialPoints<dim>& points_;
  std::vector<char> drained_;  // of each point; empty: no body has water
};

}  // namespace

template <int dim>
double share_volumes(const CellOwners<dim>& owners, const std::vector<Body<dim>>& bodies,
                     MaterialPoints<dim>& points, LawsOfPoints<dim> laws,
                     SofteningAverages averages) {
  SharedWater<dim> water(owners, bodies, points);
  double lost = water.share();
  GroupVolumes<dim> volumes(owners, points);
  std::vector<double> theta(points.size(), 0.0);
  const auto for_each_point = [&](const auto& act) {
    for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
      std::visit(
          [&](const auto& law) {
            for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
              if (points.cell[p] >= 0 && water.is_of_skeleton(p)) act(law, b, p);
            }
          },
          bodies[b].material.law);
    }
  };
  for_each_point([&](const auto& law, std::int32_t b, std::int32_t p) {
    theta[p] = volumetric_strain(law, points.history[p]);
    volumes.add(b, p, theta[p]);
  });
  volumes.sum();
  const StepContext<dim> at_once{.dt = 0, .grid = &owners.grid, .averages = averages};
  for_each_point([&]<class Law>(const Law&, std::int32_t b, std::int32_t p) {
    const double d = volumes.strain(b, p) - theta[p];
    if (!(std::abs(d) > same_strain)) return;
    LawInStep<Law, dim> in_step{std::get<Law>(law_of<dim>(laws, p, bodies[b].material.law)), {}};
    if constexpr (RemembersInternal<Law> || HasVariables<Law>) {
      in_step.context = at_once.of_point(points, p);
    }
    lost += points.is_wet(p) ? change_volume(in_step, *bodies[b].water, d, p, points)
                             : change_volume(in_step, d, p, points);
  });
  sum_over_ranks(owners.comm, std::span<double>(&lost, 1));
  return lost;
}

template double share_volumes<2>(const CellOwners<2>&, const std::vector<Body<2>>&,
                                 MaterialPoints<2>&, LawsOfPoints<2>, SofteningAverages);
template double share_volumes<3>(const CellOwners<3>&, const std::vector<Body<3>>&,
                                 MaterialPoints<3>&, LawsOfPoints<3>, SofteningAverages);

}  // namespace gabion::mpm
