// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/linear_model.hpp"

#include <fmt/format.h>

namespace gabion::fem {

std::string name(const Unknown& unknown) {
  return unknown.node == 0 ? fmt::format("mode {}", unknown.direction)
                           : fmt::format("node {}, direction {}", unknown.node, unknown.direction);
}

SparseMatrix part_of(const SparseMatrix& A, const std::vector<int>& rows,
                     const std::vector<int>& columns) {
  std::vector<int> place(A.rows(), -1);
  for (std::size_t i = 0; i < rows.size(); ++i) place[rows[i]] = static_cast<int>(i);
  std::vector<Eigen::Triplet<double>> triplets;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    for (SparseMatrix::InnerIterator entry(A, columns[j]); entry; ++entry) {
      const int i = place[entry.row()];
      if (i >= 0) triplets.emplace_back(i, static_cast<int>(j), entry.value());
    }
  }
  SparseMatrix part(static_cast<int>(rows.size()), static_cast<int>(columns.size()));
  part.setFromTriplets(triplets.begin(), triplets.end());
  return part;
}

LinearModel part_of(const LinearModel& model, const std::vector<int>& kept) {
  LinearModel part;
  part.K = part_of(model.K, kept, kept);
  if (model.M.rows() > 0) part.M = part_of(model.M, kept, kept);
  if (model.damped()) part.C = part_of(model.C, kept, kept);
  for (const int i : kept) part.unknowns.push_back(model.unknowns[i]);
  return part;
}

}  // namespace gabion::fem
