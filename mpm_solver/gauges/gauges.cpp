// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/gauges/gauges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/tensor_functions.hpp"

namespace gabion::mpm {

namespace {

/// Sums over the soil in a slab: first of this rank, then of all ranks.
struct SlabSums {
  double volume = 0, mass = 0;
  double momentum = 0;      // along the normal [kg m/s]
  double speed = 0;         // sum of m |v|
  double twice_energy = 0;  // sum of m (v . n)^2 [J]
  double push = 0;          // sum of -V n . sigma n [J]
};
constexpr std::size_t num_sums = sizeof(SlabSums) / sizeof(double);

struct SlabMaxima {
  double top = -std::numeric_limits<double>::infinity();
  double speed = top, pressure = top;
};
constexpr std::size_t num_maxima = sizeof(SlabMaxima) / sizeof(double);

// Half lengths of the box that a point stands for.
template <int dim>
Vector<dim> half_lengths(const MaterialPoints<dim>& points, std::int32_t p) {
  if (!points.half_length.empty()) return points.half_length[p];
  return Vector<dim>::Constant(0.5 * cube_side<dim>(points.V0[p] * points.J[p]));
}

// Part of a length around `middle` that lies within b / 2 of zero, over the length.
double share_in_slab(double middle, double length, double b) {
  const double high = std::min(middle + length / 2, b / 2);
  const double low = std::max(middle - length / 2, -b / 2);
  return std::max(0.0, high - low) / length;
}

template <int dim>
double pressure_on(const Vector<dim>& n, const MaterialPoints<dim>& points, std::int32_t p) {
  return -n.dot(in_plane<dim>(points.tau[p]) * n) / points.J[p];
}

template <int dim>
void add_point(const Gauge<dim>& gauge, const MaterialPoints<dim>& points, std::int32_t p,
               double share, std::pair<SlabSums, SlabMaxima>& slab) {
  auto& [sums, maxima] = slab;
  const Vector<dim>& v = points.v[p];
  const double m = share * points.m[p], V = share * points.V0[p] * points.J[p];
  const double v_n = v.dot(gauge.normal), pressure = pressure_on<dim>(gauge.normal, points, p);
  sums.volume += V;
  sums.mass += m;
  sums.momentum += m * v_n;
  sums.speed += m * v.norm();
  sums.twice_energy += m * v_n * v_n;
  sums.push += V * pressure;
  const double half = half_lengths(points, p).dot(gauge.up.cwiseAbs());
  maxima.top = std::max(maxima.top, gauge.height * (gauge.up.dot(points.x[p] - gauge.foot) + half));
  maxima.speed = std::max(maxima.speed, v.norm());
  maxima.pressure = std::max(maxima.pressure, pressure);
}

template <int dim>
std::pair<SlabSums, SlabMaxima> own_slab(const Gauge<dim>& gauge, const MaterialPoints<dim>& points,
                                         double thickness) {
  std::pair<SlabSums, SlabMaxima> slab;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double distance = gauge.distance(points.x[p]);
    const double length = 2 * half_lengths(points, p).dot(gauge.normal.cwiseAbs());
    if (2 * std::abs(distance) >= thickness + length || !gauge.holds(points.x[p])) continue;
    add_point(gauge, points, p, share_in_slab(distance, length, thickness), slab);
  }
  return slab;
}

template <int dim>
Section section_of(const Gauge<dim>& gauge, const SlabSums& sums, const SlabMaxima& maxima,
                   double thickness) {
  if (!(sums.volume > 0)) return {};
  const double area = sums.volume / thickness;
  return {.area = area,
          .depth = area * gauge.height / gauge.size,
          .top = maxima.top,
          .mass_flux = sums.momentum / thickness,
          .normal_speed = sums.momentum / sums.mass,
          .speed = sums.speed / sums.mass,
          .max_speed = maxima.speed,
          .dynamic_pressure = sums.twice_energy / sums.volume,
          .pressure = sums.push / sums.volume,
          .max_pressure = maxima.pressure};
}

}  // namespace

template <int dim>
std::vector<Section> gauge_sections(MPI_Comm comm, const std::vector<Gauge<dim>>& gauges,
                                    const MaterialPoints<dim>& points, double thickness) {
  std::vector<SlabSums> sums;
  std::vector<SlabMaxima> maxima;
  for (const auto& gauge : gauges) {
    const auto slab = own_slab(gauge, points, thickness);
    sums.push_back(slab.first);
    maxima.push_back(slab.second);
  }
  std::vector<Section> sections;
  if (gauges.empty()) return sections;
  sum_over_ranks(comm, std::span<double>(&sums.front().volume, num_sums * sums.size()));
  max_over_ranks(comm, std::span<double>(&maxima.front().top, num_maxima * maxima.size()));
  for (std::size_t k = 0; k < gauges.size(); ++k) {
    sections.push_back(section_of(gauges[k], sums[k], maxima[k], thickness));
  }
  return sections;
}

template <int dim>
Gauges<dim>::Gauges(MPI_Comm comm, const std::vector<Gauge<dim>>& gauges, double thickness)
    : comm_(comm), gauges_(gauges), thickness_(thickness), passages_(gauges.size()) {}

template <int dim>
void Gauges<dim>::add_step(std::span<const Vector<dim>> x_n, const MaterialPoints<dim>& points,
                           double dt) {
  if (gauges_.empty()) return;
  std::vector<Vector<dim + 1>> passed(gauges_.size(), Vector<dim + 1>::Zero());
  for (std::size_t k = 0; k < gauges_.size(); ++k) {
    for (std::int32_t p = 0; p < points.size(); ++p) {
      const int path = gauges_[k].crossing(x_n[p], points.x[p]);
      if (path == 0) continue;
      passed[k][0] += path * points.m[p];
      passed[k].template tail<dim>() += path * points.m[p] * points.v[p];
    }
  }
  sum_over_ranks<dim + 1>(comm_, std::span<Vector<dim + 1>>(passed));
  for (std::size_t k = 0; k < gauges_.size(); ++k) {
    const Vector<dim> momentum = passed[k].template tail<dim>();
    passages_[k].mass += passed[k][0];
    passages_[k].momentum += momentum;
    passages_[k].mass_flux = passed[k][0] / dt;
    passages_[k].momentum_flux = momentum / dt;
  }
}

template <int dim>
std::vector<std::string> Gauges<dim>::names(const std::vector<Gauge<dim>>& gauges) {
  static constexpr const char* passed[] = {"passed_mass", "mass_flux"};
  static constexpr const char* section[] = {
      "area",         "depth",       "top",       "section_flux",
      "normal_speed", "speed",       "max_speed", "dynamic_pressure",
      "pressure",     "max_pressure"};
  std::vector<std::string> names;
  for (const auto& gauge : gauges) {
    for (const char* column : passed) names.push_back(fmt::format("{}.{}", gauge.name, column));
    for (const char* kind : {"passed_momentum", "momentum_flux"}) {
      for (int d = 0; d < dim; ++d) {
        names.push_back(fmt::format("{}.{}_{}", gauge.name, kind, "xyz"[d]));
      }
    }
    for (const char* column : section) names.push_back(fmt::format("{}.{}", gauge.name, column));
  }
  return names;
}

template <int dim>
std::vector<double> Gauges<dim>::values(const MaterialPoints<dim>& points) const {
  std::vector<double> values;
  const auto sections = gauge_sections(comm_, gauges_, points, thickness_);
  for (std::size_t k = 0; k < sections.size(); ++k) {
    const Passage<dim>& passage = passages_[k];
    values.insert(values.end(), {passage.mass, passage.mass_flux});
    values.insert(values.end(), passage.momentum.begin(), passage.momentum.end());
    values.insert(values.end(), passage.momentum_flux.begin(), passage.momentum_flux.end());
    const Section& s = sections[k];
    values.insert(values.end(), {s.area, s.depth, s.top, s.mass_flux, s.normal_speed, s.speed,
                                 s.max_speed, s.dynamic_pressure, s.pressure, s.max_pressure});
  }
  return values;
}

template <int dim>
void Gauges<dim>::visit_state(StateVisitor& visitor) {
  for (std::size_t k = 0; k < gauges_.size(); ++k) {
    const std::string name = fmt::format("gauge.{}.", gauges_[k].name);
    Passage<dim>& passage = passages_[k];
    visitor.real(name + "mass", passage.mass);
    visitor.real(name + "mass_flux", passage.mass_flux);
    visitor.reals(name + "momentum", {passage.momentum.data(), dim});
    visitor.reals(name + "momentum_flux", {passage.momentum_flux.data(), dim});
  }
}

template std::vector<Section> gauge_sections<2>(MPI_Comm, const std::vector<Gauge<2>>&,
                                                const MaterialPoints<2>&, double);
template std::vector<Section> gauge_sections<3>(MPI_Comm, const std::vector<Gauge<3>>&,
                                                const MaterialPoints<3>&, double);
template class Gauges<2>;
template class Gauges<3>;

}  // namespace gabion::mpm
