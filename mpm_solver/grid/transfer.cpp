// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/transfer.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "common/mechanics/simd/lanes.hpp"
#include "mpm_solver/grid/group_vectors.hpp"
#include "mpm_solver/points/flat.hpp"

namespace gabion::mpm {

namespace {

// Below this share of the mean nodal mass a mapped velocity is a quotient of rounding errors.
constexpr double weightless = 1e-14;

// Velocity of a point continued to a node at the distance `arm`.
template <int dim>
Vector<dim> velocity_at(const MaterialPoints<dim>& points, std::int32_t p, const Vector<dim>& arm) {
  return points.v[p] + points.grad_v[p] * arm;
}

template <int dim>
Vector<dim> acceleration_at(const MaterialPoints<dim>& points, std::int32_t p,
                            const Vector<dim>& arm) {
  return points.a[p] + points.grad_a[p] * arm;
}

// Mean velocity and acceleration of the points of the adjacent cells, for nodes without weight.
template <int dim>
void fill_weightless_nodes(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
                           double limit, GridNodes<dim>& nodes) {
  std::vector<double> count(nodes.m.size(), 0);
  std::vector<Vector<dim>> v(nodes.m.size(), Vector<dim>::Zero());
  std::vector<Vector<dim>> a(nodes.m.size(), Vector<dim>::Zero());
  for (const CellGroup& group : weights.groups) {
    for (const std::int32_t grid_node : weights.nodes_of(group)) {
      const std::int32_t i = nodes.active[grid_node];
      if (nodes.m[i] > limit) continue;
      for (std::int32_t e = group.first; e < group.last; ++e) {
        const std::int32_t p = weights.point[e];
        count[i] += 1;
        if (points.has_gradients()) {
          v[i] += velocity_at<dim>(points, p, nodes.x[i] - points.x[p]);
          a[i] += acceleration_at<dim>(points, p, nodes.x[i] - points.x[p]);
        } else {
          v[i] += points.v[p];
          a[i] += points.a[p];
        }
      }
    }
  }
  nodes.shared.sum(count, 1);
  nodes.shared.sum(flat(v), dim);
  nodes.shared.sum(flat(a), dim);
  for (std::size_t i = 0; i < count.size(); ++i) {
    if (nodes.m[i] > limit) continue;
    nodes.v[i] = v[i] / count[i];
    nodes.a[i] = a[i] / count[i];
  }
}

// Contribution of the gradients of a point to the momenta of its nodes, beyond m_p v_p and m_p a_p.
template <int dim>
void add_gradient_momentum(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
                           std::int32_t entry, const std::int32_t* active, GridNodes<dim>& nodes) {
  const std::int32_t p = weights.point[entry];
  const double* N = weights.N_of(entry);
  const std::uint8_t* local = weights.local_of(entry);
  for (int i = 0; i < weights.num_nodes(entry); ++i) {
    const std::int32_t node = active[local[i]];
    const Vector<dim> moment = N[i] * points.m[p] * (nodes.x[node] - points.x[p]);
    nodes.v[node] += points.grad_v[p] * moment;
    nodes.a[node] += points.grad_a[p] * moment;
  }
}

/// Mass and momenta at the nodes of a group, summed up over its points.
/// @tparam num_nodes  see EntryValues
template <int dim, int num_nodes>
class GroupMomenta {
 public:
  void start(int n) { std::fill_n(x_, n, Node{}); }
  void add(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
           std::int32_t entry) {
    const std::int32_t p = weights.point[entry];
    const EntryValues<dim, num_nodes> values(weights, entry);
    double moved[8] = {0, 0, 0, 0, 0, 0, 0, 1};
    for (int d = 0; d < dim; ++d) {
      moved[d] = points.v[p][d];
      moved[dim + d] = points.a[p][d];
    }
    const Lanes first = load_lanes(moved), last = load_lanes(moved + 4);
    for (int i = 0; i < values.size(); ++i) {
      const double weight = values.N[i] * points.m[p];
      Node& node = x_[values.number(i)];
      node.x[0] += weight * first;
      node.x[1] += weight * last;
    }
  }
  void scatter(int n, const std::int32_t* active, GridNodes<dim>& nodes) const {
    for (int i = 0; i < n; ++i) {
      nodes.m[active[i]] += x_[i].x[1][3];
      for (int d = 0; d < dim; ++d) {
        nodes.v[active[i]][d] += x_[i].x[d / 4][d % 4];
        nodes.a[active[i]][d] += x_[i].x[(dim + d) / 4][(dim + d) % 4];
      }
    }
  }

 private:
  /// m v, then m a; m stands last.
  struct Node {
    Lanes x[2] = {};
  };
  Node x_[max_group_nodes<dim>];
};

// The nodes that act on a point: values of an entry of PointWeights.
template <int dim>
struct EntryNodes {
  std::int32_t entry;
  const Vector<dim>* grad;
  const std::int32_t* active;  // numbers of the group's nodes
};

// Gradients of velocity and acceleration at the new position of a point.
template <int dim>
void update_gradients(const NodalMotion<dim>& motion, const PointWeights<dim>& weights,
                      const EntryNodes<dim>& at, MaterialPoints<dim>& points) {
  const std::uint8_t* local = weights.local_of(at.entry);
  Matrix<dim> F = Matrix<dim>::Identity();
  Matrix<dim> grad_v = Matrix<dim>::Zero();
  Matrix<dim> grad_a = Matrix<dim>::Zero();
  for (int i = 0; i < weights.num_nodes(at.entry); ++i) {
    const std::int32_t node = at.active[local[i]];
    F += motion.du[node] * at.grad[i].transpose();
    grad_v += motion.v_new[node] * at.grad[i].transpose();
    grad_a += motion.a_new[node] * at.grad[i].transpose();
  }
  const std::int32_t p = weights.point[at.entry];
  const Matrix<dim> F_inverse = F.inverse();
  points.grad_v[p] = grad_v * F_inverse;
  points.grad_a[p] = grad_a * F_inverse;
}

}  // namespace

template <int dim>
double weightless_mass(const GridNodes<dim>& nodes) {
  return weightless * total_mass(nodes) / static_cast<double>(nodes.num_of_all());
}

template <int dim>
void points_to_grid(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
                    GridNodes<dim>& nodes) {
  std::int32_t active[max_group_nodes<dim>];
  nodes.m.assign(nodes.grid_node.size(), 0);
  nodes.v.assign(nodes.m.size(), Vector<dim>::Zero());
  nodes.a.assign(nodes.m.size(), Vector<dim>::Zero());
  with_num_nodes(weights, [&]<int n>() {
    GroupMomenta<dim, n> momenta;
    for (const CellGroup& group : weights.groups) {
      nodes.list_active(weights.nodes_of(group), active);
      momenta.start(group.num_nodes);
      for (std::int32_t e = group.first; e < group.last; ++e) {
        momenta.add(points, weights, e);
        if (points.has_gradients()) add_gradient_momentum(points, weights, e, active, nodes);
      }
      momenta.scatter(group.num_nodes, active, nodes);
    }
  });
  nodes.shared.sum(nodes.m, 1);
  nodes.shared.sum(flat(nodes.v), dim);
  nodes.shared.sum(flat(nodes.a), dim);

  const double limit = weightless_mass(nodes);
  bool any_weightless = false;
  for (std::size_t i = 0; i < nodes.m.size(); ++i) {
    if (nodes.m[i] > limit) {
      nodes.v[i] /= nodes.m[i];
      nodes.a[i] /= nodes.m[i];
    } else {
      any_weightless = true;
    }
  }
  if (nodes.shared.all(!any_weightless)) return;
  fill_weightless_nodes(points, weights, limit, nodes);
}

template <int dim>
std::vector<double> point_forces(const MaterialPoints<dim>& points,
                                 const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                                 std::span<const Vector<dim>> b) {
  std::vector<double> f(nodes.grid_node.size() * dim, 0.0);
  with_num_nodes(weights, [&]<int n>() {
    GroupVectors<dim, n> sum;
    for (const CellGroup& group : weights.groups) {
      sum.set_zero(group.num_nodes);
      for (std::int32_t e = group.first; e < group.last; ++e) {
        const std::int32_t p = weights.point[e];
        sum.add(weights, e, points.m[p] * b[p]);
      }
      sum.scatter(nodes, weights.nodes_of(group), f);
    }
  });
  nodes.shared.sum(f, dim);
  return f;
}

template <int dim>
void grid_to_points(const GridNodes<dim>& nodes, const NodalMotion<dim>& motion,
                    const PointWeights<dim>& weights, double pic_share,
                    MaterialPoints<dim>& points) {
  std::int32_t active[max_group_nodes<dim>];
  for (const CellGroup& group : weights.groups) {
    nodes.list_active(weights.nodes_of(group), active);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      const int n = weights.num_nodes(e);
      const double* N = weights.N_of(e);
      const std::uint8_t* local = weights.local_of(e);
      Vector<dim> du = Vector<dim>::Zero();
      Vector<dim> dv = Vector<dim>::Zero();
      Vector<dim> v_grid = Vector<dim>::Zero();
      Vector<dim> a_grid = Vector<dim>::Zero();
      for (int i = 0; i < n; ++i) {
        du += N[i] * motion.du[active[local[i]]];
        dv += N[i] * (motion.v_new[active[local[i]]] - nodes.v[active[local[i]]]);
        v_grid += N[i] * motion.v_new[active[local[i]]];
        a_grid += N[i] * motion.a_new[active[local[i]]];
      }
      if (points.has_gradients()) {
        const std::int32_t row = weights.constant_gradient ? group.first : e;
        update_gradients<dim>(motion, weights,
                              {.entry = e, .grad = weights.grad_of(row), .active = active}, points);
      }
      points.x[p] += du;
      points.u[p] += du;
      points.v[p] = (1 - pic_share) * (points.v[p] + dv) + pic_share * v_grid;
      points.a[p] = a_grid;
    }
  }
}

template double weightless_mass<2>(const GridNodes<2>&);
template double weightless_mass<3>(const GridNodes<3>&);
template void points_to_grid<2>(const MaterialPoints<2>&, const PointWeights<2>&, GridNodes<2>&);
template void points_to_grid<3>(const MaterialPoints<3>&, const PointWeights<3>&, GridNodes<3>&);
template std::vector<double> point_forces<2>(const MaterialPoints<2>&, const PointWeights<2>&,
                                             const GridNodes<2>&, std::span<const Vector<2>>);
template std::vector<double> point_forces<3>(const MaterialPoints<3>&, const PointWeights<3>&,
                                             const GridNodes<3>&, std::span<const Vector<3>>);
template void grid_to_points<2>(const GridNodes<2>&, const NodalMotion<2>&, const PointWeights<2>&,
                                double, MaterialPoints<2>&);
template void grid_to_points<3>(const GridNodes<3>&, const NodalMotion<3>&, const PointWeights<3>&,
                                double, MaterialPoints<3>&);

}  // namespace gabion::mpm
