// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/membrane_block.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/elements/shape_functions.hpp"

namespace gabion::fem {

namespace {

constexpr double flattest = 1e-10;  // area of a parallelogram over the square of the longest side

Eigen::Map<const Vector<3>> at(std::span<const double> u, std::int32_t node) {
  return Eigen::Map<const Vector<3>>(u.data() + static_cast<std::size_t>(node) * 3);
}
Eigen::Map<Vector<3>> at(std::span<double> f, std::int32_t node) {
  return Eigen::Map<Vector<3>>(f.data() + static_cast<std::size_t>(node) * 3);
}

/// Matrix of the unknowns of a sheet.
using SheetMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, 12, 12>;

Eigen::Matrix<double, 3, 2> tangents_at(CellType type, std::span<const Vector<3>> x,
                                        const Vector<2>& xi, ShapeValues<2>& shape) {
  shape_functions<2>(type, xi, shape);
  Eigen::Matrix<double, 3, 2> tangents = Eigen::Matrix<double, 3, 2>::Zero();
  for (std::size_t a = 0; a < x.size(); ++a) tangents += x[a] * shape.dN[a].transpose();
  return tangents;
}

/// Derivative of the strain by the displacement of a node, to be multiplied from the right.
Eigen::Matrix<double, 3, 3> strain_by_node(const Eigen::Matrix<double, 3, 2>& F,
                                           const Vector<2>& gradient) {
  Eigen::Matrix<double, 3, 3> B;
  B.row(0) = gradient[0] * F.col(0).transpose();
  B.row(1) = gradient[1] * F.col(1).transpose();
  B.row(2) = (gradient[0] * F.col(1) + gradient[1] * F.col(0)).transpose() / std::numbers::sqrt2;
  return B;
}

}  // namespace

MembraneBlock::MembraneBlock(const Mesh<3>& mesh, const MembraneMaterial& material,
                             std::vector<std::int32_t> sheets, bool lumped_mass)
    : material_(material),
      type_(facet_type(mesh.cell_type)),
      nodes_per_sheet_(static_cast<std::size_t>(num_nodes(type_))),
      sheets_(std::move(sheets)),
      lumped_mass_(lumped_mass),
      smallest_size_(std::numeric_limits<double>::infinity()) {
  require<ConfigError>(type_ == CellType::tri3 || type_ == CellType::quad4,
                       "{}: found \"formulation\" \"membrane\" with cells of type {}, allowed: "
                       "tri3, quad4",
                       material_.where, name(type_));
  const auto rule = gauss_rule<2>(type_, type_ == CellType::tri3 ? 1 : 3);
  points_per_sheet_ = rule.size();
  const Vector<2> middle = Vector<2>::Constant(type_ == CellType::tri3 ? 1.0 / 3 : 0.0);
  std::vector<Vector<3>> x(nodes_per_sheet_);
  for (const std::int32_t s : sheets_) {
    const auto nodes = mesh.sheet(s);
    nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
    for (std::size_t a = 0; a < x.size(); ++a) x[a] = mesh.nodes[nodes[a]];
    check(mesh.file, x);
    double area = 0;
    for (const auto& q : rule) {
      points_.push_back(point_at(x, q.xi));
      points_.back().weight *= q.weight;
      area += points_.back().weight / material_.thickness;
    }
    smallest_size_ = std::min(smallest_size_, std::sqrt(area));
    middles_.push_back(point_at(x, middle));
    add_masses(x);
  }
}

/// @param x  corners of the sheet [m]
void MembraneBlock::check(const std::string& file, std::span<const Vector<3>> x) const {
  const auto normal_at = [&](const Vector<2>& xi) -> Vector<3> {
    ShapeValues<2> shape;
    const auto tangents = tangents_at(type_, x, xi, shape);
    return tangents.col(0).cross(tangents.col(1));
  };
  const bool simplex = is_simplex(type_);
  const Vector<3> mean = normal_at(Vector<2>::Constant(simplex ? 1.0 / 3 : 0.0));
  double longest = 0;
  for (const auto& a : x) {
    for (const auto& b : x) longest = std::max(longest, (a - b).squaredNorm());
  }
  double least = mean.norm();
  for (const double xi : {-1.0, 1.0}) {
    for (const double eta : {-1.0, 1.0}) {
      if (!simplex) least = std::min(least, normal_at({xi, eta}).dot(mean) / mean.norm());
    }
  }
  if (least > flattest * longest) return;
  Vector<3> centre = Vector<3>::Zero();
  for (const auto& corner : x) centre += corner / static_cast<double>(x.size());
  throw ConfigError(fmt::format(
      "{}: found a degenerate, folded or non-convex membrane cell of type {} near ({:.6g}) in "
      "group \"{}\" of {}, allowed: cells whose corners turn one way round",
      material_.where, name(type_), fmt::join(centre.data(), centre.data() + 3, ", "),
      material_.group, file.empty() ? "a box" : file));
}

/// The weight is that per measure of the reference cell.
MembraneBlock::Point MembraneBlock::point_at(std::span<const Vector<3>> x,
                                             const Vector<2>& xi) const {
  ShapeValues<2> shape;
  const Frame tangents = tangents_at(type_, x, xi, shape);
  Frame axes;
  axes.col(0) = tangents.col(0).normalized();
  axes.col(1) = (tangents.col(1) - axes.col(0) * axes.col(0).dot(tangents.col(1))).normalized();
  const Matrix<2> J = axes.transpose() * tangents;
  const Matrix<2> inverse = J.inverse();
  const double stretch = material_.stretch();
  Point point{.frame = stretch * axes,
              .gradients = {},
              .weight = material_.thickness * J.determinant() / (stretch * stretch)};
  for (std::size_t a = 0; a < x.size(); ++a) {
    point.gradients[a] = stretch * (inverse.transpose() * shape.dN[a]);
  }
  return point;
}

void MembraneBlock::add_masses(std::span<const Vector<3>> x) {
  const std::size_t n = nodes_per_sheet_, first = masses_.size();
  masses_.resize(first + n * n, 0.0);
  for (const auto& q : gauss_rule<2>(type_, type_ == CellType::tri3 ? 2 : 3)) {
    ShapeValues<2> shape;
    shape_functions<2>(type_, q.xi, shape);
    const double mass = material_.density * q.weight * point_at(x, q.xi).weight;
    for (std::size_t a = 0; a < n; ++a) {
      for (std::size_t b = 0; b < n; ++b) {
        masses_[first + a * n + (lumped_mass_ ? a : b)] += mass * shape.N[a] * shape.N[b];
      }
    }
  }
}

/// 2 E = F^T F - 1, without the difference of large numbers where displacements are small.
StrainVector<2> MembraneBlock::strain(std::size_t k, const Point& point, std::span<const double> u,
                                      Frame& F) const {
  Frame H = Frame::Zero();
  const auto nodes = nodes_of(k);
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    H += at(u, nodes[a]) * point.gradients[a].transpose();
  }
  F = point.frame + H;
  const double start =
      material_.prestress * (1 - material_.poisson_ratio) / material_.young_modulus;
  const Matrix<2> mixed = point.frame.transpose() * H;
  const Matrix<2> change = 0.5 * (mixed + mixed.transpose() + H.transpose() * H);
  return strain_vector<2>(start * Matrix<2>::Identity() + change);
}

double MembraneBlock::add_internal(std::span<const double> u, std::span<double> f_int,
                                   BlockMatrix<3>* K, std::int32_t first) const {
  const std::size_t n = nodes_per_sheet_;
  double energy = 0;
  SheetMatrix K_sheet(n * 3, n * 3);
  for (std::size_t k = 0; k < sheets_.size(); ++k) {
    const auto nodes = nodes_of(k);
    if (K) K_sheet.setZero();
    for (std::size_t q = 0; q < points_per_sheet_; ++q) {
      const Point& point = points_[k * points_per_sheet_ + q];
      Frame F;
      const MembraneResponse response = respond(material_, strain(k, point, u, F));
      energy += point.weight * response.energy;
      if (response.state == MembraneState::slack) continue;
      const Matrix<2> S = strain_tensor<2>(response.stress.S);
      const Frame P = point.weight * F * S;
      for (std::size_t a = 0; a < n; ++a) at(f_int, nodes[a]) += P * point.gradients[a];
      if (!K) continue;
      std::array<Eigen::Matrix3d, most_nodes> B;
      for (std::size_t a = 0; a < n; ++a) B[a] = strain_by_node(F, point.gradients[a]);
      for (std::size_t a = 0; a < n; ++a) {
        const Eigen::Matrix3d left = point.weight * B[a].transpose() * response.stress.D;
        const Vector<2> pull = point.weight * S * point.gradients[a];
        for (std::size_t b = 0; b < n; ++b) {
          auto block = K_sheet.block<3, 3>(static_cast<Eigen::Index>(a) * 3,
                                           static_cast<Eigen::Index>(b) * 3);
          block.noalias() += left * B[b];
          block.diagonal().array() += pull.dot(point.gradients[b]);
        }
      }
    }
    if (K) K->add_cell(first + sheets_[k], K_sheet.data());
  }
  return energy;
}

void MembraneBlock::add_stiffness(double share, BlockMatrix<3>& K, std::int32_t first) const {
  const std::size_t n = nodes_per_sheet_;
  SheetMatrix K_sheet(n * 3, n * 3);
  for (std::size_t k = 0; k < sheets_.size(); ++k) {
    K_sheet.setZero();
    for (std::size_t q = 0; q < points_per_sheet_; ++q) {
      const Point& point = points_[k * points_per_sheet_ + q];
      const double stiffness = share * material_.young_modulus * point.weight;
      for (std::size_t a = 0; a < n; ++a) {
        for (std::size_t b = 0; b < n; ++b) {
          const double own = stiffness * point.gradients[a].dot(point.gradients[b]);
          for (std::size_t i = 0; i < 3; ++i) K_sheet(a * 3 + i, b * 3 + i) += own;
        }
      }
    }
    K.add_cell(first + sheets_[k], K_sheet.data());
  }
}

void MembraneBlock::add_mass_times(std::span<const double> a, std::span<double> f) const {
  const std::size_t n = nodes_per_sheet_;
  for (std::size_t k = 0; k < sheets_.size(); ++k) {
    const auto nodes = nodes_of(k);
    const double* M = masses_.data() + k * n * n;
    for (std::size_t i = 0; i < n; ++i) {
      Vector<3> sum = Vector<3>::Zero();
      for (std::size_t j = 0; j < n; ++j) sum += M[i * n + j] * at(a, nodes[j]);
      at(f, nodes[i]) += sum;
    }
  }
}

void MembraneBlock::add_mass(double scale, BlockMatrix<3>& K, std::int32_t first) const {
  const std::size_t n = nodes_per_sheet_;
  SheetMatrix M_sheet(n * 3, n * 3);
  for (std::size_t k = 0; k < sheets_.size(); ++k) {
    M_sheet.setZero();
    const double* M = masses_.data() + k * n * n;
    for (std::size_t a = 0; a < n; ++a) {
      for (std::size_t b = 0; b < n; ++b) {
        for (std::size_t i = 0; i < 3; ++i) M_sheet(a * 3 + i, b * 3 + i) = scale * M[a * n + b];
      }
    }
    K.add_cell(first + sheets_[k], M_sheet.data());
  }
}

std::vector<MembraneBlock::Values> MembraneBlock::values(std::span<const double> u) const {
  std::vector<Values> all(sheets_.size());
  for (std::size_t k = 0; k < sheets_.size(); ++k) {
    Values& own = all[k];
    Frame F;
    const StrainVector<2> E = strain(k, middles_[k], u, F);
    const double mean = 0.5 * (E[0] + E[1]);
    const double radius = std::hypot(0.5 * (E[0] - E[1]), E[2] / std::numbers::sqrt2);
    own.strain = std::sqrt(1 + 2 * (mean + radius)) - 1;
    const MembraneResponse response = respond(material_, E);
    own.state = response.state;
    if (own.state == MembraneState::slack) continue;
    const Matrix<2> S = strain_tensor<2>(response.stress.S);
    const Matrix<2> C = F.transpose() * F;
    const double scale = material_.thickness / std::sqrt(C.determinant());
    const Eigen::Matrix3d force = scale * F * S * F.transpose();
    own.force << force(0, 0), force(1, 1), force(2, 2), force(0, 1), force(1, 2), force(0, 2);
    // On axes of the deformed plane, so that equal values stay equal but for rounding.
    const Vector<3> along = F.col(0).normalized();
    const Vector<3> across = (F.col(1) - along * along.dot(F.col(1))).normalized();
    const double n_11 = along.dot(force * along), n_22 = across.dot(force * across);
    const double middle = 0.5 * (n_11 + n_22);
    const double half = std::hypot(0.5 * (n_11 - n_22), along.dot(force * across));
    own.principal = {middle + half, middle - half};
  }
  return all;
}

}  // namespace gabion::fem
