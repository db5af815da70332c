// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/mechanics/ranks/packet.hpp"
#include "common/mechanics/tensor.hpp"
#include "common/run/state.hpp"
#include "mpm_solver/contact/front_features.hpp"
#include "mpm_solver/contact/index_table.hpp"

namespace gabion::mpm {

/// Memory of a contact point of the accepted state.
template <int dim>
struct RememberedContact {
  std::int32_t owner = 0;                    ///< member of the contact that has the facet
  Vector<dim> normal = Vector<dim>::Zero();  ///< of length 1, into the soil
  Vector<dim> force = Vector<dim>::Zero();   ///< of the last step, on the soil [N]
  Vector<dim> slip = Vector<dim>::Zero();    ///< elastic; along -normal the initial penetration [m]
  double part = 1;                           ///< of the tangential stiffness, in which the slip is
  Vector<dim> lasting = Vector<dim>::Zero();  ///< part of the force that has lasted [N]
  bool took_weight = false;                   ///< the contact began in a step in which soil took
                                              ///< its weight
  /// Its facet left the surface. Its force still belongs to the acceleration of the accepted state;
  /// nothing else of it counts any more.
  bool gone = false;

  /// Initial penetration [m].
  double initial_penetration() const { return -normal.dot(slip); }
  Vector<dim> tangential() const { return slip + initial_penetration() * normal; }
};

/// Memory of the contact points of one material point.
template <int dim>
using RememberedContacts = std::vector<RememberedContact<dim>>;

/// Whether the contacts of a point began in a step in which soil took its weight.
/// @param contacts  may be null
/// @param now       of a point without any, whose facet is still there
template <int dim>
bool took_weight(const RememberedContacts<dim>* contacts, bool now) {
  for (std::size_t k = 0; contacts && k < contacts->size(); ++k) {
    if (!(*contacts)[k].gone) return (*contacts)[k].took_weight;
  }
  return now;
}

/// Add those whose facets are still there. @param contacts  may be null
template <int dim>
void add_known(const RememberedContacts<dim>* contacts, std::vector<KnownContact<dim>>& known) {
  for (std::size_t k = 0; contacts && k < contacts->size(); ++k) {
    const auto& contact = (*contacts)[k];
    if (!contact.gone) known.push_back({contact.owner, contact.normal});
  }
}

inline constexpr std::int32_t any_owner = -1;

/// The contact that continues with this normal; null: none does.
/// @param contacts  may be null
template <int dim>
const RememberedContact<dim>* going_on(const RememberedContacts<dim>* contacts,
                                       const Vector<dim>& normal, std::int32_t owner = any_owner) {
  if (!contacts) return nullptr;
  const RememberedContact<dim>* best = nullptr;
  double largest = same_normal;
  for (const auto& contact : *contacts) {
    if (contact.gone || (owner != any_owner && contact.owner != owner)) continue;
    if (contact.normal.dot(normal) <= largest) continue;
    largest = contact.normal.dot(normal);
    best = &contact;
  }
  return best;
}

/// Memory of contact by facets of the material points of a rank, by their ids: their contact
/// points, how far their contact spheres are off from them, and the shapes of those spheres that
/// deform.
template <int dim>
class ContactMemory {
 public:
  using Contacts = RememberedContacts<dim>;
  /// Contacts and offset of a point; null: none.
  struct Known {
    const Contacts* contacts = nullptr;
    const Vector<dim>* offset = nullptr;
  };

  /// The contacts of a point; null: none.
  const Contacts* contacts(std::int64_t id) const;
  Contacts& add(std::int64_t id) { return contacts_[id]; }
  /// Points of which make_index() found contacts or an offset.
  std::int32_t num_known() const { return index_.size(); }
  /// Hands out all contacts and forgets them.
  std::map<std::int64_t, Contacts> take_contacts() { return std::exchange(contacts_, {}); }
  /// Offset of a contact sphere from its point [m].
  Vector<dim> offset(std::int64_t id) const;
  std::map<std::int64_t, Vector<dim>>& offsets() { return offsets_; }
  /// The offset with which the sphere was laid [m]; zero once it has gone back to its point.
  Vector<dim> laid_offset(std::int64_t id) const;
  std::map<std::int64_t, Vector<dim>>& laid_offsets() { return laid_offsets_; }
  /// |shape^T n| is the radius in direction n [m].
  /// @param depth  of the point in the cell that it was laid in [m]
  Matrix<dim> shape(std::int64_t id, double depth) const;
  std::map<std::int64_t, Matrix<dim>>& shapes() { return shapes_; }

  /// Prepare known(): contacts and offsets do not change until it is called again.
  void make_index();
  Known known(std::int64_t id) const;

  /// Sum of the forces on these points, one member after the other [N].
  Vector<dim> force_on(std::span<const std::int64_t> ids, std::size_t num_members) const;
  /// Forget the contacts with a member; a contact sphere without other contacts goes back to its
  /// point.
  void forget_member(std::int32_t member);
  /// The facet of a contact left: that of a member with exactly this normal, if the point is here.
  void leave(std::int64_t id, std::int32_t member, const Vector<dim>& normal);
  void give(std::span<const std::int64_t> ids, Packet& packet);
  void take(Packet& packet);
  /// @throws Error  a saved member is none of num_members
  void visit_state(StateVisitor& visitor, const std::string& prefix, std::size_t num_members);

 private:
  void visit_contacts(StateVisitor& visitor, const std::string& prefix, std::size_t num_members);

  std::map<std::int64_t, Contacts> contacts_;
  std::map<std::int64_t, Vector<dim>> offsets_, laid_offsets_;
  std::map<std::int64_t, Matrix<dim>> shapes_;
  IndexTable<1> index_;       // ids of points with contacts or offset
  std::vector<Known> known_;  // of them
};

}  // namespace gabion::mpm
