// SPDX-License-Identifier: BSD-3-Clause
// Tables of coupling methods as CSV on standard output, for scripts/bench coupling:
//
//     coupling_benchmark affine
//     coupling_benchmark tube
//     coupling_benchmark grid [STEPS]
//     coupling_benchmark overhead METHOD NODES [COLUMNS]
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "common/base/log.hpp"
#include "coupler/convergence/convergence.hpp"
#include "tests/benchmarks/trivial_participants.hpp"
#include "tests/support/tube_run.hpp"
#include "tests/unit/coupler/affine_map.hpp"

namespace {

using namespace gabion;
using test::TubeRun;

/// Plain iteration x <- x_tilde of the affine map, judged as in a run.
std::string gauss_seidel(double m) {
  ConvergenceSettings limits;
  limits.displacement.relative = 1e-8;
  Convergence convergence(limits);
  convergence.begin_step();
  test::AffineMap map(m);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(map.size());
  for (int k = 1;; ++k) {
    const Eigen::VectorXd x_tilde = map(x);
    const Verdict verdict = convergence.check(x, x_tilde, x).verdict;
    if (verdict == Verdict::converged) return fmt::format("{}", k);
    if (verdict != Verdict::going_on) return name(verdict);
    x = x_tilde;
  }
}

void affine() {
  fmt::print("m,gauss_seidel,aitken,iqn_ils,mvqn\n");
  for (const double m : {0.5, 2.0, 10.0, 50.0}) {
    fmt::print("{},{}", m, gauss_seidel(m));
    for (const std::string method : {"aitken", "iqn_ils", "mvqn"}) {
      AccelerationSettings s;
      s.method = method;
      s.relaxation = 0.1;
      s.history = method == "mvqn" ? 100 : 10;
      s.max_columns = 1000;
      const auto acceleration = make_acceleration(s, {50});
      fmt::print(",{}", fmt::join(test::iteration_counts(test::AffineMap(m), *acceleration), " "));
    }
    fmt::print("\n");
  }
}

void print_tube(const std::string& label, const TubeRun& run) {
  const test::TubeResult result = test::run_tube(run);
  if (!result.failure.empty()) return fmt::print("{},failed,,,,,\n", label);
  fmt::print("{},{:.2f},{},{},{},{:.4f},{:.8f}\n", label, result.mean_iterations, result.first_step,
             result.max, result.at_limit, result.pressure, result.area);
}

void tube() {
  fmt::print("method,mean,first,max,at_limit,pressure,area\n");
  TubeRun run;
  run.max_iterations = 300;
  run.acceleration.max_columns = 1000;
  run.acceleration.method = "aitken";
  run.accept_at_limit = true;
  for (const double omega : {0.1, 0.01}) {
    run.acceleration.relaxation = omega;
    print_tube(fmt::format("aitken {}", omega), run);
  }
  run.accept_at_limit = false;
  run.acceleration.method = "iqn_ils";
  run.acceleration.relaxation = 0.01;
  run.acceleration.filter.limit = 1e-3;
  for (const int history : {1, 2, 4, 8, 16}) {
    run.acceleration.history = history;
    print_tube(fmt::format("iqn_ils history {}", history), run);
  }
  run.acceleration.history = 8;
  for (const int order : {1, 2}) {
    run.predictor = order;
    print_tube(fmt::format("iqn_ils history 8 predictor {}", order), run);
  }
  run.acceleration.method = "mvqn";
  run.acceleration.filter = {};
  for (const auto& [history, order] : {std::pair{8, 0}, {100, 0}, {100, 2}}) {
    run.acceleration.history = history;
    run.predictor = order;
    print_tube(fmt::format("mvqn history {} predictor {}", history, order), run);
  }
}

/// @param steps  of each run; 0: one second
void grid(int steps) {
  struct Setting {
    std::string label;
    TubeRun run;
    test::TubeResult result;
  };
  std::vector<Setting> settings;
  for (const auto& [label, filter] : test::grid_filters()) {
    for (const double relaxation : {0.01, 0.1, 0.5}) {
      for (const int columns : {20, 50, 100}) {
        for (const double dt : {0.005, 0.01, 0.02}) {
          TubeRun run = test::grid_run(filter, relaxation, columns, dt);
          if (steps > 0) run.steps = steps;
          settings.push_back({fmt::format("{},{},{},{}", label, relaxation, columns, dt), run, {}});
        }
      }
    }
  }
  {
    std::atomic<std::size_t> next = 0;
    std::vector<std::jthread> threads;
    for (unsigned k = 0; k < std::max(1U, std::thread::hardware_concurrency()); ++k) {
      threads.emplace_back([&] {
        for (std::size_t i = next++; i < settings.size(); i = next++) {
          settings[i].result = test::run_tube(settings[i].run);
        }
      });
    }
  }
  fmt::print("filter,relaxation,columns,dt,mean,max\n");
  for (const auto& [label, run, result] : settings) {
    const bool ok = result.failure.empty();
    fmt::print("{},{},{}\n", label, ok ? fmt::format("{:.2f}", result.mean_iterations) : "failed",
               result.max);
  }
}

void overhead(const std::vector<std::string>& words) {
  test::Overhead what;
  what.method = words.at(1);
  what.num_nodes = std::stoll(words.at(2));
  if (words.size() > 3) what.columns = std::stoi(words[3]);
  what.steps = 2 * (what.columns / (what.iterations - 1) + 20);
  const test::OverheadResult result = test::measure_overhead(what);
  fmt::print("{},{},{:.1f},{:.1f},{:.1f},{:.1f},{:.0f}\n", what.method, what.num_nodes, result.all,
             result.messages, result.acceleration, result.rest, result.resident_mb);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  log::start("bench", log::Level::error, true);
  try {
    const std::string table = words.empty() ? "" : words[0];
    if (table == "affine") {
      affine();
    } else if (table == "tube") {
      tube();
    } else if (table == "grid") {
      grid(words.size() > 1 ? std::stoi(words[1]) : 0);
    } else if (table == "overhead" && words.size() > 2) {
      overhead(words);
    } else {
      fmt::print(stderr,
                 "usage: coupling_benchmark affine | tube | grid [STEPS] | overhead METHOD NODES "
                 "[COLUMNS]\n");
      return 2;
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "coupling_benchmark: {}\n", error.what());
    return 1;
  }
  return 0;
}
