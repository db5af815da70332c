// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/contact/contact.hpp"
#include "mpm_solver/contact/moving_surface.hpp"

namespace gabion::mpm {

/// Boundary points on the surface of a structure: the displacement of the grid at each point is
/// held to the displacement of the surface by a penalty (docs/theory/interface.md).
///
///     g = g_n + sum_i N_i du_i - du_surface ,  t = -penalty g ,  f_i = sum_b N_i t_b A_b
///
/// The condition (closed, sliding) is decided inside the Newton loop. The opposite of t acts on the
/// structure at the same point, so force and moment are equal on both sides. The first rank
/// carries them all.
template <int dim>
class BoundaryPoints final : public WholeContact<dim> {
 public:
  BoundaryPoints(const ContactSettings<dim>& settings, const BoundaryPointSettings& method);

  /// Find the soil of each boundary point at its accepted position: that of the point's cell (on a
  /// facet of the grid, of a cell with soil). If this cell holds none, that of the nearest cell in
  /// front of the point is taken, within soil.reach, or within one cell size for a point that had
  /// soil in the step before. The basis functions of such a cell are continued to the point. So a
  /// wall that recedes across a line of the grid keeps its soil.
  void begin_step(const SoilSurface<dim>& soil) override;
  bool asks_for_cells() const override { return true; }
  std::vector<std::int32_t> find_nodes(const SoilSurface<dim>& soil) override;
  bool can_touch(std::size_t = 0) const override { return !touching_.empty(); }
  bool symmetric() const override { return !law_.has_friction(); }
  void append_cells(std::vector<std::int32_t>& offsets,
                    std::vector<std::int32_t>& nodes) const override;

  void set_displacement(std::span<const double> displacement, std::size_t = 0) override;
  void add_forces(std::span<const double> du, std::span<double> r, BlockMatrix<dim>* K) override;
  void mark_touched(std::span<char> nodes, std::size_t = 0) const override;

  std::vector<double> forces_on_structure(std::size_t = 0) const override;
  ContactResultant<dim> resultant(std::size_t = 0) const override;
  double work_on_soil(std::span<const double> du) const override;
  ContactCounts counts(std::size_t = 0) const override;
  double approach_step(double dt, double margin) const override;

  void accept() override;
  /// Gaps are those that the law sees: known where a boundary point has soil.
  ContactFields<dim> fields(const MaterialPoints<dim>& points, double reach,
                            std::size_t = 0) const override;
  std::span<const ContactMark<dim>> marks(std::size_t = 0) const override { return marks_; }
  void visit_state(StateVisitor& visitor, const std::string& prefix) override;

 private:
  struct Point {
    std::int32_t facet = 0;
    std::array<double, 4> phi{};               // weights of the facet's vertices
    double area = 0;                           // share of the reference surface [m^2] (2D: m)
    Vector<dim> x = Vector<dim>::Zero();       // accepted position
    Vector<dim> normal = Vector<dim>::Zero();  // accepted, of the facet, into the soil
    std::int32_t cell = -1;                 // of the grid, with its soil; hint for the next search
    bool has_soil = false;                  // accepted
    Vector<dim> gap = Vector<dim>::Zero();  // accepted, in the facet's frame (normal first)
    Vector<dim> force = Vector<dim>::Zero();  // accepted, on the soil [N]
    // of the current step
    std::int32_t nodes[max_cell_nodes] = {};  // active ones
    double N[max_cell_nodes] = {};
    Matrix<dim> frame = Matrix<dim>::Identity();  // columns: normal, tangents
    Vector<dim> du = Vector<dim>::Zero();         // of the surface
    Vector<dim> gap_trial = Vector<dim>::Zero();
    ContactTraction<dim> trial{};  // in the frame
  };

  void mark_closed_points();
  void evaluate_point(std::span<const double> du, Point& b, Matrix<dim>* slope) const;
  void find_cells(const SoilSurface<dim>& soil);
  std::int32_t find_cell(const SoilSurface<dim>& soil, const Point& b) const;

  MovingSurface<dim> surface_;
  double friction_ = -1;  // as in ContactLaw, of full strength
  ContactLaw law_;
  GapMemory memory_;
  double dt_ = 0;  // of the current step
  std::vector<Point> points_;
  std::vector<ContactMark<dim>> marks_;  // of the accepted step
  std::vector<Vector<dim>> vertices_;    // accepted
  bool cells_found_ = false;             // for the coming step
  std::vector<std::int32_t> touching_;   // points with soil; none but on the first rank
  int nodes_per_cell_ = 0;
};

}  // namespace gabion::mpm
