// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/cell_failure.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <variant>

namespace gabion::fem {

namespace {

constexpr double gone_below = 1e-9;     // of the share that is left
constexpr double holding_share = 1e-6;  // of the stiffness of a cell, in statics

/// Value that a cell or line has reached, and its limit.
struct Reached {
  FailureReason reason;
  double value;
  const std::optional<double>& limit;
};

/// The first limit that is exceeded.
Failure failure_beyond(std::int32_t element, std::initializer_list<Reached> all) {
  for (const auto& [reason, value, limit] : all) {
    if (limit && value > *limit) return {element, reason, value, *limit};
  }
  return {.element = element};
}

/// The time that a wave needs to cross a cell [s].
template <int dim>
double crossing_time(const CellBlock<dim>& block, std::size_t c) {
  const auto weights = block.weights(c);
  const double size = std::pow(std::accumulate(weights.begin(), weights.end(), 0.0), 1.0 / dim);
  const double mu =
      std::visit([](const auto& law) { return law.shear_modulus(); }, block.material().law);
  return size / std::sqrt(mu / block.material().density);
}
template <int dim>
double crossing_time(const LineBlock<dim>& block, std::size_t k) {
  return block.free_length(k) /
         std::sqrt(block.material().young_modulus / block.material().density);
}

/// A strain of the points of a cell of concrete, their mean; 0 of other laws.
/// @param strain_of  (law, history of a point)
template <int dim, class StrainOf>
double mean_strain(const CellBlock<dim>& block, std::size_t c, std::span<const double> history,
                   const StrainOf& strain_of) {
  const auto* law = std::get_if<Concrete<dim>>(&block.material().law);
  if (!law) return 0;
  constexpr std::size_t size = Concrete<dim>::history_size;
  const auto weights = block.weights(c);
  double sum = 0, volume = 0;
  for (std::size_t q = 0; q < weights.size(); ++q) {
    const auto point = history.subspan(c * block.history_width() + q * size, size);
    sum += weights[q] * strain_of(*law, point);
    volume += weights[q];
  }
  return sum / volume;
}

/// Failures in a block of cells, by what each has reached.
template <int dim>
std::vector<Failure> failures_of(const CellBlock<dim>& block, std::span<const double>,
                                 std::span<const double> history) {
  const FailureLimits& limits = block.material().failure;
  const auto opening = [](const Concrete<dim>& law, std::span<const double> point) {
    return law.opening_strain(point);
  };
  const auto crushing = [](const Concrete<dim>& law, std::span<const double> point) {
    return law.crushing_strain(point);
  };
  std::vector<Failure> failures;
  for (std::size_t c = 0; c < block.cells().size(); ++c) {
    failures.push_back(failure_beyond(
        block.cells()[c],
        {{FailureReason::plastic_strain, block.largest_plastic_strain(c, history),
          limits.plastic_strain},
         {FailureReason::strain, mean_strain(block, c, history, opening), limits.strain},
         {FailureReason::crushing_strain, mean_strain(block, c, history, crushing),
          limits.crushing_strain}}));
  }
  return failures;
}

/// Failures in a block of lines, whose numbers here are those among the lines.
template <int dim>
std::vector<Failure> failures_of(const LineBlock<dim>& block, std::span<const double> u,
                                 std::span<const double> history) {
  const FailureLimits& limits = block.material().failure;
  const std::vector<double> forces = block.forces(u, history), strains = block.strains(u, history);
  const std::vector<double> plastic = block.plastic_strains(history);
  std::vector<Failure> failures;
  for (std::size_t k = 0; k < block.lines().size(); ++k) {
    failures.push_back(failure_beyond(
        block.lines()[k], {{FailureReason::force, forces[k], limits.force},
                           {FailureReason::strain, strains[k], limits.strain},
                           {FailureReason::plastic_strain, plastic.empty() ? 0 : plastic[k],
                            limits.plastic_strain}}));
  }
  return failures;
}

/// Begin, or go on with, the failure of the cells of a block.
/// @param history  of the block; changed
/// @returns        whether it changed
template <class Block>
bool advance(const Block& block, const AcceptedStep& step, std::int32_t first_element,
             std::span<double> history, std::vector<Failure>& begun) {
  bool changed = false;
  const std::vector<Failure> reached = failures_of(block, step.u, history);
  for (std::size_t k = 0; k < reached.size(); ++k) {
    const auto own = failure_of(history.subspan(k * block.history_width(), block.history_width()));
    if (own[fade_time] == 0) {
      if (reached[k].reason == FailureReason::none) continue;
      own[fade_time] = block.material().failure.fade_steps * step.dt;
      if (step.dynamic) own[fade_time] = std::max(own[fade_time], crossing_time(block, k));
      own[time_of_failure] = step.time;
      own[reason_of_failure] = static_cast<double>(reached[k].reason);
      begun.push_back(reached[k]);
      begun.back().element += first_element;
    }
    if (own[lost_share] == 1) continue;
    own[lost_share] += step.dt / own[fade_time];
    if (own[lost_share] > 1 - gone_below) own[lost_share] = 1;
    changed = true;
  }
  return changed;
}

/// Visit the blocks that may fail, with their parts of a history.
template <int dim, class OfCells, class OfLines>
void for_failing(const CellIntegrals<dim>& cells, std::span<const double> history,
                 const OfCells& of_cells, const OfLines& of_lines) {
  for (std::size_t b = 0; b < cells.blocks().size(); ++b) {
    if (cells.blocks()[b].may_fail()) of_cells(cells.blocks()[b], cells.of_block(history, b));
  }
  for (std::size_t b = 0; b < cells.line_blocks().size(); ++b) {
    const LineBlock<dim>& block = cells.line_blocks()[b];
    if (block.may_fail()) of_lines(block, cells.of_line_block(history, b));
  }
}

/// The share that each cell or line of a block has lost.
template <class Block>
void find_lost_shares(const Block& block, std::span<const std::int32_t> elements,
                      std::span<const double> history, std::vector<double>& shares) {
  for (std::size_t k = 0; k < elements.size(); ++k) {
    shares[elements[k]] = 1 - block.share_left(k, history);
  }
}

}  // namespace

template <int dim>
bool may_fail(const CellIntegrals<dim>& cells) {
  const auto fails = [](const auto& block) { return block.may_fail(); };
  return std::ranges::any_of(cells.blocks(), fails) ||
         std::ranges::any_of(cells.line_blocks(), fails);
}

template <int dim>
FailureChange failure_after(const CellIntegrals<dim>& cells, const AcceptedStep& step) {
  FailureChange change{.history = {step.history.begin(), step.history.end()}, .begun = {}};
  bool changed = false;
  const auto writable = [&](std::span<const double> part) {
    return std::span(change.history)
        .subspan(static_cast<std::size_t>(part.data() - change.history.data()), part.size());
  };
  for_failing<dim>(
      cells, change.history,
      [&](const CellBlock<dim>& block, std::span<const double> own) {
        changed = advance(block, step, 0, writable(own), change.begun) || changed;
      },
      [&](const LineBlock<dim>& block, std::span<const double> own) {
        changed = advance(block, step, cells.num_cells(), writable(own), change.begun) || changed;
      });
  if (!changed) change.history.clear();
  return change;
}

template <int dim>
std::vector<double> lost_shares_of_cells(const CellIntegrals<dim>& cells,
                                         std::span<const double> history) {
  std::vector<double> shares(static_cast<std::size_t>(cells.num_cells()), 0.0);
  for_failing<dim>(
      cells, history,
      [&](const CellBlock<dim>& block, std::span<const double> own) {
        find_lost_shares(block, block.cells(), own, shares);
      },
      [](const LineBlock<dim>&, std::span<const double>) {});
  return shares;
}

template <int dim>
std::vector<double> lost_shares_of_lines(const CellIntegrals<dim>& cells,
                                         std::span<const double> history, std::int32_t num_lines) {
  std::vector<double> shares(static_cast<std::size_t>(num_lines), 0.0);
  for_failing<dim>(
      cells, history, [](const CellBlock<dim>&, std::span<const double>) {},
      [&](const LineBlock<dim>& block, std::span<const double> own) {
        find_lost_shares(block, block.lines(), own, shares);
      });
  return shares;
}

template <int dim>
std::vector<double> history_before_failure(const LineBlock<dim>& block,
                                           std::span<const double> history, double time) {
  std::vector<double> before(history.begin(), history.end());
  const std::size_t width = block.history_width();
  for (std::size_t first = 0; block.may_fail() && first < before.size(); first += width) {
    const auto own = failure_of(std::span(before).subspan(first, width));
    if (own[fade_time] > 0 && own[time_of_failure] == time) own[lost_share] = 0;
  }
  return before;
}

template <int dim>
std::int64_t count_failed(const CellIntegrals<dim>& cells, std::span<const double> history) {
  std::int64_t count = 0;
  const auto add = [&](const auto& block, std::span<const double> own) {
    const std::size_t width = block.history_width();
    for (std::size_t first = 0; first < own.size(); first += width) {
      if (failure_of(own.subspan(first, width))[fade_time] > 0) ++count;
    }
  };
  for_failing<dim>(cells, history, add, add);
  return count;
}

template <int dim>
void hold_nodes_of_gone(const CellIntegrals<dim>& cells, const Mesh<dim>& mesh,
                        std::span<const double> history, BlockMatrix<dim>& K) {
  const auto hold = [&](std::span<const std::int32_t> nodes, double stiffness) {
    for (const std::int32_t i : nodes) K.add_diagonal(i, holding_share * stiffness);
  };
  for_failing<dim>(
      cells, history,
      [&](const CellBlock<dim>& block, std::span<const double> own) {
        const double modulus =
            std::visit([](const auto& law) { return law.p_wave_modulus(); }, block.material().law);
        for (std::size_t c = 0; c < block.cells().size(); ++c) {
          if (block.share_left(c, own) > 0) continue;
          const auto weights = block.weights(c);
          const double volume = std::accumulate(weights.begin(), weights.end(), 0.0);
          hold(mesh.cell(block.cells()[c]), modulus * std::pow(volume, 1 - 2.0 / dim));
        }
      },
      [&](const LineBlock<dim>& block, std::span<const double> own) {
        for (std::size_t k = 0; k < block.lines().size(); ++k) {
          if (block.share_left(k, own) > 0) continue;
          const double stiffness = block.material().stiffness() / block.free_length(k);
          hold(mesh.line(block.lines()[k]), stiffness);
          if (block.beams()) hold(block.beams()->rotations(k), stiffness);
        }
      });
}

template <int dim>
std::string describe(const Failure& failure, const Mesh<dim>& mesh, const MeshRanks& ranks) {
  const bool is_line = failure.element >= mesh.num_cells();
  const auto nodes = mesh.element(failure.element);
  Vector<dim> centre = Vector<dim>::Zero();
  for (const std::int32_t i : nodes) centre += mesh.nodes[i] / static_cast<double>(nodes.size());
  const std::int64_t number = is_line ? ranks.line_of_all(failure.element - mesh.num_cells())
                                      : ranks.cell_of_all(failure.element);
  return fmt::format("{} {} near ({:.6g}) {}: {}", is_line ? "line" : "cell", number,
                     fmt::join(centre.data(), centre.data() + dim, ", "),
                     is_line ? "breaks" : "fails",
                     describe(failure.reason, failure.value, failure.limit));
}

template bool may_fail(const CellIntegrals<2>&);
template FailureChange failure_after(const CellIntegrals<2>&, const AcceptedStep&);
template std::vector<double> lost_shares_of_cells(const CellIntegrals<2>&, std::span<const double>);
template std::vector<double> lost_shares_of_lines(const CellIntegrals<2>&, std::span<const double>,
                                                  std::int32_t);
template std::vector<double> history_before_failure(const LineBlock<2>&, std::span<const double>,
                                                    double);
template std::int64_t count_failed(const CellIntegrals<2>&, std::span<const double>);
template void hold_nodes_of_gone(const CellIntegrals<2>&, const Mesh<2>&, std::span<const double>,
                                 BlockMatrix<2>&);
template std::string describe(const Failure&, const Mesh<2>&, const MeshRanks&);
template bool may_fail(const CellIntegrals<3>&);
template FailureChange failure_after(const CellIntegrals<3>&, const AcceptedStep&);
template std::vector<double> lost_shares_of_cells(const CellIntegrals<3>&, std::span<const double>);
template std::vector<double> lost_shares_of_lines(const CellIntegrals<3>&, std::span<const double>,
                                                  std::int32_t);
template std::vector<double> history_before_failure(const LineBlock<3>&, std::span<const double>,
                                                    double);
template std::int64_t count_failed(const CellIntegrals<3>&, std::span<const double>);
template void hold_nodes_of_gone(const CellIntegrals<3>&, const Mesh<3>&, std::span<const double>,
                                 BlockMatrix<3>&);
template std::string describe(const Failure&, const Mesh<3>&, const MeshRanks&);

}  // namespace gabion::fem
