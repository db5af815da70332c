// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/boundary_points.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/mechanics/elements/shape_functions.hpp"
#include "common/mechanics/flat.hpp"
#include "common/mechanics/mesh/boundary.hpp"

namespace gabion::mpm {

namespace {

struct FacetPoint {
  double phi[4];
  double share;  // of the facet's area
};

// n midpoints on a segment; on a triangle or quadrilateral the rule with n points.
std::vector<FacetPoint> facet_points(CellType type, int n) {
  std::vector<FacetPoint> result;
  if (type == CellType::line2) {
    for (int k = 0; k < n; ++k) {
      const double s = (k + 0.5) / n;
      result.push_back({{1 - s, s, 0, 0}, 1.0 / n});
    }
    return result;
  }
  double total = 0;
  ShapeValues<2> shape;
  for (const auto& q : point_rule<2>(type, n)) {
    shape_functions<2>(type, q.xi, shape);
    FacetPoint point{};
    std::copy_n(shape.N, num_nodes(type), point.phi);
    point.share = q.weight;
    total += q.weight;
    result.push_back(point);
  }
  for (auto& point : result) point.share /= total;
  return result;
}

}  // namespace

template <int dim>
BoundaryPoints<dim>::BoundaryPoints(ContactSettings<dim> settings)
    : settings_(std::move(settings)), vertices_per_facet_(num_nodes(settings_.surface.facet_type)) {
  if (settings_.mode == ContactMode::slip) settings_.friction = 0;
  const auto& surface = settings_.surface;
  const auto rule = facet_points(surface.facet_type, settings_.points_per_facet);
  const auto geometry = facet_geometry<dim>(surface.vertices, surface.facet_type, surface.facets);
  vertices_now_ = surface.vertices;
  for (std::size_t f = 0; f < geometry.size(); ++f) {
    for (const FacetPoint& q : rule) {
      Point b;
      b.facet = static_cast<std::int32_t>(f);
      std::copy_n(q.phi, 4, b.phi);
      b.area = q.share * geometry[f].area;
      b.x = position(b);
      points_.push_back(b);
    }
  }
  set_normals();
}

template <int dim>
void BoundaryPoints<dim>::set_normals() {
  const auto geometry =
      facet_geometry<dim>(vertices_now_, settings_.surface.facet_type, settings_.surface.facets);
  for (Point& b : points_) b.normal = geometry[b.facet].normal;
}

template <int dim>
InterfaceMesh BoundaryPoints<dim>::interface_mesh() const {
  InterfaceMesh mesh;
  mesh.name = settings_.name;
  mesh.dim = dim;
  mesh.vertices_per_facet = vertices_per_facet_;
  for (const auto& x : settings_.surface.vertices) {
    mesh.coordinates.insert(mesh.coordinates.end(), x.data(), x.data() + dim);
  }
  mesh.facets.assign(settings_.surface.facets.begin(), settings_.surface.facets.end());
  return mesh;
}

template <int dim>
Vector<dim> BoundaryPoints<dim>::position(const Point& b) const {
  Vector<dim> x = Vector<dim>::Zero();
  for (int k = 0; k < vertices_per_facet_; ++k) {
    x += b.phi[k] * vertices_now_[settings_.surface.facets[b.facet * vertices_per_facet_ + k]];
  }
  return x;
}

// Normal and tangents of a facet; in 3D the first tangent follows its first edge.
template <int dim>
Matrix<dim> BoundaryPoints<dim>::frame(std::int32_t facet, const Vector<dim>& n) const {
  Matrix<dim> result;
  result.col(0) = n;
  if constexpr (dim == 2) {
    result.col(1) = Vector<2>(-n[1], n[0]);
  } else {
    const std::int32_t* corners = settings_.surface.facets.data() + facet * vertices_per_facet_;
    const Vector<3> along = vertices_now_[corners[1]] - vertices_now_[corners[0]];
    result.col(1) = (along - along.dot(n) * n).normalized();
    result.col(2) = n.cross(result.col(1));
  }
  return result;
}

// The shape functions of all cells that contain the point agree there, so any of them with soil
// will do.
template <int dim>
std::int32_t BoundaryPoints<dim>::find_cell(const BackgroundGrid<dim>& grid,
                                            std::span<const std::int32_t> occupied, double reach,
                                            const Point& b) const {
  const std::int32_t cell = grid.locator.locate(b.x, b.cell);
  if (cell < 0 || occupied[cell] != 0) return cell;
  for (const std::int32_t other : grid.locator.cells_at(b.x)) {
    if (occupied[other] != 0) return other;
  }
  const double farthest = b.has_soil ? shortest_edge(grid.mesh, cell) : reach;
  for (const double share : {0.25, 0.5, 0.75, 1.0}) {
    const std::int32_t ahead = grid.locator.locate(b.x + share * farthest * b.normal, cell);
    if (ahead >= 0 && occupied[ahead] != 0) return ahead;
  }
  return cell;
}

template <int dim>
void BoundaryPoints<dim>::begin_step(const BackgroundGrid<dim>& grid, const GridNodes<dim>& nodes,
                                     std::span<const std::int32_t> occupied, double reach) {
  touching_.clear();
  nodes_per_cell_ = grid.mesh.nodes_per_cell();
  ShapeValues<dim> shape;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    Point& b = points_[k];
    b.closed = false;
    b.sliding = false;
    b.traction.setZero();
    b.gap_trial.setZero();
    b.cell = find_cell(grid, occupied, reach, b);
    if (b.cell < 0 || occupied[b.cell] == 0) {
      b.gap.setZero();
      continue;
    }
    shape_functions<dim>(grid.mesh.cell_type, grid.locator.local_coordinates(b.cell, b.x), shape);
    std::copy_n(shape.N, nodes_per_cell_, b.N);
    const auto cell = grid.mesh.cell(b.cell);
    for (int i = 0; i < nodes_per_cell_; ++i) b.nodes[i] = nodes.active[cell[i]];
    touching_.push_back(static_cast<std::int32_t>(k));
  }
}

template <int dim>
void BoundaryPoints<dim>::append_cells(std::vector<std::int32_t>& offsets,
                                       std::vector<std::int32_t>& nodes) const {
  for (const std::int32_t k : touching_) {
    nodes.insert(nodes.end(), points_[k].nodes, points_[k].nodes + nodes_per_cell_);
    offsets.push_back(static_cast<std::int32_t>(nodes.size()));
  }
}

template <int dim>
void BoundaryPoints<dim>::set_displacement(std::span<const double> displacement) {
  const auto& surface = settings_.surface;
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
    vertices_now_[i] =
        surface.vertices[i] + Eigen::Map<const Vector<dim>>(displacement.data() + i * dim);
  }
  if (touching_.empty()) return;
  const auto geometry = facet_geometry<dim>(vertices_now_, surface.facet_type, surface.facets);
  for (const std::int32_t k : touching_) {
    Point& b = points_[k];
    b.du = position(b) - b.x;
    b.frame = frame(b.facet, geometry[b.facet].normal);
  }
}

// Gap, status and traction of one point; `slope` = -dt/dgap in the frame.
template <int dim>
void BoundaryPoints<dim>::evaluate_point(std::span<const double> du, Point& b,
                                         Matrix<dim>* slope) const {
  Vector<dim> relative = -b.du;
  for (int i = 0; i < nodes_per_cell_; ++i) {
    relative += b.N[i] * Eigen::Map<const Vector<dim>>(du.data() + b.nodes[i] * dim);
  }
  b.gap_trial = b.frame.transpose() * relative;
  if (settings_.memory == GapMemory::accumulated) b.gap_trial += b.gap;
  b.closed = settings_.mode == ContactMode::fixed || b.gap_trial[0] < 0;
  b.sliding = false;
  b.traction.setZero();
  if (slope) slope->setZero();
  if (!b.closed) return;

  Vector<dim> eps = Vector<dim>::Constant(settings_.tangential_share * settings_.penalty);
  eps[0] = settings_.penalty;
  b.traction = -eps.cwiseProduct(b.gap_trial);
  if (slope) *slope = eps.asDiagonal();
  if (settings_.mode == ContactMode::fixed || settings_.friction < 0) return;

  const double limit = settings_.friction * b.traction[0];
  const double size = b.traction.template tail<dim - 1>().norm();
  if (size <= limit) return;
  b.sliding = true;
  Vector<dim> direction = b.traction / size;
  direction[0] = 0;
  b.traction.template tail<dim - 1>() = limit * direction.template tail<dim - 1>();
  if (!slope) return;
  *slope *= limit / size;
  *slope -= eps[dim - 1] * (limit / size) * direction * direction.transpose();
  slope->col(0) = settings_.friction * eps[0] * direction;
  (*slope)(0, 0) = eps[0];
}

template <int dim>
void BoundaryPoints<dim>::add_forces(std::span<const double> du, std::span<double> r,
                                     BlockMatrix<dim>* K) {
  Matrix<dim> slope;
  for (const std::int32_t k : touching_) {
    Point& b = points_[k];
    evaluate_point(du, b, K ? &slope : nullptr);
    if (!b.closed) continue;
    const Vector<dim> force = b.area * (b.frame * b.traction);
    Matrix<dim> stiffness = Matrix<dim>::Zero();
    if (K) stiffness = b.area * (b.frame * slope * b.frame.transpose());
    for (int i = 0; i < nodes_per_cell_; ++i) {
      Eigen::Map<Vector<dim>>(r.data() + b.nodes[i] * dim) += b.N[i] * force;
      if (!K) continue;
      for (int j = 0; j < nodes_per_cell_; ++j) {
        K->add_block(b.nodes[i], b.nodes[j], b.N[i] * b.N[j] * stiffness);
      }
    }
  }
}

template <int dim>
std::vector<double> BoundaryPoints<dim>::forces_on_structure() const {
  std::vector<double> forces(vertices_now_.size() * dim, 0.0);
  for (const std::int32_t k : touching_) {
    const Point& b = points_[k];
    if (!b.closed) continue;
    const Vector<dim> force = -b.area * (b.frame * b.traction);
    for (int v = 0; v < vertices_per_facet_; ++v) {
      const std::int32_t vertex = settings_.surface.facets[b.facet * vertices_per_facet_ + v];
      Eigen::Map<Vector<dim>>(forces.data() + vertex * dim) += b.phi[v] * force;
    }
  }
  return forces;
}

template <int dim>
typename BoundaryPoints<dim>::Resultant BoundaryPoints<dim>::resultant() const {
  Resultant sum;
  for (const std::int32_t k : touching_) {
    const Point& b = points_[k];
    if (!b.closed) continue;
    const Vector<dim> force = -b.area * (b.frame * b.traction);
    sum.force += force;
    if constexpr (dim == 2) {
      sum.moment[0] += b.x[0] * force[1] - b.x[1] * force[0];
    } else {
      sum.moment += b.x.cross(force);
    }
  }
  return sum;
}

template <int dim>
double BoundaryPoints<dim>::work_on_soil(std::span<const double> du) const {
  double work = 0;
  for (const std::int32_t k : touching_) {
    const Point& b = points_[k];
    Vector<dim> motion = Vector<dim>::Zero();
    for (int i = 0; i < nodes_per_cell_; ++i) {
      motion += b.N[i] * Eigen::Map<const Vector<dim>>(du.data() + b.nodes[i] * dim);
    }
    work += 0.5 * motion.dot(b.force + b.area * (b.frame * b.traction));
  }
  return work;
}

template <int dim>
int BoundaryPoints<dim>::num_closed() const {
  return static_cast<int>(std::count_if(touching_.begin(), touching_.end(),
                                        [this](std::int32_t k) { return points_[k].closed; }));
}

template <int dim>
int BoundaryPoints<dim>::num_sliding() const {
  return static_cast<int>(std::count_if(touching_.begin(), touching_.end(),
                                        [this](std::int32_t k) { return points_[k].sliding; }));
}

template <int dim>
double BoundaryPoints<dim>::max_penetration() const {
  double result = 0;
  for (const std::int32_t k : touching_) {
    if (points_[k].closed) result = std::max(result, -points_[k].gap_trial[0]);
  }
  return result;
}

template <int dim>
double BoundaryPoints<dim>::approach_step(double dt, double margin) const {
  double result = std::numeric_limits<double>::infinity();
  for (const std::int32_t k : touching_) {
    const Point& b = points_[k];
    const double before = settings_.memory == GapMemory::accumulated ? b.gap[0] : 0;
    const double closing = before - b.gap_trial[0];
    if (!(closing > 0)) continue;
    result = std::min(result, dt * (std::max(b.gap_trial[0], 0.0) + margin) / closing);
  }
  return result;
}

template <int dim>
void BoundaryPoints<dim>::accept() {
  set_normals();
  for (Point& b : points_) {
    b.x = position(b);
    b.force = b.area * (b.frame * b.traction);
    b.has_soil = false;
  }
  for (const std::int32_t k : touching_) points_[k].has_soil = true;
  if (settings_.memory == GapMemory::step) return;
  for (const std::int32_t k : touching_) {
    Point& b = points_[k];
    const double normal = b.gap_trial[0];
    b.gap = b.gap_trial;
    if (b.sliding) {  // the part beyond the friction limit has slid for good
      b.gap = -b.traction / (settings_.tangential_share * settings_.penalty);
    } else if (!b.closed) {
      b.gap.setZero();  // tangential: sticking begins anew when the gap closes
    }
    b.gap[0] = normal;
  }
}

template <int dim>
void BoundaryPoints<dim>::visit_state(StateVisitor& visitor, const std::string& prefix) {
  const std::pair<const char*, Vector<dim> Point::*> vectors[] = {
      {"x", &Point::x}, {"normal", &Point::normal}, {"gap", &Point::gap}, {"force", &Point::force}};
  for (const auto& [name, member] : vectors) {
    std::vector<Vector<dim>> values;
    for (const Point& b : points_) values.push_back(b.*member);
    visitor.reals(prefix + name, flat(values));
    for (std::size_t k = 0; k < points_.size(); ++k) points_[k].*member = values[k];
  }
  std::vector<std::int32_t> cells, with_soil;
  for (const Point& b : points_) {
    cells.push_back(b.cell);
    with_soil.push_back(b.has_soil ? 1 : 0);
  }
  visitor.integers(prefix + "cell", cells);
  visitor.integers(prefix + "has_soil", with_soil);
  for (std::size_t k = 0; k < points_.size(); ++k) {
    points_[k].cell = cells[k];
    points_[k].has_soil = with_soil[k] != 0;
  }
}

template class BoundaryPoints<2>;
template class BoundaryPoints<3>;

}  // namespace gabion::mpm
