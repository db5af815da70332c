// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/elements/shape_functions.hpp"
#include "common/mechanics/materials/material.hpp"
#include "common/mechanics/mesh/mesh.hpp"
#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// A body: one material, laid out as material points.
template <int dim>
struct Body {
  std::string name;
  Material<dim> material;
};

/// State of the material points of one rank at an accepted time, one entry per point in each array.
/// Points of one body are contiguous. A point stays with its rank for the whole run.
template <int dim>
struct MaterialPoints {
  std::vector<Vector<dim>> x;               ///< position [m]
  std::vector<Vector<dim>> u;               ///< displacement since the start [m]
  std::vector<Vector<dim>> v;               ///< velocity [m/s]
  std::vector<Vector<dim>> a;               ///< acceleration [m/s^2]
  std::vector<Matrix<dim>> grad_v;          ///< velocity gradient [1/s]; empty unless TPIC
  std::vector<Matrix<dim>> grad_a;          ///< acceleration gradient [1/s^2]; empty unless TPIC
  std::vector<double> m;                    ///< mass [kg] (2D: per metre of thickness)
  std::vector<double> V0;                   ///< volume in the stress-free state [m^3]
  std::vector<double> J;                    ///< current volume / V0
  std::vector<double> energy;               ///< elastic energy / V0 [J/m^3]
  std::vector<Symmetric<dim>> tau;          ///< Kirchhoff stress [Pa]
  std::vector<MaterialState<dim>> history;  ///< of the material law
  std::vector<std::int32_t> cell;           ///< of the background grid that holds x
  std::vector<std::int64_t> id;             ///< number in the whole run, from 0
  /// Only where the basis follows the points' domains (PointLayout::with_domains), else empty:
  std::vector<Vector<dim>> half_length;   ///< of the domain at the start, along each axis [m]
  std::vector<Matrix<dim>> F;             ///< deformation gradient since the start
  std::vector<std::int32_t> body_starts;  ///< first point of each body, and the number of points

  std::int32_t size() const { return static_cast<std::int32_t>(x.size()); }
  bool has_gradients() const { return !grad_v.empty(); }
  std::int32_t num_bodies() const { return static_cast<std::int32_t>(body_starts.size()) - 1; }
};

/// How a body is filled with points.
template <int dim>
struct PointLayout {
  Mesh<dim> mesh;           ///< body mesh; not used after the points are laid
  int points_per_cell = 1;  ///< see point_rule()
  Vector<dim> velocity = Vector<dim>::Zero();
  PointPlacement placement = PointPlacement::gauss;
  bool with_domains = false;  ///< fill half_length and F
};

/// Half lengths of the box that stands for a point: as long by wide as the cell of its body
/// reaches along the axes, with the volume of the point. In a cell along the axes with `regular`
/// points these boxes fill the cell.
/// @param jacobian  dx/dxi of the body's cell at the point
template <int dim>
Vector<dim> point_domain(const Matrix<dim>& jacobian, double volume);

/// Give the points the gradients of velocity and acceleration that TPIC remembers, all zero.
template <int dim>
void add_gradients(MaterialPoints<dim>& points);

/// Append the points of one body: each cell of the body mesh gets the points of `point_rule`, with
/// the volume of the cell shared by the rule's weights.
/// @param first_id         number of the body's first point in the whole run
/// @param part, num_parts  this rank takes the part-th of num_parts equal contiguous shares
/// @returns number of points of the body on all ranks
template <int dim>
std::int64_t lay_points(const PointLayout<dim>& layout, double density, std::int64_t first_id,
                        int part, int num_parts, MaterialPoints<dim>& points);

/// Take points out. @param which  ascending numbers, each once
template <int dim>
void remove_points(std::span<const std::int32_t> which, MaterialPoints<dim>& points);

}  // namespace gabion::mpm
