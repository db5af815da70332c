// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/gabion_participant.h"

#include <fmt/format.h>

#include "common/base/require.hpp"
#include "protocol/participant.hpp"

/// Holds settings until initialize() or the first interface needs the participant itself.
struct gabion_participant {
  gabion::ParticipantSettings settings;
  std::unique_ptr<gabion::Participant> participant;
  std::string error;
};

namespace {

thread_local std::string creation_error;

/// Run `action`; an exception becomes a status and a text.
template <class Action>
gabion_status guarded(std::string& error, Action action) noexcept {
  try {
    try {
      action();
      error.clear();
      return GABION_OK;
    } catch (const gabion::UsageError& problem) {
      error = problem.what();
      return GABION_ERROR_USAGE;
    } catch (const gabion::ProtocolError& problem) {
      error = problem.what();
      return GABION_ERROR_PROTOCOL;
    } catch (const std::exception& problem) {
      error = problem.what();
      return GABION_ERROR;
    } catch (...) {
      error = "an exception of unknown type";
      return GABION_ERROR;
    }
  } catch (...) {
    return GABION_ERROR;  // no memory for the text
  }
}

template <class Value>
void require_given(const Value* pointer, const char* what) {
  gabion::require<gabion::UsageError>(pointer != nullptr,
                                      fmt::format("{}: found NULL, allowed: a pointer", what));
}

/// `action(participant)` with the participant made when it is not there yet.
template <class Action>
gabion_status call(gabion_participant* p, Action action) noexcept {
  if (p == nullptr) return GABION_ERROR_USAGE;
  return guarded(p->error, [&] {
    if (!p->participant) p->participant = std::make_unique<gabion::Participant>(p->settings);
    action(*p->participant);
  });
}

gabion_status change(gabion_participant* p,
                     const std::function<void(gabion::ParticipantSettings&)>& action) noexcept {
  if (p == nullptr) return GABION_ERROR_USAGE;
  return guarded(p->error, [&] {
    gabion::require<gabion::UsageError>(
        !p->participant, "program, connect deadline and keys: allowed before everything else only");
    action(p->settings);
  });
}

gabion_status answer_of(gabion_participant* p, int* answer,
                        bool (*question)(gabion::Participant&)) noexcept {
  return call(p, [&](gabion::Participant& participant) {
    require_given(answer, "answer");
    *answer = question(participant) ? 1 : 0;
  });
}

std::size_t checked_count(gabion::Participant& participant, const char* interface_name,
                          std::size_t count) {
  require_given(interface_name, "interface name");
  const std::size_t expected = participant.num_values(interface_name);
  gabion::require<gabion::UsageError>(
      count == expected,
      fmt::format("found {} values for \"{}\", allowed: {}", count, interface_name, expected));
  return count;
}

}  // namespace

extern "C" {

gabion_participant* gabion_create(const char* name, const char* endpoint, int dimension,
                                  const char* receives) {
  std::unique_ptr<gabion_participant> made;
  const gabion_status status = guarded(creation_error, [&] {
    require_given(name, "name");
    require_given(endpoint, "endpoint");
    require_given(receives, "receives");
    const std::string quantity = receives;
    gabion::require<gabion::UsageError>(
        quantity == "force" || quantity == "displacement",
        fmt::format("receives: found \"{}\", allowed: force, displacement", quantity));
    made = std::make_unique<gabion_participant>();
    gabion::ParticipantSettings& settings = made->settings;
    settings.name = name;
    settings.endpoint = endpoint;
    settings.program = "foreign code";
    settings.dimension = dimension;
    settings.receives = quantity == "force" ? gabion::force() : gabion::displacement();
    settings.sends = quantity == "force" ? gabion::displacement() : gabion::force();
    settings.exit_when_coupler_is_lost = false;
    const gabion::Participant check(settings);
  });
  return status == GABION_OK ? made.release() : nullptr;
}

gabion_status gabion_set_program(gabion_participant* p, const char* program, const char* version) {
  return change(p, [&](gabion::ParticipantSettings& settings) {
    require_given(program, "program");
    require_given(version, "version");
    settings.program = program;
    settings.program_version = version;
  });
}

gabion_status gabion_set_connect_deadline(gabion_participant* p, double seconds) {
  return change(p, [&](gabion::ParticipantSettings& settings) {
    gabion::require<gabion::UsageError>(
        seconds > 0, fmt::format("connect deadline: found {} s, allowed: > 0", seconds));
    settings.connect_deadline = seconds;
  });
}

gabion_status gabion_set_keys(gabion_participant* p, const char* key_file,
                              const char* coupler_key_file) {
  return change(p, [&](gabion::ParticipantSettings& settings) {
    require_given(key_file, "key file");
    require_given(coupler_key_file, "coupler key file");
    settings.key_file = key_file;
    settings.coupler_key_file = coupler_key_file;
  });
}

gabion_status gabion_set_interface(gabion_participant* p, const char* name, size_t num_vertices,
                                   const double* coordinates, int vertices_per_facet,
                                   size_t num_facets, const int64_t* facets) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(name, "name");
    require_given(coordinates, "coordinates");
    if (num_facets > 0) require_given(facets, "facets");
    const auto dim = static_cast<std::size_t>(p->settings.dimension);
    const auto width = static_cast<std::size_t>(std::max(vertices_per_facet, 0));
    participant.set_interface(name, {coordinates, num_vertices * dim}, vertices_per_facet,
                              {facets, num_facets * width});
  });
}

gabion_status gabion_set_force_kind(gabion_participant* p, const char* interface_name,
                                    gabion_force_kind kind) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(interface_name, "interface name");
    gabion::require<gabion::UsageError>(
        kind == GABION_END_OF_STEP || kind == GABION_STEP_MEAN,
        fmt::format("force kind: found {}, allowed: GABION_END_OF_STEP, GABION_STEP_MEAN",
                    static_cast<int>(kind)));
    participant.set_force_kind(interface_name, kind == GABION_STEP_MEAN
                                                   ? gabion::ForceKind::step_mean
                                                   : gabion::ForceKind::end_of_step);
  });
}

gabion_status gabion_get_force_kind(gabion_participant* p, const char* interface_name,
                                    gabion_force_kind* kind) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(interface_name, "interface name");
    require_given(kind, "kind");
    *kind = participant.force_kind(interface_name) == gabion::ForceKind::step_mean
                ? GABION_STEP_MEAN
                : GABION_END_OF_STEP;
  });
}

gabion_status gabion_set_start_displacement(gabion_participant* p, const char* interface_name,
                                            const double* values, size_t count) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(values, "values");
    participant.set_start_displacement(interface_name,
                                       {values, checked_count(participant, interface_name, count)});
  });
}

gabion_status gabion_on_set_start(gabion_participant* p,
                                  int (*take)(const char*, const double*, size_t, void*),
                                  void* user) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(reinterpret_cast<const void*>(take), "take");
    participant.on_set_start([take, user](const gabion::InterfaceValues& displacements) {
      for (const auto& [name, values] : displacements) {
        const int code = take(name.c_str(), values.data(), values.size(), user);
        gabion::require(code == 0, "taking the start of \"{}\" failed, code {}", name, code);
      }
    });
  });
}

gabion_status gabion_set_facets_may_change(gabion_participant* p, const char* interface_name) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(interface_name, "interface name");
    participant.set_facets_may_change(interface_name);
  });
}

gabion_status gabion_write_facets(gabion_participant* p, const char* interface_name,
                                  size_t num_facets, const int64_t* facets) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(interface_name, "interface name");
    if (num_facets > 0) require_given(facets, "facets");
    const auto width = static_cast<std::size_t>(participant.vertices_per_facet(interface_name));
    participant.write_facets(interface_name, {facets, num_facets * width});
  });
}

gabion_status gabion_on_set_facets(gabion_participant* p,
                                   int (*take)(const char*, size_t, const int64_t*, void*),
                                   void* user) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(reinterpret_cast<const void*>(take), "take");
    participant.on_set_facets([take, user, &participant](const gabion::InterfaceFacets& changed) {
      for (const auto& [name, facets] : changed) {
        const auto width = static_cast<std::size_t>(participant.vertices_per_facet(name));
        const int code = take(name.c_str(), facets.size() / width, facets.data(), user);
        gabion::require(code == 0, "taking other facets of \"{}\" failed, code {}", name, code);
      }
    });
  });
}

gabion_status gabion_set_probes(gabion_participant* p, size_t count, const char* const* names,
                                const double* values) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(names, "names");
    require_given(values, "values");
    participant.set_probes({names, names + count}, {values, count});
  });
}

gabion_status gabion_write_probes(gabion_participant* p, size_t count, const double* values) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(values, "values");
    participant.write_probes({values, count});
  });
}

gabion_status gabion_set_output(gabion_participant* p, int (*write)(double, void*), void* user) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(reinterpret_cast<const void*>(write), "write");
    participant.set_output([write, user](double time) {
      const int code = write(time, user);
      gabion::require(code == 0, "writing the state at {} s failed, code {}", time, code);
    });
  });
}

gabion_status gabion_set_state(gabion_participant* p, int (*save)(const void**, size_t*, void*),
                               int (*load)(const void*, size_t, void*), void* user) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(reinterpret_cast<const void*>(save), "save");
    require_given(reinterpret_cast<const void*>(load), "load");
    participant.set_state(
        [save, user] {
          const void* data = nullptr;
          std::size_t size = 0;
          const int code = save(&data, &size, user);
          gabion::require(code == 0, "saving the state failed, code {}", code);
          if (size > 0) require_given(data, "data of the state");
          const auto* bytes = static_cast<const std::byte*>(data);
          return std::vector<std::byte>(bytes, bytes + size);
        },
        [load, user](std::span<const std::byte> bytes) {
          const int code = load(bytes.data(), bytes.size(), user);
          gabion::require(code == 0, "loading the state failed, code {}", code);
        });
  });
}

gabion_status gabion_initialize(gabion_participant* p) {
  return call(p, [](gabion::Participant& participant) { participant.initialize(); });
}

gabion_status gabion_is_coupling_ongoing(gabion_participant* p, int* answer) {
  return answer_of(p, answer, [](gabion::Participant& it) { return it.is_coupling_ongoing(); });
}

gabion_status gabion_is_time_window_complete(gabion_participant* p, int* answer) {
  return answer_of(p, answer, [](gabion::Participant& it) { return it.is_time_window_complete(); });
}

gabion_status gabion_get_max_time_step_size(gabion_participant* p, double* seconds) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(seconds, "seconds");
    *seconds = participant.get_max_time_step_size();
  });
}

gabion_status gabion_get_time(gabion_participant* p, double* seconds) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(seconds, "seconds");
    *seconds = participant.get_time();
  });
}

gabion_status gabion_requires_writing_checkpoint(gabion_participant* p, int* answer) {
  return answer_of(p, answer,
                   [](gabion::Participant& it) { return it.requires_writing_checkpoint(); });
}

gabion_status gabion_requires_reading_checkpoint(gabion_participant* p, int* answer) {
  return answer_of(p, answer,
                   [](gabion::Participant& it) { return it.requires_reading_checkpoint(); });
}

gabion_status gabion_read_data(gabion_participant* p, const char* interface_name, double* values,
                               size_t count) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(values, "values");
    checked_count(participant, interface_name, count);
    const std::vector<double> received = participant.read_data(interface_name);
    std::copy(received.begin(), received.end(), values);
  });
}

gabion_status gabion_write_data(gabion_participant* p, const char* interface_name,
                                const double* values, size_t count) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(values, "values");
    participant.write_data(interface_name,
                           {values, checked_count(participant, interface_name, count)});
  });
}

gabion_status gabion_advance(gabion_participant* p, double dt) {
  return call(p, [&](gabion::Participant& participant) { participant.advance(dt); });
}

gabion_status gabion_fail_step(gabion_participant* p, const char* reason) {
  return call(p, [&](gabion::Participant& participant) {
    require_given(reason, "reason");
    participant.fail_step(reason);
  });
}

gabion_status gabion_finalize(gabion_participant* p) {
  return call(p, [](gabion::Participant& participant) { participant.finalize(); });
}

const char* gabion_last_error(const gabion_participant* p) {
  return p == nullptr ? creation_error.c_str() : p->error.c_str();
}

void gabion_destroy(gabion_participant* p) {
  delete p;
}

}  // extern "C"
