// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "mpm_solver/stress/stress_parts.hpp"
#include "mpm_solver/stress/yielding_points.hpp"

namespace gabion::mpm {

template <int dim>
class AveragedForces;

/// Some groups whose stresses are evaluated, and others whose forces are known.
struct ForcePart {
  std::span<const GroupRange> ranges;    ///< ascending, each of one body
  std::span<const std::int32_t> known;   ///< groups, ascending, in none of the ranges
  std::span<const double> known_forces;  ///< GroupForces::values of them, one after the other
};

/// Internal forces of one rank's material points on the active nodes during one step,
///
///     f_int,i = sum_p V0_p P_p(H_p) grad N_ip ,   H_p = sum_i du_i (x) grad N_ip
///
/// and their derivative. Most soil hardly notices a coupling iteration, so stresses that are known
/// are not evaluated again: where H of a triangle or tetrahedron differs from the last evaluated
/// one by at most `same_strain`, P follows from its tangent (not under F-bar). `finish` brings the
/// trial state of all points to the accepted du.
template <int dim>
class InternalForces {
 public:
  /// @param same_strain   largest difference of a component of H that the tangent may bridge
  /// @param average_volumes  F-bar (AveragedForces)
  /// @param repeats          several solutions may follow each other: K is kept for the next one
  InternalForces(const StressParts<dim>& parts, double cell_size, double same_strain,
                 bool average_volumes = false, bool repeats = true);
  ~InternalForces();
  InternalForces(const InternalForces&) = delete;
  InternalForces& operator=(const InternalForces&) = delete;
  InternalForces(InternalForces&&) = delete;
  InternalForces& operator=(InternalForces&&) = delete;

  /// @param K      null, or set to the derivative of the internal forces
  /// @param worst  set to the point that made the state inadmissible
  /// @returns false when a point of this rank has no stress, or would be squeezed below min_J_ratio
  ///          of its volume
  bool evaluate(std::span<const double> du, BlockMatrix<dim>* K, RefusedPoint& worst);
  /// The forces of a part alone: those on nodes whose groups are all in it have the bits that
  /// `evaluate` gives them, those on other nodes have no meaning.
  /// @pre gradients of each point
  bool evaluate_part(std::span<const double> du, const ForcePart& part, RefusedPoint& worst);
  /// Whether K of the last evaluation was that of a neighbouring state.
  bool neighbours_matrix() const { return neighbours_matrix_; }
  const std::vector<double>& forces() const { return f_int_; }  ///< num_nodes x dim [N]
  /// Forces of the accepted stresses on the nodes of this step, those of du = 0: num_nodes x dim
  /// [N].
  std::vector<double> start_forces() const;

  /// Begin a new solution with other interface values: its first evaluation may take the matrix
  /// from the neighbouring state where the last solution ended.
  void begin_solution() {
    first_evaluation_ = true;
    yielding_.forget();
  }
  /// Whether a point of this rank yielded in any state since the solution began.
  bool yielded() const { return yielding_.any(); }
  /// See YieldingPoints.
  void add_regularisation(double share, BlockMatrix<dim>& K) const {
    yielding_.add_stiffness(share, parts_, K);
  }
  /// Forget earlier solutions of this step, so that repeated requests give the same bits.
  void forget();
  /// Bring the trial state of the points to exactly this du.
  void finish(std::span<const double> du);

 private:
  struct GroupStress {
    bool is_known = false;
    bool has_A = false;
    Matrix<dim> H = Matrix<dim>::Zero();
    Matrix<dim> P = Matrix<dim>::Zero();    // sum of V0 P
    Tangent<dim> A = Tangent<dim>::Zero();  // sum of V0 dP/dH
  };

  struct Work;
  /// Purpose of an evaluation of points.
  struct Request {
    std::span<const double> du;
    BlockMatrix<dim>* K;  // null: forces alone
    RefusedPoint& worst;
  };

  bool all_forces(const Request& request);
  bool forces_of(const GroupRange& range, const Request& request);
  void add_known(std::int32_t g, const double* forces);
  template <class Law>
  bool range_forces(const Law& law, const GroupRange& range, const Request& request);
  /// @tparam n  see EntryValues
  template <int n, class Law>
  bool point_forces(const Law& law, const GroupRange& range, const Request& request);
  template <int n, class Law>
  bool find_terms(const Law& law, const GroupRange& range, const Request& request);
  template <class Law>
  bool simplex_forces(const Law& law, const GroupRange& range, const Request& request);
  template <class Law>
  bool simplex_stress(const Law& law, std::int32_t g, const Matrix<dim>& H, const Request& request,
                      Matrix<dim>& P);
  template <class Law>
  bool group_stress(const Law& law, std::int32_t g, const Matrix<dim>& H, const Request& request);

  StressParts<dim> parts_;
  std::unique_ptr<AveragedForces<dim>> averaged_;  // null: each point sees its own volume change
  double cell_size_;
  double given_same_strain_;
  double same_strain_ = 0;
  std::unique_ptr<Work> work_;
  std::vector<double> f_int_;
  std::vector<GroupStress> known_;  // of each group
  std::vector<double> du_known_;    // where the forces were last evaluated; empty: nowhere
  std::vector<double> du_K_;        // where K_int_ was evaluated; empty: nowhere
  bool repeats_;
  std::vector<double> K_int_;  // values of the matrix
  bool first_evaluation_ = true;
  bool neighbours_matrix_ = false;
  YieldingPoints<dim> yielding_;
};

}  // namespace gabion::mpm
