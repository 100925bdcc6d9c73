// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>
#include <vector>

#include "graph/align_map.hpp"
#include "graph/optimiser.hpp"
#include "support/simulated/campus.hpp"

namespace slam {
namespace {

/// One closure after another is found on a campus of 10,000 keyframes whose earlier closures are worked in; the graph
/// is optimised and laid where it moves least.
void incrementalOptimisation(benchmark::State& state) {
  test::Campus campus = test::makeCampus(static_cast<int>(state.range(0)), 1);
  const std::size_t known = campus.closures.size() * 9 / 10;
  for (std::size_t i = 0; i < known; ++i) campus.graph.addEdge(campus.closures[i]);
  Optimiser optimiser;
  optimiser.optimise(campus.graph);
  std::size_t next = known;
  int iterations = 0;
  for (auto _ : state) {
    if (next < campus.closures.size()) campus.graph.addEdge(campus.closures[next++]);
    const std::vector<Pose2> before(campus.graph.poses().begin(), campus.graph.poses().end());
    iterations += optimiser.optimise(campus.graph).iterations;
    benchmark::DoNotOptimize(alignToPreviousMap(before, campus.graph.poses()));
  }
  state.counters["closures"] = static_cast<double>(campus.closures.size());
  state.counters["iterations"] = static_cast<double>(iterations) / static_cast<double>(state.iterations());
}
BENCHMARK(incrementalOptimisation)
    ->Name("one more closure")
    ->Arg(1000)
    ->Arg(10000)
    ->Iterations(20)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace slam
