// SPDX-License-Identifier: BSD-3-Clause
// A solid of deal.II as the structure of a coupled run.
//
//     dealii_structure --coupler tcp://host:port [--name structure] [--settings structure.json]
#include <deal.II/base/multithread_info.h>

#include <csignal>
#include <cstdio>
#include <map>
#include <string>

#include "structure.hpp"

namespace {

using dealii_structure::Settings;

constexpr const char* usage =
    "usage: dealii_structure --coupler tcp://host:port [--name structure] "
    "[--settings structure.json]\n";

struct Arguments {
  std::string coupler, name = "structure", settings = "structure.json";
};

Arguments parse(int argc, char** argv) {
  Arguments out;
  const std::map<std::string, std::string*> known = {
      {"--coupler", &out.coupler}, {"--name", &out.name}, {"--settings", &out.settings}};
  for (int i = 1; i < argc; i += 2) {
    const auto found = known.find(argv[i]);
    if (found == known.end() || i + 1 == argc) throw gabion::ConfigError(usage);
    *found->second = argv[i + 1];
  }
  if (out.coupler.empty()) throw gabion::ConfigError(usage);
  return out;
}

template <int dim>
void run(const Arguments& arguments, const Settings& settings) {
  dealii_structure::Structure<dim> structure(settings);
  gabion::ParticipantSettings introduction;
  introduction.endpoint = arguments.coupler;
  introduction.name = arguments.name;
  introduction.program = "dealii_structure";
  introduction.dimension = dim;
  introduction.receives = gabion::force();
  introduction.sends = gabion::displacement();
  gabion::Connection connection(introduction);
  gabion::serve(structure, connection, [&] {
    const gabion::Json& described = connection.run_settings();
    if (described.value("check", false) || !described.contains("output")) return;
    structure.write_to(described.at("output").get<std::string>() + "/" + arguments.name);
  });
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGTERM, SIG_IGN);  // a signal ends the run, with a checkpoint, not this program
  std::signal(SIGINT, SIG_IGN);
  dealii::MultithreadInfo::set_thread_limit(1);  // the programs are the parallelism
  try {
    const Arguments arguments = parse(argc, argv);
    const Settings settings = dealii_structure::read_settings(arguments.settings);
    settings.dimension == 2 ? run<2>(arguments, settings) : run<3>(arguments, settings);
  } catch (const gabion::Error& problem) {
    std::fprintf(stderr, "[dealii] error: %s\n", problem.what());
    return problem.exit_code();
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "[dealii] error: %s\n", problem.what());
    return 1;
  }
  return 0;
}
