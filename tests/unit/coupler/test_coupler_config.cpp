// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "coupler/coupler_config.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/coupler/good_coupler.hpp"

namespace gabion::test_coupler_config {
namespace {

CouplerSettings read_with(const std::string& pointer, const Json& value) {
  Json config = test::good_coupler();
  config[Json::json_pointer(pointer)] = value;
  return read_coupler_settings(ConfigReader(config, "coupler.json", coupler_keys()));
}

/// The good file with this value there is refused at the place `at`.
void expect_refused(const std::string& pointer, const Json& value, const std::string& at,
                    const std::string& text) {
  test::expect_error<ConfigError>([&] { read_with(pointer, value); },
                                  {"coupler.json: at " + at + ": ", text});
}

TEST(CouplerConfig, a_short_file_takes_the_defaults_and_shows_them) {
  const ConfigReader reader(test::good_coupler(), "coupler.json", coupler_keys());
  const CouplerSettings s = read_coupler_settings(reader);
  EXPECT_EQ(s.time.dt, 2e-4);
  EXPECT_EQ(s.output_interval, 0.01);
  ASSERT_EQ(s.participants.size(), 2u);
  EXPECT_TRUE(s.participants[0].sends_force);
  EXPECT_TRUE(s.interfaces[0].moment_about.empty());
  EXPECT_EQ(s.coupling.scheme, Scheme::serial_implicit);
  EXPECT_EQ(s.coupling.acceleration.method, "mvqn");
  const Json resolved = reader.resolved();
  EXPECT_EQ(resolved["coupling"]["on_limit"], "cut");
  EXPECT_EQ(resolved["coupling"]["acceleration"]["relaxation"], s.coupling.acceleration.relaxation);
  EXPECT_EQ(resolved["coupling"]["convergence"]["stagnation"], 20);
  EXPECT_TRUE(resolved["protocol"].contains("silence_deadline"));
  // The resolved settings are a complete config that reads as the same.
  const ConfigReader again(resolved, "resolved", coupler_keys());
  read_coupler_settings(again);
  EXPECT_EQ(again.resolved(), resolved);
}

TEST(CouplerConfig, a_number_is_the_limit_of_qr2_and_an_object_names_the_filter) {
  const auto filter_of = [](const Json& value) {
    Json config = test::good_coupler();
    config["coupling"]["acceleration"]["filter"] = value;
    return read_coupler_settings(ConfigReader(config, "coupler.json", coupler_keys()))
        .coupling.acceleration.filter;
  };
  EXPECT_EQ(filter_of(0.05).kind, FilterKind::qr2);
  EXPECT_EQ(filter_of(0.05).limit, 0.05);
  EXPECT_EQ(filter_of({{"kind", "qr1"}}).kind, FilterKind::qr1);
  EXPECT_EQ(filter_of({{"kind", "qr1"}}).limit, Filter().limit);
  EXPECT_EQ(filter_of({{"kind", "qr1_absolute"}, {"limit", 3}}).limit, 3);
  EXPECT_EQ(filter_of({{"kind", "none"}}).kind, FilterKind::none);
}

TEST(CouplerConfig, one_criterion_of_one_field_is_enough) {
  Json config = test::good_coupler();
  config["coupling"]["convergence"] = {{"displacement", {{"drop", 1e-4}}}, {"combine", "or"}};
  const ConvergenceSettings s =
      read_coupler_settings(ConfigReader(config, "coupler.json", coupler_keys()))
          .coupling.convergence;
  EXPECT_EQ(*s.displacement.drop, 1e-4);
  EXPECT_FALSE(s.displacement.absolute || s.displacement.relative || s.force.given());
  EXPECT_EQ(s.combine, Combine::any);
}

TEST(CouplerConfig, both_at_once_need_a_limit_of_the_force) {
  Json config = test::good_coupler();
  config["coupling"]["scheme"] = "parallel_implicit";
  EXPECT_NO_THROW(read_coupler_settings(ConfigReader(config, "coupler.json", coupler_keys())));
  config["coupling"]["convergence"].erase("force");
  test::expect_error<ConfigError>(
      [&] { read_coupler_settings(ConfigReader(config, "coupler.json", coupler_keys())); },
      {"coupler.json: at /coupling/convergence", "found no \"force\"", "parallel_implicit"});
}

TEST(CouplerConfig, a_participant_may_have_a_command) {
  Json config = test::good_coupler();
  config["participants"]["structure"]["command"] = {"python3", "wall.py"};
  const CouplerSettings s =
      read_coupler_settings(ConfigReader(config, "coupler.json", coupler_keys()));
  EXPECT_EQ(s.participants[1].command, (std::vector<std::string>{"python3", "wall.py"}));
  EXPECT_TRUE(s.participants[0].command.empty());
}

TEST(CouplerConfig, moments_about_a_place) {
  Json json = test::good_coupler();
  json["interfaces"][0]["moment_about"] = {0.5, -1};
  const auto s = read_coupler_settings(ConfigReader(json, "coupler.json", coupler_keys()));
  EXPECT_EQ(s.interfaces[0].moment_about, (std::vector<double>{0.5, -1}));
}

TEST(CouplerConfig, mistakes_are_named_with_their_place) {
  expect_refused("/coupling/predictr", 1, "/coupling/predictr", "did you mean \"predictor\"?");
  expect_refused("/coupling/predictor", 3, "/coupling/predictor", "a number from 0 to 2");
  expect_refused("/coupling/max_iterations", 1, "/coupling/max_iterations", "a number >= 2");
  expect_refused("/coupling/on_limit", "ignore", "/coupling/on_limit", "cut, stop, accept");
  expect_refused("/coupling/scheme", "parallel", "/coupling/scheme",
                 "serial_implicit, parallel_implicit, explicit");
  expect_refused("/coupling/acceleration", {{"method", "mvq"}}, "/coupling/acceleration/method",
                 "did you mean \"mvqn\"?");
  expect_refused("/coupling/acceleration", {{"relaxation", 0}}, "/coupling/acceleration/relaxation",
                 "a number > 0 and <= 2");
  expect_refused("/coupling/acceleration", {{"method", "aitken"}, {"filter", 0.1}},
                 "/coupling/acceleration/filter", "unknown key");
  expect_refused("/coupling/acceleration", {{"filter", {{"kind", "qr4"}}}},
                 "/coupling/acceleration/filter/kind", "none, qr1, qr1_absolute, qr2, qr3");
  expect_refused("/coupling/acceleration", {{"filter", {{"kind", "qr1"}, {"limit", 1}}}},
                 "/coupling/acceleration/filter/limit", "a number >= 0 and < 1");
  expect_refused("/coupling/acceleration", {{"filter", {{"kind", "qr1_absolute"}}}},
                 "/coupling/acceleration/filter/limit", "missing");
  expect_refused("/coupling/acceleration", {{"filter", {{"kind", "none"}, {"limit", 0.1}}}},
                 "/coupling/acceleration/filter/limit", "unknown key");
  expect_refused("/coupling/acceleration", {{"filter", 1}}, "/coupling/acceleration/filter",
                 "a number >= 0 and < 1");
  expect_refused("/coupling/acceleration", {{"method", "aitken"}, {"filter", 0.1}},
                 "/coupling/acceleration/filter", "unknown key");
  expect_refused("/coupling/step_control", {{"few", 5}, {"many", 5}}, "/coupling/step_control/many",
                 "more than few = 5");
  expect_refused("/coupling/step_control", {{"few", -1}}, "/coupling/step_control/few",
                 "a number >= 0");
  expect_refused("/coupling/convergence/force/floor", -1, "/coupling/convergence/force/floor",
                 "a number >= 0");
  expect_refused("/coupling/convergence/force", {{"floor", 1}}, "/coupling/convergence/force/floor",
                 "without \"relative\"");
  expect_refused("/coupling/convergence/force/relative", 1e-16,
                 "/coupling/convergence/force/relative", "round-off");
  expect_refused("/coupling/convergence/force/drop", 1, "/coupling/convergence/force/drop",
                 "a number > 0 and < 1");
  expect_refused("/coupling/convergence/combine", "xor", "/coupling/convergence/combine",
                 "and, or");
  expect_refused("/coupling/convergence", Json::object(), "/coupling/convergence/displacement",
                 "no criterion");
  expect_refused("/coupling/mapping/tolerance", -1, "/coupling/mapping/tolerance", "a number > 0");
  expect_refused("/time/dt_min", 1, "/time/dt_min", "<= dt");
  expect_refused("/time/dt_min", 1e-20, "/time/dt_min", "allowed: a number >= ");
  expect_refused("/output/interval", 0, "/output/interval", "a number > 0");
  expect_refused("/interfaces", Json::array(), "/interfaces", "found none");
  expect_refused("/interfaces/0/soil", "structure", "/interfaces/0/soil",
                 "allowed: a participant that sends force: soil");
  expect_refused("/interfaces/0/structure", "wal", "/interfaces/0/structure",
                 "allowed: a participant that sends displacement: structure");
  expect_refused(
      "/participants/structure/sends", "force", "/participants/structure/sends",
      "found \"force\" of a participant that \"interfaces\" names as structure, allowed: "
      "displacement");
  expect_refused("/participants/soil/sends", "displacement", "/participants/soil/sends",
                 "names as soil, allowed: force");
  expect_refused("/participants", {{"soil", {{"sends", "force"}}}}, "/participants",
                 "found none that sends displacement");
  expect_refused("/interfaces/1", {{"name", "wall"}, {"soil", "soil"}, {"structure", "structure"}},
                 "/interfaces/1/name", "each name once");
  expect_refused("/participants/rock", {{"sends", "force"}}, "/participants/rock", "no entry");
  expect_refused("/participants/soil/command", Json::array(), "/participants/soil/command",
                 "allowed: [program, argument, ...]");
  expect_refused("/participants/soil/command", {""}, "/participants/soil/command",
                 "found no program");
  expect_refused("/participants/soil/command", "python3 soil.py", "/participants/soil/command",
                 "allowed: a list");
  expect_refused("/participants/rock", {{"sends", "heat"}}, "/participants/rock/sends",
                 "force, displacement");
}

TEST(CouplerConfig, deformed_positions_need_a_projection) {
  const std::string at = "/coupling/mapping";
  Json config = test::good_coupler();
  config["coupling"]["mapping"] = {{"tolerance", 1}, {"positions", "deformed"}, {"moved", 0}};
  const auto mapping =
      read_coupler_settings(ConfigReader(config, "c.json", coupler_keys())).coupling.mapping;
  EXPECT_TRUE(mapping.deformed);
  EXPECT_EQ(mapping.moved, 0);
  expect_refused(at, {{"tolerance", 1}, {"positions", "current"}}, at + "/positions",
                 "reference, deformed");
  for (const char* method : {"radial_basis", "nearest_neighbor"}) {
    expect_refused(at, {{"tolerance", 1}, {"method", method}, {"positions", "deformed"}},
                   at + "/positions", "nearest_projection");
  }
  expect_refused(at, {{"tolerance", 1}, {"moved", 0.1}}, at + "/moved",
                 R"("positions": "deformed")");
  expect_refused(at, {{"tolerance", 1}, {"positions", "deformed"}, {"moved", -1}}, at + "/moved",
                 ">= 0");
}

TEST(CouplerConfig, radial_basis_keys_belong_to_the_radial_basis) {
  const std::string at = "/coupling/mapping";
  const std::vector<std::pair<std::string, Json>> keys = {
      {"kernel", "thin_plate"}, {"cluster_size", 20}, {"support", 1}};
  for (const auto& [key, value] : keys) {
    expect_refused(at, {{"tolerance", 1}, {key, value}}, at + "/" + key,
                   R"(allowed only with "method": "radial_basis")");
  }
  expect_refused(at, {{"tolerance", 1}, {"method", "radial_basis"}, {"kernel", "gauss"}},
                 at + "/kernel", "wendland_c2, wendland_c4, wendland_c6, thin_plate");
  expect_refused(at, {{"tolerance", 1}, {"method", "radial_basis"}, {"cluster_size", 3}},
                 at + "/cluster_size", "4 to 1000");
  expect_refused(at, {{"tolerance", 1}, {"method", "radial_basis"}, {"support", 0}},
                 at + "/support", "> 0");
  expect_refused(
      at, {{"tolerance", 1}, {"method", "radial_basis"}, {"kernel", "thin_plate"}, {"support", 1}},
      at + "/support", "wendland_c2");
}

TEST(CouplerConfig, names_that_no_table_can_hold) {
  const std::vector<std::string> bad = {
      "", "a,b", "a\"b", "a\nb", "a b", std::string("a\0b", 3), std::string(65, 'a')};
  for (const std::string& name : bad) {
    expect_refused("/interfaces/0/name", name, "/interfaces/0/name", "letters, digits, _ and -");
    Json roles = test::good_coupler()["participants"];
    roles[name] = {{"sends", "force"}};
    expect_refused("/participants", roles, "/participants", "letters, digits, _, - and .");
  }
  expect_refused("/interfaces/0/name", "a/b", "/interfaces/0/name", "letters, digits, _ and -");
  EXPECT_EQ(read_with("/interfaces/0/name", "Wall-2_b").interfaces[0].name, "Wall-2_b");
}

}  // namespace
}  // namespace gabion::test_coupler_config
