// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Json soil() {
  return {{"law", "mohr_coulomb"}, {"density", 2650},        {"young_modulus", 840e3},
          {"poisson_ratio", 0.3},  {"friction_angle", 19.8}, {"cohesion", 10}};
}

std::string message_of(const Json& material) {
  try {
    read_material<2>(ConfigReader(material, "mpm.json", material_keys(material_laws)));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

std::string message_with(const std::string& key, const Json& value) {
  Json material = soil();
  material[key] = value;
  return message_of(material);
}

TEST(ReadMaterial, MohrCoulomb) {
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

TEST(ReadMaterial, Tresca) {
  const auto material =
      read_material<3>(ConfigReader(clay(), "mpm.json", material_keys(material_laws)));
  const auto& law = std::get<Tresca<3>>(material.law);
  EXPECT_NEAR(law.parameters().mu, 5e6 / 2.9, 1e-6);
  EXPECT_EQ(law.parameters().cohesion, 2e4);
  EXPECT_TRUE(law.symmetric_tangent());
  EXPECT_FALSE(is_elastic<3>(material.law));

  Json bad = clay();
  bad["cohesion"] = 0;
  EXPECT_THAT(message_of(bad), AllOf(HasSubstr("/cohesion"), HasSubstr("> 0")));
  bad = clay();
  bad.erase("cohesion");
  EXPECT_THAT(message_of(bad), HasSubstr("cohesion"));
  bad = clay();
  bad["friction_angle"] = 10;
  EXPECT_THAT(message_of(bad), HasSubstr("friction_angle"));
}

TEST(ReadMaterial, DruckerPrager) {
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
  EXPECT_THAT(message_of(json),
              AllOf(HasSubstr("/match"), HasSubstr("inner"), HasSubstr("plane_strain")));
  json.erase("match");
  json["friction_angle"] = 0;
  EXPECT_THAT(message_of(json), AllOf(HasSubstr("/friction_angle"), HasSubstr("tresca")));
}

TEST(ReadMaterial, ApexVolume) {
  for (const std::string law : {"mohr_coulomb", "drucker_prager"}) {
    Json json = soil();
    json["law"] = law;
    json["apex_volume"] = "lost";
    EXPECT_THAT(message_of(json), AllOf(HasSubstr("/apex_volume"), HasSubstr("lost"),
                                        HasSubstr("gap"), HasSubstr("forget")));
  }
  Json json = soil();
  json["apex_volume"] = "forget";
  const auto material =
      read_material<2>(ConfigReader(json, "mpm.json", material_keys(material_laws)));
  EXPECT_EQ(std::get<MohrCoulomb<2>>(material.law).parameters().apex_volume, ApexVolume::forget);
}

TEST(ReadMaterial, TensionCutoff) {
  Json json = soil();  // apex at 10 / tan 19.8 = 27.78
  json["tension_cutoff"] = 5;
  const auto sand = read_material<2>(ConfigReader(json, "mpm.json", material_keys(material_laws)));
  EXPECT_EQ(std::get<MohrCoulomb<2>>(sand.law).parameters().tension_cutoff, 5);
  for (const double bad : {-1.0, 28.0}) {
    EXPECT_THAT(message_with("tension_cutoff", bad),
                AllOf(HasSubstr("/tension_cutoff"), HasSubstr("27.7"), HasSubstr("apex")));
  }
  json["law"] = "drucker_prager";
  EXPECT_THAT(message_of(json), HasSubstr("tension_cutoff"));

  json = clay();
  const auto uncut = read_material<2>(ConfigReader(json, "mpm.json", material_keys(material_laws)));
  EXPECT_EQ(std::get<Tresca<2>>(uncut.law).parameters().tension_cutoff, no_cutoff);
  json["apex_volume"] = "gap";
  EXPECT_THAT(message_of(json), HasSubstr("apex_volume"));  // nothing to apply it to
  json["tension_cutoff"] = 0;
  const auto cut = read_material<2>(ConfigReader(json, "mpm.json", material_keys(material_laws)));
  EXPECT_EQ(std::get<Tresca<2>>(cut.law).parameters().tension_cutoff, 0);
  json["tension_cutoff"] = -1;
  EXPECT_THAT(message_of(json), AllOf(HasSubstr("/tension_cutoff"), HasSubstr(">= 0")));
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
  EXPECT_THROW(
      read_material<3>(ConfigReader(with_friction, "fem.json", material_keys(elastic_laws))),
      ConfigError);
}

TEST(ReadMaterial, ElasticLaws) {
  expect_elastic<LinearElastic<3>>("linear_elastic");
  expect_elastic<NeoHookean<3>>("neo_hookean");
  expect_elastic<HenckyElastic<3>>("hencky_elastic");
}

TEST(ReadMaterial, TheVariantUpdatesLikeItsLaw) {
  const auto material =
      read_material<2>(ConfigReader(soil(), "mpm.json", material_keys(material_laws)));
  const Matrix<2> H = -0.01 * Matrix<2>::Identity();
  StressUpdate<2> out;
  ASSERT_TRUE(update<2>(material.law, H, {}, out, nullptr));
  EXPECT_EQ(out.P, stress<2>(std::get<MohrCoulomb<2>>(material.law), H, {}).P);
}

TEST(ReadMaterial, ErrorsSayWhereWhatAndWhatIsAllowed) {
  EXPECT_THAT(message_with("density", -1), AllOf(HasSubstr("mpm.json"), HasSubstr("/density"),
                                                 HasSubstr("-1"), HasSubstr("> 0")));
  EXPECT_THAT(message_with("law", "mohr_columb"),
              AllOf(HasSubstr("/law"), HasSubstr("mohr_columb"), HasSubstr("mohr_coulomb"),
                    HasSubstr("hencky_elastic")));
  EXPECT_THAT(message_with("poisson_ratio", 0.5),
              AllOf(HasSubstr("/poisson_ratio"), HasSubstr("0.5, both excluded")));
  EXPECT_THAT(message_with("poisson_ratio", -1), HasSubstr("/poisson_ratio"));
  EXPECT_THAT(message_with("young_modulus", 0), HasSubstr("/young_modulus"));
  EXPECT_THAT(message_with("friction_angle", 0),
              AllOf(HasSubstr("/friction_angle"), HasSubstr("\"tresca\"")));
  EXPECT_THAT(message_with("friction_angle", 90), HasSubstr("/friction_angle"));
  EXPECT_THAT(message_with("dilation_angle", 25),
              AllOf(HasSubstr("/dilation_angle"), HasSubstr("19.8")));
  EXPECT_THAT(message_with("cohesion", -5), HasSubstr("/cohesion"));
  EXPECT_THAT(message_with("cohession", 5), AllOf(HasSubstr("cohession"), HasSubstr("cohesion")));
  Json without_law = soil();
  without_law.erase("law");
  EXPECT_THAT(message_of(without_law), HasSubstr("law"));
}

}  // namespace
}  // namespace gabion::testing
