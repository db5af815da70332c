// SPDX-License-Identifier: BSD-3-Clause
// The accepted state of a contact by facets.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/run/list_lengths.hpp"
#include "mpm_solver/contact/facet_contact.hpp"
#include "mpm_solver/points/flat.hpp"

namespace gabion::mpm {

namespace {

// Lists `name`_ids and `name`s.
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

// What is known of these points goes into the packet.
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
ContactMark<dim> FacetContact<dim>::mark_of(const Touch& touch) const {
  const Vector<dim>& n = touch.feature.normal;
  const Member& member = members_[touch.owner];
  const int cuts = member.surface.facet_type == CellType::quad4 ? 2 : 1;
  return {.facet = (touch.feature.simplex - member.first_simplex) / cuts,
          .sliding = touch.traction.sliding,
          .area = touch.area,
          .gap = touch.gap + touch.begun,
          .x = touch.feature.x,
          .normal = n,
          .force = -touch.force,
          .slip = (touch.relative - n.dot(touch.relative) * n) / dt_};
}

template <int dim>
Vector<dim> FacetContact<dim>::offset_of(std::int64_t id) const {
  const auto found = offset_.find(id);
  return found == offset_.end() ? Vector<dim>(Vector<dim>::Zero()) : found->second;
}

// @param depth  of the point in the cell that it was laid in
template <int dim>
Matrix<dim> FacetContact<dim>::shape_of(std::int64_t id, double depth) const {
  const auto found = shape_.find(id);
  return found == shape_.end() ? Matrix<dim>(depth * Matrix<dim>::Identity()) : found->second;
}

template <int dim>
ContactFields<dim> FacetContact<dim>::fields(const MaterialPoints<dim>& points, double reach,
                                             std::size_t member) const {
  const Member& own = members_[member];
  const auto first = start_.begin() + own.first_vertex;
  ContactFields<dim> fields({first, first + own.num_vertices},
                            own.surface.facets.size() / num_nodes(own.surface.facet_type));
  if (own.dropped) return fields;
  spread_marks<dim>(own.surface, own.marks, fields);
  const auto radius = [&](std::int32_t p, const Vector<dim>& n) {
    const std::int64_t id = points.id[p];
    return (shape_of(id, points.depth[p]) * n).norm() - offset_of(id).dot(n);
  };
  add_gaps<dim>(own.surface, points, radius, reach, fields);
  return fields;
}

// The deepest touch of a ball comes last: it holds where normals are not at right angles.
template <int dim>
void FacetContact<dim>::accept_offsets() {
  find_opened();
  std::vector<const Touch*> order;
  for (const auto* touches : {&touches_, &opened_}) {
    for (const Touch& touch : *touches) order.push_back(&touch);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const Touch* a, const Touch* b) { return a->gap > b->gap; });
  offset_.clear();
  for (const Touch* touch : order) {
    const Candidate& c = candidates_[touch->candidate];
    const Vector<dim>& n = touch->feature.normal;
    Vector<dim>& offset = offset_.try_emplace(c.id, c.offset).first->second;
    offset += (offset_after(*touch) - offset.dot(n)) * n;
  }
  std::erase_if(offset_, [](const auto& entry) { return entry.second.isZero(0); });
}

template <int dim>
typename FacetContact<dim>::Memory FacetContact<dim>::memory_of(const Touch& touch) const {
  const Vector<dim>& n = touch.feature.normal;
  Memory memory{.owner = touch.owner,
                .normal = n,
                .force = touch.force,
                .slip = -touch.begun * n,
                .part = touch.part,
                .lasting = lasting_force(touch),
                .took_weight = candidates_[touch.candidate].took_weight};
  const ContactLaw law = law_of(candidates_[touch.candidate], touch.owner, touch.part);
  if (law.mode == ContactMode::contact) {
    const Vector<dim> pull = touch.force - n.dot(touch.force) * n;
    memory.slip -= pull / (touch.area * law.tangential_penalty);
  }
  return memory;
}

template <int dim>
double FacetContact<dim>::stored_in_slip(const Touch& touch, const Memory& memory) const {
  const Candidate& c = candidates_[touch.candidate];
  const double k = law_of(c, touch.owner, touch.part).tangential_penalty;
  return 0.5 * touch.area * k * memory.tangential().squaredNorm();
}

template <int dim>
double FacetContact<dim>::stored_in_depth(const Touch& touch) const {
  const ContactLaw law = law_of(candidates_[touch.candidate], touch.owner, 1);
  return touch.area * law.stored(touch.stored_depth);
}

template <int dim>
void FacetContact<dim>::accept_touches(std::size_t owner) {
  Member& member = members_[owner];
  double work = 0, stored = 0, stored_slip = 0, slid = 0;
  member.marks.clear();
  for (const std::int32_t k : touches_of(owner)) {
    const Touch& touch = touches_[k];
    deepest_ = std::max(deepest_, -touch.gap);
    member.marks.push_back(mark_of(touch));
    const Memory memory = memory_of(touch);
    if (member.mode == ContactMode::contact) {
      const Vector<dim>& n = touch.feature.normal;
      const Vector<dim> pull = touch.force - n.dot(touch.force) * n;
      slid -= pull.dot(touch.slip - memory.tangential());
    }
    stored_slip += stored_in_slip(touch, memory);
    stored += stored_in_depth(touch) + stored_in_slip(touch, memory);
    work -= touch.force.dot(touch.relative);
    memory_[candidates_[touch.candidate].id].push_back(memory);
  }
  if (has_substeps_) {
    const Substeps& sums = member.substeps;
    work = sums.normal_work + sums.tangential_work;
    slid = sums.tangential_work - (stored_slip - member.stored_slip);
  }
  member.energy.add_step(work, stored, slid);
  member.stored_slip = stored_slip;
}

template <int dim>
void FacetContact<dim>::accept() {
  const auto before = std::exchange(memory_, {});  // candidates refer to it
  deepest_ = 0;
  for (std::size_t owner = 0; owner < members_.size(); ++owner) accept_touches(owner);
  deepest_ = max_over_ranks(comm_, deepest_);
  accept_offsets();
  shape_.clear();
  for (const Candidate& c : candidates_) {
    if (c.deforms) shape_[c.id] = c.shape * (Matrix<dim>::Identity() + c.H).transpose();
  }
  start_ = end_;
  for (std::size_t m = 0; m < members_.size(); ++m) {
    search_.add_motion(m, members_[m].motion);
    members_[m].last_motion = members_[m].motion;
  }
  soil_.reset();
  watched_.clear();
  watched_groups_.clear();
  candidates_.clear();
  touches_.clear();
  order_touches();
}

// What is remembered of the touches of all candidates, at the place where they are as the step
// starts.
template <int dim>
void FacetContact<dim>::add_remembered(std::int32_t owner, Vector<dim> Memory::*force, double share,
                                       std::span<double> field) const {
  std::vector<double> w;
  for (const Candidate& c : candidates_) {
    if (!c.memory) continue;
    w.resize(c.num_values);
    for (const Memory& memory : *c.memory) {
      if (memory.owner != owner) continue;
      surface_weights(c, memory.normal, w.data());
      scatter(c, w.data(), share * memory.*force, field);
    }
  }
}

template <int dim>
void FacetContact<dim>::add_old_forces(std::int32_t owner, double share,
                                       std::span<double> field) const {
  add_remembered(owner, &Memory::force, share, field);
}

template <int dim>
Vector<dim> FacetContact<dim>::step_force_on(std::span<const std::int64_t> ids) const {
  std::vector<Vector<dim>> sums(members_.size(), Vector<dim>::Zero());
  for (const std::int64_t id : ids) {
    const auto found = memory_.find(id);
    if (found == memory_.end()) continue;
    for (const Memory& memory : found->second) sums[memory.owner] += memory.force;
  }
  Vector<dim> sum = Vector<dim>::Zero();
  for (const Vector<dim>& force : sums) sum += force;
  return sum;
}

template <int dim>
void FacetContact<dim>::give(std::span<const std::int64_t> ids, Packet& packet) {
  const auto put_memory = [&packet](const std::vector<Memory>& touches) {
    packet.put(std::ssize(touches));
    for (const Memory& memory : touches) {
      packet.put(memory.owner);
      packet.put(memory.part);
      packet.put(memory.took_weight);
      for (const Vector<dim>& v : {memory.normal, memory.force, memory.slip, memory.lasting}) {
        packet.put(v);
      }
    }
  };
  give_by_id<std::vector<Memory>>(ids, memory_, put_memory, packet);
  give_by_id<Vector<dim>>(
      ids, offset_, [&](const auto& value) { packet.put(value); }, packet);
  give_by_id<Matrix<dim>>(
      ids, shape_, [&](const auto& value) { packet.put(value); }, packet);
}

template <int dim>
void FacetContact<dim>::take(Packet& packet) {
  const auto take_memory = [&packet] {
    std::vector<Memory> touches(static_cast<std::size_t>(packet.take<std::ptrdiff_t>()));
    for (Memory& memory : touches) {
      memory.owner = packet.take<std::int32_t>();
      memory.part = packet.take<double>();
      memory.took_weight = packet.take<bool>();
      for (Vector<dim>* v : {&memory.normal, &memory.force, &memory.slip, &memory.lasting}) {
        *v = packet.take<Vector<dim>>();
      }
    }
    return touches;
  };
  take_by_id<std::vector<Memory>>(packet, memory_, take_memory);
  take_by_id<Vector<dim>>(packet, offset_, [&] { return packet.take<Vector<dim>>(); });
  take_by_id<Matrix<dim>>(packet, shape_, [&] { return packet.take<Matrix<dim>>(); });
}

template <int dim>
void FacetContact<dim>::visit_memory(StateVisitor& visitor, const std::string& prefix) {
  std::vector<std::int64_t> ids, owners, took_weight;
  std::vector<double> values, parts;
  for (const auto& [id, touches] : memory_) {
    for (const Memory& memory : touches) {
      ids.push_back(id);
      owners.push_back(memory.owner);
      parts.push_back(memory.part);
      took_weight.push_back(memory.took_weight ? 1 : 0);
      for (const Vector<dim>& v : {memory.normal, memory.force, memory.slip, memory.lasting}) {
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
    require(owner >= 0 && owner < std::ssize(members_),
            "saved state: {}touch_owners: found {}, allowed: 0 to {}", prefix, owner,
            members_.size() - 1);
  }
  require_values_each(prefix + "touch_parts", parts.size(), ids.size(), 1);
  require_values_each(prefix + "touch_took_weight", took_weight.size(), ids.size(), 1);
  require_values_each(prefix + "touches", values.size(), ids.size(), 4 * dim);
  memory_.clear();
  const auto vector = [&](std::size_t k) {
    return Vector<dim>(Eigen::Map<const Vector<dim>>(values.data() + k * dim));
  };
  for (std::size_t k = 0; k < ids.size(); ++k) {
    memory_[ids[k]].push_back({.owner = static_cast<std::int32_t>(owners[k]),
                               .normal = vector(4 * k),
                               .force = vector(4 * k + 1),
                               .slip = vector(4 * k + 2),
                               .part = parts[k],
                               .lasting = vector(4 * k + 3),
                               .took_weight = took_weight[k] != 0});
  }
}

template <int dim>
void FacetContact<dim>::visit_state(StateVisitor& visitor, const std::string& prefix) {
  visitor.reals(prefix + "vertices", flat(start_));
  search_.forget();
  visitor.real(prefix + "deepest", deepest_);
  visit_memory(visitor, prefix);
  visit_by_id(visitor, prefix + "offset", offset_);
  visit_by_id(visitor, prefix + "shape", shape_);
  for (std::size_t m = 0; m < members_.size(); ++m) {
    Member& member = members_[m];
    const std::string own = fmt::format("{}member_{}.", prefix, m);
    visitor.real(own + "last_motion", member.last_motion);
    visit_marks<dim>(visitor, own,
                     member.surface.facets.size() / num_nodes(member.surface.facet_type),
                     member.marks);
    const std::pair<const char*, double*> energies[] = {{"stored", &member.energy.stored},
                                                        {"friction", &member.energy.friction},
                                                        {"loss", &member.energy.loss},
                                                        {"stored_slip", &member.stored_slip}};
    for (const auto& [name, value] : energies) visitor.share(own + name, *value);
  }
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
