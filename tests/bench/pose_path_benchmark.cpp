// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <atomic>
#include <benchmark/benchmark.h>
#include <chrono>
#include <memory>
#include <pthread.h>
#include <thread>
#include <vector>

#include "frontend/front_end.hpp"
#include "graph/optimiser.hpp"
#include "support/simulated/campus.hpp"
#include "support/simulated/room.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr int kScans = 4000;

/// Optimises a graph of 10,000 keyframes again and again on a thread of its own.
class GraphAtWork {
 public:
  GraphAtWork()
      : thread_([this] {
          test::Campus campus = test::makeCampus(10000, 1);
          for (const Edge& edge : campus.closures) campus.graph.addEdge(edge);
          Optimiser optimiser;
          while (!stop_) {
            optimiser.optimise(campus.graph);
            started_ = true;
            for (int id = 1; id < campus.graph.size(); ++id) {  // as far off as a new closure makes it
              const Pose2& pose = campus.graph.pose(id);
              campus.graph.setPose(id, {pose.x + 0.01, pose.y, pose.theta});
            }
          }
        }) {
    while (!started_) std::this_thread::yield();
  }
  ~GraphAtWork() {
    stop_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> stop_{false}, started_{false};
  std::thread thread_;
};

/// As the estimator thread of the daemon runs, where that is permitted.
bool scheduleAsThePosePath(bool realtime) {
  sched_param parameters{};
  parameters.sched_priority = realtime ? 70 : 0;
  return pthread_setschedparam(pthread_self(), realtime ? SCHED_FIFO : SCHED_OTHER, &parameters) == 0;
}

/// Work on one scan, 360 beams at 10 Hz in a room, with the back end's thread idle (0) or optimising (1).
void scanOfThePosePath(benchmark::State& state) {
  const auto graph = state.range(0) != 0 ? std::make_unique<GraphAtWork>() : nullptr;
  const test::Room room{.length = 8.0, .width = 5.0, .range_sigma = 0.01};
  std::mt19937 random(1);
  std::vector<LaserScan> scans;
  Pose2 pose;
  for (int i = 0; i < 200; ++i) {
    scans.push_back(room.scan(pose, random));
    pose = pose * Pose2{0.03 * (i < 100 ? 1.0 : -1.0), 0.0, 0.0};
  }
  std::vector<double> times;
  state.counters["realtime"] = scheduleAsThePosePath(true) ? 1.0 : 0.0;
  for (auto _ : state) {
    auto front_end = std::make_unique<FrontEnd>(FrontEndConfig{});
    Timestamp now{100s};
    for (int i = 0; i < kScans; ++i) {
      LaserScan& scan = scans[static_cast<std::size_t>(i) % scans.size()];
      scan.stamp = now += 100ms;
      const auto begin = std::chrono::steady_clock::now();
      benchmark::DoNotOptimize(front_end->add(scan));
      times.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
    }
  }
  scheduleAsThePosePath(false);
  std::sort(times.begin(), times.end());
  state.counters["p50_us"] = times[times.size() / 2];
  state.counters["p99_us"] = times[times.size() * 99 / 100];
}
BENCHMARK(scanOfThePosePath)
    ->Name("scan, graph optimising")
    ->Arg(0)
    ->Arg(1)
    ->Iterations(3)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace slam
