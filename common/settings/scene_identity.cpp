// SPDX-License-Identifier: BSD-3-Clause
#include "common/settings/scene_identity.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "common/base/read_file.hpp"
#include "common/base/require.hpp"

namespace gabion {

namespace {

constexpr const char* may_differ[] = {"/time/end", "/output", "/checkpoint", "/protocol",
                                      "/$schema"};

/// "name hash" of each file that the settings name, by JSON pointer.
Json file_hashes(const Scene& scene, const Json& settings) {
  Json hashes = Json::object();
  const Json values = settings.flatten();
  for (const auto& item : values.items()) {
    if (!item.value().is_string()) continue;
    const auto name = item.value().get<std::string>();
    if (name.empty() || !std::filesystem::is_regular_file(scene.path(name))) continue;
    const std::string content = read_file(scene.path(name), "file of the scene");
    hashes[item.key()] = fmt::format("{} {}", name, hash_text(content));
  }
  return hashes;
}

struct Difference {
  std::string pointer;
  std::string saved, now;
};

std::string shown(const Json* value) {
  if (value == nullptr) return "nothing";
  const std::string text = value->dump();
  constexpr std::size_t longest = 120;
  return text.size() <= longest ? text : text.substr(0, longest) + "…";
}

const Json* part_of(const Json& whole, const std::string& key) {
  return whole.contains(key) ? &whole.at(key) : nullptr;
}

std::optional<Difference> first_difference(const Json* saved, const Json* now,
                                           const std::string& pointer) {
  for (const char* free : may_differ) {
    if (pointer == free) return std::nullopt;
  }
  if (saved != nullptr && now != nullptr && *saved == *now) return std::nullopt;
  const bool objects = saved != nullptr && now != nullptr && saved->is_object() && now->is_object();
  const bool lists = saved != nullptr && now != nullptr && saved->is_array() && now->is_array() &&
                     saved->size() == now->size();
  if (objects) {
    Json keys = *saved;
    keys.update(*now);
    for (const auto& item : keys.items()) {
      const auto found =
          first_difference(part_of(*saved, item.key()), part_of(*now, item.key()),
                           pointer + (Json::json_pointer() / item.key()).to_string());
      if (found) return found;
    }
    return std::nullopt;
  }
  if (lists) {
    for (std::size_t k = 0; k < saved->size(); ++k) {
      const auto found =
          first_difference(&saved->at(k), &now->at(k), pointer + "/" + std::to_string(k));
      if (found) return found;
    }
    return std::nullopt;
  }
  return Difference{pointer, shown(saved), shown(now)};
}

}  // namespace

Json scene_identity(const Scene& scene) {
  Json files = Json::object();
  for (const auto& item : scene.settings().items()) {
    const Json hashes = file_hashes(scene, item.value());
    files[item.key()] = hashes.empty() ? Json::object() : hashes.unflatten();
  }
  return {{"settings", scene.settings()}, {"files", files}};
}

namespace {

void require_same(const Json& saved, const Json& now, const std::string& folder,
                  const std::string& source, const char* hint) {
  Json names = saved;
  names.update(now);
  for (const auto& item : names.items()) {
    const std::string& file = item.key();
    const auto difference = first_difference(part_of(saved, file), part_of(now, file), "");
    if (!difference) continue;
    throw ConfigError(
        fmt::format("{}/{}: at {}: found {}, allowed: {} as in {}, which is continued{}", folder,
                    file, difference->pointer, difference->now, difference->saved, source, hint));
  }
}

}  // namespace

void require_same_scene(const Json& saved, const Json& now, const std::string& folder,
                        const std::string& source) {
  for (const char* part : {"settings", "files"}) {
    require(saved.is_object() && saved.contains(part) && saved.at(part).is_object(),
            "{}: its checkpoint does not tell the {} of the scene", source, part);
  }
  require_same(saved.at("settings"), now.at("settings"), folder, source,
               "; only /time/end, /output, /checkpoint and /protocol may change");
  require_same(saved.at("files"), now.at("files"), folder, source, "; the contents of that file");
}

}  // namespace gabion
