// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <bit>
#include <random>
#include <set>

#include "common/mechanics/elements/quadratic_cells.hpp"
#include "fem_solver/interface/wet_surfaces.hpp"
#include "tests/support/check_tangent.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/cells_of_mesh.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test::test_quadratic_cells {
namespace {

constexpr double E = 1e6, nu = 0.3;

const std::vector<std::string> plane_types = {"tri6", "quad8", "quad9"};
const std::vector<std::string> space_types = {"tet10", "hex20", "hex27"};

template <int dim>
const std::vector<std::string>& quadratic_types() {
  return dim == 2 ? plane_types : space_types;
}

Json material_of(const std::string& law, const std::string& formulation = "full") {
  Json material = elastic(law, E, nu, 1000);
  material["formulation"] = formulation;
  if (law == "von_mises") {
    material["yield_stress"] = 0.01 * E;
    material["hardening_modulus"] = 0.02 * E;
  }
  return material;
}

/// A box of 2 m by 1 m (by 1 m).
template <int dim>
fem::FemSettings<dim> box_of(const std::string& type, const Json& material, int cells) {
  const Json mesh = dim == 2 ? box_2d({2, 1}, {cells, cells}, type)
                             : box_3d({2, 1, 1}, {cells, cells, cells}, type);
  return fem_settings<dim>({{"dimension", dim}, {"mesh", mesh}, {"material", material}});
}

/// Move inner nodes: all of them, which bends edges, or corners alone, with the middle nodes on
/// straight edges.
template <int dim>
void distort(Mesh<dim>& mesh, bool bend) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.04, 0.04);
  const auto inner = inner_nodes(mesh);
  const int corners = num_corners(mesh.cell_type);
  std::vector<char> is_corner(mesh.nodes.size(), 0);
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    for (int a = 0; a < corners; ++a) is_corner[mesh.cell(c)[a]] = 1;
  }
  for (std::size_t i = 0; i < inner.size(); ++i) {
    for (int c = 0; c < dim && inner[i]; ++c) {
      if (bend || is_corner[i]) mesh.nodes[i][c] += shift(random);
    }
  }
  const auto sets = middle_nodes(mesh.cell_type);
  for (std::int32_t c = 0; c < mesh.num_cells() && !bend; ++c) {
    for (std::size_t k = 0; k < sets.size(); ++k) {
      Vector<dim> sum = Vector<dim>::Zero();
      for (int a = 0; a < corners; ++a) {
        if (sets[k] >> a & 1) sum += mesh.nodes[mesh.cell(c)[a]];
      }
      mesh.nodes[mesh.cell(c)[corners + k]] = sum / std::popcount(sets[k]);
    }
  }
}

/// Under an affine displacement of the nodes inner ones bear no force, and the stress is the same
/// everywhere.
template <int dim>
void expect_patch(const std::string& type, const Json& material, bool bend) {
  SCOPED_TRACE(type + material["law"].get<std::string>());
  auto settings = box_of<dim>(type, material, 3);
  distort(settings.mesh, bend);
  const Cells<dim> cells(settings);
  const Eigen::VectorXd u = affine<dim>(settings.mesh, some_gradient<dim>(1));
  const Eigen::VectorXd f = cells.forces(u);
  const auto inner = inner_nodes(settings.mesh);
  int count = 0;
  for (std::size_t i = 0; i < inner.size(); ++i) {
    if (!inner[i]) continue;
    ++count;
    EXPECT_LT(f.segment<dim>(static_cast<Eigen::Index>(i) * dim).norm(), 1e-13 * E);
  }
  EXPECT_GT(count, 4);
  const auto s =
      cells.integrals.cell_stresses({u.data(), static_cast<std::size_t>(u.size())}, cells.history);
  for (std::size_t k = 0; k < s.size(); ++k) {
    EXPECT_NEAR(s[k], s[k % symmetric_size<dim>], 1e-12 * E);
  }
}

TEST(QuadraticCells, patch_test_on_distorted_cells) {
  for (const std::string law : {"linear_elastic", "neo_hookean", "von_mises"}) {
    for (const auto& type : plane_types) expect_patch<2>(type, material_of(law), true);
    for (const auto& type : space_types) {
      expect_patch<3>(type, material_of(law), type == "hex27");
    }
    expect_patch<2>("quad8", material_of(law, "reduced"), false);
  }
}

/// Displacement of a bar along x that is bent about an axis, exact for a linear law.
template <int dim>
Vector<dim> bent(const Vector<dim>& X, double curvature) {
  const double x = X[0], z = X[dim - 1];
  if constexpr (dim == 2) {
    return curvature * Vector<2>(x * z, -0.5 * (x * x + nu / (1 - nu) * z * z));
  } else {
    const double y = X[1];
    return curvature * Vector<3>(x * z, -nu * y * z, -0.5 * (x * x + nu * (z * z - y * y)));
  }
}

/// Pure bending is in the space of quadratic cells: nodes between the ends bear no force with one
/// cell across, and the energy is 1/2 E I curvature^2 L.
template <int dim>
void expect_exact_bending(const std::string& type, const std::string& formulation) {
  SCOPED_TRACE(type + formulation);
  auto settings = box_of<dim>(type, material_of("linear_elastic", formulation), 1);
  const double curvature = 0.01;
  for (auto& X : settings.mesh.nodes) X[dim - 1] -= 0.5;
  const Cells<dim> cells(settings);
  Eigen::VectorXd u(static_cast<Eigen::Index>(settings.mesh.nodes.size()) * dim);
  for (std::size_t i = 0; i < settings.mesh.nodes.size(); ++i) {
    u.segment<dim>(static_cast<Eigen::Index>(i) * dim) =
        bent<dim>(settings.mesh.nodes[i], curvature);
  }
  double energy = 0;
  const Eigen::VectorXd f = cells.forces(u, &energy);
  const double modulus = dim == 2 ? E / (1 - nu * nu) : E;
  const double exact = 0.5 * modulus / 12 * curvature * curvature * 2;
  EXPECT_NEAR(energy, exact, 1e-12 * exact);
  for (std::size_t i = 0; i < settings.mesh.nodes.size(); ++i) {
    const double x = settings.mesh.nodes[i][0];
    if (x == 0 || x == 2) continue;
    EXPECT_LT(f.segment<dim>(static_cast<Eigen::Index>(i) * dim).norm(), 1e-13 * E) << i;
  }
}

TEST(QuadraticCells, one_cell_across_bends_exactly) {
  for (const auto& type : plane_types) expect_exact_bending<2>(type, "full");
  for (const auto& type : space_types) expect_exact_bending<3>(type, "full");
  expect_exact_bending<2>("quad8", "reduced");
  expect_exact_bending<3>("hex20", "reduced");
}

template <int dim>
void expect_tangent(const std::string& type, const Json& material) {
  SCOPED_TRACE(type + material["law"].get<std::string>());
  const auto settings = box_of<dim>(type, material, 1);
  Cells<dim> cells(settings);
  Eigen::VectorXd u = affine<dim>(settings.mesh, some_gradient<dim>(0.3));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shift(-0.01, 0.01);
  for (auto& value : u) value += shift(random);
  const auto f = [&](const Eigen::VectorXd& at) { return cells.forces(at); };
  const Eigen::MatrixXd K = cells.tangent(u);
  EXPECT_LT(tangent_error(f, u, K, 1e-5), 1e-7);
  EXPECT_LT((K - K.transpose()).cwiseAbs().maxCoeff(), 1e-12 * K.cwiseAbs().maxCoeff());
}

TEST(QuadraticCells, tangents_are_derivatives_and_symmetric) {
  for (const std::string law : {"neo_hookean", "von_mises"}) {
    for (const auto& type : plane_types) expect_tangent<2>(type, material_of(law));
    for (const auto& type : space_types) expect_tangent<3>(type, material_of(law));
    expect_tangent<2>("quad8", material_of(law, "reduced"));
    expect_tangent<3>("hex20", material_of(law, "reduced"));
  }
}

template <int dim>
int num_zero_modes(const std::string& type, const std::string& formulation) {
  const auto settings = box_of<dim>(type, material_of("linear_elastic", formulation), 1);
  const Cells<dim> cells(settings);
  EXPECT_TRUE(is_simplex(settings.mesh.cell_type) || settings.mesh.num_cells() == 1);
  const Eigen::VectorXd zero =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(settings.mesh.nodes.size()) * dim);
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(cells.tangent(zero)).eigenvalues();
  return static_cast<int>((values.array().abs() < 1e-9 * values.maxCoeff()).count());
}

TEST(QuadraticCells, free_cells_have_the_zero_modes_of_rigid_bodies) {
  for (const auto& type : plane_types) EXPECT_EQ(num_zero_modes<2>(type, "full"), 3) << type;
  for (const auto& type : space_types) EXPECT_EQ(num_zero_modes<3>(type, "full"), 6) << type;
  EXPECT_EQ(num_zero_modes<2>("quad8", "reduced"), 4);
  EXPECT_EQ(num_zero_modes<3>("hex20", "reduced"), 12);
}

template <int dim>
void expect_mass(const std::string& type) {
  SCOPED_TRACE(type);
  auto settings = box_of<dim>(type, material_of("linear_elastic"), 2);
  for (const bool lumped : {false, true}) {
    const fem::CellIntegrals<dim> cells(settings.mesh, settings.materials, lumped);
    std::vector<double> a(settings.mesh.nodes.size() * dim, 1.0), f(a.size(), 0.0);
    cells.add_mass_times(a, f);
    double sum = 0, least = INFINITY;
    for (std::size_t i = 0; i < f.size(); i += dim) {
      sum += f[i];
      least = std::min(least, f[i]);
    }
    EXPECT_NEAR(sum, 2000, 1e-9);
    EXPECT_TRUE(!lumped || least > 0) << least;
  }
}

TEST(QuadraticCells, mass_is_that_of_the_body_and_lumped_masses_are_positive) {
  for (const auto& type : plane_types) expect_mass<2>(type);
  for (const auto& type : space_types) expect_mass<3>(type);
}

TEST(QuadraticCells, formulations_of_other_cells_are_refused) {
  const auto settings = box_of<2>("quad9", material_of("neo_hookean", "reduced"), 1);
  expect_error<ConfigError>(
      [&] { const Cells<2> cells(settings); },
      {"found \"formulation\" \"reduced\" with cells of type quad9, allowed: quad8, hex20"});
}

/// A row of single cells keeps a mode of each of them, even where an end is held.
TEST(QuadraticCells, reduced_hexahedra_in_a_row_are_refused) {
  Json json = {{"dimension", 3},
               {"mesh", box_3d({2, 1, 1}, {3, 1, 1}, "hex20")},
               {"material", material_of("neo_hookean", "reduced")},
               {"supports", {{{"group", "left"}}}}};
  expect_error<ConfigError>([&] { fem_solver<3>(json); },
                            {"\"reduced\" with cell 0 near (0.333333, 0.5, 0.5), which has "
                             "neighbours along 1 of its axes",
                             "allowed: hex20 with neighbours along two, or \"full\""});
  json["mesh"] = box_3d({2, 1, 1}, {3, 1, 2}, "hex20");
  fem_solver<3>(json);
}

/// Work of random forces of the vertices over displacements of the vertices and of the nodes.
template <int dim>
void expect_same_work(const std::string& type) {
  SCOPED_TRACE(type);
  auto settings = box_of<dim>(type, material_of("neo_hookean"), 2);
  settings.interfaces = {{.name = "wall", .groups = {"right", "top"}, .where = ""}};
  fem::WetSurfaces<dim> surfaces(settings.mesh, settings.interfaces);
  const auto& mesh = surfaces.meshes().front();
  std::set<std::int64_t> used(mesh.facets.begin(), mesh.facets.end());
  EXPECT_EQ(used.size() * dim, mesh.coordinates.size());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> value(-1, 1);
  std::vector<double> u(settings.mesh.nodes.size() * dim), forces(mesh.coordinates.size());
  for (double& x : u) x = value(random);
  for (double& x : forces) x = value(random);
  const auto sent = surfaces.displacements(u).at("wall");
  const auto nodal = surfaces.nodal_forces({{"wall", forces}});
  double of_vertices = 0, of_nodes = 0;
  for (std::size_t k = 0; k < forces.size(); ++k) of_vertices += forces[k] * sent[k];
  for (std::size_t k = 0; k < u.size(); ++k) of_nodes += nodal.end[k] * u[k];
  EXPECT_NEAR(of_vertices, of_nodes, 1e-13 * std::abs(of_nodes));
}

TEST(QuadraticCells, linear_wet_facets_use_all_nodes_and_do_the_same_work) {
  for (const auto& type : plane_types) expect_same_work<2>(type);
  for (const auto& type : space_types) expect_same_work<3>(type);
}

/// A saved state goes on with the same bits, with the history of reduced cells that yield.
TEST(QuadraticCells, a_restart_gives_the_same_bits) {
  const Json json = {{"dimension", 2},
                     {"mesh", box_2d({2, 1}, {4, 2}, "quad8")},
                     {"material", material_of("von_mises", "reduced")},
                     {"supports", {{{"group", "left"}}}},
                     {"tractions", {{{"group", "right"}, {"traction", {0.0, -6e3}}}}}};
  const auto whole = fem_solver<2>(json), resumed = fem_solver<2>(json);
  const auto advance = [](Solver& solver, int n) {
    const StepRequest request{n, 0, (n - 1) * 0.01, 0.01};
    InterfaceValues sent;
    solver.solve_step(request, {}, sent);
    solver.accept_step(request, true);
  };
  for (int n = 1; n <= 5; ++n) advance(*whole, n);
  EXPECT_GT(whole->state().plastic_work, 0);
  resumed->load_state(whole->save_state());
  for (int n = 6; n <= 8; ++n) {
    advance(*whole, n);
    advance(*resumed, n);
  }
  EXPECT_EQ(whole->state().motion.u, resumed->state().motion.u);
  EXPECT_EQ(*whole->state().history, *resumed->state().history);
}

/// Cook's membrane at finite strain, plane strain: displacement of the top corner under a dead load
/// of 100 N. Numbers computed once with reduced quad8 of another program.
TEST(QuadraticCells, cooks_membrane_at_finite_strain) {
  Json material = elastic("neo_hookean", 240.565, 0.3, 1);
  material["formulation"] = "reduced";
  auto settings = fem_settings<2>({{"dimension", 2},
                                   {"mesh", box_2d({48, 1}, {4, 4}, "quad8")},
                                   {"material", material},
                                   {"analysis", "static"},
                                   {"supports", {{{"group", "left"}}}},
                                   {"tractions", {{{"group", "right"}, {"traction", {0.0, 6.25}}}}},
                                   {"newton", {{"residual_tolerance", 1e-10}}}});
  std::size_t corner = 0;
  for (std::size_t i = 0; i < settings.mesh.nodes.size(); ++i) {
    auto& X = settings.mesh.nodes[i];
    if (X[0] == 48 && X[1] == 1) corner = i;
    X[1] = 44 * X[0] / 48 + X[1] * (44 - 28 * X[0] / 48);
  }
  fem::FemSolver<2> solver(comm(), settings, "");
  InterfaceValues sent;
  solver.solve_step({.step = 0, .time = 0, .dt = 1}, {}, sent);
  solver.accept_step({.step = 0, .time = 0, .dt = 1}, true);
  const auto& u = solver.state().motion.u;
  EXPECT_NEAR(u[2 * corner], -6.886, 2e-3);
  EXPECT_NEAR(u[2 * corner + 1], 7.696, 2e-3);
}

}  // namespace
}  // namespace gabion::test::test_quadratic_cells
