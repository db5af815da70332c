// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "common/mechanics/newton/newton.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test {

/// Nodes 0 .. n in a row, one length h apart, joined by springs with the force
///
///     N(e) = E (e + c e^2 + d e^3) ,   e = (u_{i+1} - u_i) / h      along x, k w across (y)
///
/// Node 0 is held, node n carries the load. A spring with e <= -1 is turned inside out:
/// inadmissible. Each rank evaluates its share of the springs.
class SpringChain : public NewtonProblem<2> {
 public:
  int num_springs = 10;
  double stiffness = 100, quadratic = 0.8, cubic = 2, length = 1;
  double load_x = 30, load_y = 4;
  double tangent_factor = 1;  ///< 1: exact tangent
  bool likely_last = false;   ///< what each evaluation says
  int evaluations = 0;
  int tangents = 0;

  std::size_t num_dofs() const { return 2 * (static_cast<std::size_t>(num_springs) + 1); }
  double increment_scale() const override { return length; }

  void set_pattern(BlockMatrix<2>& K) const {
    std::vector<std::int32_t> offsets{0}, nodes;
    for (int i = 0; i < num_springs; ++i) {
      nodes.insert(nodes.end(), {i, i + 1});
      offsets.push_back(static_cast<std::int32_t>(nodes.size()));
    }
    K.set_pattern(num_springs + 1, offsets, nodes);
  }

  Evaluation evaluate(std::span<const double> du, std::span<double> r, BlockMatrix<2>* K) override {
    ++evaluations;
    tangents += K != nullptr;
    if (K) K->set_zero();
    std::vector<double> internal(du.size(), 0.0);
    Evaluation evaluation;
    evaluation.likely_last = likely_last;
    for (int i = 0; i < num_springs; ++i) add_spring(i, du, internal, K, evaluation);
    std::fill(r.begin(), r.end(), 0.0);
    r[du.size() - 2] = load_x;
    r[du.size() - 1] = load_y;
    double internal_squares = 0;
    for (std::size_t k = 0; k < du.size(); ++k) {
      internal_squares += internal[k] * internal[k];
      r[k] -= internal[k];
    }
    r[0] = r[1] = 0;
    if (K) {
      const std::vector<std::int32_t> held{0};
      const std::vector<NodeBlock<2>> none{NodeBlock<2>::Zero()};
      K->constrain(held, none, [](std::int32_t) { return rank() == 0; });
    }
    evaluation.force_scale = std::max(std::hypot(load_x, load_y), std::sqrt(internal_squares));
    return evaluation;
  }

 private:
  void add_spring(int i, std::span<const double> du, std::vector<double>& internal,
                  BlockMatrix<2>* K, Evaluation& evaluation) const {
    const double e = (du[2 * i + 2] - du[2 * i]) / length;
    const double w = du[2 * i + 3] - du[2 * i + 1];
    if (!(e > -1)) {
      evaluation.admissible = false;
      evaluation.reason = "spring " + std::to_string(i) + " is turned inside out";
    }
    const double force[2] = {stiffness * (e + quadratic * e * e + cubic * e * e * e),
                             stiffness * w};
    for (int a = 0; a < 2; ++a) {
      internal[2 * i + a] -= force[a];
      internal[2 * i + 2 + a] += force[a];
    }
    if (K == nullptr || i % size() != rank()) return;
    const double slope =
        tangent_factor * stiffness * (1 + 2 * quadratic * e + 3 * cubic * e * e) / length;
    NodeBlock<2> block = NodeBlock<2>::Zero();
    block(0, 0) = slope;
    block(1, 1) = stiffness;
    K->add_block(i, i, block);
    K->add_block(i + 1, i + 1, block);
    K->add_block(i, i + 1, -block);
    K->add_block(i + 1, i, -block);
  }
};

}  // namespace gabion::test
