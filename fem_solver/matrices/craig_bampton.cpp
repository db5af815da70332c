// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/craig_bampton.hpp"

#include "common/base/require.hpp"
#include "fem_solver/matrices/lowest_modes.hpp"
#include "fem_solver/matrices/symmetric_factor.hpp"

namespace gabion::fem {

namespace {

std::vector<int> others(int size, const std::vector<int>& kept) {
  std::vector<char> is_kept(size, 0);
  for (const int i : kept) is_kept[i] = 1;
  std::vector<int> result;
  for (int i = 0; i < size; ++i) {
    if (!is_kept[i]) result.push_back(i);
  }
  return result;
}

SparseMatrix projected(const SparseMatrix& A, const Eigen::MatrixXd& T) {
  const Eigen::MatrixXd product = A * T;
  const Eigen::MatrixXd B = T.transpose() * product;
  return Eigen::MatrixXd(0.5 * (B + B.transpose())).sparseView(1, 0);
}

}  // namespace

Reduction craig_bampton(const LinearModel& full, const std::vector<int>& kept, int num_modes) {
  const std::vector<int> interior = others(full.size(), kept);
  require<ConfigError>(num_modes <= std::ssize(interior),
                       "found {} modes, allowed: at most {}, the unknowns that are not on wet "
                       "surfaces",
                       num_modes, interior.size());
  const auto num_kept = static_cast<int>(kept.size());
  Reduction result;
  result.T = Eigen::MatrixXd::Zero(full.size(), num_kept + num_modes);
  for (int k = 0; k < num_kept; ++k) result.T(kept[k], k) = 1;
  if (!interior.empty()) {
    const LinearModel inside = part_of(full, interior);
    const SymmetricFactor K_ii(inside.K, inside.unknowns, "stiffness with the wet surfaces held");
    const Eigen::MatrixXd K_ib(part_of(full.K, interior, kept));
    const Eigen::MatrixXd Psi = K_ii.solve(K_ib);
    for (std::size_t i = 0; i < interior.size(); ++i) {
      result.T.row(interior[i]).head(num_kept) = -Psi.row(static_cast<int>(i));
    }
    if (num_modes > 0) {
      const Modes modes = lowest_modes(inside, num_modes);
      result.omega2 = modes.omega2;
      for (std::size_t i = 0; i < interior.size(); ++i) {
        result.T.row(interior[i]).tail(num_modes) = modes.shapes.row(static_cast<int>(i));
      }
    }
  }
  result.model.K = projected(full.K, result.T);
  if (full.M.rows() > 0) result.model.M = projected(full.M, result.T);
  if (full.damped()) result.model.C = projected(full.C, result.T);
  for (const int i : kept) result.model.unknowns.push_back(full.unknowns[i]);
  for (int m = 1; m <= num_modes; ++m) result.model.unknowns.push_back({0, m});
  return result;
}

}  // namespace gabion::fem
