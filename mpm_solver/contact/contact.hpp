// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/ranks/packet.hpp"
#include "common/run/state.hpp"
#include "mpm_solver/contact/contact_fields.hpp"
#include "mpm_solver/contact/contact_settings.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/points/laid_sides.hpp"

namespace gabion::mpm {

/// What a step shows a contact of the soil, at the accepted positions.
template <int dim>
struct SoilSurface {
  const BackgroundGrid<dim>& grid;
  const GridNodes<dim>& nodes;        ///< active ones
  const MaterialPoints<dim>& points;  ///< of this rank
  const PointWeights<dim>& weights;   ///< of this rank's points
  /// 1 for grid cells with a point of any rank; on the first rank, where a contact asks_for_cells
  const SparseList<char>* occupied = nullptr;
  bool has_points(std::int32_t cell) const { return (*occupied)[cell] != 0; }
  double reach = 0;                  ///< how far soil extends beyond its points [m]
  double cell_size = 0;              ///< mean [m]
  double dt = 0;                     ///< of the step [s]
  double step_force_weight = 1;      ///< of NewmarkBossak; quasi-static: 1
  std::span<const char> elastic{};   ///< 1 for bodies that never yield
  std::span<const double> moduli{};  ///< of P waves, of the bodies [Pa]
  /// Soil takes its weight in the step: it is quasi-static, or gravity grows. New contacts are then
  /// as stiff as the pressures of that weight ask for.
  bool takes_weight = false;
  std::span<const double> weights_of{};  ///< pressure under each body by its own weight [Pa]
  /// Pressure of pore water that drains at the points when the step begins, -infinity of others
  /// [Pa]; empty: none drains.
  std::span<const double> pore_pressures{};
  Vector<dim> water_weight = Vector<dim>::Zero();  ///< of that water, rho_w g [N/m^3]
  MPI_Comm comm = MPI_COMM_SELF;                   ///< of the ranks that share the soil
};

/// Counts of the contact points after the last add_forces.
struct ContactCounts {
  int closed = 0;          ///< places that carry force, or carried it in a substep
  int sliding = 0;         ///< of them, those at the friction limit
  double penetration = 0;  ///< largest [m]
};

/// Energy that soil and surface put into their contact, by where it went [J].
struct ContactEnergy {
  double stored = 0;    ///< in the penalty springs, can come back
  double friction = 0;  ///< dissipated by sliding, since the start
  double loss = 0;      ///< taken by impacts and the time law since the start, less what they gave

  /// @param work    of soil and surface on the contact in a step
  /// @param stored_now, slid  energy at its end, friction in it
  void add_step(double work, double stored_now, double slid);
};

/// Soil as it was laid when the run begins.
template <int dim>
struct SoilAtRest {
  /// Sides that a point was laid at.
  std::function<std::vector<LaidSide<dim>>(std::int32_t body, std::int64_t id)> sides;
  /// 1 for bodies under stress. The others lie on a surface and do not press on it.
  std::vector<char> is_stressed;
  /// Cauchy stresses of a body under stress along the axes at a place [Pa].
  std::function<Vector<dim>(std::int32_t body, const Vector<dim>& x)> stress;
  /// Soil that is farther from a surface does not lie on it [m].
  double deepest_row = std::numeric_limits<double>::infinity();
};

/// One or several surfaces, its members, that touch the soil: between them act equal and opposite
/// forces, by a method of their own. A step: begin_step; then set_displacement and add_forces as
/// often as wanted; then accept, or the next begin_step. Forces, counts and energies are those that
/// this rank carries: their sums over the ranks are those of the contact.
template <int dim>
class Contact {
 public:
  Contact() = default;
  Contact(const Contact&) = delete;
  Contact& operator=(const Contact&) = delete;
  Contact(Contact&&) = delete;
  Contact& operator=(Contact&&) = delete;
  virtual ~Contact() = default;

  /// Whether it reads SoilSurface::occupied.
  virtual bool asks_for_cells() const { return false; }
  /// Grid nodes that the coming step needs here besides those of this rank's material points.
  /// @param soil  without weights and nodes as yet
  virtual std::vector<std::int32_t> find_nodes(const SoilSurface<dim>& soil) {
    static_cast<void>(soil);
    return {};
  }
  /// Start a step from the accepted state: find the soil that the surface can touch in it.
  /// Collective over soil.comm.
  virtual void begin_step(const SoilSurface<dim>& soil) = 0;
  /// Whether a force can arise in this step.
  virtual bool can_touch(std::size_t member = 0) const = 0;
  /// Whether the stiffness of this step is symmetric.
  virtual bool symmetric() const = 0;
  /// Cells that carry contact terms, as lists of active nodes (for the matrix pattern).
  virtual void append_cells(std::vector<std::int32_t>& offsets,
                            std::vector<std::int32_t>& nodes) const = 0;

  /// Displacement of a member at the end of the step, num_vertices x dim, from the reference.
  virtual void set_displacement(std::span<const double> displacement, std::size_t member = 0) = 0;
  /// Add the contact force, as the balance at the end of the step sees it, to r and its stiffness
  /// -df/du to K (may be null).
  virtual void add_forces(std::span<const double> du, std::span<double> r, BlockMatrix<dim>* K) = 0;

  // Substeps of an explicit step: begin_substeps, then for each one set_share, add_forces with the
  // motion since the start of the step, add_substep; at last add_forces with the motion of the
  // whole step. Forces on the structure and their resultant are then means over the substeps.

  /// Add the force that has lasted up to the accepted state, to which substeps look ahead: at rest
  /// that of the contact [N].
  virtual void add_lasting_forces(std::span<double>) const {}
  virtual void begin_substeps() {}
  /// Move the surfaces to their places at this share of the step, on the line to that of
  /// set_displacement.
  virtual void set_share(double) {}
  /// The forces of the last add_forces acted over this share of the step.
  /// @param move  of the soil in that time [m], num_nodes x dim
  virtual void add_substep(std::span<const double> move, double share) {
    static_cast<void>(move);
    static_cast<void>(share);
  }
  /// Add the row sums of the stiffness of the last add_forces, sum_j |K_ij|, its places counted one
  /// by one: num_nodes [N/m].
  virtual void add_stiffness_sums(std::span<double>) const {}
  /// Set the active nodes that act on the points which a member touched in the last add_forces
  /// to 1.
  virtual void mark_touched(std::span<char> nodes, std::size_t member = 0) const {
    static_cast<void>(nodes), static_cast<void>(member);
  }

  // All of the following are those of the last add_forces.

  /// Nodal forces of the soil on the structure, num_vertices of the member x dim [N].
  virtual std::vector<double> forces_on_structure(std::size_t member = 0) const = 0;
  /// Their sum, and the sum of their moments about the origin, at the positions at the start of the
  /// step.
  struct Resultant {
    Vector<dim> force = Vector<dim>::Zero();                                 ///< [N]
    Vector<dim == 2 ? 1 : 3> moment = Vector < dim == 2 ? 1 : 3 > ::Zero();  ///< [N m]

    void add(const Vector<dim>& x, const Vector<dim>& f) {
      force += f;
      if constexpr (dim == 2) {
        moment[0] += x[0] * f[1] - x[1] * f[0];
      } else {
        moment += x.cross(f);
      }
    }
  };
  virtual Resultant resultant(std::size_t member = 0) const = 0;
  virtual std::size_t num_members() const { return 1; }
  /// Work on the soil in this step by the trapezoidal rule, from the forces of the accepted state
  /// and the present ones [J].
  virtual double work_on_soil(std::span<const double> du) const = 0;
  virtual ContactCounts counts(std::size_t member = 0) const = 0;
  /// Whether the force is constant in a step, see NewmarkBossak::step_force_weight. The resultant
  /// is then that force, not what add_forces added.
  virtual bool is_step_force() const { return false; }
  /// A step force: add F - F_o, its change since the step before, to a nodal field [N].
  virtual void add_step_force_change(std::span<double>) const {}
  /// The step force on these material points of this rank, in the accepted state [N].
  virtual Vector<dim> step_force_on(std::span<const std::int64_t> ids) const {
    static_cast<void>(ids);
    return Vector<dim>::Zero();
  }
  /// Search margin: how far beyond twice its displacement by the velocity of fastest_about a
  /// material point of this rank may move before the candidates of begin_step may be incomplete
  /// [m]; infinite: the method does not look ahead.
  virtual double allowed_motion(std::size_t member = 0) const {
    static_cast<void>(member);
    return std::numeric_limits<double>::infinity();
  }
  /// Largest next step [s] in which the surface goes no deeper into the soil than `margin` [m],
  /// where it is open beyond its gap, at its speed in the step under way, of length dt; infinite
  /// when it comes no nearer.
  virtual double approach_step(double dt, double margin) const = 0;

  /// Soil that touches the surface as the run begins presses on it with its stress there, from now
  /// on: forces, counts and energy are those of soil that has not moved. Spheres of soil that was
  /// laid against the surface reach it, with stress or without. Without effect where a method
  /// cannot. Collective over the soil's ranks.
  /// @pre begin_step and set_displacement for the start of the run
  virtual void begin_at_rest(const SoilAtRest<dim>& rest) { static_cast<void>(rest); }
  /// Positions of the vertices of a member in the accepted state [m]; empty: it acts no more, or
  /// the method has no facets.
  virtual std::span<const Vector<dim>> accepted_vertices(std::size_t) const { return {}; }
  /// Make the end of the step the accepted state.
  virtual void accept() = 0;
  /// Energy that contact stores and has lost, in the accepted state.
  virtual ContactEnergy energy() const { return {}; }
  /// Let a member act no more, what its springs hold is lost; or act again, from a state that is
  /// loaded next. @returns false: the method cannot, the contact has to be replaced
  virtual bool drop(std::size_t member, bool dropped) {
    static_cast<void>(member), static_cast<void>(dropped);
    return false;
  }
  /// What this rank's soil does to each facet of a member, in the accepted state.
  /// @param points  of this rank, accepted
  /// @param reach   how far to look for gaps [m]
  virtual ContactFields<dim> fields(const MaterialPoints<dim>& points, double reach,
                                    std::size_t member = 0) const = 0;
  /// Places where this rank's soil touched a member, in the accepted state.
  virtual std::span<const ContactMark<dim>> marks(std::size_t member = 0) const = 0;
  /// Material points move to another rank: put what this contact remembers of them into the packet,
  /// and forget it. @param ids  of the points
  virtual void give(std::span<const std::int64_t> ids, Packet& packet) {
    static_cast<void>(ids), static_cast<void>(packet);
  }
  /// Remember what the contact of another rank gave.
  virtual void take(Packet& packet) { static_cast<void>(packet); }
  /// Save or load the accepted state. Names begin with `prefix`.
  virtual void visit_state(StateVisitor& visitor, const std::string& prefix) = 0;
};

template <int dim>
using Contacts = std::vector<std::unique_ptr<Contact<dim>>>;

/// The contact of the method that the settings ask for.
template <int dim>
std::unique_ptr<Contact<dim>> make_contact(const ContactSettings<dim>& settings);

/// One contact of surfaces that all have the method `facets`: what a point touches is searched as
/// if they were one surface.
/// @param members  not empty
template <int dim>
std::unique_ptr<Contact<dim>> make_joint_contact(
    const std::vector<const ContactSettings<dim>*>& members);

}  // namespace gabion::mpm
