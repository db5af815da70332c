// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/contact_memory.hpp"

#include <algorithm>
#include <functional>

#include "common/base/require.hpp"
#include "common/run/list_lengths.hpp"

namespace gabion::mpm {

namespace {

// Save or load the lists `name`_ids and `name`s.
template <typename Value>
void visit_by_id(StateVisitor& visitor, const std::string& name,
                 std::map<std::int64_t, Value>& by_id) {
  constexpr int size = Value::SizeAtCompileTime;
  std::vector<std::int64_t> ids;
  std::vector<double> values;
  for (const auto& [id, value] : by_id) {
    ids.push_back(id);
    values.insert(values.end(), value.data(), value.data() + size);
  }
  visitor.list(name + "_ids", ids);
  visitor.list(name + "s", values);
  require_values_each(name + "s", values.size(), ids.size(), size);
  by_id.clear();
  for (std::size_t k = 0; k < ids.size(); ++k) {
    by_id[ids[k]] = Eigen::Map<const Value>(values.data() + k * size);
  }
}

// The value of a point; zero where there is none.
template <int dim>
Vector<dim> vector_of(const std::map<std::int64_t, Vector<dim>>& by_id, std::int64_t id) {
  const auto found = by_id.find(id);
  return found == by_id.end() ? Vector<dim>(Vector<dim>::Zero()) : found->second;
}

// Put what is known of these points into the packet.
template <typename Value>
void give_by_id(std::span<const std::int64_t> ids, std::map<std::int64_t, Value>& by_id,
                const std::function<void(const Value&)>& put, Packet& packet) {
  std::int64_t count = 0;
  for (const std::int64_t id : ids) count += by_id.contains(id) ? 1 : 0;
  packet.put(count);
  for (const std::int64_t id : ids) {
    const auto found = by_id.find(id);
    if (found == by_id.end()) continue;
    packet.put(id);
    put(found->second);
    by_id.erase(found);
  }
}

template <typename Value>
void take_by_id(Packet& packet, std::map<std::int64_t, Value>& by_id,
                const std::function<Value()>& take) {
  for (auto count = packet.take<std::int64_t>(); count > 0; --count) {
    const auto id = packet.take<std::int64_t>();
    by_id[id] = take();
  }
}

}  // namespace

template <int dim>
auto ContactMemory<dim>::contacts(std::int64_t id) const -> const Contacts* {
  const auto found = contacts_.find(id);
  return found == contacts_.end() ? nullptr : &found->second;
}

template <int dim>
Vector<dim> ContactMemory<dim>::offset(std::int64_t id) const {
  return vector_of<dim>(offsets_, id);
}

template <int dim>
Vector<dim> ContactMemory<dim>::laid_offset(std::int64_t id) const {
  return vector_of<dim>(laid_offsets_, id);
}

template <int dim>
Matrix<dim> ContactMemory<dim>::shape(std::int64_t id, double depth) const {
  const auto found = shapes_.find(id);
  return found == shapes_.end() ? Matrix<dim>(depth * Matrix<dim>::Identity()) : found->second;
}

template <int dim>
void ContactMemory<dim>::make_index() {
  index_.clear();
  known_.clear();
  const auto entry = [this](std::int64_t id) -> Known& {
    const auto k = static_cast<std::size_t>(index_.add({id}));
    known_.resize(static_cast<std::size_t>(index_.size()));
    return known_[k];
  };
  for (const auto& [id, contacts] : contacts_) entry(id).contacts = &contacts;
  for (const auto& [id, offset] : offsets_) entry(id).offset = &offset;
}

template <int dim>
auto ContactMemory<dim>::known(std::int64_t id) const -> Known {
  const std::int32_t k = index_.find({id});
  return k < 0 ? Known{} : known_[k];
}

template <int dim>
Vector<dim> ContactMemory<dim>::force_on(std::span<const std::int64_t> ids,
                                         std::size_t num_members) const {
  std::vector<Vector<dim>> sums(num_members, Vector<dim>::Zero());
  for (const std::int64_t id : ids) {
    const auto found = contacts_.find(id);
    if (found == contacts_.end()) continue;
    for (const auto& contact : found->second) sums[contact.owner] += contact.force;
  }
  Vector<dim> sum = Vector<dim>::Zero();
  for (const Vector<dim>& force : sums) sum += force;
  return sum;
}

template <int dim>
void ContactMemory<dim>::forget_member(std::int32_t member) {
  for (auto entry = contacts_.begin(); entry != contacts_.end();) {
    auto& [id, contacts] = *entry;
    const auto forgotten =
        std::erase_if(contacts, [member](const auto& contact) { return contact.owner == member; });
    if (forgotten > 0 && contacts.empty()) offsets_.erase(id);
    entry = contacts.empty() ? contacts_.erase(entry) : std::next(entry);
  }
}

template <int dim>
void ContactMemory<dim>::leave(std::int64_t id, std::int32_t member, const Vector<dim>& normal) {
  const auto entry = contacts_.find(id);
  if (entry == contacts_.end()) return;
  for (auto& contact : entry->second) {
    if (contact.owner != member || contact.normal != normal) continue;
    contact = {.owner = member, .normal = normal, .force = contact.force, .gone = true};
  }
}

template <int dim>
void ContactMemory<dim>::give(std::span<const std::int64_t> ids, Packet& packet) {
  const auto put_contacts = [&packet](const Contacts& contacts) {
    packet.put(std::ssize(contacts));
    for (const auto& contact : contacts) {
      packet.put(contact.owner);
      packet.put(contact.part);
      packet.put(contact.took_weight);
      packet.put(contact.gone);
      for (const Vector<dim>& v : {contact.normal, contact.force, contact.slip, contact.lasting}) {
        packet.put(v);
      }
    }
  };
  give_by_id<Contacts>(ids, contacts_, put_contacts, packet);
  for (auto* vectors : {&offsets_, &laid_offsets_}) {
    give_by_id<Vector<dim>>(
        ids, *vectors, [&](const auto& value) { packet.put(value); }, packet);
  }
  give_by_id<Matrix<dim>>(
      ids, shapes_, [&](const auto& value) { packet.put(value); }, packet);
}

template <int dim>
void ContactMemory<dim>::take(Packet& packet) {
  const auto take_contacts = [&packet] {
    Contacts contacts(static_cast<std::size_t>(packet.take<std::ptrdiff_t>()));
    for (auto& contact : contacts) {
      contact.owner = packet.take<std::int32_t>();
      contact.part = packet.take<double>();
      contact.took_weight = packet.take<bool>();
      contact.gone = packet.take<bool>();
      for (Vector<dim>* v : {&contact.normal, &contact.force, &contact.slip, &contact.lasting}) {
        *v = packet.take<Vector<dim>>();
      }
    }
    return contacts;
  };
  take_by_id<Contacts>(packet, contacts_, take_contacts);
  for (auto* vectors : {&offsets_, &laid_offsets_}) {
    take_by_id<Vector<dim>>(packet, *vectors, [&] { return packet.take<Vector<dim>>(); });
  }
  take_by_id<Matrix<dim>>(packet, shapes_, [&] { return packet.take<Matrix<dim>>(); });
}

template <int dim>
void ContactMemory<dim>::visit_contacts(StateVisitor& visitor, const std::string& prefix,
                                        std::size_t num_members) {
  std::vector<std::int64_t> ids, owners, took_weight;
  std::vector<double> values, parts;
  for (const auto& [id, contacts] : contacts_) {
    for (const auto& contact : contacts) {
      ids.push_back(id);
      owners.push_back(contact.owner);
      parts.push_back(contact.part);
      took_weight.push_back((contact.took_weight ? 1 : 0) + (contact.gone ? 2 : 0));
      for (const Vector<dim>& v : {contact.normal, contact.force, contact.slip, contact.lasting}) {
        values.insert(values.end(), v.begin(), v.end());
      }
    }
  }
  visitor.list(prefix + "touch_ids", ids);
  visitor.list(prefix + "touch_owners", owners);
  visitor.list(prefix + "touch_parts", parts);
  visitor.list(prefix + "touch_took_weight", took_weight);
  visitor.list(prefix + "touches", values);
  require_values_each(prefix + "touch_owners", owners.size(), ids.size(), 1);
  for (const std::int64_t owner : owners) {
    require(owner >= 0 && owner < static_cast<std::int64_t>(num_members),
            "saved state: {}touch_owners: found {}, allowed: 0 to {}", prefix, owner,
            num_members - 1);
  }
  require_values_each(prefix + "touch_parts", parts.size(), ids.size(), 1);
  require_values_each(prefix + "touch_took_weight", took_weight.size(), ids.size(), 1);
  require_values_each(prefix + "touches", values.size(), ids.size(), 4 * dim);
  contacts_.clear();
  const auto vector = [&](std::size_t k) {
    return Vector<dim>(Eigen::Map<const Vector<dim>>(values.data() + k * dim));
  };
  for (std::size_t k = 0; k < ids.size(); ++k) {
    contacts_[ids[k]].push_back({.owner = static_cast<std::int32_t>(owners[k]),
                                 .normal = vector(4 * k),
                                 .force = vector(4 * k + 1),
                                 .slip = vector(4 * k + 2),
                                 .part = parts[k],
                                 .lasting = vector(4 * k + 3),
                                 .took_weight = took_weight[k] % 2 != 0,
                                 .gone = took_weight[k] >= 2});
  }
}

template <int dim>
void ContactMemory<dim>::visit_state(StateVisitor& visitor, const std::string& prefix,
                                     std::size_t num_members) {
  visit_contacts(visitor, prefix, num_members);
  visit_by_id(visitor, prefix + "offset", offsets_);
  visit_by_id(visitor, prefix + "laid_offset", laid_offsets_);
  visit_by_id(visitor, prefix + "shape", shapes_);
}

template class ContactMemory<2>;
template class ContactMemory<3>;

}  // namespace gabion::mpm
