// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/beam_cells.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "common/base/require.hpp"
#include "fem_solver/beams/beam_axes.hpp"

namespace gabion::fem {

namespace {

constexpr double largest_angle = 3;  // of a node in a step, and between nodes [rad]

Turn<double> accepted_turn(std::span<const double> history, int end) {
  const double* q = &history[4 * end];
  return {1 + q[0], {q[1], q[2], q[3]}};
}

template <class S>
Turn<S> constant(const Turn<double>& q) {
  return {S(q.w), {S(q.v[0]), S(q.v[1]), S(q.v[2])}};
}

}  // namespace

template <int dim>
BeamCells<dim>::BeamCells(const Mesh<dim>& mesh, const LineMaterial& material,
                          std::span<const std::int32_t> lines, const BeamNodes& nodes)
    : material_(material),
      stiffness_(material.beam->stiffness(material.young_modulus)),
      length_(nodes.length) {
  if (material.hardening) {
    fibre_numbers_ = FibreSection::fibre_width * material.beam->section.fibres.size();
  }
  for (const std::int32_t l : lines) {
    const auto ends = mesh.line(l);
    Cell cell{.element = mesh.num_cells() + l,
              .nodes = {ends[0], ends[1], nodes.of(ends[0]), nodes.of(ends[1])},
              .length = 0,
              .chord = mesh.nodes[ends[1]] - mesh.nodes[ends[0]],
              .frame = {},
              .rotary_mass = 0};
    require(cell.nodes[2] >= 0 && cell.nodes[3] >= 0, "beams: found nodes without rotations");
    cell.length = cell.chord.norm();
    const auto& moments = material.beam->section.moments;
    const double I = dim == 2 ? moments[1] : std::max(moments[0], moments[1]);
    cell.rotary_mass = 0.5 * material.density * I * cell.length / (length_ * length_);
    if constexpr (dim == 3) set_frame(material, cell);
    cells_.push_back(cell);
  }
}

template <int dim>
void BeamCells<dim>::set_frame(const LineMaterial& material, Cell& cell) const {
  if constexpr (dim == 3) {
    const Eigen::Quaterniond q(beam_axes(*material.beam, cell.chord, material.where));
    cell.frame = {q.w(), {q.x(), q.y(), q.z()}};
  }
}

/// Rotations of both nodes.
template <int dim>
template <class S>
std::array<Turn<S>, 2> BeamCells<dim>::turns(const Cell& cell, std::span<const double> u,
                                             std::span<const double> history) const {
  std::array<Turn<S>, 2> result;
  for (int end = 0; end < 2; ++end) {
    Triple<S> angle;
    for (int c = 0; c < 3; ++c) {
      const double w = u[static_cast<std::size_t>(cell.nodes[2 + end]) * 3 + c];
      angle[c] = S(1 / length_) * unknown<S>(w - history[8 + 3 * end + c], (2 + end) * 3 + c);
    }
    result[end] = turn_by(angle) * constant<S>(accepted_turn(history, end));
  }
  return result;
}

template <int dim>
template <class S>
auto BeamCells<dim>::forces(const Cell& cell, std::span<const double> u,
                            HistoryStep history) const {
  const auto accepted = history.accepted;
  if (fibre_numbers_ == 0) return forces_with<S>(ElasticSection{stiffness_}, cell, u, accepted);
  const FibreSection section(material_, stiffness_, history.part(rotation_width, fibre_numbers_));
  return forces_with<S>(section, cell, u, accepted);
}

template <int dim>
template <class S, class Section>
auto BeamCells<dim>::forces_with(const Section& section, const Cell& cell,
                                 std::span<const double> u, std::span<const double> history) const {
  std::array<S, dim> chord;
  for (int c = 0; c < dim; ++c) {
    const auto at = [&](int end) {
      const double x = u[static_cast<std::size_t>(cell.nodes[end]) * dim + c];
      return unknown<S>(x, end * dim + c);
    };
    chord[c] = S(cell.chord[c]) + (at(1) - at(0));
  }
  if constexpr (dim == 3) {
    const auto q = turns<S>(cell, u, history);
    return beam_forces({cell.frame, cell.length}, chord, q[0], q[1], section);
  } else {
    const auto angle = [&](int end) {
      const double w = u[static_cast<std::size_t>(cell.nodes[2 + end]) * 2];
      return S(1 / length_) * unknown<S>(w, (2 + end) * 2);
    };
    const StraightFrame frame = {{cell.chord[0] / cell.length, cell.chord[1] / cell.length},
                                 cell.length};
    return frame_forces(frame, chord, angle(0), angle(1), section);
  }
}

/// Write the rotations at the end of the step into the trial history.
/// @returns  what is wrong, null: nothing
template <int dim>
const char* BeamCells<dim>::remember(const Cell& cell, std::span<const double> u,
                                     HistoryStep history) const {
  if constexpr (dim == 3) {
    const auto q = turns<double>(cell, u, history.accepted);
    for (int end = 0; end < 2; ++end) {
      double square = 0;
      for (int c = 0; c < 3; ++c) {
        const double w = u[static_cast<std::size_t>(cell.nodes[2 + end]) * 3 + c];
        const double angle = (w - history.accepted[8 + 3 * end + c]) / length_;
        square += angle * angle;
        history.trial[8 + 3 * end + c] = w;
      }
      if (!(square < largest_angle * largest_angle)) return "a rotation of 3 rad in a step";
      const double size = std::sqrt(q[end].w * q[end].w + dot(q[end].v, q[end].v));
      double* own = &history.trial[4 * end];
      own[0] = q[end].w / size - 1;
      for (int c = 0; c < 3; ++c) own[1 + c] = q[end].v[c] / size;
    }
  }
  return nullptr;
}

template <int dim>
void BeamCells<dim>::add_to(const Cell& cell, std::span<const double> f_cell,
                            std::span<double> f_int) const {
  for (int a = 0; a < 4; ++a) {
    for (int c = 0; c < dim; ++c) {
      f_int[static_cast<std::size_t>(cell.nodes[a]) * dim + c] += f_cell[a * dim + c];
    }
  }
}

namespace {

/// Forces in the order of a cell's unknowns.
template <class S>
std::array<S, 12> of_unknowns(const BeamForces<S>& b, double length) {
  std::array<S, 12> f;
  for (int c = 0; c < 3; ++c) {
    f[c] = -b.n[c];
    f[3 + c] = b.n[c];
    f[6 + c] = S(1 / length) * b.m_1[c];
    f[9 + c] = S(1 / length) * b.m_2[c];
  }
  return f;
}
template <class S>
std::array<S, 8> of_unknowns(const FrameForces<S>& b, double length) {
  const S none = 0.0, l = 1 / length;
  return {-b.n[0], -b.n[1], b.n[0], b.n[1], l * b.m_1, none, l * b.m_2, none};
}

double angle_between(const BeamForces<double>& b) {
  return b.relative;
}
double angle_between(const FrameForces<double>&) {
  return 0;
}

}  // namespace

template <int dim>
StressIntegral BeamCells<dim>::add_internal(std::span<const double> u, std::span<double> f_int,
                                            BlockMatrix<dim>* K, HistoryStep history) const {
  StressIntegral result;
  for (std::size_t k = 0; k < cells_.size(); ++k) {
    const Cell& cell = cells_[k];
    const HistoryStep own = history.part(k * history_width(), history_width());
    const double share = material_.failure.any() ? share_left(own.accepted) : 1;
    if (material_.failure.any()) keep_failure(share, own);
    if (share == 0) {  // the rotations of its nodes go on
      if (const char* fault = remember(cell, u, own)) {
        return {.inadmissible_cell = cell.element, .fault = fault, .energy = result.energy};
      }
      continue;
    }
    const auto beam = forces<double>(cell, u, own);
    const char* fault = remember(cell, u, own);
    if (angle_between(beam) > largest_angle) fault = "nodes turned by 3 rad to each other";
    if (fault) {
      return {.inadmissible_cell = cell.element, .fault = fault, .energy = result.energy};
    }
    result.energy += share * beam.energy;
    auto f_cell = of_unknowns(beam, length_);
    for (double& f : f_cell) f *= share;
    add_to(cell, f_cell, f_int);
    if (!K) continue;
    const auto f = of_unknowns(forces<Own>(cell, u, own), length_);
    std::array<double, num_unknowns * num_unknowns> K_cell;
    for (int i = 0; i < num_unknowns; ++i) {
      std::ranges::copy(f[i].slope, K_cell.begin() + i * num_unknowns);
    }
    for (double& slope : K_cell) slope *= share;
    K->add_cell(cell.element, K_cell.data());
  }
  return result;
}

template <int dim>
void BeamCells<dim>::add_rotary_mass_times(std::span<const double> a, std::span<double> f) const {
  constexpr int num_rotations = dim == 3 ? 3 : 1;
  for (const Cell& cell : cells_) {
    for (int end = 2; end < 4; ++end) {
      const std::size_t first = static_cast<std::size_t>(cell.nodes[end]) * dim;
      for (int c = 0; c < num_rotations; ++c) f[first + c] += cell.rotary_mass * a[first + c];
    }
  }
}

template <int dim>
void BeamCells<dim>::add_rotary_mass(double scale, BlockMatrix<dim>& K) const {
  for (const Cell& cell : cells_) {
    for (int end = 2; end < 4; ++end) K.add_diagonal(cell.nodes[end], scale * cell.rotary_mass);
  }
}

template <int dim>
std::vector<SectionResultants<double>> BeamCells<dim>::resultants(
    std::span<const double> u, std::span<const double> history) const {
  std::vector<SectionResultants<double>> result;
  std::vector<double> unused(history_width());
  for (std::size_t k = 0; k < cells_.size(); ++k) {
    const auto own = history.subspan(k * history_width(), history_width());
    const auto beam = forces<double>(cells_[k], u, {.accepted = own, .trial = unused});
    const double share = material_.failure.any() ? share_left(own) : 1;
    SectionResultants<double> section{{}, {}};
    if constexpr (dim == 3) {
      section = beam.section;
    } else {
      section = {{beam.N, beam.V, 0}, {0, 0, beam.M}};
    }
    for (double& force : section.force) force *= share;
    for (double& moment : section.moment) moment *= share;
    result.push_back(section);
  }
  return result;
}

template <int dim>
template <class Visit>
void BeamCells<dim>::for_each_fibre(std::size_t k, std::span<const double> history,
                                    const Visit& visit) const {
  constexpr std::size_t width = FibreSection::fibre_width;
  const std::size_t first = k * history_width() + rotation_width;
  for (std::size_t i = 0; i * width < fibre_numbers_; ++i) {
    visit(i, history.subspan(first + i * width, width));
  }
}

template <int dim>
double BeamCells<dim>::plastic_work(std::size_t k, std::span<const double> history) const {
  double sum = 0;
  for_each_fibre(k, history, [&](std::size_t i, std::span<const double> own) {
    sum += material_.beam->section.fibres[i].area * fem::plastic_work(material_, own);
  });
  return cells_[k].length * sum;
}

template <int dim>
double BeamCells<dim>::plastic_strain(std::size_t k, std::span<const double> history) const {
  double largest = 0;
  for_each_fibre(k, history, [&](std::size_t, std::span<const double> own) {
    largest = std::max(largest, own[1]);
  });
  return largest;
}

template class BeamCells<2>;
template class BeamCells<3>;

}  // namespace gabion::fem
