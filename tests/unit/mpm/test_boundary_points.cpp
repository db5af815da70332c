// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "mpm_solver/contact/contact.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_boundary_points {
namespace {

using mpm::BoundaryPointSettings;
using mpm::ContactMode;
using mpm::ContactSettings;
using mpm::GapMemory;

constexpr double penalty = 1e4;

/// One facet in the middle of the soil that looks upwards, of area 0.6 (2D) or 0.36.
template <int dim>
ContactSettings<dim> plate(ContactMode mode = ContactMode::contact) {
  ContactSettings<dim> settings;
  settings.name = "plate";
  settings.mode = mode;
  settings.method = BoundaryPointSettings{.penalty = penalty, .points_per_facet = 1};
  if constexpr (dim == 2) {
    settings.surface.vertices = {{0.8, 0.5}, {0.2, 0.5}};
    settings.surface.facets = {0, 1};
  } else {
    settings.surface.facet_type = CellType::quad4;
    settings.surface.vertices = {
        {0.2, 0.2, 0.5}, {0.8, 0.2, 0.5}, {0.8, 0.8, 0.5}, {0.2, 0.8, 0.5}};
    settings.surface.facets = {0, 1, 2, 3};
  }
  return settings;
}

template <int dim>
constexpr double plate_area = dim == 2 ? 0.6 : 0.36;

/// Soil around a surface, stepped by hand: both sides' displacements are given.
template <int dim>
struct SteppedContact {
  SoilPatch<dim> soil;
  std::unique_ptr<mpm::Contact<dim>> boundary;  // by the factory
  std::vector<Vector<dim>> vertices;            // reference
  std::vector<double> r;
  std::vector<double> displacement;  // accepted, of the surface

  explicit SteppedContact(const ContactSettings<dim>& settings,
                          CellType type = dim == 2 ? CellType::quad4 : CellType::hex8)
      : soil(type), boundary(make_contact(settings)), vertices(settings.surface.vertices) {
    soil.fill(type == CellType::tri3 ? 3 : dim == 2 || type == CellType::tet4 ? 4 : 8);
    soil.to_grid();
    displacement.assign(vertices.size() * dim, 0);
  }
  void begin(double reach = 0) {
    const auto occupied = soil.occupied();
    boundary->begin_step({.grid = soil.grid,
                          .nodes = soil.nodes,
                          .points = soil.points,
                          .weights = soil.weights,
                          .occupied = &occupied,
                          .reach = reach});
  }
  /// Forces for increments of both sides: of the grid's nodes, and a motion of the surface.
  std::vector<double> forces(const std::vector<double>& du, const std::vector<double>& surface_du) {
    begin();
    std::vector<double> total = displacement;
    for (std::size_t k = 0; k < total.size(); ++k) total[k] += surface_du[k];
    boundary->set_displacement(total);
    r.assign(soil.num_dofs(), 0);
    boundary->assembly().add_forces(du, r, nullptr);
    trial_displacement_ = total;
    return boundary->results().forces_on_structure();
  }
  /// Force on the structure when grid and surface move as wholes.
  Vector<dim> force(const Vector<dim>& grid, const Vector<dim>& surface) {
    const auto nodal =
        forces(repeat(grid, soil.num_dofs() / dim), repeat(surface, vertices.size()));
    Vector<dim> sum = Vector<dim>::Zero();
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      sum += Eigen::Map<const Vector<dim>>(nodal.data() + v * dim);
    }
    return sum;
  }
  Vector<dim> force(const Vector<dim>& surface) { return force(Vector<dim>::Zero(), surface); }
  void accept() {
    boundary->accept();
    displacement = trial_displacement_;
  }
  static std::vector<double> repeat(const Vector<dim>& x, std::size_t n) {
    std::vector<double> values;
    for (std::size_t i = 0; i < n; ++i) values.insert(values.end(), x.data(), x.data() + dim);
    return values;
  }

 private:
  std::vector<double> trial_displacement_;
};

template <int dim>
Vector<dim> up(double size) {
  return size * Vector<dim>::Unit(dim - 1);
}
template <int dim>
Vector<dim> along(double size) {
  return size * Vector<dim>::Unit(0);
}

/// A bent surface with several facets, none of them aligned with the grid.
template <int dim>
ContactSettings<dim> bent_surface(CellType facet, ContactMode mode) {
  ContactSettings<dim> settings;
  settings.name = "bent";
  settings.mode = mode;
  settings.surface.facet_type = facet;
  if constexpr (dim == 2) {
    settings.surface.vertices = {{0.83, 0.2}, {0.71, 0.56}, {0.4, 0.64}, {0.13, 0.37}};
    settings.surface.facets = {0, 1, 1, 2, 2, 3};
    settings.method = BoundaryPointSettings{.penalty = penalty, .points_per_facet = 3};
  } else {
    settings.surface.vertices = {{0.1, 0.2, 0.45}, {0.52, 0.15, 0.6}, {0.9, 0.2, 0.4},
                                 {0.15, 0.8, 0.5}, {0.5, 0.85, 0.62}, {0.85, 0.9, 0.45}};
    if (facet == CellType::quad4) {
      settings.surface.facets = {0, 1, 4, 3, 1, 2, 5, 4};
      settings.method = BoundaryPointSettings{.penalty = penalty, .points_per_facet = 4};
    } else {
      settings.surface.facets = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4};
      settings.method = BoundaryPointSettings{.penalty = penalty, .points_per_facet = 3};
    }
  }
  return settings;
}

template <int dim>
void check_action_and_reaction(CellType grid, CellType facet, ContactMode mode, double friction) {
  auto settings = bent_surface<dim>(facet, mode);
  settings.friction = friction;
  SteppedContact<dim> contact(settings, grid);
  for (int step = 0; step < 3; ++step) {
    std::vector<double> surface_du =
        contact.soil.random.values(contact.vertices.size() * dim, 0.004);
    for (std::size_t v = 0; v < contact.vertices.size(); ++v) surface_du[v * dim + dim - 1] += 0.01;
    const auto du = contact.soil.random.values(contact.soil.num_dofs(), 0.01);
    const auto nodal = contact.forces(du, surface_du);
    ForceAndMoment<dim> on_structure, on_soil;
    for (std::size_t v = 0; v < contact.vertices.size(); ++v) {
      const Vector<dim> x = contact.vertices[v] +
                            Eigen::Map<const Vector<dim>>(contact.displacement.data() + v * dim);
      on_structure.add(x, Eigen::Map<const Vector<dim>>(nodal.data() + v * dim));
    }
    for (std::int32_t i = 0; i < contact.soil.nodes.size(); ++i) {
      on_soil.add(contact.soil.node(i), Eigen::Map<const Vector<dim>>(contact.r.data() + i * dim));
    }
    EXPECT_GT(contact.boundary->results().counts().closed, 2);
    EXPECT_GT(on_structure.size, 1);
    EXPECT_LT((on_structure.force + on_soil.force).norm(), 1e-13 * on_soil.size);
    EXPECT_LT((on_structure.moment + on_soil.moment).norm(), 1e-13 * on_soil.size);
    contact.accept();
  }
}

TEST(BoundaryPoints, action_equals_reaction_in_force_and_moment) {
  for (const ContactMode mode : {ContactMode::fixed, ContactMode::contact, ContactMode::slip}) {
    check_action_and_reaction<2>(CellType::tri3, CellType::line2, mode, -1);
    check_action_and_reaction<2>(CellType::quad4, CellType::line2, mode, -1);
    check_action_and_reaction<3>(CellType::tet4, CellType::tri3, mode, -1);
    check_action_and_reaction<3>(CellType::hex8, CellType::tri3, mode, -1);
    check_action_and_reaction<3>(CellType::hex8, CellType::quad4, mode, -1);
  }
  check_action_and_reaction<2>(CellType::tri3, CellType::line2, ContactMode::contact, 0.2);
  check_action_and_reaction<3>(CellType::hex8, CellType::tri3, ContactMode::contact, 0.2);
}

template <int dim>
void check_modes() {
  const double A = plate_area<dim>;
  {
    SteppedContact<dim> contact(plate<dim>(ContactMode::contact));
    EXPECT_LT((contact.force(up<dim>(0.01)) + up<dim>(penalty * 0.01 * A)).norm(), 1e-10);
    EXPECT_EQ(contact.force(up<dim>(-0.01)), (Vector<dim>::Zero()));
    EXPECT_EQ(contact.force(up<dim>(-0.01) + along<dim>(0.02)), (Vector<dim>::Zero()));
    const Vector<dim> stuck = contact.force(up<dim>(0.01) + along<dim>(0.02));
    EXPECT_LT((stuck + penalty * A * (up<dim>(0.01) + along<dim>(0.02))).norm(), 1e-10);
  }
  {
    SteppedContact<dim> contact(plate<dim>(ContactMode::slip));
    EXPECT_LT(
        (contact.force(up<dim>(0.01) + along<dim>(0.02)) + up<dim>(penalty * 0.01 * A)).norm(),
        1e-10);
    EXPECT_EQ(contact.force(up<dim>(-0.01)), (Vector<dim>::Zero()));
  }
  {
    SteppedContact<dim> contact(plate<dim>(ContactMode::fixed));
    const Vector<dim> pull = up<dim>(-0.01) + along<dim>(0.02);
    EXPECT_LT((contact.force(pull) + penalty * A * pull).norm(), 1e-10);
  }
}

TEST(BoundaryPoints, modes) {
  check_modes<2>();
  check_modes<3>();
}

template <int dim>
void check_approach() {
  const double dt = 0.2, margin = 0.05;
  SteppedContact<dim> contact(plate<dim>());
  contact.force(up<dim>(0.02));
  EXPECT_NEAR(contact.boundary->approach_step(dt, margin), dt * margin / 0.02, 1e-12);
  contact.force(up<dim>(-0.01), up<dim>(0.01));  // the soil comes down on the plate that rises
  EXPECT_NEAR(contact.boundary->approach_step(dt, margin), dt * margin / 0.02, 1e-12);
  contact.force(up<dim>(-0.03));
  EXPECT_EQ(contact.boundary->approach_step(dt, margin), std::numeric_limits<double>::infinity());
  contact.accept();  // open by 0.03
  contact.force(up<dim>(0.01));
  EXPECT_NEAR(contact.boundary->approach_step(dt, margin), dt * (0.02 + margin) / 0.01, 1e-12);
}

TEST(BoundaryPoints, the_next_step_may_close_the_gap_and_go_in_by_the_margin) {
  check_approach<2>();
  check_approach<3>();
}

TEST(BoundaryPoints, friction_holds_up_to_its_limit_and_keeps_direction) {
  auto settings = plate<3>();
  settings.friction = 0.4;
  SteppedContact<3> contact(settings);
  const double normal = penalty * 0.01 * plate_area<3>;
  EXPECT_NEAR(contact.force({0.0024, 0.0032 - 1e-9, 0.01})[2], -normal, 1e-9);
  EXPECT_EQ(contact.boundary->results().counts().sliding, 0);  // |(0.0024, 0.0032)| = 0.4 * 0.01
  for (const double push : {1.001, 2.0, 10.0}) {
    const Vector<3> f = contact.force({0.0024 * push, 0.0032 * push, 0.01});
    EXPECT_EQ(contact.boundary->results().counts().sliding, 1);
    EXPECT_LT((f - normal * Vector<3>(-0.24, -0.32, -1)).norm(), 1e-9);
  }
  // Slip beyond the elastic part is not recovered: after a long slide, a move back by less than the
  // elastic slip lowers the force.
  contact.force({0.03, 0, 0.01});
  contact.accept();
  const Vector<3> back = contact.force({-0.002, 0, 0});
  EXPECT_NEAR(back[0], -0.2 * normal, 1e-9);
  EXPECT_EQ(contact.boundary->results().counts().sliding, 0);
}

TEST(BoundaryPoints, small_steps_give_the_force_of_one_large_step) {
  const Vector<2> push(0.004, 0.01), grid(-0.003, -0.002);
  for (const double friction : {-1.0, 0.3}) {
    auto settings = plate<2>();
    settings.friction = friction;
    SteppedContact<2> once(settings);
    const Vector<2> expected = once.force(grid, push);
    EXPECT_GT(expected.norm(), 10);
    settings.method = BoundaryPointSettings{
        .penalty = penalty, .memory = GapMemory::accumulated, .points_per_facet = 1};
    SteppedContact<2> many(settings);
    settings.method =
        BoundaryPointSettings{.penalty = penalty, .memory = GapMemory::step, .points_per_facet = 1};
    SteppedContact<2> forgetful(settings);
    Vector<2> force, forgotten;
    for (int k = 0; k < 8; ++k) {
      force = many.force(grid / 8, push / 8);
      forgotten = forgetful.force(grid / 8, push / 8);
      many.accept();
      forgetful.accept();
    }
    EXPECT_LT((force - expected).norm(), 1e-12 * expected.norm());
    EXPECT_LT((forgotten - expected / 8).norm(), 1e-12 * expected.norm());
  }
}

/// Linear displacement of the grid over a surface that stays: the points stay too, and the gap is
/// the same linear function in one step or many.
TEST(BoundaryPoints, small_steps_under_a_linear_displacement) {
  auto settings = bent_surface<2>(CellType::line2, ContactMode::contact);
  SteppedContact<2> once(settings, CellType::tri3), many(settings, CellType::tri3);
  std::vector<double> du, still(once.vertices.size() * 2, 0.0);
  for (std::int32_t i = 0; i < once.soil.nodes.size(); ++i) {
    const auto& x = once.soil.node(i);
    du.insert(du.end(), {0.01 * x[1] - 0.004, -0.02 * x[1] + 0.006 * x[0]});
  }
  const auto expected = once.forces(du, still);
  for (double& value : du) value /= 5;
  std::vector<double> force;
  for (int k = 0; k < 5; ++k) {
    force = many.forces(du, still);
    many.accept();
  }
  for (std::size_t k = 0; k < force.size(); ++k) EXPECT_NEAR(force[k], expected[k], 1e-12 * 100);
}

/// No force acts in the step that opens; soil that moves away by d is in contact again after d, not
/// before.
TEST(BoundaryPoints, an_open_gap_is_followed) {
  SteppedContact<2> contact(plate<2>());
  contact.force(up<2>(0.01));
  contact.accept();
  EXPECT_NEAR(contact.force(up<2>(-0.004))[1], -penalty * 0.006 * 0.6, 1e-9);  // still closed
  EXPECT_EQ(contact.force(up<2>(-0.0101)), (Vector<2>::Zero()));               // pulled away
  EXPECT_EQ(contact.boundary->results().counts().closed, 0);
  EXPECT_EQ(contact.boundary->results().counts().penetration, 0);
  contact.accept();
  EXPECT_EQ(contact.force(up<2>(0.00009)), (Vector<2>::Zero()));
  EXPECT_NEAR(contact.force(up<2>(0.0021))[1], -penalty * 0.002 * 0.6, 1e-9);
  EXPECT_NEAR(contact.boundary->results().counts().penetration, 0.002, 1e-15);
}

TEST(BoundaryPoints, a_rotated_wall_keeps_its_gap) {
  auto settings = plate<2>();
  settings.friction = 5;
  SteppedContact<2> contact(settings);
  const Vector<2> first = contact.force({0.003, 0.01});
  contact.accept();
  const double angle = 0.4;
  Matrix<2> turn;
  turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  std::vector<double> surface_du;
  for (const auto& vertex : contact.vertices) {
    const Vector<2> arm = vertex - Vector<2>(0.5, 0.5);
    const Vector<2> move = turn * arm - arm;
    surface_du.insert(surface_du.end(), move.data(), move.data() + 2);
  }
  const auto nodal = contact.forces(std::vector<double>(contact.soil.num_dofs(), 0.0), surface_du);
  const Vector<2> second(nodal[0] + nodal[2], nodal[1] + nodal[3]);
  EXPECT_LT((second - turn * first).norm(), 1e-11 * first.norm());
}

TEST(BoundaryPoints, normals_point_from_the_facets_into_the_soil) {
  for (const bool reversed : {false, true}) {
    auto settings = plate<2>();
    if (reversed) settings.surface.facets = {1, 0};
    SteppedContact<2> contact(settings);
    EXPECT_EQ(contact.force(up<2>(0.01)).norm() > 0, !reversed);
    EXPECT_EQ(contact.force(up<2>(-0.01)).norm() > 0, reversed);
    auto settings_3d = plate<3>();
    if (reversed) settings_3d.surface.facets = {3, 2, 1, 0};
    SteppedContact<3> contact_3d(settings_3d);
    EXPECT_EQ(contact_3d.force(up<3>(0.01)).norm() > 0, !reversed);
    EXPECT_EQ(contact_3d.force(up<3>(-0.01)).norm() > 0, reversed);
  }
}

/// Soil in the left third of the grid only, or a surface outside the grid.
TEST(BoundaryPoints, cannot_touch_where_no_point_is) {
  for (const double x : {0.1, 0.5, 2.0}) {
    auto settings = plate<2>();
    settings.surface.vertices = {{x + 0.1, 0.5}, {x, 0.5}};
    SteppedContact<2> contact(settings);
    auto& points = contact.soil.points;
    for (auto& position : points.x) position[0] /= 3.01;
    contact.soil.to_grid();
    EXPECT_EQ(contact.force(up<2>(0.01)).norm() > 0, x == 0.1);
    EXPECT_EQ(contact.boundary->can_touch(), x == 0.1);
    std::vector<std::int32_t> offsets{0}, nodes;
    contact.boundary->assembly().append_cells(offsets, nodes);
    EXPECT_EQ(nodes.size(), x == 0.1 ? 4u : 0u);
  }
}

ContactSettings<2> wall_at(double x) {
  auto settings = plate<2>();
  settings.surface.vertices = {{x, 0.6}, {x, 0.4}};
  return settings;
}

/// A wall that looks at soil in the left third of the grid, whose edge is a line of the grid.
struct WallAtTheEdge : SteppedContact<2> {
  explicit WallAtTheEdge(double beyond) : SteppedContact<2>(wall_at(1.0 / 3 + beyond)) {
    for (auto& position : soil.points.x) position[0] /= 3.01;
    soil.to_grid();
  }
};

TEST(BoundaryPoints, a_wall_that_recedes_over_a_line_of_the_grid_keeps_its_soil) {
  WallAtTheEdge contact(0);
  EXPECT_NEAR(contact.force(along<2>(-0.01))[0], penalty * 0.01 * 0.2, 1e-9);
  contact.accept();
  EXPECT_EQ(contact.force(along<2>(0.11)), (Vector<2>::Zero()));  // 0.3 cells into the empty cell
  contact.accept();
  EXPECT_NEAR(contact.force(along<2>(-0.104))[0], penalty * 0.004 * 0.2, 1e-9);
  contact.force(along<2>(0.3));
  contact.accept();
  contact.begin();  // 1.2 cells away
  EXPECT_FALSE(contact.boundary->can_touch());
}

/// The basis functions of the cell in front are continued to the wall.
TEST(BoundaryPoints, soil_in_front_feels_the_force_and_moment_at_the_wall) {
  WallAtTheEdge contact(0);
  contact.force(along<2>(0.05));
  contact.accept();
  const auto du = contact.soil.random.values(contact.soil.num_dofs(), 0.01);
  const auto nodal = contact.forces(du, SteppedContact<2>::repeat({-0.1, 0.02}, 2));
  ForceAndMoment<2> on_structure, on_soil;
  for (int v = 0; v < 2; ++v) {
    on_structure.add(contact.vertices[v] + along<2>(0.05),
                     Vector<2>(nodal[2 * v], nodal[2 * v + 1]));
  }
  for (std::int32_t i = 0; i < contact.soil.nodes.size(); ++i) {
    on_soil.add(contact.soil.node(i), Eigen::Map<const Vector<2>>(contact.r.data() + 2 * i));
  }
  EXPECT_GT(on_structure.size, 1);
  EXPECT_LT((on_structure.force + on_soil.force).norm(), 1e-13 * on_soil.size);
  EXPECT_LT((on_structure.moment + on_soil.moment).norm(), 1e-13 * on_soil.size);
}

TEST(BoundaryPoints, soil_reaches_beyond_its_points) {
  for (const double reach : {0.04, 0.06}) {
    WallAtTheEdge contact(0.05);
    contact.begin(reach);
    EXPECT_EQ(contact.boundary->can_touch(), reach > 0.05);
  }
}

TEST(ContactSettings, interface_mesh_is_the_surface) {
  const auto settings = bent_surface<3>(CellType::tri3, ContactMode::contact);
  const InterfaceMesh mesh = mpm::interface_mesh(settings);
  EXPECT_EQ(mesh.name, "bent");
  EXPECT_EQ(mesh.dim, 3);
  EXPECT_EQ(mesh.vertices_per_facet, 3);
  EXPECT_EQ(mesh.num_vertices(), 6);
  EXPECT_EQ(mesh.coordinates[5], 0.6);
  EXPECT_EQ(mesh.facets, (std::vector<std::int64_t>{0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4}));
}

}  // namespace
}  // namespace gabion::test::test_boundary_points
