// SPDX-License-Identifier: BSD-3-Clause
#include "common/checkpoint/checkpoints.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/run/results_folder.hpp"
#include "common/settings/scene_identity.hpp"

namespace gabion {

namespace fs = std::filesystem;

namespace {

void require_apart(const std::string& results, const std::string& output) {
  const auto same = [&](const std::string& other) {
    std::error_code error;
    return fs::equivalent(results, other, error) && !error;
  };
  const bool replaced = fs::exists(output) && same(place_of_earlier_results(output));
  require<ConfigError>(!same(output) && !replaced,
                       "--restart {}: would be replaced by the new results in {}; give "
                       "another folder with --output",
                       results, output);
}

}  // namespace

KeyTable checkpoint_keys() {
  return {
      "checkpoint",
      "When the run is saved so that `--restart` can continue from there: after so many steps, so "
      "many minutes, or both; `{}` only at the end and at a signal.",
      {key::integer("steps", "Accepted steps from one checkpoint to the next.")
           .in(at_least(1))
           .or_none(),
       key::number("minutes", "min", "Wall time from one checkpoint to the next.")
           .in(positive())
           .or_computed(fmt::format("none; {} without the object `checkpoint`",
                                    CheckpointSettings{}.minutes))}};
}

CheckpointSettings read_checkpoint_settings(ConfigReader& in) {
  const bool given = in.has("checkpoint");
  ConfigReader object = in.object("checkpoint");
  CheckpointSettings settings;
  if (object.has("steps")) settings.steps = object.integer("steps");
  if (object.has("minutes") || !given) {
    settings.minutes = object.number_or("minutes", settings.minutes);
  } else {
    settings.minutes = 0;
  }
  object.finish();
  return settings;
}

Checkpoint Checkpoints::load(const std::string& results, const std::string& output,
                             const std::string& kind, const Scene& scene) {
  require_apart(results, output);
  Checkpoint checkpoint = read_checkpoint(find_checkpoint(results), kind);
  const State& run = checkpoint.state_of("run");
  require(run.facts.contains("scene"), "--restart {}: its checkpoint says nothing about the scene",
          results);
  require_same_scene(run.facts.at("scene"), scene_identity(scene), scene.folder(), results);
  return checkpoint;
}

RestartPoint restart_point(const std::string& results, const Checkpoint& checkpoint) {
  return {checkpoint_path(results, checkpoint.point), checkpoint.point, checkpoint.state_of("run")};
}

Checkpoints::Checkpoints(const CheckpointSettings& settings, const Scene& scene, Parts parts,
                         std::optional<RestartPoint> start)
    : settings_(settings),
      scene_(scene_identity(scene)),
      parts_(std::move(parts)),
      start_(std::move(start)),
      last_step_(start_ ? start_->point.step : 0) {}

bool Checkpoints::is_due(std::int64_t step) const {
  const bool by_steps = settings_.steps > 0 && step - last_step_ >= settings_.steps;
  const bool by_time = settings_.minutes > 0 && since_last_.seconds() >= 60 * settings_.minutes;
  return by_steps || by_time;
}

bool Checkpoints::due(std::int64_t step) {
  if (parts_.agree(is_due(step) ? 1 : 0) == 0) return false;
  last_step_ = step;
  since_last_ = Stopwatch();
  return true;
}

void Checkpoints::save(const RunPoint& point, const State& run) {
  Checkpoint checkpoint{point, {}};
  if (parts_.writes) begin_checkpoint(parts_.folder, point);
  const fs::path folder = fs::absolute(checkpoint_path(parts_.folder, point)).lexically_normal();
  for (const auto& [name, save_to] : parts_.solvers) {
    checkpoint.states[name] = save_to((folder / (name + ".h5")).string());
  }
  if (!parts_.writes) return;
  checkpoint.states["run"] = run;
  checkpoint.states["run"].facts["scene"] = scene_;
  write_checkpoint(parts_.folder, parts_.kind, checkpoint);
  log::info("checkpoint of step {}, {} s", point.step, point.time);
}

int Checkpoints::signal() {
  return parts_.agree(interrupt::requested());
}

}  // namespace gabion
