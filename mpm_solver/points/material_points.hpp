// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/elements/shape_functions.hpp"
#include "common/mechanics/materials/material.hpp"
#include "common/mechanics/mesh/mesh.hpp"
#include "common/mechanics/tensor.hpp"
#include "mpm_solver/points/pore_water.hpp"

namespace gabion::mpm {

/// A body: one material, laid out as material points.
template <int dim>
struct Body {
  std::string name;
  Material<dim> material;
  std::optional<PoreWater> water = std::nullopt;  ///< none: dry
  /// Keys of the material that vary in space, as paths within it; MaterialPoints::parameters has
  /// the values, in this order.
  std::vector<std::string> varying{};
};

/// State of a law from a library (Umat) at a point.
using StateVariables = Eigen::Matrix<double, umat_state_size, 1>;
inline std::span<double> numbers_of(StateVariables& variables) {
  return {variables.data(), umat_state_size};
}
inline std::span<const double> numbers_of(const StateVariables& variables) {
  return {variables.data(), umat_state_size};
}

/// Values of the parameters of a material that vary in space, at a point; unused ones are 0.
using VaryingParameters = Eigen::Vector4d;

/// Modulus of P waves of a body without its water [Pa].
template <int dim>
double skeleton_modulus(const Body<dim>& body) {
  return std::visit([](const auto& law) { return law.p_wave_modulus(); }, body.material.law);
}
/// Modulus of P waves of a body with its water: that of undrained soil [Pa].
template <int dim>
double undrained_modulus(const Body<dim>& body) {
  const double M = skeleton_modulus(body);
  return body.water ? M + body.water->modulus() : M;
}

/// State of the material points of one rank at an accepted time, one entry per point in each array.
/// Ordered by id; points of one body are contiguous. A rank has the points of its part of space
/// (PointRanks).
template <int dim>
struct MaterialPoints {
  std::vector<Vector<dim>> x;                 ///< position [m]
  std::vector<Vector<dim>> u;                 ///< displacement since the start [m]
  std::vector<Vector<dim>> v;                 ///< velocity [m/s]
  std::vector<Vector<dim>> a;                 ///< acceleration [m/s^2]
  std::vector<Matrix<dim>> grad_v;            ///< velocity gradient [1/s]; empty unless TPIC
  std::vector<Matrix<dim>> grad_a;            ///< acceleration gradient [1/s^2]; empty unless TPIC
  std::vector<double> m;                      ///< mass [kg] (2D: per metre of thickness)
  std::vector<double> V0;                     ///< volume in the stress-free state [m^3]
  std::vector<double> depth;                  ///< below the nearest side of its body's cell [m]
  std::vector<double> J;                      ///< current volume / V0
  std::vector<double> energy;                 ///< elastic energy / V0 [J/m^3]
  std::vector<Symmetric<dim>> tau;            ///< Kirchhoff stress [Pa]
  std::vector<MaterialState<dim>> history;    ///< of the material law
  std::vector<InternalState> internal;        ///< internal variables of the material law; empty
                                              ///< unless a law remembers them
  std::vector<StateVariables> variables;      ///< of laws from a library; empty without one
  std::vector<VaryingParameters> parameters;  ///< Body::varying; empty where no body has any
  std::vector<std::int32_t> cell;             ///< of the background grid that holds x
  std::vector<std::int64_t> id;               ///< number in the whole run, from 0
  /// Pore water of each point when it is free of pressure, over V0, 0: dry; empty where no body has
  /// any (PoreWater::at).
  std::vector<double> water;
  /// Half lengths, empty unless the basis follows the points' domains (PointLayout::with_domains):
  std::vector<Vector<dim>> half_length;   ///< of the domain along each axis, uncut [m]
  std::vector<std::int32_t> body_starts;  ///< first point of each body, and the number of points
  std::vector<std::int64_t> body_ids;  ///< first id of each body, and the number of ids; of a run

  std::int32_t size() const { return static_cast<std::int32_t>(x.size()); }
  bool is_wet(std::int32_t p) const { return !water.empty() && water[p] > 0; }
  bool has_gradients() const { return !grad_v.empty(); }
  std::int32_t num_bodies() const { return static_cast<std::int32_t>(body_starts.size()) - 1; }
};

/// Name each array of MaterialPoints that has an entry a point, once: visit(name, member), member a
/// pointer to the std::vector.
template <int dim, class Visit>
constexpr void for_each_field(const Visit& visit) {
  using Points = MaterialPoints<dim>;
  visit("id", &Points::id);
  visit("m", &Points::m);
  visit("V0", &Points::V0);
  visit("depth", &Points::depth);
  visit("x", &Points::x);
  visit("u", &Points::u);
  visit("v", &Points::v);
  visit("a", &Points::a);
  visit("grad_v", &Points::grad_v);
  visit("grad_a", &Points::grad_a);
  visit("J", &Points::J);
  visit("energy", &Points::energy);
  visit("tau", &Points::tau);
  visit("history", &Points::history);
  visit("internal", &Points::internal);
  visit("variables", &Points::variables);
  visit("parameters", &Points::parameters);
  visit("cell", &Points::cell);
  visit("water", &Points::water);
  visit("half_length", &Points::half_length);
}

/// Like for_each_field, for the fields of `history`: visit(name, member).
template <int dim, class Visit>
constexpr void for_each_history_field(const Visit& visit) {
  visit("e", &MaterialState<dim>::e);
  visit("plastic_strain", &MaterialState<dim>::plastic_strain);
  visit("gap", &MaterialState<dim>::gap);
}

/// J p of the pore water of a point; 0 of a dry one [Pa].
template <int dim>
double pore_tau(const Body<dim>& body, const MaterialPoints<dim>& points, std::int32_t p) {
  if (!body.water || !points.is_wet(p)) return 0;
  return points.J[p] * body.water->at(points.water[p], points.J[p]).p;
}

/// Layout of the points that fill a body.
template <int dim>
struct PointLayout {
  Mesh<dim> mesh;           ///< body mesh; not used after the points are laid
  int points_per_cell = 1;  ///< see point_rule()
  Vector<dim> velocity = Vector<dim>::Zero();
  PointPlacement placement = PointPlacement::gauss;
  bool with_domains = false;  ///< fill half_length
};

/// A rank's share of the points of a body that it lays: the part-th of num_parts equal contiguous
/// shares. They then go to the ranks that their cells belong to.
struct PointShare {
  std::int64_t first_id = 0;  ///< number of the body's first point in the whole run
  int part = 0;
  int num_parts = 1;
};

/// A material point without stress, its cell unknown.
template <int dim>
struct NewPoint {
  std::int64_t id = 0;
  Vector<dim> x = Vector<dim>::Zero();
  Vector<dim> v = Vector<dim>::Zero();
  double m = 0;
  double V0 = 0;
  double depth = 0;
  std::optional<Vector<dim>> half_length{};  ///< where the points have domains
};

/// Append a point; gradients and internal variables are left to add_gradients and add_internal,
/// body_starts to the caller.
template <int dim>
void add_point(const NewPoint<dim>& point, MaterialPoints<dim>& points);

/// A place in a cell.
template <int dim>
struct CellPlace {
  Vector<dim> x = Vector<dim>::Zero();         ///< [m]
  Matrix<dim> jacobian = Matrix<dim>::Zero();  ///< dx/dxi [m]
};
template <int dim>
CellPlace<dim> place_in_cell(CellType type, std::span<const Vector<dim>> corners,
                             const Vector<dim>& xi);

/// Distance of the place xi to the nearest side of a cell: where soil begins that is cut there [m].
/// Sides of a hex8 may be warped: then it is the distance to their tangent plane opposite to xi.
template <int dim>
double depth_in_cell(CellType type, std::span<const Vector<dim>> corners, const Vector<dim>& xi);

/// Whether boxes as long as the edges of a cell, dx_d/dxi_d, have its volume: it is a box along the
/// axes, or a column whose bottom and top are inclined, as over terrain.
template <int dim>
bool is_column(const Matrix<dim>& jacobian);

/// Whether all cells of a mesh of quad4 or hex8 are such columns.
template <int dim>
bool has_columns(const Mesh<dim>& mesh);

/// Half lengths of the box that stands for a point, with the volume of the point. In a cell that
/// is_column and that these boxes fill with `regular` points, the sides have the ratio of the
/// cell's edges, else that of its extents along the axes.
/// @param jacobian  dx/dxi of the body's cell at the point
template <int dim>
Vector<dim> point_domain(const Matrix<dim>& jacobian, double volume);

/// Give the points the gradients of velocity and acceleration that TPIC remembers, all zero.
template <int dim>
void add_gradients(MaterialPoints<dim>& points);

/// Give the points the internal variables of laws, all zero.
template <int dim>
void add_internal(MaterialPoints<dim>& points);

/// Give the points the state variables of a Umat, those of virgin soil; nothing where no body has
/// one.
template <int dim>
void add_variables(const std::vector<Body<dim>>& bodies, MaterialPoints<dim>& points);

/// Fill the pores of the points of bodies that have water, without pressure.
/// @pre all bodies are laid, free of stress
template <int dim>
void add_water(const std::vector<Body<dim>>& bodies, MaterialPoints<dim>& points);

/// Number of points of a body on all ranks.
template <int dim>
std::int64_t num_points(const PointLayout<dim>& layout);

/// Append the points of one body: each cell of the body mesh gets the points of `point_rule`, with
/// the volume of the cell shared by the rule's weights.
/// @returns number of points of the body on all ranks
template <int dim>
std::int64_t lay_points(const PointLayout<dim>& layout, double density, const PointShare& share,
                        MaterialPoints<dim>& points);

/// Points ordered by id were replaced by others: find where each body starts.
template <int dim>
void find_bodies(MaterialPoints<dim>& points);

/// Order the points by id and find where each body starts.
/// @param num_ordered  so many at the front are in order already
template <int dim>
void order_points(std::size_t num_ordered, MaterialPoints<dim>& points);

/// The place of a point, -1: this rank does not have it.
template <int dim>
std::int32_t find_point(const MaterialPoints<dim>& points, std::int64_t id);

/// Take points out. @param which  ascending numbers, each once
template <int dim>
void remove_points(std::span<const std::int32_t> which, MaterialPoints<dim>& points);

}  // namespace gabion::mpm
