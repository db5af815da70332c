// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/support/expect_error.hpp"
#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing::test_read_material {
namespace {

Json soil() {
  return {{"law", "mohr_coulomb"}, {"density", 2650},        {"young_modulus", 840e3},
          {"poisson_ratio", 0.3},  {"friction_angle", 19.8}, {"cohesion", 10}};
}

void expect_refused(const Json& material, const std::vector<std::string_view>& parts) {
  test::expect_error<ConfigError>(
      [&] { read_material<2>(ConfigReader(material, "mpm.json", material_keys(material_laws))); },
      parts);
}

void expect_refused_with(const std::string& key, const Json& value,
                         const std::vector<std::string_view>& parts) {
  Json material = soil();
  material[key] = value;
  expect_refused(material, parts);
}

TEST(ReadMaterial, mohr_coulomb) {
  const auto material =
      read_material<2>(ConfigReader(soil(), "mpm.json", material_keys(material_laws)));
  EXPECT_EQ(material.law_name, "mohr_coulomb");
  EXPECT_EQ(material.density, 2650);
  const auto& law = std::get<MohrCoulomb<2>>(material.law);
  EXPECT_NEAR(law.p_wave_modulus(), 840e3 * 0.7 / (1.3 * 0.4), 1e-6);
  EXPECT_NEAR(law.parameters().mu, 840e3 / 2.6, 1e-6);
  EXPECT_NEAR(law.parameters().friction_angle, 19.8 * degree, 1e-15);
  EXPECT_EQ(law.parameters().dilation_angle, 0);
  EXPECT_EQ(law.parameters().cohesion, 10);
  EXPECT_EQ(law.parameters().apex_volume, ApexVolume::gap);
  EXPECT_FALSE(law.symmetric_tangent());
}

Json clay() {
  return {{"law", "tresca"},
          {"density", 1800},
          {"young_modulus", 5e6},
          {"poisson_ratio", 0.45},
          {"cohesion", 2e4}};
}

TEST(ReadMaterial, tresca) {
  const auto material =
      read_material<3>(ConfigReader(clay(), "mpm.json", material_keys(material_laws)));
  const auto& law = std::get<Tresca<3>>(material.law);
  EXPECT_NEAR(law.parameters().mu, 5e6 / 2.9, 1e-6);
  EXPECT_EQ(law.parameters().cohesion, 2e4);
  EXPECT_TRUE(law.symmetric_tangent());
  EXPECT_FALSE(is_elastic<3>(material.law));

  Json bad = clay();
  bad["cohesion"] = 0;
  expect_refused(bad, {"/cohesion", "> 0"});
  bad = clay();
  bad.erase("cohesion");
  expect_refused(bad, {"/cohesion", "missing"});
  bad = clay();
  bad["friction_angle"] = 10;
  expect_refused(bad, {"/friction_angle", "unknown"});
}

TEST(ReadMaterial, drucker_prager) {
  Json json = soil();
  json["law"] = "drucker_prager";
  const auto plain = std::get<DruckerPrager<2>>(
      read_material<2>(ConfigReader(json, "f", material_keys(material_laws))).law);
  EXPECT_EQ(plain.parameters().match, ConeMatch::plane_strain);
  EXPECT_EQ(plain.parameters().apex_volume, ApexVolume::gap);
  EXPECT_NEAR(plain.cone().eta, std::sin(19.8 * degree), 1e-15);
  for (const auto& [word, match] :
       {std::pair{"compression", ConeMatch::compression}, {"extension", ConeMatch::extension}}) {
    json["match"] = word;
    const auto law = std::get<DruckerPrager<2>>(
        read_material<2>(ConfigReader(json, "f", material_keys(material_laws))).law);
    EXPECT_EQ(law.parameters().match, match);
  }
  json["match"] = "inner";
  expect_refused(json, {"/match", "inner", "plane_strain"});
  json.erase("match");
  json["friction_angle"] = 0;
  expect_refused(json, {"/friction_angle", "tresca"});
}

TEST(ReadMaterial, herschel_bulkley) {
  Json json = {{"law", "herschel_bulkley"}, {"density", 1800},   {"young_modulus", 1e6},
               {"poisson_ratio", 0.49},     {"yield_stress", 0}, {"consistency", 20}};
  const auto read = [&] {
    return std::get<HerschelBulkley<2>>(
               read_material<2>(ConfigReader(json, "f", material_keys(material_laws))).law)
        .parameters();
  };
  EXPECT_EQ(read().flow_index, 1);
  EXPECT_EQ(read().yield_stress, 0);
  json["flow_index"] = 0.4;
  EXPECT_EQ(read().flow_index, 0.4);
  EXPECT_EQ(read().consistency, 20);
  const Json good = json;
  for (const auto& [name, bad] : {std::pair{"flow_index", 0.05},
                                  {"flow_index", 2.1},
                                  {"consistency", 0.0},
                                  {"yield_stress", -1.0}}) {
    json = good;
    json[name] = bad;
    expect_refused(json, {std::string("/") + name});
  }
  json = good;
  json["cohesion"] = 1;
  expect_refused(json, {"/cohesion", "unknown"});
}

TEST(ReadMaterial, mu_i) {
  const Json good = {{"law", "mu_i"},           {"density", 1500},         {"young_modulus", 1e6},
                     {"poisson_ratio", 0.3},    {"static_friction", 0.38}, {"limit_friction", 0.64},
                     {"inertial_number", 0.28}, {"grain_size", 5e-4},      {"grain_density", 2450}};
  Json json = good;
  const auto read = [&] {
    return std::get<MuI<2>>(
               read_material<2>(ConfigReader(json, "f", material_keys(material_laws))).law)
        .parameters();
  };
  EXPECT_EQ(read().static_friction, 0.38);
  EXPECT_EQ(read().limit_friction, 0.64);
  EXPECT_EQ(read().inertial_number, 0.28);
  EXPECT_EQ(read().grain_size, 5e-4);
  EXPECT_EQ(read().grain_density, 2450);
  EXPECT_EQ(read().apex_volume, ApexVolume::gap);
  json["limit_friction"] = 0.38;  // a cone of constant friction
  EXPECT_EQ(read().limit_friction, 0.38);
  for (const auto& [name, bad] : {std::pair{"static_friction", 0.0},
                                  {"limit_friction", 0.37},
                                  {"inertial_number", 0.0},
                                  {"grain_size", 0.0},
                                  {"grain_density", -1.0}}) {
    json = good;
    json[name] = bad;
    expect_refused(json, {std::string("/") + name});
    json.erase(name);
    expect_refused(json, {name});
  }
  json = good;
  json["friction_angle"] = 30;
  expect_refused(json, {"/friction_angle", "unknown"});
}

TEST(ReadMaterial, newtonian) {
  const Json good = {
      {"law", "newtonian"}, {"density", 1000}, {"sound_speed", 24}, {"viscosity", 1e-3}};
  Json json = good;
  const auto read = [&] {
    return std::get<Newtonian<2>>(
               read_material<2>(ConfigReader(json, "f", material_keys(material_laws))).law)
        .parameters();
  };
  EXPECT_EQ(read().bulk_modulus, 576000);
  EXPECT_EQ(read().viscosity, 1e-3);
  EXPECT_EQ(read().cavitation_pressure, 0);
  json["viscosity"] = 0;
  json["cavitation_pressure"] = 1e5;
  EXPECT_EQ(read().viscosity, 0);
  EXPECT_EQ(read().cavitation_pressure, 1e5);
  for (const auto& [name, bad] :
       {std::pair{"sound_speed", 0.0}, {"viscosity", -1.0}, {"cavitation_pressure", -1.0}}) {
    json = good;
    json[name] = bad;
    expect_refused(json, {std::string("/") + name});
  }
  for (const char* name : {"sound_speed", "viscosity"}) {
    json = good;
    json.erase(name);
    expect_refused(json, {name});
  }
  for (const char* name : {"young_modulus", "poisson_ratio", "yield_stress"}) {
    json = good;
    json[name] = 0.3;
    expect_refused(json, {std::string("/") + name});
  }
}

TEST(ReadMaterial, apex_volume) {
  for (const std::string law : {"mohr_coulomb", "drucker_prager"}) {
    Json json = soil();
    json["law"] = law;
    json["apex_volume"] = "lost";
    expect_refused(json, {"/apex_volume", "lost", "gap", "forget"});
  }
  Json json = soil();
  json["apex_volume"] = "forget";
  const auto material =
      read_material<2>(ConfigReader(json, "mpm.json", material_keys(material_laws)));
  EXPECT_EQ(std::get<MohrCoulomb<2>>(material.law).parameters().apex_volume, ApexVolume::forget);
}

TEST(ReadMaterial, tension_cutoff) {
  Json json = soil();  // apex at 10 / tan 19.8 = 27.78
  json["tension_cutoff"] = 5;
  const auto sand = read_material<2>(ConfigReader(json, "mpm.json", material_keys(material_laws)));
  EXPECT_EQ(std::get<MohrCoulomb<2>>(sand.law).parameters().tension_cutoff, 5);
  for (const double bad : {-1.0, 28.0}) {
    expect_refused_with("tension_cutoff", bad, {"/tension_cutoff", "27.7", "apex"});
  }
  json["law"] = "drucker_prager";
  expect_refused(json, {"/tension_cutoff", "unknown"});

  json = clay();
  const auto uncut = read_material<2>(ConfigReader(json, "mpm.json", material_keys(material_laws)));
  EXPECT_EQ(std::get<Tresca<2>>(uncut.law).parameters().tension_cutoff, no_cutoff);
  json["apex_volume"] = "gap";
  expect_refused(json, {"/apex_volume", "unknown"});  // nothing to apply it to
  json["tension_cutoff"] = 0;
  const auto cut = read_material<2>(ConfigReader(json, "mpm.json", material_keys(material_laws)));
  EXPECT_EQ(std::get<Tresca<2>>(cut.law).parameters().tension_cutoff, 0);
  json["tension_cutoff"] = -1;
  expect_refused(json, {"/tension_cutoff", ">= 0"});
}

template <class Law>
void expect_elastic(const std::string& name) {
  const Json wall = {
      {"law", name}, {"density", 1100}, {"young_modulus", 1e6}, {"poisson_ratio", 0}};
  const auto material =
      read_material<3>(ConfigReader(wall, "fem.json", material_keys(elastic_laws)));
  ASSERT_TRUE(std::holds_alternative<Law>(material.law)) << name;
  EXPECT_TRUE(is_elastic<3>(material.law));
  EXPECT_EQ(std::get<Law>(material.law).lambda, 0);
  EXPECT_EQ(std::get<Law>(material.law).mu, 5e5);

  Json with_friction = wall;
  with_friction["friction_angle"] = 30;
  expect_refused(with_friction, {"/friction_angle", "unknown"});
}

TEST(ReadMaterial, elastic_laws) {
  expect_elastic<LinearElastic<3>>("linear_elastic");
  expect_elastic<NeoHookean<3>>("neo_hookean");
  expect_elastic<HenckyElastic<3>>("hencky_elastic");
}

/// A law in all but one function.
struct WithoutModuli {
  static constexpr bool is_elastic = true;
  bool update(const Matrix<2>&, const MaterialState<2>&, StressUpdate<2>&, Tangent<2>*) const;
  bool symmetric_tangent() const;
};
struct WithModuli : WithoutModuli {
  double p_wave_modulus() const;
  double shear_modulus() const;
};

TEST(ConstitutiveLaw, is_what_the_solvers_ask_for) {
  EXPECT_TRUE((ConstitutiveLaw<WithModuli, 2>));
  EXPECT_FALSE((ConstitutiveLaw<WithoutModuli, 2>));
  EXPECT_FALSE((ConstitutiveLaw<WithModuli, 3>));  // its update is that of the plane
}

TEST(ReadMaterial, the_variant_updates_like_its_law) {
  const auto material =
      read_material<2>(ConfigReader(soil(), "mpm.json", material_keys(material_laws)));
  const Matrix<2> H = -0.01 * Matrix<2>::Identity();
  StressUpdate<2> out;
  ASSERT_TRUE(update<2>(material.law, H, {}, out, nullptr));
  EXPECT_EQ(out.P, stress<2>(std::get<MohrCoulomb<2>>(material.law), H, {}).P);
}

TEST(ReadMaterial, errors_say_where_what_and_what_is_allowed) {
  expect_refused_with("density", -1, {"mpm.json", "/density", "-1", "> 0"});
  expect_refused_with("law", "mohr_columb",
                      {"/law", "mohr_columb", "mohr_coulomb", "hencky_elastic"});
  expect_refused_with("poisson_ratio", 0.5, {"/poisson_ratio", "0.5, both excluded"});
  expect_refused_with("poisson_ratio", -1, {"/poisson_ratio: found -1"});
  expect_refused_with("young_modulus", 0, {"/young_modulus: found 0", "> 0"});
  expect_refused_with("friction_angle", 0, {"/friction_angle", "\"tresca\""});
  expect_refused_with("friction_angle", 90, {"/friction_angle: found 90"});
  expect_refused_with("dilation_angle", 25, {"/dilation_angle", "19.8"});
  expect_refused_with("cohesion", -5, {"/cohesion: found -5"});
  expect_refused_with("cohession", 5, {"/cohession", "unknown", "cohesion"});
  Json without_law = soil();
  without_law.erase("law");
  expect_refused(without_law, {"/law", "missing"});
}

}  // namespace
}  // namespace gabion::testing::test_read_material
