// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "mpm_solver/grid/outer_point.hpp"
#include "mpm_solver/points/pool.hpp"
#include "mpm_solver/stress/seepage_inlets.hpp"
#include "mpm_solver/stress/stress_parts.hpp"

namespace gabion::mpm {

/// Data on which the water of a step depends, besides the points.
template <int dim>
struct SeepageStepData {
  Vector<dim> gravity = Vector<dim>::Zero();  ///< at the end of the step [m/s^2]
  double dt = 0;                              ///< [s]
  double cell_size = 0;                       ///< [m]
  double inertia_slope = 0;  ///< NewmarkBossak::inertia_slope; 0: quasi-static [1/s^2]
  bool by_inertia = false;   ///< pressures move the soil by its inertia alone, not its stiffness
  bool averages = false;     ///< volumes are those of groups (F-bar), as in AveragedForces
  PoolLevels pools{};        ///< at the end of the step
  /// Rain at the end of the step, volume by area across it, along gravity [m/s].
  Vector<dim> rain = Vector<dim>::Zero();
};

/// A place where water passes the surface of the soil in the last evaluation and did not before, or
/// no more.
struct OutletChange {
  std::int32_t entry;
  const double* w;  ///< of the nodes of the entry
  double drained;   ///< change of the volume in the step by pressure [m^3/Pa]
};

/// Pore water of bodies that drain, between the grains of the points and with its pressure on the
/// nodes. The unknown of a node is q, the pressure above that of water at rest,
///
///     p(x) = sum_k N_k q_k + rho_w g . x ,
///
/// and a step balances the volume of water (W13) while the pressure adds to the forces (W12) of
/// docs/theory/water.md. Pools press on the whole border of the soil (W17): that is equivalent to
/// subtracting their pressure, continued into the soil, from the soil's own, and to a body force
/// along its gradient. Each rank has the points of its groups; volumes and what is found of them
/// are of all ranks. Refers to its parts; valid for one step.
template <int dim>
class SeepageForces {
 public:
  static constexpr int block_size = dim + 1;

  /// @note Collective.
  SeepageForces(const StressParts<dim>& parts, const SeepageStepData<dim>& step);

  /// Let water leave at these points where it is under pressure; only rain comes in, as far as the
  /// pressure there does not become positive. Below the level of a pool water flows in both
  /// directions, by the difference of the pressures. Replaces earlier outlets.
  void open(const BackgroundGrid<dim>& grid, std::span<const OuterPoint<dim>> surface);

  /// Let water enter at these places.
  void feed(SeepageInlets<dim> inlets) { inlets_.emplace(std::move(inlets)); }

  /// Unknowns of a trial state.
  struct Trial {
    std::span<const double> du;  ///< num_nodes x dim [m]
    std::span<const double> q;   ///< num_nodes [Pa]
  };
  /// Find forces and volumes of a trial state.
  /// @param K  null, or gets what the water adds to -dr/d(du, q): node blocks of dim rows of forces
  ///           and one of volumes
  /// @returns false when pores would be closed on any rank; `worst` is that point where it is of
  ///          this one
  /// @note Collective.
  bool evaluate(const Trial& trial, BlockMatrix<block_size>* K, RefusedPoint& worst);
  /// Forces of the accepted pressures, those of du = 0. Replaces forces().
  void find_start_forces();
  /// Let the next evaluations continue from the last one, over another dt: what seeped and left so
  /// far remains. @pre one rank. Of rain and of
  /// the work of pools each evaluation has that of its own dt
  void carry_on();
  /// Outlets that changed since the last call, or since the last evaluation with K.
  std::vector<OutletChange> take_outlet_changes();

  /// Force of the pressure on the skeleton, of the points of this rank, num_nodes x dim [N].
  const std::vector<double>& forces() const { return f_; }
  /// Volume that is missing at each node: r of the balance of water, num_nodes [m^3].
  const std::vector<double>& volumes() const { return r_; }
  /// Work of the pools' pressure on the skeleton as it moves, of this rank [J].
  double pool_work(std::span<const double> du) const;
  /// Forces of the pools on the skeleton, num_nodes x dim, of this rank [N]; empty without pools.
  const std::vector<double>& pool_forces() const { return f_pool_; }
  /// Their sum [N].
  Vector<dim> pool_force() const;
  /// Work on the water that comes in from pools and fed sides, less that of what leaves there, in
  /// the last evaluation, of this rank [J].
  double inflow_work() const { return inflow_work_; }
  /// Volume of water that leaves at the points of open(), less what enters through fed sides, in
  /// the last evaluation [m^3].
  double outflow() const { return outflow_; }
  /// Volume of the water that leaves there, without what enters, of this rank [m^3].
  double leaving() const { return leaving_; }
  /// Pressures of the entries in the last evaluation, 0 where no water drains [Pa].
  const std::vector<double>& pressures() const { return p_; }
  /// From now on keep the places where water leaves during a solution, since Newton's method may
  /// fail to converge over that kink.
  void hold_outlets() { hold_ = true; }
  /// Find anew where the soil takes all of the rain, from the last evaluation, and with
  /// hold_outlets() where water leaves; until then the places stay as they were, at first those
  /// under the accepted pressures.
  /// @returns whether that is elsewhere now, on any rank
  /// @note Collective.
  bool update_outlets();
  /// Volumes of the rain that the soil takes and does not take, in the last evaluation [m^3].
  double rain_in() const { return rain_in_; }
  double rain_run_off() const { return rain_run_off_; }
  /// Work of gravity on the water that seeps through the skeleton, in the last evaluation, of the
  /// points of this rank [J].
  double weight_work() const { return weight_work_; }
  /// Norm of the terms of the balance of water [m^3]. @note Collective.
  double volume_scale() const;

  /// q of the nodes that fits the accepted pressures best, as a guess [Pa]; 0 at dry nodes.
  /// @note Collective.
  std::vector<double> start_heads() const;
  /// 1 for nodes that may act on points, of any rank, whose water drains, num_nodes.
  const std::vector<char>& wet() const { return wet_; }
  /// p of water at rest that q leaves out, at a place [Pa].
  double at_rest(std::int32_t body, const Vector<dim>& x) const;
  /// Modulus of P waves of the stiffest body that drains: it scales pressures [Pa].
  double modulus() const { return modulus_; }

  /// Give the trial state of the points, so far that of the skeleton, the pressures of the last
  /// evaluation.
  /// @returns what the water gives up as it seeps and leaves: the work against its pressure that
  ///          does not become energy of the water in the points, of this rank [J]
  double finish(std::span<const double> du);
  /// Like finish(du), after the last substep.
  /// @returns energy that the water of the points got, of this rank [J]
  double finish();
  /// Put pressures and masses of the last evaluation into the points.
  void store(MaterialPoints<dim>& points) const;

 private:
  struct Work;
  struct Group;
  /// A place where water may leave.
  struct Outlet {
    std::int32_t entry = 0;
    std::array<double, dim == 2 ? 9 : 27> w = {};  // of the nodes of the entry
    double at_rest = 0;                            // pressure that q leaves out there [Pa]
    double drained = 0;                            // volume in the step by pressure [m^3/Pa]
    double outside = 0;                            // pressure of a pool, 0: air [Pa]
    double rain = 0;                               // volume in the step [m^3]
    double at_pressure = 0;  // volume that the pressure of the last evaluation lets out [m^3]
    bool full = false;       // the soil does not take all of the rain; without rain: water leaves
    bool follows = false;    // water passed in the last evaluation
    bool in_K = false;       // water passed in the last one with K
  };
  void list_wet();
  void list_pool_pressures();
  bool evaluate_groups(const Trial& trial, BlockMatrix<block_size>* K, RefusedPoint& worst);
  double tie_of_nodes(const CellGroup& group) const;
  double give_water(std::int32_t body, std::int32_t entry);
  void gather(const CellGroup& group, const Trial& trial, Group& work) const;
  static void bear(const PoreWater& water, Work& point);
  bool sum_up(const CellGroup& group, Group& work, RefusedPoint& worst) const;
  bool fill_pores(const CellGroup& group, Group& work, RefusedPoint& worst) const;
  void add_forces(const CellGroup& group, Group& work);
  void add_volumes(const CellGroup& group, Group& work);
  void add_outflow(const CellGroup& group, Group& work, bool with_stiffness);
  bool follows_pressure(const Outlet& outlet, double& volume);
  void add_stiffness(const CellGroup& group, Group& work) const;
  void add_point_stiffness(const CellGroup& group, const Work& point, Group& work) const;
  void add_mobility_stiffness(const CellGroup& group, const Work& point, Group& work) const;
  void add_group_stiffness(const CellGroup& group, Group& work) const;

  StressParts<dim> parts_;
  SeepageStepData<dim> step_;
  double modulus_ = 0;
  double weight_work_ = 0, outflow_ = 0, inflow_work_ = 0, rain_in_ = 0, rain_run_off_ = 0;
  double leaving_ = 0;
  std::vector<Outlet> outlets_;  // ascending entries
  std::optional<SeepageInlets<dim>> inlets_;
  bool hold_ = false;                 // see hold_outlets()
  std::vector<std::int32_t> groups_;  // of the weights, those of bodies that drain
  std::vector<double> tau_st_;        // of each body [1/Pa]
  std::vector<double> p_n_;           // accepted pressure of each entry [Pa]
  std::vector<double> p_;             // of each entry in the last evaluation [Pa]
  std::vector<double> J_;             // volume ratio of each entry since it was free of stress
  std::vector<char> wet_;
  std::vector<double> q_start_;  // start_heads()
  std::vector<double> f_, r_, squeezed_, seeped_;
  std::vector<double> left_;  // volumes through outlets of the last evaluation, num_nodes [m^3]

  // Volumes at the nodes and sums so far, after carry_on(); else empty and 0.
  std::vector<double> gone_;
  double weight_work_gone_ = 0, outflow_gone_ = 0;

  // Pressures of pools; without pools empty.
  std::vector<double> p_pool_;             // pressure of pools at each entry [Pa]
  std::vector<Vector<dim>> p_pool_slope_;  // its gradient [Pa/m]
  std::vector<double> f_pool_;             // the pools' part of f_
};

}  // namespace gabion::mpm
