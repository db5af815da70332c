// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "common/mechanics/materials/material.hpp"

namespace gabion {
namespace {

constexpr int num_points = 1024;
constexpr double degree = 3.14159265358979323846 / 180;

/// Displacement gradients of size 1e-3 about a compression that keeps the points off the apex.
template <int dim>
std::vector<Matrix<dim>> steps(double compression) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-1e-3, 1e-3);
  std::vector<Matrix<dim>> H(num_points);
  for (auto& step : H) {
    step = Matrix<dim>::NullaryExpr([&] { return uniform(generator); });
    step.diagonal().array() -= compression;
  }
  return H;
}

template <int dim, class Law>
void run(benchmark::State& bench, const Law& law, double compression, bool with_tangent) {
  const auto H = steps<dim>(compression);
  const MaterialState<dim> state_n;
  StressUpdate<dim> out;
  Tangent<dim> A;
  int plastic = 0;
  for (auto _ : bench) {
    plastic = 0;
    for (const auto& step : H) {
      law.update(step, state_n, out, with_tangent ? &A : nullptr);
      plastic += out.plastic();
      benchmark::DoNotOptimize(out);
      benchmark::DoNotOptimize(A);
    }
  }
  bench.counters["ns_per_call"] =
      benchmark::Counter(num_points * 1e-9, benchmark::Counter::kIsIterationInvariantRate |
                                                benchmark::Counter::kInvert);
  bench.counters["plastic_share"] = double(plastic) / num_points;
}

constexpr double lambda = 5e5, mu = 3e5;

template <int dim>
void mohr_coulomb_plastic(benchmark::State& bench) {
  run<dim>(bench, MohrCoulomb<dim>{lambda, mu, 30 * degree, 0, 0}, 2e-4, bench.range(0));
}
template <int dim>
void mohr_coulomb_elastic(benchmark::State& bench) {
  run<dim>(bench, MohrCoulomb<dim>{lambda, mu, 30 * degree, 0, 1e5}, 2e-4, bench.range(0));
}
template <int dim>
void hencky(benchmark::State& bench) {
  run<dim>(bench, HenckyElastic<dim>{lambda, mu}, 2e-4, bench.range(0));
}
template <int dim>
void neo_hookean(benchmark::State& bench) {
  run<dim>(bench, NeoHookean<dim>{lambda, mu}, 2e-4, bench.range(0));
}
template <int dim>
void linear(benchmark::State& bench) {
  run<dim>(bench, LinearElastic<dim>{lambda, mu}, 2e-4, bench.range(0));
}

// Argument 0: stress only; 1: stress and tangent.
BENCHMARK(mohr_coulomb_plastic<2>)->Arg(0)->Arg(1);
BENCHMARK(mohr_coulomb_elastic<2>)->Arg(0)->Arg(1);
BENCHMARK(hencky<2>)->Arg(0)->Arg(1);
BENCHMARK(neo_hookean<2>)->Arg(0)->Arg(1);
BENCHMARK(linear<2>)->Arg(0)->Arg(1);
BENCHMARK(mohr_coulomb_plastic<3>)->Arg(0)->Arg(1);
BENCHMARK(mohr_coulomb_elastic<3>)->Arg(0)->Arg(1);
BENCHMARK(hencky<3>)->Arg(0)->Arg(1);
BENCHMARK(neo_hookean<3>)->Arg(0)->Arg(1);
BENCHMARK(linear<3>)->Arg(0)->Arg(1);

}  // namespace
}  // namespace gabion

BENCHMARK_MAIN();
