// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/points/material_points.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "common/mechanics/elements/cell_facets.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
constexpr std::size_t bytes_of_fields() {
  std::size_t sum =
      sizeof(MaterialPoints<dim>::body_starts) + sizeof(MaterialPoints<dim>::body_ids);
  for_each_field<dim>(
      [&sum]<class Values>(const char*, Values MaterialPoints<dim>::*) { sum += sizeof(Values); });
  return sum;
}

template <int dim>
constexpr std::size_t bytes_of_history() {
  std::size_t sum = 0;
  for_each_history_field<dim>(
      [&sum]<class Value>(const char*, Value MaterialState<dim>::*) { sum += sizeof(Value); });
  return sum;
}

static_assert(bytes_of_fields<2>() == sizeof(MaterialPoints<2>), "a field without a name");
static_assert(bytes_of_history<2>() == sizeof(MaterialState<2>), "a field without a name");

}  // namespace

namespace {

// Unit vector across dim - 1 tangents.
template <int dim>
Vector<dim> across(const Vector<dim>& first, [[maybe_unused]] const Vector<dim>& second) {
  if constexpr (dim == 2) {
    return Vector<2>(first[1], -first[0]).normalized();
  } else {
    return first.cross(second).normalized();
  }
}

template <int dim>
double depth_in_simplex(CellType type, const Vector<dim>* corners, const Vector<dim>& x) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int f = 0; f < num_facets(type); ++f) {
    const auto local = facet_nodes(type, f);
    const Vector<dim>& origin = corners[local[0]];
    const Vector<dim> normal =
        across<dim>(corners[local[1]] - origin, corners[local[dim - 1]] - origin);
    nearest = std::min(nearest, std::abs(normal.dot(x - origin)));
  }
  return nearest;
}

}  // namespace

template <int dim>
CellPlace<dim> place_in_cell(CellType type, std::span<const Vector<dim>> corners,
                             const Vector<dim>& xi) {
  ShapeValues<dim> shape;
  shape_functions<dim>(type, xi, shape);
  CellPlace<dim> place;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    place.x += shape.N[i] * corners[i];
    place.jacobian += corners[i] * shape.dN[i].transpose();
  }
  return place;
}

template <int dim>
double depth_in_cell(CellType type, std::span<const Vector<dim>> corners, const Vector<dim>& xi) {
  const Vector<dim> x = place_in_cell<dim>(type, corners, xi).x;
  if (type != CellType::quad4 && type != CellType::hex8) {
    return depth_in_simplex<dim>(type, corners.data(), x);
  }
  double nearest = std::numeric_limits<double>::infinity();
  for (int d = 0; d < dim; ++d) {
    for (const double side : {-1.0, 1.0}) {
      Vector<dim> foot = xi;
      foot[d] = side;
      const auto place = place_in_cell<dim>(type, corners, foot);
      const Vector<dim> normal =
          across<dim>(place.jacobian.col((d + 1) % dim), place.jacobian.col((d + 2) % dim));
      nearest = std::min(nearest, std::abs(normal.dot(x - place.x)));
    }
  }
  return nearest;
}

template <int dim>
bool is_column(const Matrix<dim>& jacobian) {
  const double det = std::abs(jacobian.determinant());
  return std::abs(std::abs(jacobian.diagonal().prod()) - det) <= 1e-9 * det;
}

template <int dim>
bool has_columns(const Mesh<dim>& mesh) {
  if (mesh.cell_type != CellType::quad4 && mesh.cell_type != CellType::hex8) return false;
  const auto places = gauss_rule<dim>(mesh.cell_type, 3);
  Vector<dim> corners[max_cell_nodes];
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    const auto nodes = mesh.cell(c);
    for (std::size_t i = 0; i < nodes.size(); ++i) corners[i] = mesh.nodes[nodes[i]];
    for (const auto& q : places) {
      const std::span<const Vector<dim>> cell(corners, nodes.size());
      if (!is_column<dim>(place_in_cell<dim>(mesh.cell_type, cell, q.xi).jacobian)) return false;
    }
  }
  return true;
}

template <int dim>
Vector<dim> point_domain(const Matrix<dim>& jacobian, double volume) {
  const Vector<dim> reach = is_column<dim>(jacobian)
                                ? Vector<dim>(jacobian.diagonal().cwiseAbs())
                                : Vector<dim>(jacobian.cwiseAbs().rowwise().sum());
  return reach * (0.5 * cube_side<dim>(volume / reach.prod()));
}

template <int dim>
void add_point(const NewPoint<dim>& point, MaterialPoints<dim>& points) {
  points.id.push_back(point.id);
  points.m.push_back(point.m);
  points.V0.push_back(point.V0);
  points.depth.push_back(point.depth);
  points.x.push_back(point.x);
  points.u.push_back(Vector<dim>::Zero());
  points.v.push_back(point.v);
  points.a.push_back(Vector<dim>::Zero());
  points.J.push_back(1);
  points.energy.push_back(0);
  points.tau.push_back(Symmetric<dim>::Zero());
  points.history.emplace_back();
  points.cell.push_back(-1);
  if (point.half_length) points.half_length.push_back(*point.half_length);
}

template <int dim>
std::int64_t num_points(const PointLayout<dim>& layout) {
  const auto rule =
      point_rule<dim>(layout.mesh.cell_type, layout.points_per_cell, layout.placement);
  return layout.mesh.num_cells() * static_cast<std::int64_t>(rule.size());
}

template <int dim>
std::int64_t lay_points(const PointLayout<dim>& layout, double density, const PointShare& share,
                        MaterialPoints<dim>& points) {
  const Mesh<dim>& mesh = layout.mesh;
  const auto rule = point_rule<dim>(mesh.cell_type, layout.points_per_cell, layout.placement);
  const auto rule_size = static_cast<std::int64_t>(rule.size());
  const std::int64_t total = num_points(layout);
  const std::int64_t first = total * share.part / share.num_parts;
  const std::int64_t last = total * (share.part + 1) / share.num_parts;
  if (points.body_starts.empty()) points.body_starts.push_back(0);
  if (points.body_ids.empty()) points.body_ids.push_back(share.first_id);

  Vector<dim> corners[max_cell_nodes];
  ShapeValues<dim> shape;
  for (std::int64_t k = first; k < last; ++k) {
    const auto nodes = mesh.cell(static_cast<std::int32_t>(k / rule_size));
    const auto& q = rule[k % rule_size];
    for (std::size_t i = 0; i < nodes.size(); ++i) corners[i] = mesh.nodes[nodes[i]];
    const std::span<const Vector<dim>> cell(corners, nodes.size());
    const auto [x, jacobian] = place_in_cell<dim>(mesh.cell_type, cell, q.xi);
    shape_functions<dim>(mesh.cell_type, q.xi, shape);
    const double volume = q.weight * map_gradients<dim>(mesh.cell_type, corners, shape);

    NewPoint<dim> point{.id = share.first_id + k,
                        .x = x,
                        .v = layout.velocity,
                        .m = density * volume,
                        .V0 = volume,
                        .depth = depth_in_cell<dim>(mesh.cell_type, cell, q.xi)};
    if (layout.with_domains) point.half_length = point_domain<dim>(jacobian, volume);
    add_point(point, points);
  }
  points.body_starts.push_back(points.size());
  points.body_ids.push_back(share.first_id + total);
  return total;
}

template <int dim>
void add_water(const std::vector<Body<dim>>& bodies, MaterialPoints<dim>& points) {
  const auto is_wet = [](const Body<dim>& body) { return body.water.has_value(); };
  if (std::none_of(bodies.begin(), bodies.end(), is_wet)) return;
  for (const auto& body : bodies) {
    const std::size_t b = &body - bodies.data();
    const auto count = static_cast<std::size_t>(points.body_starts[b + 1]);
    points.water.resize(count, body.water ? body.water->content_at(0, 1) : 0);
  }
}

template <int dim>
void add_gradients(MaterialPoints<dim>& points) {
  points.grad_v.assign(points.x.size(), Matrix<dim>::Zero());
  points.grad_a.assign(points.x.size(), Matrix<dim>::Zero());
}

template <int dim>
void add_internal(MaterialPoints<dim>& points) {
  points.internal.assign(points.x.size(), InternalState::Zero());
}

template <int dim>
void add_variables(const std::vector<Body<dim>>& bodies, MaterialPoints<dim>& points) {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const auto* law = std::get_if<Umat<dim>>(&bodies[b].material.law);
    if (law == nullptr) continue;
    points.variables.resize(points.x.size(), StateVariables::Zero());
    for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
      law->set_start(numbers_of(points.variables[p]));
    }
  }
}

namespace {

// Close the gaps that the given places leave; fields that the points do not have are empty.
template <class Value>
void take_out(std::span<const std::int32_t> which, std::vector<Value>& values) {
  if (values.empty()) return;
  std::size_t kept = 0, next = 0;
  for (std::size_t p = 0; p < values.size(); ++p) {
    if (next < which.size() && static_cast<std::size_t>(which[next]) == p) {
      ++next;
    } else {
      values[kept++] = values[p];
    }
  }
  values.resize(kept);
}

}  // namespace

template <int dim>
void find_bodies(MaterialPoints<dim>& points) {
  for (std::size_t b = 0; b < points.body_starts.size(); ++b) {
    const auto first = std::lower_bound(points.id.begin(), points.id.end(), points.body_ids[b]);
    points.body_starts[b] = static_cast<std::int32_t>(first - points.id.begin());
  }
}

template <int dim>
void order_points(std::size_t num_ordered, MaterialPoints<dim>& points) {
  std::vector<std::int32_t> order(points.id.size());
  std::iota(order.begin(), order.end(), 0);
  const auto before = [&](std::int32_t a, std::int32_t b) { return points.id[a] < points.id[b]; };
  const auto rest = order.begin() + static_cast<std::ptrdiff_t>(num_ordered);
  std::sort(rest, order.end(), before);
  std::inplace_merge(order.begin(), rest, order.end(), before);
  for_each_field<dim>([&](const char*, auto field) {
    auto& values = points.*field;
    if (values.empty()) return;
    auto ordered = values;
    for (std::size_t p = 0; p < order.size(); ++p) ordered[p] = values[order[p]];
    values = std::move(ordered);
  });
  find_bodies(points);
}

template <int dim>
std::int32_t find_point(const MaterialPoints<dim>& points, std::int64_t id) {
  const auto found = std::lower_bound(points.id.begin(), points.id.end(), id);
  if (found == points.id.end() || *found != id) return -1;
  return static_cast<std::int32_t>(found - points.id.begin());
}

template <int dim>
void remove_points(std::span<const std::int32_t> which, MaterialPoints<dim>& points) {
  for (std::int32_t& start : points.body_starts) {
    start -= static_cast<std::int32_t>(std::lower_bound(which.begin(), which.end(), start) -
                                       which.begin());
  }
  for_each_field<dim>([&](const char*, auto field) { take_out(which, points.*field); });
}

template bool is_column<2>(const Matrix<2>&);
template bool is_column<3>(const Matrix<3>&);
template bool has_columns<2>(const Mesh<2>&);
template bool has_columns<3>(const Mesh<3>&);
template Vector<2> point_domain<2>(const Matrix<2>&, double);
template Vector<3> point_domain<3>(const Matrix<3>&, double);
template void add_point<2>(const NewPoint<2>&, MaterialPoints<2>&);
template void add_point<3>(const NewPoint<3>&, MaterialPoints<3>&);
template void find_bodies<2>(MaterialPoints<2>&);
template void find_bodies<3>(MaterialPoints<3>&);
template void order_points<2>(std::size_t, MaterialPoints<2>&);
template void order_points<3>(std::size_t, MaterialPoints<3>&);
template std::int32_t find_point<2>(const MaterialPoints<2>&, std::int64_t);
template std::int32_t find_point<3>(const MaterialPoints<3>&, std::int64_t);
template void remove_points<2>(std::span<const std::int32_t>, MaterialPoints<2>&);
template void remove_points<3>(std::span<const std::int32_t>, MaterialPoints<3>&);
template void add_water<2>(const std::vector<Body<2>>&, MaterialPoints<2>&);
template void add_water<3>(const std::vector<Body<3>>&, MaterialPoints<3>&);
template void add_gradients<2>(MaterialPoints<2>&);
template void add_gradients<3>(MaterialPoints<3>&);
template void add_internal<2>(MaterialPoints<2>&);
template void add_variables<2>(const std::vector<Body<2>>&, MaterialPoints<2>&);
template void add_variables<3>(const std::vector<Body<3>>&, MaterialPoints<3>&);
template void add_internal<3>(MaterialPoints<3>&);
template std::int64_t num_points<2>(const PointLayout<2>&);
template std::int64_t num_points<3>(const PointLayout<3>&);
template std::int64_t lay_points<2>(const PointLayout<2>&, double, const PointShare&,
                                    MaterialPoints<2>&);
template std::int64_t lay_points<3>(const PointLayout<3>&, double, const PointShare&,
                                    MaterialPoints<3>&);

}  // namespace gabion::mpm
