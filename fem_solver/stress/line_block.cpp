// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/line_block.hpp"

#include <fmt/format.h>

#include <utility>

#include "common/base/require.hpp"

namespace gabion::fem {

namespace {

constexpr double shortest_share = 1e-9;  // of the stress-free length, of a line with a force

template <int dim>
Eigen::Map<const Vector<dim>> at(std::span<const double> u, std::int32_t node) {
  return Eigen::Map<const Vector<dim>>(u.data() + static_cast<std::size_t>(node) * dim);
}
template <int dim>
Eigen::Map<Vector<dim>> at(std::span<double> f, std::int32_t node) {
  return Eigen::Map<Vector<dim>>(f.data() + static_cast<std::size_t>(node) * dim);
}

/// Matrix of the nodes of a line, in memory that is used again.
using LineMatrix =
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

LineMatrix line_matrix(std::size_t num_unknowns, std::vector<double>& memory) {
  memory.resize(num_unknowns * num_unknowns);
  const auto n = static_cast<Eigen::Index>(num_unknowns);
  return {memory.data(), n, n};
}

template <int dim>
void set_block(LineMatrix& K, std::size_t a, std::size_t b, const Matrix<dim>& S) {
  K.template block<dim, dim>(static_cast<Eigen::Index>(a) * dim,
                             static_cast<Eigen::Index>(b) * dim) = S;
}

}  // namespace

template <int dim>
LineBlock<dim>::LineBlock(const Mesh<dim>& mesh, const LineMaterial& material,
                          std::vector<std::int32_t> lines, bool lumped_mass,
                          const LinesOfMesh<dim>& of)
    : material_(material),
      lines_(std::move(lines)),
      num_cells_(mesh.num_cells()),
      // The held end of a rope feels the rope's force alone then, never a push.
      lumped_mass_(lumped_mass || !material_.in_compression) {
  const EmbeddedNodes<dim>& embedded = of.nodes_inside();
  if (material_.beam) beams_.emplace(mesh, material_, lines_, of.beam_nodes);
  for (const std::int32_t l : lines_) {
    const auto ends = mesh.line(l);
    for (const std::int32_t i : embedded.line_nodes(mesh, l)) {
      shares_.push_back({i, embedded.weight(ends[0], i), embedded.weight(ends[1], i)});
    }
    starts_.push_back(shares_.size());
    chords_.push_back(mesh.nodes[ends[1]] - mesh.nodes[ends[0]]);
    free_lengths_.push_back(material_.length_ratio * chords_.back().norm());
    if (!material_.brake) continue;
    const double k = material_.stiffness() / free_lengths_.back();
    require<ConfigError>(material_.brake->steepest_fall() < k,
                         "{}: found a brake whose force falls by {:.6g} N/m, allowed: less than "
                         "the stiffness of its line, {:.6g} N/m over {:.6g} m; it would tear",
                         material_.where, material_.brake->steepest_fall(), k,
                         free_lengths_.back());
  }
}

template <int dim>
typename LineBlock<dim>::Ends LineBlock<dim>::ends(std::size_t k, std::span<const double> u) const {
  Vector<dim> u_1 = Vector<dim>::Zero(), u_2 = Vector<dim>::Zero();
  for (const Share& share : shares(k)) {
    u_1 += share.first * at<dim>(u, share.node);
    u_2 += share.second * at<dim>(u, share.node);
  }
  const Vector<dim> chord = chords_[k] + u_2 - u_1;
  const double length = chord.norm();
  return {.direction = length > 0 ? Vector<dim>(chord / length) : Vector<dim>::Zero(),
          .length = length};
}

/// K_ab += g_a g_b S, g the share in the second end less that in the first: K_11 = K_22 += S and
/// K_12 = K_21 -= S where both ends are nodes.
template <int dim>
void LineBlock<dim>::add_pair(std::size_t k, const Matrix<dim>& S, BlockMatrix<dim>& K,
                              std::vector<double>& memory) const {
  const auto own = shares(k);
  LineMatrix K_line = line_matrix(own.size() * dim, memory);
  for (std::size_t a = 0; a < own.size(); ++a) {
    for (std::size_t b = 0; b < own.size(); ++b) {
      const double share = (own[a].second - own[a].first) * (own[b].second - own[b].first);
      set_block<dim>(K_line, a, b, share * S);
    }
  }
  K.add_cell(num_cells_ + lines_[k], K_line.data());
}

template <int dim>
StressIntegral LineBlock<dim>::add_internal(std::span<const double> u, std::span<double> f_int,
                                            BlockMatrix<dim>* K, HistoryStep history) const {
  if (beams_) return beams_->add_internal(u, f_int, K, history);
  StressIntegral result;
  std::vector<double> memory;
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const HistoryStep own = history.part(k * history_width(), history_width());
    const double left = share_left(k, history.accepted);
    if (may_fail()) keep_failure(left, own);
    if (left == 0) continue;
    const auto [e, length] = ends(k, u);
    LineResponse line = respond(material_, free_lengths_[k], length, own.accepted, own.trial);
    line.force *= left;
    line.slope *= left;
    result.energy += left * line.energy;
    if (line.force == 0 && line.slope == 0) continue;
    if (length < shortest_share * free_lengths_[k]) {
      return {.inadmissible_cell = num_cells_ + lines_[k],
              .fault = "no length",
              .energy = result.energy};
    }
    if (has_plain_ends(k)) {
      at<dim>(f_int, shares(k)[1].node) += line.force * e;
      at<dim>(f_int, shares(k)[0].node) -= line.force * e;
    } else {
      for (const Share& share : shares(k)) {
        at<dim>(f_int, share.node) += (share.second - share.first) * (line.force * e);
      }
    }
    if (!K) continue;
    const Matrix<dim> along = e * e.transpose();
    add_pair(k, line.slope * along + line.force / length * (Matrix<dim>::Identity() - along), *K,
             memory);
  }
  return result;
}

template <int dim>
void LineBlock<dim>::add_stiffness(double share, BlockMatrix<dim>& K) const {
  if (beams_) return;
  std::vector<double> memory;
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const double stiffness = share * material_.stiffness() / free_lengths_[k];
    add_pair(k, stiffness * Matrix<dim>::Identity(), K, memory);
  }
}

template <int dim>
void LineBlock<dim>::add_mass_times(std::span<const double> a, std::span<double> f) const {
  if (beams_) beams_->add_rotary_mass_times(a, f);
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const double mass = material_.density * material_.area * free_lengths_[k];
    const double own = lumped_mass_ ? 1.0 / 2 : 1.0 / 3, other = 0.5 - own;
    if (has_plain_ends(k)) {
      const std::int32_t i = shares(k)[0].node, j = shares(k)[1].node;
      const Vector<dim> a_1 = at<dim>(a, i), a_2 = at<dim>(a, j);
      at<dim>(f, i) += mass * (own * a_1 + other * a_2);
      at<dim>(f, j) += mass * (own * a_2 + other * a_1);
      continue;
    }
    Vector<dim> a_1 = Vector<dim>::Zero(), a_2 = Vector<dim>::Zero();
    for (const Share& share : shares(k)) {
      a_1 += share.first * at<dim>(a, share.node);
      a_2 += share.second * at<dim>(a, share.node);
    }
    const Vector<dim> f_1 = mass * (own * a_1 + other * a_2);
    const Vector<dim> f_2 = mass * (own * a_2 + other * a_1);
    for (const Share& share : shares(k)) {
      at<dim>(f, share.node) += share.first * f_1 + share.second * f_2;
    }
  }
}

template <int dim>
void LineBlock<dim>::add_mass(double scale, BlockMatrix<dim>& K) const {
  const Matrix<dim> unit = Matrix<dim>::Identity();
  std::vector<double> memory;
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const double mass = scale * material_.density * material_.area * free_lengths_[k];
    const double own = lumped_mass_ ? 1.0 / 2 : 1.0 / 3, other = 0.5 - own;
    const auto nodes = shares(k);
    if (beams_) {
      for (int end = 0; end < 2; ++end) {
        K.add_block(nodes[end].node, nodes[end].node, own * mass * unit);
        K.add_block(nodes[end].node, nodes[1 - end].node, other * mass * unit);
      }
      continue;
    }
    LineMatrix M = line_matrix(nodes.size() * dim, memory);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Share& a = nodes[i];
      for (std::size_t j = 0; j < nodes.size(); ++j) {
        const Share& b = nodes[j];
        const double share = own * (a.first * b.first + a.second * b.second) +
                             other * (a.first * b.second + a.second * b.first);
        set_block<dim>(M, i, j, share * unit);
      }
    }
    M *= mass;
    K.add_cell(num_cells_ + lines_[k], M.data());
  }
  if (beams_) beams_->add_rotary_mass(scale, K);
}

template <int dim>
std::vector<double> LineBlock<dim>::forces(std::span<const double> u,
                                           std::span<const double> history) const {
  std::vector<double> forces;
  if (beams_) {
    for (const auto& beam : beams_->resultants(u, history)) forces.push_back(beam.force[0]);
    return forces;
  }
  const std::size_t width = history_width();
  std::vector<double> unused(width);
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const auto own = history.subspan(k * width, width);
    const double share = share_left(k, history);
    forces.push_back(share *
                     respond(material_, free_lengths_[k], ends(k, u).length, own, unused).force);
  }
  return forces;
}

template <int dim>
std::vector<double> LineBlock<dim>::strains(std::span<const double> u,
                                            std::span<const double> history) const {
  std::vector<double> strains(lines_.size(), 0.0);
  for (std::size_t k = 0; !beams_ && k < lines_.size(); ++k) {
    const double run = material_.brake ? history[k * history_width()] : 0;
    strains[k] = (ends(k, u).length - free_lengths_[k] - run) / free_lengths_[k];
  }
  return strains;
}

template <int dim>
double LineBlock<dim>::brake_work(std::span<const double> history) const {
  double sum = 0;
  if (!material_.brake) return sum;
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    sum += share_left(k, history) * material_.brake->work(history[k * history_width()]);
  }
  return sum;
}

template <int dim>
double LineBlock<dim>::plastic_work(std::span<const double> history) const {
  double sum = 0;
  if (!yields()) return sum;
  for (std::size_t k = 0; beams_ && k < lines_.size(); ++k) {
    sum += share_left(k, history) * beams_->plastic_work(k, history);
  }
  for (std::size_t k = 0; !beams_ && k < lines_.size(); ++k) {
    sum += share_left(k, history) * material_.area * free_lengths_[k] *
           fem::plastic_work(material_, history.subspan(k * history_width(), history_width()));
  }
  return sum;
}

template <int dim>
std::vector<double> LineBlock<dim>::plastic_strains(std::span<const double> history) const {
  std::vector<double> strains;
  if (!yields()) return strains;
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    strains.push_back(beams_ ? beams_->plastic_strain(k, history)
                             : history[k * history_width() + 1]);
  }
  return strains;
}

template class LineBlock<2>;
template class LineBlock<3>;

}  // namespace gabion::fem
