// SPDX-License-Identifier: BSD-3-Clause
// The tables of the three programs, and what they make of the scenes in configs/.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "common/settings/describe_keys.hpp"
#include "coupler/coupler_config.hpp"
#include "fem_solver/fem_config.hpp"
#include "fem_solver/matrices/matrix_settings.hpp"
#include "mpm_solver/mpm_config.hpp"

namespace gabion::test_key_tables {
namespace {

std::map<std::string, KeyTable> root_tables() {
  return {{"coupler.json", coupler_keys()},
          {"fem.json", fem::fem_keys()},
          {"mpm.json", mpm::mpm_keys()}};
}

/// Call for a table and all that are inside.
template <class Visit>
void for_each_table(const KeyTable& table, const Visit& visit) {
  visit(table);
  for (const Key& key : table.keys) {
    if (key.table) for_each_table(*key.table, visit);
  }
}

bool has_key(const KeyTable& table, const std::string& name) {
  return std::any_of(table.keys.begin(), table.keys.end(),
                     [&](const Key& key) { return key.name == name; });
}

TEST(KeyTables, each_key_has_a_sentence_and_a_default_that_is_allowed) {
  for (const auto& [file, root] : root_tables()) {
    for_each_table(root, [&](const KeyTable& table) {
      EXPECT_TRUE(table.sentence.ends_with('.')) << table.name;
      for (const Key& key : table.keys) {
        EXPECT_TRUE(key.sentence.ends_with('.')) << table.name << "/" << key.name;
        if (key.absence != Absence::fallback) continue;
        if (key.fallback.is_number()) {
          EXPECT_TRUE(key.range.holds(key.fallback)) << table.name << "/" << key.name;
        }
        if (key.type == KeyType::choice) {
          EXPECT_EQ(std::count(key.words.begin(), key.words.end(), key.fallback), 1)
              << table.name << "/" << key.name;
        }
      }
    });
  }
}

TEST(KeyTables, conditions_name_keys_and_words_of_the_same_object) {
  for (const auto& [file, root] : root_tables()) {
    for_each_table(root, [&](const KeyTable& table) {
      for (const std::string& name : table.one_of) EXPECT_TRUE(has_key(table, name)) << name;
      for (const Key& key : table.keys) {
        for (const Condition& condition : key.conditions) {
          EXPECT_TRUE(has_key(table, condition.key)) << table.name << "/" << key.name;
          for (const std::string& word : condition.words) {
            std::ptrdiff_t count = 0;  // over the forms that a key has under other conditions
            for (const Key& other : table.keys) {
              if (other.name != condition.key) continue;
              count += std::count(other.words.begin(), other.words.end(), word);
            }
            EXPECT_EQ(count, 1) << word;
          }
        }
      }
    });
  }
}

TEST(KeyTables, tables_of_one_name_in_one_file_are_equal) {
  for (const auto& [file, root] : root_tables()) {
    std::map<std::string, Json> known;
    for_each_table(root, [&](const KeyTable& table) {
      const Json schema = keys_as_schema(table, "");
      EXPECT_EQ(known.emplace(table.name, schema).first->second, schema) << table.name;
    });
  }
}

/// Every key that has a default is there, in each object of the file.
void expect_complete(const Json& object, const KeyTable& table, const std::string& place) {
  for (const Key& key : table.keys) {
    const bool may_be_absent = key.absence == Absence::none || key.computed.starts_with("none") ||
                               !key.circumstances.empty();
    if (!applies(key, table, object)) continue;  // another key of this name may
    if (!may_be_absent) {
      EXPECT_TRUE(object.contains(key.name)) << place << "/" << key.name;
    }
    if (!key.table || !object.contains(key.name)) continue;
    const Json& value = object.at(key.name);
    const std::string inside = place + "/" + key.name;
    if (key.type == KeyType::object) {
      if (value.is_object()) expect_complete(value, *key.table, inside);
    } else {
      for (const Json& entry : value) expect_complete(entry, *key.table, inside);
    }
  }
}

template <int dim>
void read_structure(const Scene& scene, ConfigReader& in) {
  if (in.has("matrices")) {
    fem::read_matrix_settings<dim>(in);
  } else {
    fem::read_fem_settings<dim>(scene, in);
  }
}

void read(const std::string& file, const Scene& scene, ConfigReader& in) {
  AloneSettings alone;
  AloneSettings* own_time = scene.has("coupler.json") ? nullptr : &alone;
  if (file == "coupler.json") {
    read_coupler_settings(in);
  } else if (file == "mpm.json") {
    in.integer("dimension") == 2
        ? static_cast<void>(mpm::read_mpm_settings<2>(scene, in, own_time))
        : static_cast<void>(mpm::read_mpm_settings<3>(scene, in, own_time));
  } else {
    fem::read_dimension(in) == 2 ? read_structure<2>(scene, in) : read_structure<3>(scene, in);
    if (own_time != nullptr) read_alone_settings(in);
    in.finish();
  }
}

void expect_the_same_read_again(const std::string& file, const KeyTable& table,
                                const Scene& scene) {
  SCOPED_TRACE(scene.path(file));
  ConfigReader in = scene.reader(file, table);
  read(file, scene, in);
  expect_complete(in.resolved(), table, file);
  ConfigReader again(in.resolved(), scene.path(file), table);
  read(file, scene, again);
  EXPECT_EQ(again.resolved(), in.resolved());
}

/// The values read, defaults included, are a file that reads as the same.
TEST(KeyTables, what_a_scene_resolves_to_is_complete_and_reads_as_the_same) {
  int count = 0;
  for (const auto& folder : std::filesystem::directory_iterator(GABION_CONFIGS)) {
    const Scene scene(folder.path().string(), {});
    for (const auto& [file, table] : root_tables()) {
      if (!scene.has(file)) continue;
      expect_the_same_read_again(file, table, scene);
      ++count;
    }
  }
  EXPECT_GE(count, 9);
  const Scene all_explicit(GABION_CONFIGS "/granular_obstacle",
                           {"mpm.json:/time_integration={\"scheme\": \"explicit\"}"});
  expect_the_same_read_again("mpm.json", mpm::mpm_keys(), all_explicit);
}

TEST(KeyTables, a_resolved_file_shows_the_tolerances_of_the_run) {
  const Scene scene(GABION_CONFIGS "/granular_obstacle", {});
  ConfigReader in = scene.reader("mpm.json", mpm::mpm_keys());
  in.integer("dimension");
  const auto settings = mpm::read_mpm_settings<2>(scene, in, nullptr);
  const Json resolved = in.resolved();
  EXPECT_EQ(resolved["newton"]["residual_tolerance"], settings.newton.residual_tolerance);
  EXPECT_EQ(resolved["newton"]["increment_tolerance"], settings.newton.increment_tolerance);
  EXPECT_EQ(resolved["linear_solver"]["method"].get<std::string>(), settings.linear_solver.method);
  EXPECT_EQ(resolved["linear_solver"]["tolerance"], settings.linear_solver.tolerance);
}

}  // namespace
}  // namespace gabion::test_key_tables
