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

}  // namespace

template <int dim>
LineBlock<dim>::LineBlock(const Mesh<dim>& mesh, const LineMaterial& material,
                          std::vector<std::int32_t> lines, bool lumped_mass,
                          const BeamNodes& beam_nodes)
    : material_(material),
      lines_(std::move(lines)),
      num_cells_(mesh.num_cells()),
      lumped_mass_(lumped_mass) {
  if (material_.beam) beams_.emplace(mesh, material_, lines_, beam_nodes);
  for (const std::int32_t l : lines_) {
    const auto ends = mesh.line(l);
    nodes_.insert(nodes_.end(), ends.begin(), ends.end());
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
  const Vector<dim> chord = chords_[k] + at<dim>(u, node(k, 1)) - at<dim>(u, node(k, 0));
  const double length = chord.norm();
  return {.direction = length > 0 ? Vector<dim>(chord / length) : Vector<dim>::Zero(),
          .length = length};
}

/// K_11 = K_22 += S, K_12 = K_21 -= S.
template <int dim>
void LineBlock<dim>::add_pair(std::size_t k, const Matrix<dim>& S, BlockMatrix<dim>& K) const {
  Eigen::Matrix<double, 2 * dim, 2 * dim, Eigen::RowMajor> K_line;
  K_line << S, -S, -S, S;
  K.add_cell(num_cells_ + lines_[k], K_line.data());
}

template <int dim>
StressIntegral LineBlock<dim>::add_internal(std::span<const double> u, std::span<double> f_int,
                                            BlockMatrix<dim>* K, HistoryStep history) const {
  if (beams_) return beams_->add_internal(u, f_int, K, history);
  StressIntegral result;
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const auto [e, length] = ends(k, u);
    const HistoryStep own = history.part(k * history_width(), history_width());
    const LineResponse line = respond(material_, free_lengths_[k], length, own.accepted, own.trial);
    result.energy += line.energy;
    if (line.force == 0 && line.slope == 0) continue;
    if (length < shortest_share * free_lengths_[k]) {
      return {.inadmissible_cell = num_cells_ + lines_[k],
              .fault = "no length",
              .energy = result.energy};
    }
    at<dim>(f_int, node(k, 1)) += line.force * e;
    at<dim>(f_int, node(k, 0)) -= line.force * e;
    if (!K) continue;
    const Matrix<dim> along = e * e.transpose();
    add_pair(k, line.slope * along + line.force / length * (Matrix<dim>::Identity() - along), *K);
  }
  return result;
}

template <int dim>
void LineBlock<dim>::add_stiffness(double share, BlockMatrix<dim>& K) const {
  if (beams_) return;
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    add_pair(k, share * material_.stiffness() / free_lengths_[k] * Matrix<dim>::Identity(), K);
  }
}

template <int dim>
void LineBlock<dim>::add_mass_times(std::span<const double> a, std::span<double> f) const {
  if (beams_) beams_->add_rotary_mass_times(a, f);
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const double mass = material_.density * material_.area * free_lengths_[k];
    const Vector<dim> a_1 = at<dim>(a, node(k, 0)), a_2 = at<dim>(a, node(k, 1));
    const double own = lumped_mass_ ? 1.0 / 2 : 1.0 / 3, other = 0.5 - own;
    at<dim>(f, node(k, 0)) += mass * (own * a_1 + other * a_2);
    at<dim>(f, node(k, 1)) += mass * (own * a_2 + other * a_1);
  }
}

template <int dim>
void LineBlock<dim>::add_mass(double scale, BlockMatrix<dim>& K) const {
  const Matrix<dim> unit = Matrix<dim>::Identity();
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const double mass = scale * material_.density * material_.area * free_lengths_[k];
    const double own = lumped_mass_ ? 1.0 / 2 : 1.0 / 3, other = 0.5 - own;
    if (beams_) {
      for (int end = 0; end < 2; ++end) {
        K.add_block(node(k, end), node(k, end), own * mass * unit);
        K.add_block(node(k, end), node(k, 1 - end), other * mass * unit);
      }
      continue;
    }
    Eigen::Matrix<double, 2 * dim, 2 * dim, Eigen::RowMajor> M;
    M << own * unit, other * unit, other * unit, own * unit;
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
    forces.push_back(respond(material_, free_lengths_[k], ends(k, u).length, own, unused).force);
  }
  return forces;
}

template <int dim>
double LineBlock<dim>::brake_work(std::span<const double> history) const {
  double sum = 0;
  if (!material_.brake) return sum;
  for (const double run : history) sum += material_.brake->work(run);
  return sum;
}

template <int dim>
double LineBlock<dim>::plastic_work(std::span<const double> history) const {
  double sum = 0;
  if (!yields()) return sum;
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    sum += material_.area * free_lengths_[k] *
           fem::plastic_work(material_, history.subspan(k * history_width(), history_width()));
  }
  return sum;
}

template <int dim>
std::vector<double> LineBlock<dim>::plastic_strains(std::span<const double> history) const {
  std::vector<double> strains;
  if (!yields()) return strains;
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    strains.push_back(history[k * history_width() + 1]);
  }
  return strains;
}

template class LineBlock<2>;
template class LineBlock<3>;

}  // namespace gabion::fem
