// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/run/solver.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"

namespace gabion::mpm {

/// The soil's copy of a structure's surface.
template <int dim>
struct ContactSurface {
  std::vector<Vector<dim>> vertices;  ///< [m], reference configuration
  CellType facet_type = CellType::line2;
  std::vector<std::int32_t> facets;  ///< normals point out of the structure, into the soil
};

enum class ContactMode {
  fixed,    ///< soil holds to the surface in all directions, in tension too
  contact,  ///< only while the gap is closed; then sticks, or slides when friction is exceeded
  slip,     ///< only while the gap is closed; normal direction only
};

/// What the penalty acts on.
enum class GapMemory {
  accumulated,  ///< gap since soil came into the point's cell: force independent of the step size
  step,         ///< displacement of this step only: the force depends on the step size
};

template <int dim>
struct ContactSettings {
  std::string name;  ///< of the interface
  ContactSurface<dim> surface;
  ContactMode mode = ContactMode::contact;
  GapMemory memory = GapMemory::accumulated;
  double penalty = 0;           ///< [Pa/m] > 0
  double friction = -1;         ///< coefficient in mode contact; < 0: unlimited (stick)
  double tangential_share = 1;  ///< of the penalty in tangential directions, in (0, 1]
  int points_per_facet = 2;
};

/// Boundary points on the surface of a structure: the displacement of the grid at each point is
/// held to the displacement of the surface by a penalty (docs/theory/interface.md).
///
///     g = g_n + sum_i N_i du_i - du_surface ,  t = -penalty g ,  f_i = sum_b N_i t_b A_b
///
/// The condition (closed, sliding) is decided inside the Newton loop. The opposite of t acts on the
/// structure at the same point, so force and moment are equal on both sides.
template <int dim>
class BoundaryPoints {
 public:
  explicit BoundaryPoints(ContactSettings<dim> settings);

  InterfaceMesh interface_mesh() const;
  const std::string& name() const { return settings_.name; }

  /// Start a step: find the soil of each boundary point at its accepted position. It is that of the
  /// point's cell (of several, on a facet of the grid, one with soil); where that holds none, that
  /// of the nearest cell in front of the point, within `reach`, or within one cell size for a point
  /// that had soil in the step before. The basis functions of such a cell are
  /// continued to the point. So a wall that recedes over a line of the grid does not lose its soil.
  /// @param occupied  1 for cells of the grid that hold a material point (on any rank)
  /// @param reach     how far soil extends beyond its material points [m]
  void begin_step(const BackgroundGrid<dim>& grid, const GridNodes<dim>& nodes,
                  std::span<const std::int32_t> occupied, double reach);
  /// Whether any boundary point has soil: otherwise no force can arise in this step.
  bool can_touch() const { return !touching_.empty(); }
  /// Whether sliding with friction makes the stiffness unsymmetric.
  bool has_friction() const { return settings_.friction > 0; }
  /// Cells that carry contact terms, as lists of active nodes (for the matrix pattern).
  void append_cells(std::vector<std::int32_t>& offsets, std::vector<std::int32_t>& nodes) const;

  /// Displacement of the surface at the end of the step, num_vertices x dim, from the reference.
  void set_displacement(std::span<const double> displacement);

  /// Add the contact force to r and its stiffness -df/du to K (may be null).
  void add_forces(std::span<const double> du, std::span<double> r, BlockMatrix<dim>* K);

  /// Nodal forces of the soil on the structure in the state of the last add_forces, num_vertices x
  /// dim.
  std::vector<double> forces_on_structure() const;
  /// Their sum, and the sum of their moments about the origin, at the positions of the points at
  /// the start of the step.
  struct Resultant {
    Vector<dim> force = Vector<dim>::Zero();                                 ///< [N]
    Vector<dim == 2 ? 1 : 3> moment = Vector < dim == 2 ? 1 : 3 > ::Zero();  ///< [N m]
  };
  Resultant resultant() const;
  /// Work on the soil in this step by the trapezoidal rule, from the forces of the accepted state
  /// and those of the last add_forces [J].
  double work_on_soil(std::span<const double> du) const;
  int num_closed() const;
  int num_sliding() const;
  double max_penetration() const;  ///< [m]
  /// Largest next step [s] in which no boundary point goes deeper into the soil than `margin` [m],
  /// where it is open beyond its gap, each at its speed in the step under way, of length dt;
  /// infinite when none comes nearer. @pre add_forces was called
  double approach_step(double dt, double margin) const;

  void accept();

  /// Save or load the accepted state of the points. Names begin with `prefix`.
  void visit_state(StateVisitor& visitor, const std::string& prefix);

 private:
  struct Point {
    std::int32_t facet = 0;
    double phi[4] = {};                        // weights of the facet's vertices
    double area = 0;                           // share of the reference surface [m^2] (2D: m)
    Vector<dim> x = Vector<dim>::Zero();       // accepted position
    Vector<dim> normal = Vector<dim>::Zero();  // accepted, of the facet, into the soil
    std::int32_t cell = -1;                 // of the grid, with its soil; hint for the next search
    bool has_soil = false;                  // accepted
    Vector<dim> gap = Vector<dim>::Zero();  // accepted, in the facet's frame (normal first)
    Vector<dim> force = Vector<dim>::Zero();  // accepted, on the soil [N]
    // of the step under way
    std::int32_t nodes[max_cell_nodes] = {};  // active ones
    double N[max_cell_nodes] = {};
    Matrix<dim> frame = Matrix<dim>::Identity();  // columns: normal, tangents
    Vector<dim> du = Vector<dim>::Zero();         // of the surface
    Vector<dim> gap_trial = Vector<dim>::Zero();
    Vector<dim> traction = Vector<dim>::Zero();  // on the soil, in the frame
    bool closed = false;
    bool sliding = false;
  };

  void evaluate_point(std::span<const double> du, Point& b, Matrix<dim>* slope) const;
  Vector<dim> position(const Point& b) const;
  std::int32_t find_cell(const BackgroundGrid<dim>& grid, std::span<const std::int32_t> occupied,
                         double reach, const Point& b) const;
  void set_normals();
  Matrix<dim> frame(std::int32_t facet, const Vector<dim>& n) const;

  ContactSettings<dim> settings_;
  int vertices_per_facet_ = 2;
  std::vector<Point> points_;
  std::vector<std::int32_t> touching_;     // points with soil
  std::vector<Vector<dim>> vertices_now_;  // at the end of the step under way
  int nodes_per_cell_ = 0;
};

}  // namespace gabion::mpm
