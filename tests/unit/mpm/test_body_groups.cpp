// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mpm_solver/contact/contact_plane.hpp"
#include "mpm_solver/contact/group_config.hpp"
#include "mpm_solver/contact/group_contact.hpp"
#include "mpm_solver/grid/group_fields.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_body_groups {
namespace {

using mpm::BodyGroups;

constexpr double h = 0.1;

BodyGroups two_groups(double friction) {
  BodyGroups groups;
  groups.names = {"lower", "upper"};
  groups.of_body = {0, 1};
  groups.pairs = {{.first = 0, .second = 1, .friction = friction}};
  return groups;
}

/// Two bodies on a box grid, with a field each.
template <int dim>
struct TwoBodies {
  mpm::BackgroundGrid<dim> grid;
  BodyGroups groups;
  mpm::MaterialPoints<dim> points;
  mpm::PointWeights<dim> weights;
  mpm::GridNodes<dim> nodes;
  std::vector<double> moduli = {2e6, 1e6};

  TwoBodies(mpm::Basis basis, const BodyGroups& groups_) : grid(box(basis)), groups(groups_) {}

  static mpm::BackgroundGrid<dim> box(mpm::Basis basis) {
    const auto cells = Eigen::Matrix<int, dim, 1>::Constant(12);
    mpm::BackgroundGrid<dim> grid(
        mpm::BoxGrid<dim>(Vector<dim>::Zero(), Vector<dim>::Constant(12 * h), cells));
    grid.basis = basis;
    return grid;
  }
  /// Body of cells of the grid's size, turned by an angle in the plane about its low corner.
  void lay(const Vector<dim>& low, const Eigen::Matrix<int, dim, 1>& cells, double angle = 0) {
    const Vector<dim> high = h * cells.template cast<double>();
    const CellType type = dim == 2 ? CellType::quad4 : CellType::hex8;
    Mesh<dim> mesh = box_mesh<dim>(Vector<dim>::Zero(), high, cells, type);
    for (Vector<dim>& x : mesh.nodes) {
      const Vector<2> flat = Eigen::Rotation2D<double>(angle) * x.template head<2>();
      x.template head<2>() = flat;
      x += low;
    }
    lay_points<dim>({.mesh = mesh,
                     .points_per_cell = 1 << dim,
                     .placement = PointPlacement::regular,
                     .with_domains = grid.basis == mpm::Basis::gimp},
                    1000, {.first_id = points.size()}, points);
  }
  void to_grid() {
    ASSERT_TRUE(find_cells(grid, points).empty());
    evaluate_basis<dim>(grid, points, weights);
    mpm::split_groups<dim>(comm(), groups.of_body, grid.num_nodes_total(), weights);
    mpm::activate_nodes<dim>(comm(), grid, weights, {}, nodes);
    points_to_grid(points, weights, nodes);
  }
  mpm::SoilSurface<dim> soil(double dt = 1e-3, double weight = 1) const {
    return {.grid = grid,
            .nodes = nodes,
            .points = points,
            .weights = weights,
            .cell_size = h,
            .dt = dt,
            .step_force_weight = weight,
            .moduli = moduli};
  }
  std::vector<mpm::GroupNode<dim>> contact_nodes() const {
    const mpm::GroupsAtNodes<dim> at_nodes(comm(), groups.of_body, nodes.num_places, weights);
    return mpm::find_contact_nodes<dim>(soil(), groups, at_nodes);
  }
};

/// Sum of the areas along the normal, and the worst normal and gap of the nodes.
struct Patch {
  double area = 0, turned = 0, gap = 0;
};

/// A wide body below, one of six cells upon it, the plane between them turned and moved.
Patch flat_patch(mpm::Basis basis, double offset, double angle) {
  TwoBodies<2> bodies(basis, two_groups(0.3));
  const Vector<2> along(std::cos(angle), std::sin(angle)), n(-along[1], along[0]);
  const Vector<2> low(0.32 + 0.3 * offset * h, 0.45 + offset * h);
  bodies.lay(low - 3 * h * n - h * along, {8, 3}, angle);
  bodies.lay(low, {6, 3}, angle);
  bodies.to_grid();
  Patch patch;
  for (const auto& node : bodies.contact_nodes()) {
    patch.area += node.area * node.n.dot(n);
    patch.turned = std::max(patch.turned, std::acos(std::min(1.0, node.n.dot(n))));
    patch.gap = std::max(patch.gap, std::abs(node.gap));
    EXPECT_TRUE(node.separates);
    EXPECT_EQ(node.modulus, 1e6);
  }
  return patch;
}

TEST(BodyGroups, a_flat_contact_has_its_normal_gap_and_area) {
  for (const mpm::Basis basis : {mpm::Basis::linear, mpm::Basis::gimp, mpm::Basis::bspline}) {
    for (const double offset : {0.0, 0.1, 0.25, 0.5, 0.8}) {
      const Patch flat = flat_patch(basis, offset, 0);
      EXPECT_NEAR(flat.area, 6 * h, 1e-3 * 6 * h) << basis_name(basis) << " " << offset;
      EXPECT_LT(flat.turned, 0.01) << basis_name(basis) << " " << offset;
      EXPECT_LT(flat.gap, 1e-3 * h) << basis_name(basis) << " " << offset;
      if (basis == mpm::Basis::bspline) continue;  // few points see its nodes where rows cut them
      for (const double angle : {0.1, 0.3, 0.5}) {
        const Patch turned = flat_patch(basis, offset, angle);
        EXPECT_NEAR(turned.area, 6 * h, (basis == mpm::Basis::gimp ? 0.015 : 0.12) * 6 * h)
            << basis_name(basis) << " " << offset << " " << angle;
        EXPECT_LT(turned.turned, 0.03) << basis_name(basis) << " " << offset << " " << angle;
        EXPECT_LT(turned.gap, 0.02 * h) << basis_name(basis) << " " << offset << " " << angle;
      }
    }
  }
}

template <int dim>
void expect_tangent(mpm::Basis basis, double friction, double weight) {
  TwoBodies<dim> bodies(basis, two_groups(friction));
  Eigen::Matrix<int, dim, 1> cells = Eigen::Matrix<int, dim, 1>::Constant(2);
  Vector<dim> low = Vector<dim>::Constant(0.33);
  bodies.lay(low, cells);
  low[dim - 1] += 2 * h;
  low[0] += 0.03;
  bodies.lay(low, cells);
  bodies.to_grid();
  mpm::GroupContact<dim> contact(bodies.groups, bodies.grid.num_nodes_total());
  Random random;
  BlockMatrix<dim> K;
  const std::size_t n = static_cast<std::size_t>(bodies.nodes.size()) * dim;
  std::vector<double> du(n), r(n);
  for (int step = 0; step < 2; ++step) {  // the second one goes on with closed nodes
    contact.begin_step(bodies.soil(1e-3, weight));
    ASSERT_TRUE(contact.can_touch());
    EXPECT_EQ(contact.symmetric(), friction == 0);
    du = random.values(n, 0.02 * h);
    for (const auto& node : bodies.contact_nodes()) {
      for (int d = 0; d < dim; ++d) du[node.second * dim + d] -= 0.02 * h * node.n[d];
    }
    std::vector<std::int32_t> offsets = {0}, cell_nodes;
    contact.append_cells(offsets, cell_nodes);
    K.set_pattern(bodies.nodes.size(), offsets, cell_nodes);
    std::fill(r.begin(), r.end(), 0.0);
    contact.add_forces(du, r, &K);
    EXPECT_GT(contact.counts(0).closed, 3);
    double largest = 0, error = 0;
    Vector<dim> sum = Vector<dim>::Zero();
    for (std::size_t k = 0; k < n; ++k) sum[k % dim] += r[k];
    std::vector<double> unit(n, 0.0), column(n), up(n), down(n);
    constexpr double eps = 1e-8 * h;
    for (std::size_t j = 0; j < n; ++j) {
      unit[j] = 1;
      std::fill(column.begin(), column.end(), 0.0);
      K.multiply(unit, column);
      unit[j] = 0;
      std::fill(up.begin(), up.end(), 0.0);
      std::fill(down.begin(), down.end(), 0.0);
      auto moved = du;
      moved[j] += eps;
      contact.add_forces(moved, up, nullptr);
      moved[j] -= 2 * eps;
      contact.add_forces(moved, down, nullptr);
      for (std::size_t i = 0; i < n; ++i) {
        largest = std::max(largest, std::abs(column[i]));
        error = std::max(error, std::abs(column[i] + (up[i] - down[i]) / (2 * eps)));
      }
    }
    EXPECT_LT(error, 1e-6 * largest) << step << " " << friction;
    EXPECT_LT(sum.norm(), 1e-12 * largest * h);
    contact.add_forces(du, r, nullptr);
    contact.accept();
  }
}

TEST(BodyGroups, tangent_is_the_slope_of_the_forces) {
  for (const double friction : {0.0, 0.3, 100.0}) {
    for (const mpm::Basis basis : {mpm::Basis::linear, mpm::Basis::gimp, mpm::Basis::bspline}) {
      expect_tangent<2>(basis, friction, 2);
    }
    expect_tangent<3>(mpm::Basis::linear, friction, 1);
  }
}

TEST(BodyGroups, clouds_that_no_plane_parts_have_no_depth) {
  TwoBodies<2> bodies(mpm::Basis::linear, two_groups(0.3));
  bodies.lay({0.3, 0.3}, {6, 2});
  bodies.lay({0.6, 0.4}, {2, 3});
  bodies.to_grid();
  bool any = false;
  for (const auto& node : bodies.contact_nodes()) {
    if (node.separates) continue;
    any = true;
    EXPECT_GE(node.gap, 0);
    EXPECT_GT(node.overlap, 0.4 * h);
  }
  EXPECT_TRUE(any);
}

Json groups_of(const std::string& first, const std::string& second, const Json& contact) {
  Json pair = contact;
  pair["groups"] = {"a", "b"};
  return {{"groups", {{{"name", "a"}, {"bodies", {first}}}, {{"name", "b"}, {"bodies", {second}}}}},
          {"pairs", {pair}}};
}

/// Two blocks that fly at each other.
Json colliding_blocks(const std::string& basis, bool is_explicit, double friction) {
  Json scene = {{"dimension", 2},
                {"grid", box({0, 0}, {2, 1}, {20, 10}, "quad4")},
                {"basis", basis},
                {"bodies",
                 {body("left", box({0.3, 0.33}, {0.7, 0.63}, {4, 3}, "quad4"), 4,
                       elastic_soil("neo_hookean", 1e6, 0.3, 1500), {2, 0.3}),
                  body("right", box({0.73, 0.37}, {1.13, 0.77}, {4, 4}, "quad4"), 4,
                       elastic_soil("neo_hookean", 2e6, 0.2, 1000), {-1, -0.4})}},
                {"contact_groups", groups_of("left", "right", {{"friction", friction}})}};
  if (is_explicit) {
    scene["time_integration"] = {{"scheme", "explicit"}};
  } else {
    scene["time_integration"] = trapezoid;
    scene["newton"] = exact_newton;
  }
  return scene;
}

double energy(const Solver& solver) {
  return probe(solver, "kinetic_energy") + probe(solver, "elastic_energy") +
         probe(solver, "contact_energy");
}

TEST(BodyGroups, blocks_that_collide_keep_their_momentum_and_part) {
  for (const char* basis : {"linear", "gimp", "bspline"}) {
    for (const bool is_explicit : {false, true}) {
      for (const double friction : {0.0, 0.4}) {
        const auto where = testing::Message() << basis << " " << is_explicit << " " << friction;
        const auto solver = make_mpm(colliding_blocks(basis, is_explicit, friction));
        const double dt = is_explicit ? 5e-4 : 1e-3;
        const double start = energy(*solver), px = probe(*solver, "momentum_x"),
                     py = probe(*solver, "momentum_y");
        double largest = start, force = 0;
        for (int n = 1; n * dt <= 0.12; ++n) {
          run_steps(*solver, dt, 1, n);
          largest = std::max(largest, energy(*solver));
          force = std::max(force, probe(*solver, "contact.a.b.fx"));
        }
        EXPECT_LT(largest, start * (1 + 1e-6)) << where;
        EXPECT_GT(force, 1e3) << where;
        EXPECT_EQ(probe(*solver, "contact.a.b.fx"), 0) << where;  // they have parted
        // Newton's method leaves a residual, and the lightest nodes have more mass than their
        // points.
        const double bound = (is_explicit ? 1e-10 : 1e-6) * std::abs(px);
        EXPECT_NEAR(probe(*solver, "momentum_x"), px, bound) << where;
        EXPECT_NEAR(probe(*solver, "momentum_y"), py, bound) << where;
        EXPECT_LT(probe(*solver, "contact_created"), (is_explicit ? 3e-5 : 1e-9) * start) << where;
        EXPECT_NEAR(probe(*solver, "energy_balance"), 0, 2e-4 * start) << where;
      }
    }
  }
}

/// A column of sand, cut in two at half its height, that flows apart: nodes of the contact come and
/// go all the time.
Json flowing_layers(const std::string& basis, double friction) {
  Json sand = elastic_soil("mohr_coulomb", 840e3, 0.3, 2650);
  sand["friction_angle"] = 19.8;
  return {{"dimension", 2},
          {"grid", box({0, 0}, {0.4, 0.12}, {40, 12}, "quad4")},
          {"basis", basis},
          {"gravity", {0, -9.81}},
          {"walls", {wall("left", "slip"), wall("bottom", "fixed")}},
          {"bodies",
           {body("low", box({0, 0}, {0.1, 0.05}, {10, 5}, "quad4"), 4, sand),
            body("high", box({0, 0.05}, {0.1, 0.1}, {10, 5}, "quad4"), 4, sand)}},
          {"time_integration", trapezoid},
          {"newton", exact_newton},
          {"contact_groups", groups_of("low", "high", {{"friction", friction}})}};
}

TEST(BodyGroups, soils_that_flow_on_each_other_gain_no_energy) {
  for (const char* basis : {"linear", "gimp"}) {
    for (const double friction : {0.0, 0.3}) {
      const auto where = testing::Message() << basis << " " << friction;
      const auto solver = make_mpm(flowing_layers(basis, friction));
      int gained = 0;
      double last = 0;
      for (int n = 1; n <= 200; ++n) {
        run_steps(*solver, 1e-3, 1, n);
        const double loss = probe(*solver, "contact_loss");
        gained += loss < last - 1e-9 ? 1 : 0;
        last = loss;
      }
      EXPECT_EQ(gained, 0) << where;
      EXPECT_LT(probe(*solver, "contact_created"), 1e-8) << where;  // of some 2 J of its fall
      EXPECT_GT(probe(*solver, "gravity_work"), 0.5) << where;
      EXPECT_GT(last, 0) << where;
    }
  }
}

/// A block that lands on a bed by its weight; both may move through the grid.
TEST(BodyGroups, a_block_that_settles_in_explicit_steps_gets_no_energy) {
  for (const double speed : {0.0, 1.0}) {
    const Json soil = elastic_soil("neo_hookean", 1e6, 0.2, 1500);
    const auto solver = make_mpm(
        {{"dimension", 2},
         {"grid", box({0, -0.3}, {1.4, 0.5}, {14, 8}, "quad4")},
         {"gravity", {0, -9.81}},
         {"time_integration", {{"scheme", "explicit"}}},
         {"walls", {wall("bottom", "slip")}},
         {"bodies",
          {body("bed", box({0.1, -0.3}, {0.9, 0.1}, {8, 4}, "quad4"), 4, soil, {speed, 0}),
           body("block", box({0.23, 0.1}, {0.63, 0.4}, {4, 3}, "quad4"), 4, soil, {speed, 0})}},
         {"contact_groups", groups_of("bed", "block", {{"friction", 0.3}})}});
    run_steps(*solver, 1e-3, 150);
    const double work = probe(*solver, "gravity_work");
    EXPECT_GT(work, 5) << speed;
    EXPECT_LT(probe(*solver, "contact_created"), 1e-10 * work) << speed;
    EXPECT_GT(probe(*solver, "contact_loss"), 1e-3 * work) << speed;
    EXPECT_GT(probe(*solver, "contact_friction"), 0) << speed;
  }
}

/// A block in or before the corner of a bed and a wall of one group, no gravity.
Json block_at_a_corner(const std::string& basis, bool is_explicit, double offset, double before,
                       double speed) {
  const double x = 0.4 + offset * h, y = 0.3 + offset * h;
  const Json hard = elastic_soil("neo_hookean", 1e7, 0.2, 2000);
  Json scene = {{"dimension", 2},
                {"grid", box({0, 0}, {1.4, 1}, {14, 10}, "quad4")},
                {"basis", basis},
                {"bodies",
                 {body("bed", box({x - 0.2, y - 0.2}, {x + 0.8, y}, {10, 2}, "quad4"), 4, hard),
                  body("wall", box({x - 0.2, y}, {x, y + 0.3}, {2, 3}, "quad4"), 4, hard),
                  body("block", box({x + before, y}, {x + before + 0.3, y + 0.3}, {3, 3}, "quad4"),
                       4, elastic_soil("neo_hookean", 1e6, 0.2, 1000), {-speed, 0})}},
                {"contact_groups", groups_of("bed", "block", {{"friction", 0.1}})}};
  scene["contact_groups"]["groups"][0]["bodies"] = {"bed", "wall"};
  if (is_explicit) {
    scene["time_integration"] = {{"scheme", "explicit"}};
  } else {
    scene["time_integration"] = trapezoid;
    scene["newton"] = exact_newton;
  }
  return scene;
}

TEST(BodyGroups, a_corner_gives_no_energy) {
  for (const char* basis : {"linear", "gimp"}) {
    for (const bool is_explicit : {false, true}) {
      for (const double offset : {0.0, 1e-4, 1.0 / 3}) {
        const auto where = testing::Message() << basis << " " << is_explicit << " " << offset;
        const double dt = is_explicit ? 4e-4 : 2e-3;
        const auto rest = make_mpm(block_at_a_corner(basis, is_explicit, offset, 0, 0));
        run_steps(*rest, dt, 10, 1);
        EXPECT_LT(energy(*rest), 1e-9) << where;
        const auto solver = make_mpm(block_at_a_corner(basis, is_explicit, offset, 0.03, 0.5));
        const double start = energy(*solver);
        double largest = start, force = 0;
        for (int n = 1; n * dt <= 0.16; ++n) {
          run_steps(*solver, dt, 1, n);
          largest = std::max(largest, energy(*solver));
          force = std::max(force, probe(*solver, "contact.a.b.fx"));
        }
        EXPECT_LT(largest, start * (1 + 1e-6)) << where;
        EXPECT_GT(force, 10) << where;
      }
    }
  }
}

/// How far its weight moves a block up that rests on a bed, with a wall beside it or without.
double rise_on_bed(double offset, bool with_wall) {
  Json scene = block_at_a_corner("gimp", false, offset, 0, 0);
  scene.erase("time_integration");
  scene["grid"] = box({0, 0.1 + offset * h}, {1.4, 1 + offset * h}, {14, 9}, "quad4");
  scene["gravity"] = {0, -9.81};
  scene["gravity_ramp"] = {{"duration", 0.05}};
  scene["analysis"] = "quasi_static";
  scene["walls"] = {wall("bottom", "fixed")};
  scene["probes"] = {{{"name", "p"}, {"point", {0.56, 0.46}}}};
  if (!with_wall) {
    scene["bodies"].erase(1);
    scene["contact_groups"]["groups"][0]["bodies"] = {"bed"};
  }
  const auto solver = make_mpm(scene);
  run_steps(*solver, 0.005, 10, 1);
  return probe(*solver, "p.uy");
}

TEST(BodyGroups, a_block_in_a_corner_sinks_as_on_a_flat_bed) {
  const double flat = rise_on_bed(0, false), corner = rise_on_bed(0, true);
  EXPECT_LT(flat, 0);
  EXPECT_NEAR(corner, flat, 0.2 * std::abs(flat));
}

TEST(BodyGroups, blocks_that_collide_in_space) {
  for (const char* scheme : {"newmark", "explicit"}) {
    Json scene = {{"dimension", 3},
                  {"grid", box({0, 0, 0}, {0.6, 0.6, 1}, {6, 6, 10}, "hex8")},
                  {"time_integration", {{"scheme", scheme}}},
                  {"bodies",
                   {body("low", box({0.15, 0.15, 0.2}, {0.45, 0.45, 0.5}, {3, 3, 3}, "hex8"), 8,
                         elastic_soil("neo_hookean", 1e6, 0.3, 1500), {0, 0, 1}),
                    body("high", box({0.22, 0.2, 0.51}, {0.42, 0.4, 0.71}, {2, 2, 2}, "hex8"), 8,
                         elastic_soil("neo_hookean", 1e6, 0.3, 1500), {0.2, 0.1, -1})}},
                  {"contact_groups", groups_of("low", "high", {{"friction", 0.3}})}};
    if (scheme == std::string("newmark")) scene["newton"] = exact_newton;
    const auto solver = make_mpm(scene);
    const double start = energy(*solver), pz = probe(*solver, "momentum_z"),
                 px = probe(*solver, "momentum_x");
    double largest = start, force = 0;
    for (int n = 1; n <= 50; ++n) {
      run_steps(*solver, 1e-3, 1, n);
      largest = std::max(largest, energy(*solver));
      force = std::max(force, probe(*solver, "contact.a.b.fz"));
    }
    EXPECT_GT(force, 100) << scheme;
    EXPECT_EQ(probe(*solver, "contact.a.b.fz"), 0) << scheme;
    EXPECT_LT(largest, start * (1 + 1e-6)) << scheme;
    EXPECT_NEAR(probe(*solver, "momentum_z"), pz, 1e-6 * pz) << scheme;
    EXPECT_NEAR(probe(*solver, "momentum_x"), px, 1e-6 * pz) << scheme;
  }
}

}  // namespace
}  // namespace gabion::test::test_body_groups
