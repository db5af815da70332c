// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/nodal_pressure.hpp"

#include <algorithm>
#include <utility>

namespace gabion::mpm {

template <int dim>
int NodalPressure<dim>::side_of(const Vector<dim>& normal) {
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return 2 * axis + (normal[axis] > 0 ? 1 : 0);
}

template <int dim>
void NodalPressure<dim>::clear() {
  places_.clear();
  averages_.clear();
  average_of_.clear();
  first_.clear();
  index_.clear();
}

template <int dim>
int NodalPressure<dim>::add(const Place& place) {
  const auto k = static_cast<std::int32_t>(places_.size());
  const int side = side_of(place.normal);
  places_.push_back(place);
  first_.push_back(average_of_.size());
  for (std::size_t i = 0; i < place.nodes.size(); ++i) {
    const auto next = static_cast<std::int32_t>(averages_.size());
    const auto [entry, is_new] = index_.try_emplace({place.nodes[i], side}, next);
    if (is_new) averages_.push_back({.node = place.nodes[i], .places = {}});
    Average& average = averages_[entry->second];
    const double area = place.N[i] * place.area;
    average.area += area;
    average.gap += area * place.gap;
    average.places.emplace_back(k, place.N[i]);
    average_of_.push_back(entry->second);
  }
  return k;
}

template <int dim>
void NodalPressure<dim>::balance() {
  for (Average& average : averages_) {
    if (average.area <= 0) continue;
    average.gap /= average.area;
    average.pressure = penalty_ * std::max(0.0, -average.gap);
  }
}

template <int dim>
double NodalPressure<dim>::pressure(int place) const {
  double sum = 0;
  const auto& N = places_[place].N;
  for (std::size_t i = 0; i < N.size(); ++i) {
    sum += N[i] * averages_[average_of_[first_[place] + i]].pressure;
  }
  return sum;
}

template <int dim>
double NodalPressure<dim>::stored_energy() const {
  double sum = 0;
  for (const Average& average : averages_) {
    sum += 0.5 * average.area * average.pressure * average.pressure / penalty_;
  }
  return sum;
}

template <int dim>
double NodalPressure<dim>::penetration() const {
  double largest = 0;
  for (const Average& average : averages_) {
    largest = std::max(largest, average.pressure / penalty_);
  }
  return largest;
}

template <int dim>
std::uint64_t NodalPressure<dim>::active_set() const {
  std::uint64_t name = 0;
  for (const Average& average : averages_) {
    if (average.pressure == 0) continue;
    const auto id = static_cast<std::uint64_t>(average.node) + 1;
    name += (id ^ (id >> 7)) * std::uint64_t{0x9E3779B97F4A7C15};
  }
  return name;
}

template <int dim>
void NodalPressure<dim>::add_stiffness(double factor, std::span<const Slope> slopes,
                                       BlockMatrix<dim>& K) const {
  struct Row {
    Vector<dim> force = Vector<dim>::Zero(), gap = Vector<dim>::Zero();
  };
  std::map<std::int32_t, Row> rows;
  for (const Average& average : averages_) {
    if (average.pressure == 0) continue;
    rows.clear();
    for (const auto& [k, N] : average.places) {
      const Place& place = places_[k];
      for (std::size_t i = 0; i < place.nodes.size(); ++i) {
        Row& row = rows[place.nodes[i]];
        const double share = N * place.area * slopes[k].w[i];
        row.force += share * slopes[k].by_pressure;
        row.gap += share * place.normal;
      }
    }
    const double scale = factor * penalty_ / average.area;
    for (const auto& [i, left] : rows) {
      for (const auto& [j, right] : rows) {
        K.add_block(i, j, scale * left.force * right.gap.transpose());
      }
    }
  }
}

template class NodalPressure<2>;
template class NodalPressure<3>;

}  // namespace gabion::mpm
