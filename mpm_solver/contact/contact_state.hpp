// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "common/mechanics/ranks/packet.hpp"
#include "common/run/state.hpp"
#include "mpm_solver/contact/contact_fields.hpp"
#include "mpm_solver/contact/soil_surface.hpp"

namespace gabion::mpm {

/// Energy that soil and surface put into their contact, by its use [J].
struct ContactEnergy {
  double stored = 0;    ///< in the penalty springs, can come back
  double friction = 0;  ///< dissipated by sliding, since the start
  double loss = 0;      ///< taken by impacts and the time law since the start, less what they gave

  /// @param work    of soil and surface on the contact in a step
  /// @param stored_now, slid  energy at its end, friction in it
  void add_step(double work, double stored_now, double slid);
};

/// The accepted state of a contact: how it begins, what it holds, and how it is saved and moved to
/// other ranks.
template <int dim>
class ContactState {
 public:
  virtual ~ContactState() = default;

  /// From now on soil that is in contact with the surface as the run begins presses on it with its
  /// stress there: forces, counts and energy are those of soil that has not moved. Spheres of soil
  /// that was laid against the surface reach it, with stress or without. Methods that cannot do
  /// this ignore the call. Collective over the soil's ranks.
  /// @pre begin_step and set_displacement for the start of the run
  virtual void begin_at_rest(const SoilAtRest<dim>& rest) { static_cast<void>(rest); }

  /// Energy that contact stores and has lost.
  virtual ContactEnergy energy() const { return {}; }
  /// Action of this rank's soil on each facet of a member.
  /// @param points  of this rank, accepted
  /// @param reach   how far to look for gaps [m]
  virtual ContactFields<dim> fields(const MaterialPoints<dim>& points, double reach,
                                    std::size_t member = 0) const = 0;
  /// Places where this rank's soil was in contact with a member.
  virtual std::span<const ContactMark<dim>> marks(std::size_t member = 0) const = 0;
  /// Positions of the vertices of a member [m]; empty: it acts no more, or the method has no
  /// facets.
  virtual std::span<const Vector<dim>> accepted_vertices(std::size_t) const { return {}; }

  /// Material points move to another rank: put what this contact remembers of them into the packet,
  /// and forget it. @param ids  of the points
  virtual void give(std::span<const std::int64_t> ids, Packet& packet) {
    static_cast<void>(ids), static_cast<void>(packet);
  }
  /// Remember what the contact of another rank gave.
  virtual void take(Packet& packet) { static_cast<void>(packet); }
  /// Save or load the state. Names begin with `prefix`.
  virtual void visit_state(StateVisitor& visitor, const std::string& prefix) = 0;
};

}  // namespace gabion::mpm
