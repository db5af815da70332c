// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/settings/config_reader.hpp"

namespace gabion {

/// A scene folder: coupler.json, mpm.json and fem.json as far as they exist, with the values that
/// `--set FILE:/json/pointer=VALUE` puts in their place.
class Scene {
 public:
  /// @param overrides  texts "FILE:/json/pointer=VALUE"; VALUE is JSON, or a text when it is not
  /// @throws ConfigError  folder or file missing, broken JSON (with line), override of a file that
  ///                      the scene does not have
  Scene(const std::string& folder, const std::vector<std::string>& overrides);

  const std::string& folder() const { return folder_; }
  std::string name() const;  ///< last part of the folder's path
  bool has(const std::string& file) const { return files_.contains(file); }
  /// Reader of one file; throws ConfigError when the scene lacks it.
  ConfigReader reader(const std::string& file, const KeyTable& table) const;
  /// Path of a file that a config names, relative to the scene's folder.
  std::string path(const std::string& relative) const;

  /// File name -> its settings, overrides included.
  const Json& settings() const { return files_; }

  /// Hash of all the scene's settings, overrides included: equal on both sides of a handshake when
  /// both read the same scene.
  std::string hash() const;

 private:
  std::string folder_;
  Json files_ = Json::object();
};

/// 16 digits by FNV-1a, 64 bit: tells texts apart, is no protection against a forger.
std::string hash_text(const std::string& text);

}  // namespace gabion
