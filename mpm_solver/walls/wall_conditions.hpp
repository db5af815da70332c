// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/walls/wall_motion.hpp"
#include "mpm_solver/walls/wall_pieces.hpp"

namespace gabion::mpm {

/// A rigid wall along facets of the background grid.
struct WallSettings {
  std::string group;     ///< facet group of the grid
  bool fixed = true;     ///< all components; otherwise slip: the normal one of each smooth piece
  std::string where;     ///< file and pointer, for messages
  WallMotion motion;     ///< prescribed; the facets stay where the grid has them
  bool drained = false;  ///< pore water passes it, with the pressure of water at rest outside
  double inflow = 0;     ///< pore water that enters the soil there, by area [m/s]
  std::string where_inflow{};  ///< file and pointer, for messages
};

/// Conditions of walls at grid nodes: the directions in which a node may move, the range of the
/// projector Q, and its displacement w in the other directions.
template <int dim>
class WallConditions {
 public:
  /// Fixed walls prevail where walls meet, then those listed first: a later wall adds only the
  /// directions that are still free. Pieces of slip walls that lie within flush_angle of each other
  /// hold one direction, their mean by area, which counts for the wall listed first.
  WallConditions(const BackgroundGrid<dim>& grid, const std::vector<WallSettings>& walls);

  /// Slip walls or pieces of them within flush_angle are one plane [deg].
  static constexpr double flush_angle = 1;
  /// Slip walls that meet, or bend, from corner_angle or flush_angle up to this are named by
  /// corner_warnings() [deg].
  static constexpr double steep_angle = 50;

  /// A sentence for each wall, and for each pair of walls, with nodes where soil may be meant to
  /// slide round a corner.
  std::vector<std::string> corner_warnings() const;
  /// Check all motions from one time to another [s]; the second may be infinite.
  /// @throws ConfigError  walls that share a node move it to different places; names both
  void require_agreement(double start, double end);

  /// Whether a wall holds this node of the grid.
  bool holds(std::int32_t grid_node) const;
  /// Whether the same walls hold both nodes of the grid along the same directions, or none does.
  bool hold_alike(std::int32_t a, std::int32_t b) const;

  /// The one direction along which the walls hold every node of the grid, within flush_angle: soil
  /// then deforms in the plane across it, as in a slice of one cell between slip walls. Null if
  /// there is none, or a second one, as in a column of one cell.
  const Vector<dim>* held_normal() const { return held_normal_ ? &*held_normal_ : nullptr; }

  /// Take the motion of the walls from time to time + dt.
  void begin_step(double time, double dt);
  /// Whether a wall moves in the current step.
  bool move() const { return move_; }
  /// Collect the constrained nodes among the active ones.
  void select(const GridNodes<dim>& nodes);

  const std::vector<std::int32_t>& constrained() const { return constrained_; }  ///< active numbers
  const std::vector<Matrix<dim>>& projectors() const { return projectors_; }

  /// Remove the constrained components: x_i <- Q_i x_i, num_nodes x dim.
  void project(std::span<double> x) const;
  /// Set the constrained components to those of the walls: x_i <- Q_i x_i + scale w_i.
  /// @param scale  1 for displacements, 1 / dt for velocities
  void impose(std::span<double> x, double scale) const;

  /// Force of the soil on each wall [N], in the order of the settings, on the nodes that this rank
  /// owns. The force at a node is shared by the walls that hold it, each along the direction that
  /// it holds.
  /// @param r  residual before it was projected, num_nodes x dim
  std::vector<Vector<dim>> forces(std::span<const double> r, const SharedNodes& shared) const;

 private:
  struct Hold {
    std::int32_t wall = 0;
    Vector<dim> n = Vector<dim>::Zero();  // unit
  };
  struct Node {
    std::int32_t grid_node = 0;
    int num_holds = 0;  // independent directions
    Hold holds[dim];
    Matrix<dim> shares = Matrix<dim>::Zero();  // x = sum_k (shares_k . x) n_k where x is held
    Matrix<dim> Q = Matrix<dim>::Identity();
    Vector<dim> w = Vector<dim>::Zero();  // motion in the current step [m]
  };
  struct Repetition {  // a direction that other walls hold already
    std::size_t node = 0;
    Hold hold;
  };
  struct SlipPiece {
    std::size_t node = 0;
    std::int32_t wall = 0;
    Vector<dim> n;
    Vector<dim> area;
  };
  struct Corner {  // the nodes where two slip walls, or two pieces of one, hold two directions
    std::int32_t walls[2];
    std::int64_t num_nodes = 0;
    double least = 0, largest = 0;            // angle between the directions [deg]
    Vector<dim> place = Vector<dim>::Zero();  // of the first node [m]
  };

  std::size_t index_of(std::int32_t grid_node) const;
  void add_fixed_walls(const BackgroundGrid<dim>& grid);
  void add_slip_walls(const BackgroundGrid<dim>& grid);
  void add_pieces(const BackgroundGrid<dim>& grid, std::span<SlipPiece> at_node);
  void note_corner(const SlipPiece& a, const SlipPiece& b, const Vector<dim>& place);
  void add(std::size_t k, const Hold& hold);
  bool any_moves() const;
  double take_steps(double time, double dt);
  void move_nodes();
  void require_agreement(const Repetition& repetition, double tolerance, double time) const;
  static void set_shares(Node& node);
  void find_held_normal(std::int32_t num_grid_nodes);

  std::vector<WallSettings> walls_;
  std::vector<Node> nodes_;  // ascending grid nodes
  std::vector<Repetition> repetitions_;
  std::vector<Corner> corners_;
  std::optional<Vector<dim>> held_normal_;  // unit
  bool move_ = false;
  std::vector<Vector<dim>> steps_;     // displacement of each wall in the step
  std::vector<std::size_t> selected_;  // active ones of nodes_
  std::vector<std::int32_t> constrained_;
  std::vector<Matrix<dim>> projectors_;
};

}  // namespace gabion::mpm
