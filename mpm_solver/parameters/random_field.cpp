// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/parameters/random_field.hpp"

#include <algorithm>
#include <cmath>

namespace gabion::mpm {

template <int dim>
RandomLattice<dim>::RandomLattice(const Eigen::AlignedBox<double, dim>& box,
                                  const Vector<dim>& largest_step)
    : low(box.min()) {
  constexpr double rounding = 1e-9;
  for (int d = 0; d < dim; ++d) {
    const double size = box.sizes()[d];
    const double cells = std::ceil(size / largest_step[d] * (1 - rounding));
    count[d] = static_cast<int>(std::clamp(cells, 1.0, 2e9));
    step[d] = size / count[d];
  }
}

template <int dim>
std::int64_t RandomLattice<dim>::num_cells() const {
  double product = 1;
  for (const int n : count) product *= n;
  return static_cast<std::int64_t>(std::min(product, 9e18));
}

template <int dim>
std::int64_t RandomLattice<dim>::cell_of(const Vector<dim>& x) const {
  std::int64_t cell = 0;
  for (int d = 0; d < dim; ++d) {
    const double place = std::floor((x[d] - low[d]) / step[d]);
    const auto i = static_cast<std::int64_t>(std::clamp(place, 0.0, count[d] - 1.0));
    cell = cell * count[d] + i;
  }
  return cell;
}

template <int dim>
std::vector<double> normal_field(const RandomLattice<dim>& lattice,
                                 const Vector<dim>& correlation_lengths,
                                 const CountedRandom& random) {
  const std::int64_t n = lattice.num_cells();
  std::vector<double> z(static_cast<std::size_t>(n));
  for (std::int64_t i = 0; i < n; ++i) z[i] = random.normal(static_cast<std::uint64_t>(i));
  std::int64_t stride = n;  // of neighbours along an axis
  for (int d = 0; d < dim; ++d) {
    const std::int64_t block = stride;
    stride /= lattice.count[d];
    const double a = std::exp(-2 * lattice.step[d] / correlation_lengths[d]);
    const double b = std::sqrt(-std::expm1(-4 * lattice.step[d] / correlation_lengths[d]));
    for (std::int64_t first = 0; first < n; first += block) {
      for (std::int64_t i = first + stride; i < first + block; ++i) {
        z[i] = a * z[i - stride] + b * z[i];
      }
    }
  }
  return z;
}

Lognormal Lognormal::of(double mean, double cov) {
  const double variance = std::log1p(cov * cov);
  return {std::log(mean) - variance / 2, std::sqrt(variance)};
}

double Lognormal::at(double z) const {
  return std::exp(mean + deviation * z);
}

template struct RandomLattice<2>;
template struct RandomLattice<3>;
template std::vector<double> normal_field<2>(const RandomLattice<2>&, const Vector<2>&,
                                             const CountedRandom&);
template std::vector<double> normal_field<3>(const RandomLattice<3>&, const Vector<3>&,
                                             const CountedRandom&);

}  // namespace gabion::mpm
