// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_mpm_config {
namespace {

Json valid() {
  return {{"dimension", 2},
          {"grid", box({0, 0}, {2, 1}, {8, 4}, "tri3")},
          {"walls", {wall("bottom", "fixed"), wall("left", "slip")}},
          {"bodies",
           {body("soil", box({0, 0}, {1, 0.5}, {4, 2}, "tri3"), 3,
                 elastic_soil("hencky_elastic", 1e5, 0.3, 1000))}},
          {"interfaces",
           {{{"name", "plate"},
             {"surface", {{"polyline", {{1.5, 0.5}, {1.5, 0}}}, {"spacing", 0.25}}}}}}};
}

Json valid_3d() {
  return {{"dimension", 3},
          {"grid", box({0, 0, 0}, {2, 1, 1}, {4, 2, 2}, "hex8")},
          {"bodies",
           {body("soil", box({0, 0, 0}, {1, 1, 1}, {2, 2, 2}, "hex8"), 8,
                 elastic_soil("hencky_elastic", 1e5, 0.3, 1000))}}};
}

void expect_refused(const Json& json, const std::vector<std::string_view>& parts) {
  expect_error<ConfigError>([&] { make_mpm(json); }, parts);
}

TEST(MpmConfig, valid_scenes_in_both_dimensions) {
  EXPECT_EQ(make_mpm(valid())->interfaces().size(), 1u);
  EXPECT_EQ(make_mpm(valid_3d())->interfaces().size(), 0u);
}

TEST(MpmConfig, keys_of_contact_by_facets) {
  Json json = valid();
  Json& interface = json["interfaces"][0];
  const auto settings = mpm_settings<2>(json);
  const auto& facets = std::get<mpm::FacetSettings>(settings.interfaces.at(0).method);
  EXPECT_EQ(facets.penalty_factor, 10);
  EXPECT_EQ(facets.tangential_factor, 0.25);
  EXPECT_EQ(mpm::interface_mesh(settings.interfaces[0]).force_kind, ForceKind::step_mean);
  interface["mode"] = "fixed";
  expect_refused(json, {"/interfaces/0/mode", "fixed", "facets", "allowed: contact, slip"});
  interface["mode"] = "contact";
  EXPECT_EQ(settings.interfaces.at(0).friction, 100);  // it sticks
  interface["tangential_factor"] = 0;
  expect_refused(json, {"/interfaces/0/tangential_factor"});
  interface.erase("tangential_factor");
  interface["penalty"] = 1e5;
  expect_refused(json, {"/interfaces/0/penalty"});
  interface.erase("penalty");
  interface["gap"] = "step";
  expect_refused(json, {"/interfaces/0/gap"});
}

TEST(MpmConfig, keys_of_contact_by_boundary_points) {
  Json json = valid();
  json["interfaces"][0]["method"] = "boundary_points";
  const TemporaryScene folder("mpm.json", json);
  const Scene scene(folder.path(), {});
  ConfigReader in = scene.reader("mpm.json", mpm::mpm_keys());
  in.integer("dimension");
  const auto settings = mpm::read_mpm_settings<2>(scene, in, nullptr);
  const double M = 1e5 * 0.7 / (1.3 * 0.4);
  const auto& interface = settings.interfaces.at(0);
  EXPECT_EQ(interface.mode, mpm::ContactMode::contact);
  EXPECT_LT(interface.friction, 0);
  const auto& points = std::get<mpm::BoundaryPointSettings>(settings.interfaces[0].method);
  EXPECT_NEAR(points.penalty, 0.5 * M / 0.25, 1e-6 * M);
  EXPECT_EQ(points.tangential_share, 1);
  EXPECT_EQ(points.memory, mpm::GapMemory::accumulated);
  EXPECT_EQ(settings.interfaces[0].surface.facets.size(), 4u);
  EXPECT_EQ(settings.pic_share, 0);
  EXPECT_EQ(settings.phases.at(0).scheme.alpha_m, -0.1);
  EXPECT_EQ(settings.gravity, Vector<2>::Zero());
}

TEST(MpmConfig, unknown_key_with_a_suggestion) {
  Json json = valid();
  json["gravitation"] = {0, -9.81};
  expect_refused(json, {"mpm.json", "/gravitation", "unknown", "gravity"});
  json = valid();
  json["bodies"][0]["material"]["friction"] = 30;
  expect_refused(json, {"/bodies/0/material/friction", "unknown"});
  json = valid();
  json["walls"][1]["mode"] = "slip";
  expect_refused(json, {"/walls/1/mode", "unknown", "group"});
}

TEST(MpmConfig, wrong_types_and_ranges) {
  Json json = valid();
  json["bodies"][0]["material"]["density"] = -5;
  expect_refused(json, {"/bodies/0/material/density", "-5", "> 0"});
  json = valid();
  json["gravity"] = "down";
  expect_refused(json, {"/gravity", "\"down\"", "2 numbers"});
  json = valid();
  json["gravity"] = {0, 0, -9.81};
  expect_refused(json, {"/gravity", "2 numbers"});
  json = valid();
  json["dimension"] = 4;
  expect_refused(json, {"/dimension", "4", "2 to 3"});
  json = valid();
  json["transfer"] = {{"pic_share", 1.5}};
  expect_refused(json, {"/transfer/pic_share", "1.5", "0 to 1"});
  json["transfer"] = {{"method", "apic"}};
  expect_refused(json, {"/transfer/method", "apic", "flip, tpic"});
  json["transfer"] = {{"method", "tpic"}, {"pic_share", 0.1}};
  expect_refused(json, {"/transfer/pic_share", "only with", "flip"});
  json = valid();
  json["bodies"] = Json::array();
  expect_refused(json, {"/bodies", "at least one body"});
  json = valid();
  json["bodies"].push_back(json["bodies"][0]);
  expect_refused(json, {"/bodies/1/name", "soil", "second time"});
  json = valid();
  json["time_integration"] = {{"scheme", "bossak"}, {"alpha", -0.5}};
  expect_refused(json, {"/time_integration/alpha", "-0.5", "-1/3"});
}

std::string locking_method(const Json& json) {
  return make_mpm(json)->summary().at("locking").at("method");
}

TEST(MpmConfig, volumes_are_averaged_where_soil_would_lock) {
  Json json = valid();
  EXPECT_EQ(locking_method(json), "none");
  json["bodies"][0]["material"]["poisson_ratio"] = 0.46;
  EXPECT_EQ(locking_method(json), "fbar");
  json = valid();
  Json& material = json["bodies"][0]["material"];
  material["law"] = "mohr_coulomb";
  material["friction_angle"] = 30;
  EXPECT_EQ(locking_method(json), "fbar");
  for (const std::string law : {"mohr_coulomb", "drucker_prager"}) {
    material["law"] = law;
    for (const double dilation_angle : {1e-9, 1.0, 30.0}) {
      material["dilation_angle"] = dilation_angle;
      EXPECT_EQ(locking_method(json), "fbar") << law << ", " << dilation_angle;
    }
  }
  json["locking"] = {{"method", "none"}};
  EXPECT_EQ(locking_method(json), "none");
  json["locking"] = {{"method", "bbar"}};
  expect_refused(json, {"/locking/method", "bbar", "fbar, none"});
  json["locking"] = {{"mode", "fbar"}};
  expect_refused(json, {"/locking/mode", "did you mean \"method\"?"});
  json["locking"] = Json::object();
  EXPECT_EQ(locking_method(json), "fbar");
}

TEST(MpmConfig, small_cuts) {
  Json json = valid();
  json["small_cuts"] = {{"method", "hope"}};
  expect_refused(json, {"/small_cuts/method", "hope", "none, ghost, mass_cutoff"});
  json["small_cuts"] = {{"method", "ghost"}, {"ghost_factor", 0}};
  expect_refused(json, {"/small_cuts/ghost_factor", "0", "> 0"});
  json["small_cuts"] = {{"method", "none"}, {"ghost_factor", 0.1}};
  expect_refused(json, {"/small_cuts/ghost_factor", "ghost"});
  json["small_cuts"] = {{"method", "mass_cutoff"}, {"mass_share", 0.1}};
  expect_refused(json, {"/small_cuts/mass_share", "0.1", "(0, 0.01]"});
  json["small_cuts"] = {{"method", "ghost"}, {"mass_share", 1e-4}};
  expect_refused(json, {"/small_cuts/mass_share", "mass_cutoff", "quasi_static"});
  json["small_cuts"] = {{"method", "ghost"}};
  json["grid"] = box({0, 0}, {2, 1}, {8, 4}, "quad4");
  json["basis"] = "bspline";
  expect_refused(json, {"/small_cuts/method", "ghost", "bspline"});
  json = valid();
  json["small_cuts"] = {{"factor", 1}};
  expect_refused(json, {"/small_cuts/factor", "unknown"});
}

TEST(MpmConfig, missing_mesh_file) {
  Json json = valid();
  json["grid"] = {{"file", "nowhere.msh"}};
  expect_refused(json, {"mpm.json", "/grid/file", "nowhere.msh"});
}

TEST(MpmConfig, missing_wall_group_names_those_that_exist) {
  for (const char* condition : {"fixed", "slip"}) {
    Json json = valid();
    json["walls"][1] = wall("floor", condition);
    expect_refused(json, {"mpm.json", "/walls/1/group", "floor", "bottom", "left", "right", "top"});
  }
  Json json = valid();
  json["walls"][0]["condition"] = "rough";
  expect_refused(json, {"/walls/0/condition", "rough", "fixed, slip"});
}

TEST(MpmConfig, basis_needs_cells_in_rows) {
  Json json = valid();
  json["basis"] = "gimp";
  expect_refused(json, {"mpm.json", "/basis", "\"gimp\"", "box", "quad4", "linear"});
  json["basis"] = "cubic";
  expect_refused(json, {"/basis", "cubic", "linear, gimp, bspline"});
  json["grid"] = box({0, 0}, {2, 1}, {8, 4}, "quad4");
  for (const char* basis : {"linear", "gimp", "bspline"}) {
    json["basis"] = basis;
    EXPECT_EQ(make_mpm(json)->summary()["basis"], basis);
  }
}

TEST(MpmConfig, linear_functions_of_soil_that_yields_sum_over_cells) {
  const auto quadrature = [](const Json& json) {
    return make_mpm(json)->summary().at("quadrature");
  };
  Json json = valid();
  json["basis"] = "linear";
  json["bodies"][0]["material"] = elastic_soil("hencky_elastic", 1e6, 0.3, 1000);
  EXPECT_EQ(quadrature(json), "points");
  json["quadrature"] = "cells";
  EXPECT_EQ(quadrature(json), "cells");
  json.erase("quadrature");
  json["bodies"][0]["material"] = elastic_soil("mohr_coulomb", 1e6, 0.3, 1000);
  json["bodies"][0]["material"].update(
      {{"friction_angle", 30}, {"dilation_angle", 0}, {"cohesion", 0}});
  EXPECT_EQ(quadrature(json), "cells");
  json["quadrature"] = "points";
  EXPECT_EQ(quadrature(json), "points");
  json["grid"] = box({0, 0}, {2, 1}, {8, 4}, "quad4");
  json["basis"] = "bspline";
  json["quadrature"] = "cells";
  expect_refused(json, {"/quadrature", "\"cells\"", "\"bspline\"", "points"});
}

TEST(MpmConfig, boxes_of_soil_in_a_box_of_cells_get_domains) {
  const auto basis = [](const Json& json) { return make_mpm(json)->summary().at("basis"); };
  EXPECT_EQ(mpm_solver<3>(valid_3d())->summary().at("basis"), "gimp");
  Json json = valid();
  EXPECT_EQ(basis(json), "linear");  // triangles
  json["grid"] = box({0, 0}, {2, 1}, {8, 4}, "quad4");
  json["bodies"][0]["mesh"] = box({0, 0}, {1, 0.5}, {4, 2}, "tri3");
  EXPECT_EQ(basis(json), "linear");  // whose points have no domains that fill them
  json["bodies"][0]["mesh"] = box({0, 0}, {1, 0.5}, {4, 2}, "quad4");
  json["bodies"][0]["points_per_cell"] = 4;
  EXPECT_EQ(basis(json), "gimp");
}

/// A file in the temporary folder that vanishes with this object.
class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& content)
      : path_(std::filesystem::temp_directory_path() /
              fmt::format("gabion_{}_{}", getpid(), name)) {
    std::ofstream(path_) << content;
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  TemporaryFile(TemporaryFile&&) = delete;
  TemporaryFile& operator=(TemporaryFile&&) = delete;

  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

/// One hex8 from (0, 0, 0) to (1, 1, 1), its top moved by `shift`.
TemporaryFile brick(const Vector<3>& shift) {
  std::string text =
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 8 1 8\n3 1 0 8\n1\n2\n3\n4\n5\n6\n7\n8\n";
  for (const int z : {0, 1}) {
    for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
      text +=
          fmt::format("{} {} {}\n", x + z * shift[0], y + z * shift[1], z + z * shift[2] + 0.1 * x);
    }
  }
  text += "$EndNodes\n$Elements\n1 1 1 1\n3 1 5 1\n1 1 2 3 4 5 6 7 8\n$EndElements\n";
  return {"brick.msh", text};
}

TEST(MpmConfig, upright_columns_get_domains_and_others_do_not) {
  for (const auto& [shift, basis] :
       {std::pair<Vector<3>, std::string>{{0, 0, 0.2}, "gimp"}, {{0.2, 0, 0}, "linear"}}) {
    const TemporaryFile file = brick(shift);
    Json json = valid_3d();
    json["grid"] = box({0, 0, 0}, {2, 2, 2}, {2, 2, 2}, "hex8");
    json["bodies"][0]["mesh"] = {{"file", file.path()}};
    EXPECT_EQ(mpm_solver<3>(json)->summary().at("basis"), basis);
  }
}

TEST(MpmConfig, surfaces_of_triangles) {
  const TemporaryFile file("bed.stl",
                           "solid bed\nfacet normal 0 0 -1\nouter loop\nvertex 0 0 0\n"
                           "vertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid\n");
  Json json = valid_3d();
  json["rigid_walls"] = {{{"name", "bed"}, {"surface", {{"triangles", file.path()}}}}};
  Json& surface = json["rigid_walls"][0]["surface"];
  expect_refused(json, {"bed", "normals point into the soil"});  // it looks down
  surface["normals"] = "up";
  const auto settings = mpm_settings<3>(json);
  const auto& read = settings.rigid_walls.at(0).boundary.surface;
  EXPECT_EQ(read.facet_type, CellType::tri3);
  EXPECT_EQ(read.facets.size(), 3U);
  EXPECT_TRUE(make_mpm(json));
  surface["normals"] = "down";
  expect_refused(json, {"/rigid_walls/0/surface/normals", "down", "file, up"});
  surface["normals"] = "up";
  surface["groups"] = {"top"};
  expect_refused(json, {"/rigid_walls/0/surface/groups"});
  surface.erase("groups");
  surface["triangles"] = "none.ply";
  expect_refused(json, {"/rigid_walls/0/surface/triangles", "none.ply: cannot open"});
  Json flat = valid();
  flat["interfaces"][0]["surface"] = {{"triangles", file.path()}};
  expect_refused(flat, {"/interfaces/0/surface/triangles", "3D only"});
}

TEST(MpmConfig, points_of_gimp_fill_their_body) {
  Json json = valid_3d();
  json["basis"] = "gimp";
  const auto solver = mpm_solver<3>(json);
  EXPECT_LT((solver->points().x[0] - Vector<3>::Constant(0.125)).norm(), 1e-15);
  json["bodies"][0]["points_per_cell"] = 1;
  EXPECT_EQ(make_mpm(json)->summary()["capped_domains"], 0);
  json["grid"]["box"]["cells"] = {8, 2, 2};
  expect_refused(json, {"/bodies/0/points_per_cell", "2 grid cells wide", "gimp"});
  json = valid();
  json["bodies"][0]["point_placement"] = "regular";
  expect_refused(json, {"/bodies/0/point_placement", "regular", "tri3", "gauss"});
  json["bodies"][0]["point_placement"] = "random";
  expect_refused(json, {"/bodies/0/point_placement", "random", "gauss, regular"});
}

TEST(MpmConfig, interfaces) {
  Json json = valid();
  json["interfaces"][0]["mode"] = "slip";
  json["interfaces"][0]["friction"] = 0.3;
  expect_refused(json, {"/interfaces/0/friction", "contact"});
  json = valid();
  json["interfaces"][0]["friction"] = -0.3;
  expect_refused(json, {"/interfaces/0/friction", "-0.3", ">= 0"});
  json = valid();
  json["interfaces"][0]["mode"] = "glue";
  expect_refused(json, {"/interfaces/0/mode", "glue", "fixed, contact, slip"});
  json = valid();
  json["interfaces"][0]["method"] = "boundary_points";
  json["interfaces"][0]["penalty"] = 1e6;
  json["interfaces"][0]["penalty_factor"] = 20;
  expect_refused(json, {"/interfaces/0/penalty_factor", "only one of", "\"penalty\""});
  json = valid();
  json["interfaces"][0]["surface"]["polyline"] = {{1.5, 0.5}};
  expect_refused(json, {"/interfaces/0/surface/polyline", "two points"});
  json = valid();
  json["interfaces"][0]["surface"] = {{"mesh", box({1, 0}, {2, 1}, {1, 1}, "quad4")},
                                      {"groups", {"roof"}}};
  expect_refused(json, {"/interfaces/0/surface/groups", "roof", "bottom", "left", "right", "top"});
  json = valid();
  json["interfaces"].push_back(json["interfaces"][0]);
  expect_refused(json, {"/interfaces/1/name", "plate", "second time"});
  json = valid_3d();
  json["interfaces"] = valid()["interfaces"];
  expect_refused(json, {"/interfaces/0/surface/polyline", "2D only"});
}

TEST(MpmConfig, surfaces_with_too_many_parts) {
  Json json = valid();
  Json& surface = json["interfaces"][0]["surface"];
  surface["spacing"] = 1e-9;
  expect_refused(json, {"/interfaces/0/surface/spacing", "1e-09", "500000000 segments", "1000000"});
  surface["spacing"] = 1e-300;
  expect_refused(json, {"/interfaces/0/surface/spacing", "1e-300", "segments", "1000000"});
  surface["spacing"] = 5e-324;
  expect_refused(json, {"/interfaces/0/surface/spacing", "inf segments"});
  surface["spacing"] = 100;
  EXPECT_EQ(mpm_settings<2>(json).interfaces[0].surface.vertices.size(), 2u);
  json["interfaces"][0]["method"] = "boundary_points";
  json["interfaces"][0]["points_per_facet"] = 2000000000;
  expect_refused(json, {"/interfaces/0/points_per_facet", "2000000000 boundary points", "1000000"});
  json = valid();
  json["rigid_walls"] = json["interfaces"];
  json["rigid_walls"][0]["surface"]["spacing"] = 1e-9;
  expect_refused(json, {"/rigid_walls/0/surface/spacing", "500000000 segments"});
}

/// 0.44 m by 0.02 m is 22 wherever the origin is.
TEST(MpmConfig, segments_of_a_polyline_far_from_the_origin) {
  for (const double far : {0.0, 1048576.0, -3.7e6}) {
    Json json = valid();
    json["grid"]["box"]["low"] = {0, far};
    json["grid"]["box"]["high"] = {2, far + 1};
    json["bodies"][0]["mesh"]["box"]["low"] = {0, far};
    json["bodies"][0]["mesh"]["box"]["high"] = {1, far + 0.5};
    Json& surface = json["interfaces"][0]["surface"];
    surface["spacing"] = 0.02;
    surface["polyline"] = {
        {1.5, far + 0.52}, {1.5, far + 0.38}, {1.5, far + 0.22}, {1.5, far + 0.08}};
    EXPECT_EQ(mpm_settings<2>(json).interfaces[0].surface.facets.size(), 2 * 22u) << far;
  }
}

TEST(MpmConfig, polyline_with_a_repeated_point) {
  Json json = valid();
  json["interfaces"][0]["surface"]["polyline"] = {{1.5, 0.5}, {1.5, 0.2}, {1.5, 0.2}, {1.5, 0}};
  expect_refused(json, {"mpm.json: at /interfaces/0/surface/polyline/2:", "(1.5, 0.2)"});
}

TEST(MpmConfig, names_that_no_table_can_hold) {
  for (const std::string name : {"", "a,b", "a\nb", "a/b"}) {
    for (const char* list : {"bodies", "interfaces"}) {
      Json json = valid();
      json[list][0]["name"] = name;
      const std::string place = "mpm.json: at /" + std::string(list) + "/0/name:";
      expect_refused(json, {place, "letters, digits"});
    }
    Json json = valid();
    json["rigid_walls"] = json["interfaces"];
    json["rigid_walls"][0]["name"] = name;
    expect_refused(json, {"mpm.json: at /rigid_walls/0/name:", "letters, digits"});
    json = valid();
    json["probes"] = {{{"name", name}, {"point", {0.5, 0.5}}}};
    expect_refused(json, {"mpm.json: at /probes/0/name:", "letters, digits"});
  }
}

TEST(MpmConfig, what_is_given_twice) {
  Json json = valid();
  json["walls"].push_back(wall("bottom", "slip"));
  expect_refused(json, {"mpm.json: at /walls/2/group:", "bottom", "second time"});
  json = valid();
  json["interfaces"].push_back(json["interfaces"][0]);
  json["interfaces"][1]["name"] = "other";
  expect_refused(json, {"mpm.json: at /interfaces/1/surface:", "(1.5, 0.5)", "second time"});
  // The other side of a thin plate.
  json["interfaces"][1]["surface"]["polyline"] = {{1.5, 0}, {1.5, 0.5}};
  EXPECT_NO_THROW(make_mpm(json));
  json = valid();
  json["interfaces"][0]["surface"] = {{"mesh", box({1, 0}, {2, 1}, {1, 1}, "quad4")},
                                      {"groups", {"left", "left"}}};
  expect_refused(json, {"/interfaces/0/surface", "second time"});
  json = valid_3d();
  json["interfaces"] = {
      {{"name", "block"},
       {"surface",
        {{"mesh", box({1, 0, 0}, {2, 1, 1}, {1, 1, 1}, "hex8")}, {"groups", {"left", "left"}}}}}};
  expect_refused(json, {"/interfaces/0/surface", "second time"});
}

/// In 3D the default count of boundary points fits the facets.
TEST(MpmConfig, three_dimensional_surfaces) {
  for (const char* type : {"tet4", "hex8"}) {
    Json json = valid_3d();
    json["interfaces"] = {
        {{"name", "block"},
         {"surface",
          {{"mesh", box({1, 0, 0}, {2, 1, 1}, {1, 1, 1}, type)}, {"groups", {"left"}}}}}};
    EXPECT_NO_THROW(make_mpm(json)) << type;
    json["interfaces"][0]["method"] = "boundary_points";
    json["interfaces"][0]["points_per_facet"] = 5;
    expect_refused(json, {"/interfaces/0/points_per_facet", "5"});
  }
}

TEST(MpmConfig, averaged_forces_at_an_interface) {
  Json json = valid();
  json["time_integration"] = {{"scheme", "generalized_alpha"}, {"rho_inf", 0.8}};
  expect_refused(json, {"mpm.json", "/time_integration", "interfaces", "bossak", "rho_inf 0"});
  json["time_integration"]["rho_inf"] = 0;
  EXPECT_NO_THROW(make_mpm(json));
  json["time_integration"]["rho_inf"] = 1.2;
  expect_refused(json, {"/time_integration/rho_inf", "1.2", "0 to 1"});
  json["time_integration"]["rho_inf"] = 0.8;
  json.erase("interfaces");
  EXPECT_NO_THROW(make_mpm(json));
}

TEST(MpmConfig, counts_of_points_that_are_not_offered) {
  Json json = valid();
  json["bodies"][0]["points_per_cell"] = 5;
  expect_refused(json, {"mpm.json", "/bodies/0/points_per_cell", "5", "tri3", "1, 3, 4, 6"});
}

TEST(MpmConfig, body_outside_the_grid) {
  Json json = valid();
  json["bodies"][0]["mesh"] = box({1.5, 0}, {2.5, 0.5}, {4, 2}, "quad4");
  json["bodies"][0]["points_per_cell"] = 1;
  expect_refused(json,
                 {"mpm.json: at /bodies/0:", "material point 2", "(2.125, 0.125)", "outside"});
  json = valid();
  json["bodies"].push_back(json["bodies"][0]);
  json["bodies"][1]["name"] = "rock";
  json["bodies"][1]["mesh"] = box({1.5, 0}, {2.5, 0.5}, {4, 2}, "tri3");
  expect_refused(json, {"mpm.json: at /bodies/1:", "outside"});
}

TEST(MpmConfig, step_control) {
  Json json = valid();
  json["step_control"] = {{"advective", nullptr}, {"newton_target", 6}};
  const auto control = mpm_settings<2>(json).step_control;
  EXPECT_FALSE(control.advective);
  EXPECT_EQ(control.newton_target, 6);
  EXPECT_EQ(control.strain, 0.02);
  EXPECT_FALSE(mpm_settings<2>(valid()).step_control.any());
  for (const char* key : {"time_error", "advective", "strain", "approach"}) {
    json["step_control"] = {{key, 1.5}};
    const std::string place = std::string("/step_control/") + key;
    expect_refused(json, {place, "1.5", "(0, 1]"});
  }
  json["step_control"] = {{"newton_target", 0}};
  expect_refused(json, {"/step_control/newton_target", "0", ">= 1"});
  json["step_control"] = {{"courant", 2}};
  expect_refused(json, {"/step_control/courant", "unknown"});
}

TEST(MpmConfig, outside) {
  Json json = valid();
  json["outside"] = "clamp";
  expect_refused(json, {"/outside", "\"clamp\"", "error, remove"});
}

TEST(MpmConfig, time_is_read_only_without_a_coupler) {
  Json json = valid();
  json["time"] = {{"end", 1.0}, {"dt", 0.1}, {"dt_min", 0.01}};
  expect_refused(json, {"/time", "only in a scene without coupler.json"});
  json["output"] = {{"interval", 0.5}};
  const TemporaryScene folder("mpm.json", json);
  const Scene scene(folder.path(), {});
  ConfigReader in = scene.reader("mpm.json", mpm::mpm_keys());
  AloneSettings alone;
  make_mpm_solver(scene, in, comm(), "", &alone);
  EXPECT_EQ(alone.time.dt, 0.1);
  EXPECT_EQ(alone.output_interval, 0.5);
}

TEST(MpmConfig, what_has_no_meaning_without_inertia) {
  Json json = valid();
  json["analysis"] = "static";
  expect_refused(json, {"/analysis", "\"static\"", "dynamic, quasi_static"});
  json["analysis"] = "quasi_static";
  EXPECT_NO_THROW(make_mpm(json));
  json["time_integration"] = {{"scheme", "newmark"}};
  expect_refused(json, {"/time_integration", "no meaning", "quasi_static"});
  json.erase("time_integration");
  json["transfer"] = {{"pic_share", 0.1}};
  expect_refused(json, {"/transfer", "no meaning", "quasi_static"});
  json.erase("transfer");
  json["bodies"][0]["velocity"] = {0, 1};
  expect_refused(json, {"/bodies/0/velocity", "zero", "quasi-static"});
}

TEST(MpmConfig, gravity_ramp) {
  Json json = valid();
  json["gravity_ramp"] = {{"duration", 0}};
  expect_refused(json, {"/gravity_ramp/duration", "0", "> 0"});
  json["gravity_ramp"] = {{"duration", 1}, {"shape", "cubic"}};
  expect_refused(json, {"/gravity_ramp/shape", "cubic", "linear, smooth"});
}

TEST(MpmConfig, motion_of_walls) {
  Json json = valid();
  json["walls"][1]["motion"] = Json::object();
  expect_refused(json, {"/walls/1/motion/velocity", "exactly one", "table"});
  json["walls"][1]["motion"] = {{"velocity", {1}}};
  expect_refused(json, {"/walls/1/motion/velocity", "2 numbers"});
  json["walls"][1]["motion"] = {{"table", {{0, 1, 0}, {0, 2, 0}}}};
  expect_refused(json, {"/walls/1/motion/table/1", "after 0", "increasing"});
  json["walls"][1]["motion"] = {{"table", Json::array()}};
  expect_refused(json, {"/walls/1/motion/table", "at least one row"});
}

TEST(MpmConfig, phases) {
  Json json = valid();
  json["phases"] = Json::array();
  expect_refused(json, {"/phases", "at least one phase"});
  json["phases"] = {{{"until", 1}}, {{"until", 2}}};
  expect_refused(json, {"/phases/1/until", "last one"});
  json["phases"] = {{{"analysis", "quasi_static"}}, Json::object()};
  expect_refused(json, {"/phases/0/until"});
  json["phases"] = {{{"until", 2}}, {{"until", 1}}, Json::object()};
  expect_refused(json, {"/phases/1/until", "found 1", "after the start of the phase, 2"});
  json["phases"] = {{{"until", 2}, {"dt", 0}}, Json::object()};
  expect_refused(json, {"/phases/0/dt", "> 0"});
  json["phases"] = {{{"until", 2}, {"walls", {wall("floor", "slip")}}}, Json::object()};
  expect_refused(json, {"/phases/0/walls/0/group", "floor", "bottom"});
  json["phases"] = {{{"until", 2}},
                    {{"analysis", "quasi_static"}, {"time_integration", trapezoid}}};
  expect_refused(json, {"/phases/1/time_integration", "no meaning", "quasi_static"});
  json["phases"] = {{{"until", 2}, {"gravity", {0, 1}}}, Json::object()};
  expect_refused(json, {"/phases/0/gravity", "unknown"});
}

/// A lone run knows its steps, and so whether one of them can end where a phase does.
TEST(MpmConfig, phases_end_on_the_raster_of_the_steps) {
  Json json = valid();
  json["time"] = {{"end", 1.0}, {"dt", 0.1}, {"dt_min", 0.01}};
  json["output"] = {{"interval", 0.5}};
  const auto read = [](const Json& scene_json) {
    const TemporaryScene folder("mpm.json", scene_json);
    const Scene scene(folder.path(), {});
    ConfigReader in = scene.reader("mpm.json", mpm::mpm_keys());
    AloneSettings alone;
    make_mpm_solver(scene, in, comm(), "", &alone);
  };
  json["phases"] = {{{"until", 0.325}}, Json::object()};
  EXPECT_NO_THROW(read(json));
  json["phases"] = {{{"until", 0.33}}, Json::object()};
  expect_error<ConfigError>([&] { read(json); },
                            {"/phases/0/until", "0.33", "multiple of time/dt = 0.1"});
}

TEST(MpmConfig, initial_stress) {
  Json json = valid();
  json["gravity"] = {0, -10};
  json["walls"].push_back(wall("right", "slip"));
  json["bodies"][0]["mesh"] = box({0, 0}, {2, 0.5}, {8, 2}, "tri3");
  json.erase("interfaces");  // its plate stands where soil is now
  Json& stress = json["bodies"][0]["initial_stress"];
  stress = {{"k0", "elastic"}, {"surface", 0.5}};
  EXPECT_NO_THROW(make_mpm(json));
  stress["k0"] = "jaky";
  expect_refused(json, {"/bodies/0/initial_stress/k0", "hencky_elastic", "friction angle"});
  stress["k0"] = -0.5;
  expect_refused(json, {"/bodies/0/initial_stress/k0", "-0.5", ">= 0"});
  stress["k0"] = "active";
  expect_refused(json, {"/bodies/0/initial_stress/k0", "active", "elastic, jaky"});
  stress["k0"] = 0.5;
  stress["ocr"] = 0.5;
  expect_refused(json, {"/bodies/0/initial_stress/ocr", "0.5"});
  stress.erase("ocr");
  stress["surface"] = 0.4;
  expect_refused(json,
                 {"/bodies/0/initial_stress/surface", "found 0.4", "material point", "above it"});
  stress["surface"] = 0.5;
  json["gravity"] = {1, -10};
  expect_refused(json,
                 {"/bodies/0/initial_stress", "found gravity (1, -10)", "against the last axis"});
  json["gravity"] = {0, -10};
  json["bodies"][0]["material"]["law"] = "neo_hookean";
  expect_refused(json, {"/bodies/0/initial_stress/k0", "neo_hookean", "Hencky"});
}

/// Without the wall at its right side the soil is not in balance.
TEST(MpmConfig, initial_stress_without_support) {
  Json json = valid();
  json["gravity"] = {0, -10};
  json["bodies"][0]["initial_stress"] = {{"k0", 0.5}, {"surface", 0.5}};
  expect_refused(json, {"/bodies/0/initial_stress/k0", "not in balance", "max_displacement"});
  json["bodies"][0]["initial_stress"]["max_displacement"] = 1;
  EXPECT_NO_THROW(make_mpm(json));
}

/// Soil in the air, away from all walls.
TEST(MpmConfig, initial_stress_of_a_body_that_is_held_nowhere) {
  Json json = valid();
  json["gravity"] = {0, -10};
  json["bodies"][0]["mesh"] = box({0.25, 0.25}, {1, 0.75}, {3, 2}, "tri3");
  json["bodies"][0]["initial_stress"] = {{"k0", 0.5}, {"surface", 0.75}};
  expect_refused(json, {"mpm.json: at /bodies/0/initial_stress/k0", "no equilibrium",
                        "part of it is not held", "allowed: bodies that rest on \"walls\""});
}

TEST(MpmConfig, initial_stress_that_the_soil_does_not_bear) {
  Json json = valid();
  json["gravity"] = {0, -10};
  json["bodies"][0]["material"]["law"] = "mohr_coulomb";
  json["bodies"][0]["material"]["friction_angle"] = 30;
  for (const double k0 : {0.3, 3.1}) {
    json["bodies"][0]["initial_stress"] = {{"k0", k0}, {"surface", 0.5}, {"max_displacement", 9}};
    expect_refused(
        json, {"/bodies/0/initial_stress/k0", "material point 0", "would yield", "[0.333333, 3]"});
  }
}

TEST(MpmConfig, probe_columns) {
  Json json = valid();
  json["probes"] = {{{"name", "A"}, {"point", {1.0, 0.5}}}};
  const auto solver = make_mpm(json);
  EXPECT_EQ(solver->probe_names(), (std::vector<std::string>{"mass",
                                                             "kinetic_energy",
                                                             "elastic_energy",
                                                             "momentum_x",
                                                             "momentum_y",
                                                             "front",
                                                             "plastic_dissipation",
                                                             "time_damping",
                                                             "transfer_loss",
                                                             "wall_loss",
                                                             "quadrature_loss",
                                                             "gravity_work",
                                                             "boundary_work",
                                                             "energy_balance",
                                                             "created_energy",
                                                             "contact_energy",
                                                             "contact_friction",
                                                             "contact_loss",
                                                             "contact_created",
                                                             "momentum_error_x",
                                                             "momentum_error_y",
                                                             "A.ux",
                                                             "A.uy",
                                                             "wall.bottom.fx",
                                                             "wall.bottom.fy",
                                                             "wall.left.fx",
                                                             "wall.left.fy"}));
  EXPECT_NEAR(probe(*solver, "mass"), 500, 1e-10);
  EXPECT_GT(probe(*solver, "front"), 0.9);
}

}  // namespace
}  // namespace gabion::test::test_mpm_config
