// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/soil_on_grid.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/mechanics/ranks/packet.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "mpm_solver/grid/group_fields.hpp"
#include "mpm_solver/grid/soil_border.hpp"
#include "mpm_solver/grid/transfer.hpp"
#include "mpm_solver/points/flat.hpp"
#include "mpm_solver/small_cuts/light_nodes.hpp"

namespace gabion::mpm {

namespace {

// Share of the mass of its points below which a node of one of several groups of bodies joins
// another one of its group.
constexpr double light_share = 0.01;

bool leads_out(const Phase& phase, const std::vector<std::string>& sides) {
  return std::any_of(phase.outflows.begin(), phase.outflows.end(), [&](const auto& outflow) {
    return std::find(sides.begin(), sides.end(), outflow.group) != sides.end();
  });
}

std::string side_text(const Phase& phase, const std::vector<std::string>& sides) {
  if (sides.empty()) return "a side without a name";
  const auto wall =
      std::find_if(phase.walls.begin(), phase.walls.end(), [&](const WallSettings& each) {
        return std::find(sides.begin(), sides.end(), each.group) != sides.end();
      });
  if (wall == phase.walls.end()) return fmt::format("side \"{}\" (no wall)", sides.front());
  return fmt::format("side \"{}\" ({})", wall->group,
                     wall->fixed ? "fixed wall"
                                 : "slip wall; where it bends away from the soil, more facets "
                                   "have to round it off");
}

// Whether nodes may be doubled; groups of bodies already use the numbers of doubled nodes.
template <int dim>
bool may_double_nodes(const SoilModel<dim>& model) {
  return can_double_nodes(model.grid) && !model.settings.body_groups.any();
}

std::vector<std::int32_t> take_cells(Packet& packet) {
  std::vector<std::int32_t> cells(static_cast<std::size_t>(packet.take<std::ptrdiff_t>()));
  for (std::int32_t& cell : cells) cell = packet.take<std::int32_t>();
  return cells;
}

}  // namespace

template <int dim>
SoilOnGrid<dim>::SoilOnGrid(const SoilModel<dim>& model, const SoilState<dim>& state,
                            PhaseTimes& times)
    : model_(model),
      points_(state.points),
      ranks_(state.ranks),
      times_(times),
      laws_(model.settings.varying),
      surfaces_(state.surfaces) {
  const MpmSettings<dim>& settings = model_.settings;
  std::set<std::string> said;
  for (const Phase& phase : settings.phases) {
    walls_of_phases_.emplace_back(model_.grid, phase.walls);
    walls_of_phases_.back().require_agreement(phase.start, phase.until);
    for (const std::string& warning : walls_of_phases_.back().corner_warnings()) {
      if (said.insert(warning).second) log::warn("{}", warning);
    }
  }
  if (settings.quadrature == Quadrature::cells) {
    quadrature_.emplace(model_.grid);
    for (const Phase& phase : settings.phases) {
      open_of_phases_.push_back(open_nodes(model_.grid, phase.walls));
    }
  }
  find_thin_walls();
  const bool has_surfaces = !settings.interfaces.empty() || !settings.rigid_walls.empty();
  if (has_surfaces && may_have_weak_nodes(settings.small_cuts, model_.grid, settings.bodies)) {
    sights_.emplace(surfaces_at_start(settings.interfaces, settings.rigid_walls), model_.grid);
  }
  if (any_has_method(SmallCutMethod::ghost, settings.small_cuts, model_.grid.basis,
                     settings.phases)) {
    ghost_.emplace(model_.grid, settings.bodies, settings.small_cuts.ghost_factor);
  }
}

template <int dim>
void SoilOnGrid<dim>::weigh() {
  laws_.follow(points_);
  std::optional<SoilBorder<dim>> border;
  if (model_.grid.splits_border) {
    border.emplace(ranks_.owners(), cells_with_points(model_.grid, points_));
  }
  evaluate_basis(model_.grid, points_, weights_, border ? &*border : nullptr);
  const BodyGroups& groups = model_.settings.body_groups;
  doubled_.clear();
  if (!groups.any()) return;
  doubled_ = split_groups(model_.comm, groups.of_body, model_.grid.num_nodes_total(), weights_);
}

// Find the thin walls, and separate the pairs that can have fields by side from the others.
template <int dim>
void SoilOnGrid<dim>::find_thin_walls() {
  const auto surfaces = surfaces_at_start(model_.settings.interfaces, model_.settings.rigid_walls);
  Faces<dim> faces(surfaces);
  shared_pairs_ = thin_pairs(faces, model_.cell_size);
  if (!may_double_nodes(model_)) return;
  const auto first = std::ranges::stable_partition(shared_pairs_, [&](const FacePair& pair) {
                       return !faces.can_have_fields(pair, surfaces);
                     }).begin();
  std::vector<FacePair> pairs(first, shared_pairs_.end());
  shared_pairs_.erase(first, shared_pairs_.end());
  if (!pairs.empty()) {
    sides_.emplace(model_.comm, std::move(faces), std::move(pairs), model_.grid);
  }
}

template <int dim>
void SoilOnGrid<dim>::renew_surfaces() {
  sides_.reset();
  find_thin_walls();
  if (!sights_) return;
  const MpmSettings<dim>& settings = model_.settings;
  sights_.emplace(surfaces_at_start(settings.interfaces, settings.rigid_walls), model_.grid);
}

// Give the sides of thin walls nodes of their own.
template <int dim>
void SoilOnGrid<dim>::split_sides() {
  if (!sides_) return;
  doubled_ = sides_->split(surfaces_, points_, weights_);
  if (said_doubled_ || sides_->num_doubled() == 0) return;
  said_doubled_ = true;
  log::info("soil on both sides of a thin wall: {} nodes are doubled (fields by side)",
            sides_->num_doubled());
}

template <int dim>
bool SoilOnGrid<dim>::wants_ghost(std::size_t phase) const {
  return method_in(model_.settings.small_cuts, model_.grid.basis,
                   model_.settings.phases[phase].dynamic) == SmallCutMethod::ghost;
}

template <int dim>
void SoilOnGrid<dim>::map(Mapping mapping) {
  {
    const ScopedTimer timer(times_, "search");
    weigh();
    split_sides();
    mapping.other_nodes.insert(mapping.other_nodes.end(), doubled_.begin(), doubled_.end());
    ghost_acts_ = wants_ghost(mapping.phase);
    if (ghost_acts_) {
      const auto nodes =
          ghost_->find_facets(ranks_.owners(), points_, weights_, doubled_, laws_.of_points());
      mapping.other_nodes.insert(mapping.other_nodes.end(), nodes.begin(), nodes.end());
    }
    activate_nodes(model_.comm, model_.grid, weights_, std::span(mapping.other_nodes), nodes_);
    if (quadrature_) {
      quadrature_->correct(open_of_phases_[mapping.phase], points_, nodes_, weights_);
    }
  }
  {
    const ScopedTimer timer(times_, "points to grid");
    points_to_grid(points_, weights_, nodes_);
    cure_small_cuts(mapping);
    walls(mapping.phase).select(nodes_);
    stop_.forget();
    if (mapping.with_inertia && !points_.has_gradients()) {
      stop_.find(points_, weights_, walls(mapping.phase), mapping.dt, nodes_);
    }
  }
}

template <int dim>
void SoilOnGrid<dim>::cure_small_cuts(const Mapping& mapping) {
  const SmallCutSettings& cuts = model_.settings.small_cuts;
  const SmallCutMethod method =
      method_in(cuts, model_.grid.basis, model_.settings.phases[mapping.phase].dynamic);
  const bool joins_light = !mapping.with_inertia || method == SmallCutMethod::mass_cutoff;
  const bool joins_weak = sights_ && sights_->follow(surfaces_);
  const bool joins_doubled =
      model_.settings.body_groups.any() && !model_.settings.phases[mapping.phase].is_explicit();
  if (joins_light || joins_weak || joins_doubled) {
    const auto joined = join_light_nodes<dim>(model_.comm,
                                              {.grid = model_.grid,
                                               .points = points_,
                                               .weights = weights_,
                                               .walls = walls(mapping.phase),
                                               .share = joins_light ? cuts.mass_share : 0,
                                               .doubled_share = joins_doubled ? light_share : 0,
                                               .sights = joins_weak ? &*sights_ : nullptr},
                                              nodes_);
    if (joined > 0) points_to_grid(points_, weights_, nodes_);
    small_cuts_.joined_nodes += joined;
  }
  if (!ghost_acts_) return;
  ghost_->begin_step(nodes_);
  ghost_acts_ = ghost_->num_facets() > 0;
  small_cuts_.ghost_steps += ghost_acts_;
  small_cuts_.ghost_facets += ghost_->num_facets();
}

template <int dim>
void SoilOnGrid<dim>::add_stopping_forces(std::size_t phase, double dt,
                                          std::span<Vector<dim>> forces) const {
  if (!stop_.acts()) return;
  std::vector<double> f = stop_.impulse();
  for (double& component : f) component /= -dt;
  std::vector<Vector<dim>> own = walls_of_phases_[phase].forces(f, nodes_.shared);
  nodes_.shared.total(flat(own));
  for (std::size_t w = 0; w < own.size(); ++w) forces[w] += own[w];
}

template <int dim>
std::vector<double> SoilOnGrid<dim>::body_forces(double time) const {
  if (!model_.settings.body_acceleration) return {};
  std::vector<Vector<dim>> b;
  for (std::int32_t p = 0; p < points_.size(); ++p) {
    b.push_back(model_.settings.body_acceleration(points_.x[p] - points_.u[p], time));
  }
  return point_forces<dim>(points_, weights_, nodes_, b);
}

template <int dim>
SparseList<char> SoilOnGrid<dim>::occupied_cells() const {
  SparseList<char> occupied = cells_with_points(model_.grid, points_);
  if (num_ranks(model_.comm) == 1) return occupied;
  Packets to_first;
  if (rank_of(model_.comm) != 0) {
    const std::set<std::int32_t> own(points_.cell.begin(), points_.cell.end());
    to_first[0].put(std::ssize(own));
    for (const std::int32_t cell : own) to_first[0].put(cell);
  }
  for (auto& [rank, packet] : send_packets(model_.comm, to_first)) {
    for (const std::int32_t cell : take_cells(packet)) occupied.at(cell) = 1;
  }
  return occupied;
}

template <int dim>
void SoilOnGrid<dim>::refuse_exits(const Phase& phase, std::span<const double> du) const {
  using Exit = typename GridExits<dim>::Exit;
  const auto sides_of = [&](const Exit& exit) {
    return model_.exits.sides(points_.x[exit.point], points_.cell[exit.point], exit.x);
  };
  const Exit exit = model_.exits.first(points_, weights_, nodes_, du, [&](const Exit& found) {
    return phase.outflows.empty() || !leads_out(phase, sides_of(found));
  });
  std::string own;
  if (exit.point >= 0) {
    const Vector<dim>& v = points_.v[exit.point];
    const Vector<dim>& x_n = points_.x[exit.point];
    own = fmt::format(
        "material point {} would leave the background grid through {}, from ({:.6g}) to ({:.6g}) "
        "with velocity ({:.4g}); make the grid larger, close the side with a wall, give it the "
        "condition \"outflow\", or set \"outside\": \"remove\"",
        points_.id[exit.point], side_text(phase, sides_of(exit)),
        fmt::join(x_n.data(), x_n.data() + dim, ", "),
        fmt::join(exit.x.data(), exit.x.data() + dim, ", "),
        fmt::join(v.data(), v.data() + dim, ", "));
  }
  const std::string text = first_text(model_.comm, own);
  if (!text.empty()) throw ConvergenceError(text, "outside");
}

template class SoilOnGrid<2>;
template class SoilOnGrid<3>;

}  // namespace gabion::mpm
