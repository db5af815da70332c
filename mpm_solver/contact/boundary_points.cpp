// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/boundary_points.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/points/flat.hpp"

namespace gabion::mpm {

template <int dim>
BoundaryPoints<dim>::BoundaryPoints(const ContactSettings<dim>& settings,
                                    const BoundaryPointSettings& method)
    : surface_(settings.surface),
      friction_(settings.friction),
      law_{.mode = settings.mode,
           .friction = settings.friction,
           .penalty = method.penalty,
           .tangential_penalty = method.tangential_share * method.penalty},
      memory_(method.memory),
      vertices_(settings.surface.vertices) {
  const auto rule = facet_points(settings.surface.facet_type, method.points_per_facet);
  const auto geometry = surface_.geometry();
  for (std::size_t f = 0; f < geometry.size(); ++f) {
    const auto facet = static_cast<std::int32_t>(f);
    for (const FacetPoint& q : rule) {
      points_.push_back({.facet = facet,
                         .phi = q.phi,
                         .area = q.share * geometry[f].area,
                         .x = surface_.position(facet, q.phi),
                         .normal = geometry[f].normal});
    }
  }
}

// The shape functions of all cells that contain the point agree there, so any of them with soil
// will do.
template <int dim>
std::int32_t BoundaryPoints<dim>::find_cell(const SoilSurface<dim>& soil, const Point& b) const {
  const std::int32_t cell = soil.grid.locate(b.x, b.cell);
  if (cell < 0 || soil.has_points(cell)) return cell;
  for (const std::int32_t other : soil.grid.cells_at(b.x)) {
    if (soil.has_points(other)) return other;
  }
  const double farthest = b.has_soil ? shortest_edge(soil.grid, cell) : soil.reach;
  for (const double share : {0.25, 0.5, 0.75, 1.0}) {
    const std::int32_t ahead = soil.grid.locate(b.x + share * farthest * b.normal, cell);
    if (ahead >= 0 && soil.has_points(ahead)) return ahead;
  }
  return cell;
}

template <int dim>
void BoundaryPoints<dim>::find_cells(const SoilSurface<dim>& soil) {
  for (Point& b : points_) b.cell = find_cell(soil, b);
  cells_found_ = true;
}

template <int dim>
std::vector<std::int32_t> BoundaryPoints<dim>::find_nodes(const SoilSurface<dim>& soil) {
  std::vector<std::int32_t> nodes;
  if (rank_of(soil.comm) != 0) return nodes;
  find_cells(soil);
  for (const Point& b : points_) {
    if (b.cell < 0 || !soil.has_points(b.cell)) continue;
    const CellList of_cell = soil.grid.cell(b.cell);
    nodes.insert(nodes.end(), of_cell.begin(), of_cell.end());
  }
  return nodes;
}

template <int dim>
void BoundaryPoints<dim>::begin_step(const SoilSurface<dim>& soil) {
  touching_.clear();
  dt_ = soil.dt;
  law_.friction = friction_ / soil.strength_factor;
  if (rank_of(soil.comm) != 0) return;
  if (!cells_found_) find_cells(soil);
  cells_found_ = false;
  nodes_per_cell_ = soil.grid.nodes_per_cell();
  ShapeValues<dim> shape;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    Point& b = points_[k];
    b.trial = {};
    b.gap_trial.setZero();
    if (b.cell < 0 || !soil.has_points(b.cell)) {
      b.gap.setZero();
      continue;
    }
    shape_functions<dim>(soil.grid.cell_type, soil.grid.local_coordinates(b.cell, b.x), shape);
    std::copy_n(shape.N, nodes_per_cell_, b.N);
    const CellList cell = soil.grid.cell(b.cell);
    for (int i = 0; i < nodes_per_cell_; ++i) b.nodes[i] = soil.nodes.active[cell[i]];
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
void BoundaryPoints<dim>::set_displacement(std::span<const double> displacement, std::size_t) {
  surface_.set_displacement(displacement);
  if (touching_.empty()) return;
  const auto geometry = surface_.geometry();
  for (const std::int32_t k : touching_) {
    Point& b = points_[k];
    b.du = surface_.position(b.facet, b.phi) - b.x;
    b.frame = surface_.frame(b.facet, geometry[b.facet].normal);
  }
}

// Gap and traction of one point; `slope` = -dt/dgap in the frame.
template <int dim>
void BoundaryPoints<dim>::evaluate_point(std::span<const double> du, Point& b,
                                         Matrix<dim>* slope) const {
  Vector<dim> relative = -b.du;
  for (int i = 0; i < nodes_per_cell_; ++i) {
    relative += b.N[i] * Eigen::Map<const Vector<dim>>(du.data() + b.nodes[i] * dim);
  }
  b.gap_trial = b.frame.transpose() * relative;
  if (memory_ == GapMemory::accumulated) b.gap_trial += b.gap;
  b.trial = law_.traction(b.gap_trial, slope);
}

template <int dim>
void BoundaryPoints<dim>::add_forces(std::span<const double> du, std::span<double> r,
                                     BlockMatrix<dim>* K) {
  Matrix<dim> slope;
  for (const std::int32_t k : touching_) {
    Point& b = points_[k];
    evaluate_point(du, b, K ? &slope : nullptr);
    if (!b.trial.closed) continue;
    const Vector<dim> force = b.area * (b.frame * b.trial.t);
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
void BoundaryPoints<dim>::mark_touched(std::span<char> nodes, std::size_t) const {
  for (const std::int32_t k : touching_) {
    const Point& b = points_[k];
    if (!b.trial.closed) continue;
    for (int i = 0; i < nodes_per_cell_; ++i) nodes[b.nodes[i]] = 1;
  }
}

template <int dim>
std::vector<double> BoundaryPoints<dim>::forces_on_structure(std::size_t) const {
  std::vector<double> forces(surface_.num_vertices() * dim, 0.0);
  for (const std::int32_t k : touching_) {
    const Point& b = points_[k];
    if (!b.trial.closed) continue;
    const Vector<dim> force = -b.area * (b.frame * b.trial.t);
    for (int v = 0; v < surface_.vertices_per_facet(); ++v) {
      const std::int32_t vertex = surface_.vertex(b.facet, v);
      Eigen::Map<Vector<dim>>(forces.data() + vertex * dim) += b.phi[v] * force;
    }
  }
  return forces;
}

template <int dim>
ContactResultant<dim> BoundaryPoints<dim>::resultant(std::size_t) const {
  ContactResultant<dim> sum;
  for (const std::int32_t k : touching_) {
    const Point& b = points_[k];
    if (!b.trial.closed) continue;
    sum.add(b.x, -b.area * (b.frame * b.trial.t));
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
    work += 0.5 * motion.dot(b.force + b.area * (b.frame * b.trial.t));
  }
  return work;
}

template <int dim>
ContactCounts BoundaryPoints<dim>::counts(std::size_t) const {
  ContactCounts result;
  for (const std::int32_t k : touching_) {
    const Point& b = points_[k];
    if (!b.trial.closed) continue;
    ++result.closed;
    result.sliding += b.trial.sliding;
    result.penetration = std::max(result.penetration, -b.gap_trial[0]);
  }
  return result;
}

template <int dim>
double BoundaryPoints<dim>::approach_step(double dt, double margin) const {
  double result = std::numeric_limits<double>::infinity();
  for (const std::int32_t k : touching_) {
    const Point& b = points_[k];
    const double before = memory_ == GapMemory::accumulated ? b.gap[0] : 0;
    const double closing = before - b.gap_trial[0];
    if (!(closing > 0)) continue;
    result = std::min(result, dt * (std::max(b.gap_trial[0], 0.0) + margin) / closing);
  }
  return result;
}

template <int dim>
void BoundaryPoints<dim>::mark_closed_points() {
  marks_.clear();
  for (const std::int32_t k : touching_) {
    const Point& b = points_[k];
    if (!b.trial.closed) continue;
    Vector<dim> path = b.gap_trial - b.gap;
    path[0] = 0;
    marks_.push_back({.facet = b.facet,
                      .sliding = b.trial.sliding,
                      .area = b.area,
                      .gap = b.gap_trial[0],
                      .x = surface_.position(b.facet, b.phi),
                      .normal = b.frame.col(0),
                      .force = -b.area * (b.frame * b.trial.t),
                      .slip = b.frame * path / dt_});
  }
}

template <int dim>
ContactFields<dim> BoundaryPoints<dim>::fields(const MaterialPoints<dim>&, double,
                                               std::size_t) const {
  ContactFields<dim> fields(vertices_, surface_.num_facets());
  for (const ContactMark<dim>& mark : marks_) {
    fields.add(static_cast<std::size_t>(mark.facet), 1, mark);
  }
  if (memory_ == GapMemory::step) return fields;
  for (const Point& b : points_) {
    if (b.has_soil) fields.gap[b.facet] = std::min(fields.gap[b.facet], b.gap[0]);
  }
  return fields;
}

template <int dim>
void BoundaryPoints<dim>::accept() {
  mark_closed_points();
  vertices_ = surface_.positions();
  const auto geometry = surface_.geometry();
  for (Point& b : points_) {
    b.normal = geometry[b.facet].normal;
    b.x = surface_.position(b.facet, b.phi);
    b.force = b.area * (b.frame * b.trial.t);
    b.has_soil = false;
  }
  for (const std::int32_t k : touching_) points_[k].has_soil = true;
  if (memory_ == GapMemory::step) return;
  for (const std::int32_t k : touching_) {
    Point& b = points_[k];
    const double normal = b.gap_trial[0];
    b.gap = b.gap_trial;
    if (b.trial.sliding) {  // the part beyond the friction limit has slid for good
      b.gap = -b.trial.t / law_.tangential_penalty;
    } else if (!b.trial.closed) {
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
  visitor.reals(prefix + "vertices", flat(vertices_));
  visit_marks<dim>(visitor, prefix, surface_.num_facets(), marks_);
  for (std::size_t k = 0; k < points_.size(); ++k) {
    points_[k].cell = cells[k];
    points_[k].has_soil = with_soil[k] != 0;
  }
}

template class BoundaryPoints<2>;
template class BoundaryPoints<3>;

}  // namespace gabion::mpm
