// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/way_out.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace gabion::mpm {

namespace {

// A plane that lacks less than this share of its depth pushes no more: it is one of the others.
constexpr double negligible = 1e-9;

constexpr int max_changes = 20;

template <int dim>
void solve(std::span<const Vector<dim>> normals, std::span<const double> deltas, WayOut<dim>& out) {
  std::sort(out.planes.begin(), out.planes.begin() + out.size);
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, dim, dim>;
  Small G(out.size, out.size);
  for (int k = 0; k < out.size; ++k) {
    for (int l = 0; l < out.size; ++l) G(k, l) = normals[out.planes[k]].dot(normals[out.planes[l]]);
  }
  out.inverse.setZero();
  out.inverse.topLeftCorner(out.size, out.size) = Small(G.inverse());
  for (int k = 0; k < out.size; ++k) {
    out.depths[k] = 0;
    for (int l = 0; l < out.size; ++l) out.depths[k] += out.inverse(k, l) * deltas[out.planes[l]];
  }
}

// @returns whether one went
template <int dim>
bool drop_pulling(WayOut<dim>& out) {
  const auto last = out.depths.begin() + out.size;
  const auto least = std::min_element(out.depths.begin(), last);
  if (*least > 0) return false;
  const auto k = least - out.depths.begin();
  std::copy(out.planes.begin() + k + 1, out.planes.begin() + out.size, out.planes.begin() + k);
  --out.size;
  return true;
}

// The plane that u is farthest from leading out of; -1: none.
template <int dim>
int most_lacking(std::span<const Vector<dim>> normals, std::span<const double> deltas,
                 const WayOut<dim>& out) {
  Vector<dim> u = Vector<dim>::Zero();
  for (int k = 0; k < out.size; ++k) u += out.depths[k] * normals[out.planes[k]];
  int worst = -1;
  double lacking = 0;
  for (std::size_t l = 0; l < normals.size(); ++l) {
    const double missing = deltas[l] - normals[l].dot(u) - negligible * deltas[l];
    if (missing <= lacking) continue;
    lacking = missing;
    worst = static_cast<int>(l);
  }
  return worst;
}

}  // namespace

template <int dim>
WayOut<dim> way_out(std::span<const Vector<dim>> normals, std::span<const double> deltas) {
  WayOut<dim> out;
  for (int change = 0; change < max_changes; ++change) {
    const int next = most_lacking<dim>(normals, deltas, out);
    if (next < 0 || out.size == dim) break;
    out.planes[out.size++] = next;
    solve<dim>(normals, deltas, out);
    while (drop_pulling(out)) solve<dim>(normals, deltas, out);
  }
  return out;
}

template WayOut<2> way_out<2>(std::span<const Vector<2>>, std::span<const double>);
template WayOut<3> way_out<3>(std::span<const Vector<3>>, std::span<const double>);

}  // namespace gabion::mpm
