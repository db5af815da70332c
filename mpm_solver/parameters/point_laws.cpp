// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/parameters/point_laws.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/materials/strength_reduction.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
bool any_varies(const VaryingMaterials<dim>& materials) {
  return std::ranges::any_of(materials, [](const auto& each) { return each != nullptr; });
}

}  // namespace

template <int dim>
void add_parameters(const VaryingMaterials<dim>& materials, MaterialPoints<dim>& points) {
  if (!any_varies<dim>(materials)) return;
  points.parameters.assign(points.x.size(), VaryingParameters::Zero());
  for (std::size_t b = 0; b < materials.size(); ++b) {
    if (!materials[b]) continue;
    for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
      points.parameters[p] = materials[b]->at(points.x[p]);
    }
  }
}

template <int dim>
std::size_t PointLaws<dim>::Hash::operator()(const VaryingParameters& values) const {
  std::uint64_t hash = 0;
  for (const double value : values) {
    const double same = value == 0 ? 0 : value;  // -0 equals 0
    hash = (hash ^ std::bit_cast<std::uint64_t>(same)) * 0x9E3779B97F4A7C15ULL;
    hash ^= hash >> 29;
  }
  return hash;
}

template <int dim>
PointLaws<dim>::PointLaws(VaryingMaterials<dim> materials) : materials_(std::move(materials)) {
  if (!any_varies<dim>(materials_)) materials_.clear();
  laws_.resize(materials_.size());
}

template <int dim>
void PointLaws<dim>::follow(const MaterialPoints<dim>& points) {
  if (materials_.empty()) return;
  require(points.parameters.size() == points.x.size(),
          "mpm_solver: found {} values of constants that vary for {} points",
          points.parameters.size(), points.x.size());
  if (body_starts_ == points.body_starts && known_ == points.parameters) return;
  of_points_.assign(points.x.size(), nullptr);
  for (std::size_t b = 0; b < materials_.size(); ++b) {
    if (!materials_[b]) continue;
    Laws used;
    for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
      const VaryingParameters& values = points.parameters[p];
      auto found = used.find(values);
      if (found == used.end()) {
        auto known = laws_[b].extract(values);
        found = known ? used.insert(std::move(known)).position
                      : used.emplace(values, materials_[b]->with(values).law).first;
      }
      of_points_[p] = &found->second;
    }
    laws_[b] = std::move(used);
  }
  known_ = points.parameters;
  body_starts_ = points.body_starts;
}

template <int dim>
PointLaws<dim> PointLaws<dim>::reduced(double factor) const {
  PointLaws weaker;
  weaker.of_points_.assign(of_points_.size(), nullptr);
  std::unordered_map<const MaterialLaw<dim>*, const MaterialLaw<dim>*> known;
  for (const Laws& laws : laws_) {
    for (const auto& [values, law] : laws) {
      auto reduced = with_reduced_strength<dim>(law, factor);
      weaker.reduced_.push_back(reduced ? *std::move(reduced) : law);
      known.emplace(&law, &weaker.reduced_.back());
    }
  }
  for (std::size_t p = 0; p < of_points_.size(); ++p) {
    if (of_points_[p] != nullptr) weaker.of_points_[p] = known.at(of_points_[p]);
  }
  return weaker;
}

template void add_parameters<2>(const VaryingMaterials<2>&, MaterialPoints<2>&);
template void add_parameters<3>(const VaryingMaterials<3>&, MaterialPoints<3>&);
template class PointLaws<2>;
template class PointLaws<3>;

}  // namespace gabion::mpm
