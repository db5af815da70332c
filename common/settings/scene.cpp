// SPDX-License-Identifier: BSD-3-Clause
#include "common/settings/scene.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>

#include "common/base/read_file.hpp"
#include "common/base/require.hpp"
#include "common/settings/json_text.hpp"

namespace gabion {

namespace fs = std::filesystem;

namespace {

const std::vector<std::string> file_names = {"coupler.json", "mpm.json", "fem.json"};

Json read_json(const std::string& path) {
  return parse_settings(read_file(path, "settings file"), path);
}

/// An index behind the end of a list would fill the list up with nulls.
void require_entries(const Json& file, Json::json_pointer pointer, const std::string& text) {
  for (; !pointer.empty(); pointer.pop_back()) {
    const auto parent = pointer.parent_pointer();
    if (!file.contains(parent) || !file.at(parent).is_array()) continue;
    const std::size_t size = file.at(parent).size();
    require<ConfigError>(file.contains(pointer),
                         "--set {}: found entry \"{}\" of {}, allowed: 0 to {}", text,
                         pointer.back(), parent.to_string(), static_cast<std::int64_t>(size) - 1);
  }
}

}  // namespace

Scene::Scene(const std::string& folder, const std::vector<std::string>& overrides)
    : folder_(folder) {
  require<ConfigError>(fs::is_directory(folder), "{}: no such scene folder", folder);
  for (const auto& name : file_names) {
    const std::string file = path(name);
    if (fs::exists(file)) files_[name] = read_json(file);
  }
  require<ConfigError>(!files_.empty(), "{}: holds none of coupler.json, mpm.json, fem.json",
                       folder);
  for (const auto& text : overrides) {
    const auto colon = text.find(':');
    const auto equal = text.find('=', colon == std::string::npos ? 0 : colon);
    require<ConfigError>(
        colon != std::string::npos && equal != std::string::npos && text[colon + 1] == '/',
        "--set {}: allowed: FILE:/json/pointer=VALUE", text);
    const std::string file = text.substr(0, colon);
    if (!has(file)) {
      std::vector<std::string> present;
      for (const auto& item : files_.items()) present.push_back(item.key());
      throw ConfigError(
          fmt::format("--set {}: the scene {} has no file \"{}\"; did you mean \"{}\"?", text,
                      folder, file, nearest_word(file, present)));
    }
    const std::string value_text = text.substr(equal + 1);
    const Json value =
        Json::accept(value_text) ? parse_settings(value_text, "--set " + text) : Json(value_text);
    try {
      const Json::json_pointer pointer(text.substr(colon + 1, equal - colon - 1));
      require_entries(files_[file], pointer, text);
      files_[file][pointer] = value;
    } catch (const Json::exception& error) {
      throw ConfigError(fmt::format("--set {}: {}", text, error.what()));
    }
  }
}

std::string Scene::name() const {
  fs::path path = fs::path(folder_).lexically_normal();
  if (path.filename().empty()) path = path.parent_path();
  return path.filename().string();
}

std::string Scene::path(const std::string& relative) const {
  return (fs::path(folder_) / relative).string();
}

ConfigReader Scene::reader(const std::string& file, const KeyTable& table) const {
  require<ConfigError>(has(file), "{}: missing", path(file));
  return ConfigReader(files_.at(file), path(file), table);
}

std::string hash_text(const std::string& text) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const unsigned char byte : text) hash = (hash ^ byte) * 1099511628211ull;
  return fmt::format("{:016x}", hash);
}

std::string Scene::hash() const {
  return hash_text(files_.dump());
}

}  // namespace gabion
