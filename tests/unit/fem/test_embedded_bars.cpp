// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "tests/support/check_tangent.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/concrete_bar.hpp"

namespace gabion::test::test_embedded_bars {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double E = 200e9, area = 1e-3, density = 7850;

fem::LineMaterial steel(bool embedded) {
  fem::LineMaterial bar;
  bar.group = "bar";
  bar.where = "/materials/0/group";
  bar.law_name = "truss";
  bar.density = density;
  bar.young_modulus = E;
  bar.area = area;
  bar.in_compression = true;
  bar.embedded = embedded;
  return bar;
}

/// A unit box of cells, its inner corners moved, with an inclined bar of 5 lines inside.
template <int dim>
Mesh<dim> box_with_bar(CellType type) {
  const CellType corners = corner_type(type);
  auto mesh = box_mesh<dim>(Vector<dim>::Zero(), Vector<dim>::Ones(),
                            Eigen::Matrix<int, dim, 1>::Constant(2), corners);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shift(-0.08, 0.08);
  for (Vector<dim>& x : mesh.nodes) {
    if (x.minCoeff() > 0 && x.maxCoeff() < 1)
      x += Vector<dim>::NullaryExpr([&] { return shift(random); });
  }
  if (is_quadratic(type)) mesh = with_middle_nodes(mesh, type);
  Vector<dim> low = Vector<dim>::Constant(0.13), high = Vector<dim>::Constant(0.93);
  high[0] = 0.71;
  const std::int32_t first = mesh.num_nodes_total();
  for (int i = 0; i <= 5; ++i) {
    const double s = i / 5.0;
    mesh.nodes.push_back(low + s * std::sqrt(s) * (high - low));
    if (i > 0) mesh.lines.insert(mesh.lines.end(), {first + i - 1, first + i});
  }
  mesh.line_groups["bar"] = {0, 1, 2, 3, 4};
  return mesh;
}

std::span<const double> view(const VectorXd& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}
std::span<double> view(VectorXd& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}

/// Forces, virtual work, mass and tangent of embedded lines against those of the lines alone, whose
/// ends are moved with the cells.
template <int dim>
void check_embedded(CellType type) {
  SCOPED_TRACE(name(type));
  const Mesh<dim> mesh = box_with_bar<dim>(type);
  const std::vector<fem::LineMaterial> tied = {steel(true)}, loose = {steel(false)};
  const auto embedded = fem::find_embedded_nodes<dim>(mesh, tied, {});
  ASSERT_EQ(embedded.nodes.size(), 6u);
  const fem::LineBlock<dim> block(mesh, tied[0], {0, 1, 2, 3, 4}, false, {{}, {}, &embedded});
  const fem::LineBlock<dim> plain(mesh, loose[0], {0, 1, 2, 3, 4}, false);
  const auto size = static_cast<Eigen::Index>(mesh.nodes.size()) * dim;

  // A linear field: all lines have its strain, the forces balance, masses sum to the bar's.
  Matrix<dim> H = Matrix<dim>::Zero();
  H(0, 0) = 2e-3;
  H(1, 0) = -1e-3;
  H(0, 1) = 3e-3;
  VectorXd u = VectorXd::Zero(size);
  for (std::int32_t i = 0; i < embedded.nodes[0]; ++i) u.segment<dim>(i * dim) = H * mesh.nodes[i];
  const auto forces = block.forces(view(u), {});
  for (std::size_t k = 0; k < 5; ++k) {
    const Vector<dim> chord = mesh.nodes[mesh.line(static_cast<int>(k))[1]] -
                              mesh.nodes[mesh.line(static_cast<int>(k))[0]];
    const double strain = (chord + H * chord).norm() / chord.norm() - 1;
    EXPECT_NEAR(forces[k], E * area * strain, 1e-9 * E * area * strain);
  }

  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-0.05, 0.05);
  const auto draw = [&] {
    VectorXd x = VectorXd::NullaryExpr(size, [&] { return shift(random); });
    embedded.follow(view(x));
    return x;
  };
  u = draw();
  const VectorXd v = draw();
  VectorXd f = VectorXd::Zero(size), f_plain = f, m = f, m_plain = f;
  block.add_internal(view(u), view(f), nullptr, {});
  plain.add_internal(view(u), view(f_plain), nullptr, {});
  block.add_mass_times(view(u), view(m));
  plain.add_mass_times(view(u), view(m_plain));
  EXPECT_NEAR(f.dot(v), f_plain.dot(v), 1e-12 * f.norm());
  EXPECT_NEAR(m.dot(v), m_plain.dot(v), 1e-12 * m.norm());
  EXPECT_EQ(f.tail(6 * dim).norm(), 0);
  for (int c = 0; c < dim; ++c) {
    double sum = 0, mass = 0;
    VectorXd unit = VectorXd::Zero(size), of_unit = unit;
    for (Eigen::Index i = c; i < size; i += dim) unit[i] = 1;
    block.add_mass_times(view(unit), view(of_unit));
    for (Eigen::Index i = c; i < size; i += dim) {
      sum += f[i];
      mass += of_unit[i];
    }
    Vector<dim> ends = mesh.nodes.back() - mesh.nodes[embedded.nodes[0]];
    EXPECT_NEAR(sum, 0, 1e-12 * f.norm());
    EXPECT_NEAR(mass, density * area * ends.norm(), 1e-11);
  }

  const auto force = [&](const VectorXd& at) {
    VectorXd result = VectorXd::Zero(size);
    block.add_internal(view(at), view(result), nullptr, {});
    return result;
  };
  std::vector<std::int32_t> offsets = {0}, nodes;
  for (std::int32_t e = 0; e < mesh.num_elements(); ++e) {
    std::vector<std::int32_t> own;
    if (e < mesh.num_cells()) {
      own.assign(mesh.cell(e).begin(), mesh.cell(e).end());
    } else {
      own = embedded.line_nodes(mesh, e - mesh.num_cells());
    }
    nodes.insert(nodes.end(), own.begin(), own.end());
    offsets.push_back(static_cast<std::int32_t>(nodes.size()));
  }
  BlockMatrix<dim> K;
  K.set_pattern(mesh.num_nodes_total(), offsets, nodes);
  K.set_zero();
  VectorXd unused = VectorXd::Zero(size);
  block.add_internal(view(u), view(unused), &K, {});
  const VectorXd along = draw();
  VectorXd Kv(size);
  K.multiply(view(along), view(Kv));
  const double h = 1e-5;
  const VectorXd difference = (8 * (force(u + h * along) - force(u - h * along)) -
                               (force(u + 2 * h * along) - force(u - 2 * h * along))) /
                              (12 * h);
  EXPECT_LT((Kv - difference).norm(), 1e-8 * difference.norm());
  K.set_zero();
  block.add_mass(1, K);
  K.multiply(view(along), view(Kv));
  unused.setZero();
  block.add_mass_times(view(along), view(unused));
  EXPECT_LT((Kv - unused).norm(), 1e-12 * unused.norm());
}

TEST(EmbeddedBars, forces_work_mass_and_tangent_in_every_cell) {
  for (const CellType type :
       {CellType::tri3, CellType::quad4, CellType::tri6, CellType::quad8, CellType::quad9})
    check_embedded<2>(type);
  for (const CellType type :
       {CellType::tet4, CellType::hex8, CellType::tet10, CellType::hex20, CellType::hex27})
    check_embedded<3>(type);
}

TEST(EmbeddedBars, refused_places) {
  Mesh<2> mesh = box_with_bar<2>(CellType::quad4);
  mesh.nodes.back() = {0.5, 1.01};
  const std::vector<fem::LineMaterial> bars = {steel(true)};
  expect_error<ConfigError>([&] { fem::find_embedded_nodes<2>(mesh, bars, {}); },
                            {"/materials/0/group", "(0.5, 1.01)", "outside all cells"});
  mesh = box_with_bar<2>(CellType::quad4);
  mesh.line_groups["bar"] = {0, 1, 2};
  mesh.line_groups["rope"] = {3, 4};
  std::vector<fem::LineMaterial> both = {steel(true), steel(false)};
  both[1].group = "rope";
  expect_error<ConfigError>([&] { fem::find_embedded_nodes<2>(mesh, both, {}); },
                            {"/materials/0/group", "rope"});
}

/// The strip with a bar that has nodes of its own: `shift` times the cell's length beside those of
/// the cells, `rise` above the lower edge.
GmshText strip_with_bar(double length, double height, int cells, double shift, double rise) {
  GmshText file = strip(length, height, cells);
  file.groups.push_back({1, 5, "steel"});
  file.entities.push_back({1, 3, {5}});
  std::vector<std::vector<int>> lines;
  const int first = static_cast<int>(file.nodes.size()) + 1;
  for (int i = 0; i <= cells; ++i) {
    const double x = length * (i + (i == 0 || i == cells ? 0 : shift)) / cells;
    file.nodes.push_back({x, rise, 0});
    if (i > 0) lines.push_back({first + i - 1, first + i});
  }
  file.blocks.push_back({1, 3, 1, lines});
  return file;
}

void turn(GmshText& file, double angle) {
  for (auto& x : file.nodes) {
    x = {std::cos(angle) * x[0] - std::sin(angle) * x[1],
         std::sin(angle) * x[0] + std::cos(angle) * x[1], 0};
  }
}

Json with_steel(Json json, bool embedded) {
  json["materials"].push_back({{"group", "steel"},
                               {"law", "bar"},
                               {"density", 7850},
                               {"young_modulus", E},
                               {"area", area},
                               {"yield_stress", 500e6}});
  if (embedded) json["materials"].back()["embedded"] = true;
  return json;
}

/// A block of concrete in tension with a bar inside: the force is that of both sections, whatever
/// the place of the bar and of its nodes, and however the block is turned.
TEST(EmbeddedBars, stiffness_sums) {
  const double L = 0.5, height = 0.1, strain = 5e-5, angle = 0.6;
  for (const double rise : {0.0, 0.013, 0.05, 0.1}) {
    for (const double shift : {0.0, 0.21}) {
      GmshText file = strip_with_bar(L, height, 5, shift, rise);
      turn(file, angle);
      const TemporaryMesh mesh(file);
      Json json = with_steel(pulled_strip(mesh.path(), 5, 0), true);
      const double e = strain * L;
      json["prescribed"] = {
          {{"group", "right"}, {"component", "x"}, {"table", {{0, 0}, {1, e * std::cos(angle)}}}},
          {{"group", "right"}, {"component", "y"}, {"table", {{0, 0}, {1, e * std::sin(angle)}}}}};
      json["newton"] = {{"residual_tolerance", 1e-12}};
      json["sections"] = {{{"name", "cut"},
                           {"point", {0.22 * std::cos(angle), 0.22 * std::sin(angle)}},
                           {"normal", {std::cos(angle), std::sin(angle)}}}};
      const auto solver = fem_solver<2>(json);
      advance(*solver, 1, 1.0);
      const double of_concrete = 30e9 * std::log1p(strain) / (1 + strain) * height;
      const double of_steel = E * area * strain, force = of_concrete + of_steel;
      EXPECT_NEAR(probe(*solver, "axial_max_steel"), of_steel, 1e-9 * of_steel);
      EXPECT_NEAR(probe(*solver, "axial_min_steel"), of_steel, 1e-9 * of_steel);
      EXPECT_NEAR(-probe(*solver, "reaction_left_x"), force * std::cos(angle), 1e-9 * force);
      EXPECT_NEAR(-probe(*solver, "reaction_left_y"), force * std::sin(angle), 1e-9 * force);
      EXPECT_NEAR(probe(*solver, "cut.N"), force, 1e-9 * force);
    }
  }
}

/// A bar with nodes of its own in the places of those of the cells is the bar on these nodes.
TEST(EmbeddedBars, on_nodes_as_without) {
  const TemporaryMesh own(strip_with_bar(0.25, 0.1, 5, 0, 0));
  const TemporaryMesh common(strip(0.25, 0.1, 5, /*with_steel=*/true));
  Json json = with_steel(pulled_strip(own.path(), 5, 4e-4), true);
  const auto embedded = fem_solver<2>(json);
  json = with_steel(pulled_strip(common.path(), 5, 4e-4), false);
  const auto plain = fem_solver<2>(json);
  json["materials"].back()["embedded"] = true;
  const auto same = fem_solver<2>(json);
  for (int n = 1; n <= 60; ++n) {
    for (auto* solver : {embedded.get(), plain.get(), same.get()}) advance(*solver, n, 1.0 / 60);
    EXPECT_EQ(same->probes(), plain->probes());  // no node to embed
    for (const std::string name : {"reaction_left_x", "axial_max_steel", "crack_width"}) {
      const double expected = probe(*plain, name);
      EXPECT_NEAR(probe(*embedded, name), expected, 1e-10 * std::abs(expected) + 1e-15) << name;
    }
  }
}

/// The state at the start moves embedded nodes with their hosts; at rest nothing is solved.
TEST(EmbeddedBars, states_follow_the_hosts) {
  const TemporaryMesh mesh(strip_with_bar(0.25, 0.1, 5, 0.3, 0.04));
  Json json = with_steel(pulled_strip(mesh.path(), 5, 0), true);
  json["analysis"] = "dynamic";
  json["prescribed"] = Json::array();
  json["initial_velocity"] = {0, 2};
  const auto moving = fem_solver<2>(json);
  const auto& v = moving->state().motion.v;
  std::size_t fastest = 0;
  for (std::size_t i = 1; i < v.size(); i += 2) fastest += v[i] == 2;
  const std::size_t held = 2 * 2;  // nodes of the side, at most
  EXPECT_GE(fastest, v.size() / 2 - held);

  const auto pulled = fem_solver<2>(with_steel(pulled_strip(mesh.path(), 5, 1e-6), true));
  EXPECT_GT(advance(*pulled, 1, 1), 0);
  EXPECT_EQ(advance(*pulled, 2, 1), 0);
}

/// Bars that stand twice, on nodes of their own each time, would count twice.
TEST(EmbeddedBars, bars_in_one_place_are_refused) {
  GmshText file = strip_with_bar(0.25, 0.1, 5, 0.3, 0.04);
  const GmshText other = strip_with_bar(0.25, 0.1, 5, 0.3, 0.04);
  const int first = static_cast<int>(file.nodes.size());
  file.nodes.insert(file.nodes.end(), other.nodes.end() - 6, other.nodes.end());
  file.groups.push_back({1, 6, "more"});
  file.entities.push_back({1, 4, {6}});
  std::vector<std::vector<int>> lines;
  for (int i = 5; i > 0; --i) lines.push_back({first + i + 1, first + i});
  file.blocks.push_back({1, 4, 1, lines});
  const TemporaryMesh mesh(file);
  Json json = with_steel(pulled_strip(mesh.path(), 5, 4e-4), true);
  json["materials"].push_back(json["materials"].back());
  json["materials"].back()["group"] = "more";
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"/materials/3/group", "\"more\"", "\"steel\"", "(0.25, 0.04)"});
}

TEST(EmbeddedBars, restart_gives_the_same_bits_and_conditions_are_refused) {
  GmshText file = strip_with_bar(0.25, 0.1, 5, 0.3, 0.04);
  const TemporaryMesh mesh(file);
  Json json = with_steel(pulled_strip(mesh.path(), 5, 4e-4), true);
  json["materials"].back()["yield_stress"] = 50e6;
  json["analysis"] = "dynamic";
  const auto run = fem_solver<2>(json), restarted = fem_solver<2>(json);
  for (int n = 1; n <= 30; ++n) advance(*run, n, 0.0125);
  restarted->load_state(run->save_state());
  for (int n = 31; n <= 60; ++n) {
    EXPECT_EQ(advance(*restarted, n, 0.0125), advance(*run, n, 0.0125));
    EXPECT_EQ(restarted->probes(), run->probes()) << n;
  }
  EXPECT_EQ(restarted->save_state().reals, run->save_state().reals);
  EXPECT_GT(probe(*run, "plastic_strain_steel"), 1e-5);

  json["supports"].push_back({{"group", "steel"}});
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"/supports/1/group", "steel", "embedded"});
  json["supports"].erase(1);
  json["loads"] = {{{"point", {0.065, 0.04}}, {"force", {1, 0}}}};
  expect_error<ConfigError>([&] { fem_solver<2>(json); }, {"/loads/0/point", "embedded"});
  json.erase("loads");
  json["materials"].push_back(json["materials"].back());
  json["materials"].back()["group"] = "gone";
  expect_error<ConfigError>([&] { fem_solver<2>(json); }, {"/materials/3/group", "gone"});
}

/// A link would pull at a node that is no unknown.
TEST(EmbeddedBars, rigid_links_to_embedded_nodes_are_refused) {
  GmshText file = strip_with_bar(0.25, 0.1, 5, 0.3, 0.04);
  const int first = static_cast<int>(file.nodes.size()) + 1;
  file.nodes.push_back({0.25, 0.5, 0});
  file.nodes.push_back({0.25, 0.9, 0});
  file.groups.insert(file.groups.end(), {{1, 7, "post"}, {0, 8, "foot"}});
  file.entities.insert(file.entities.end(), {{1, 5, {7}}, {0, 6, {8}}});
  file.blocks.push_back({1, 5, 1, {{first, first + 1}}});
  file.blocks.push_back({0, 6, 15, {{first}}});
  const TemporaryMesh mesh(file);
  Json json = with_steel(pulled_strip(mesh.path(), 5, 4e-4), true);
  json["materials"].push_back(
      {{"group", "post"},
       {"law", "beam"},
       {"density", 7850},
       {"young_modulus", E},
       {"poisson_ratio", 0.3},
       {"cross_section", {{"shape", "pipe"}, {"diameter", 0.1}, {"wall", 0.01}}}});
  json["rigid_links"] = {{{"beam", "foot"}, {"group", "steel"}}};
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"/rigid_links/0/group", "steel", "embedded"});
}

}  // namespace
}  // namespace gabion::test::test_embedded_bars
