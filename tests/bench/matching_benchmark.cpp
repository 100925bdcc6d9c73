// SPDX-License-Identifier: BSD-3-Clause
// Cost of the steps of one scan of 360 beams against a reference of 30 keyframes, and of the filter.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <chrono>
#include <memory>

#include "estimation/ekf_timeline.hpp"
#include "matching/icp.hpp"
#include "matching/plicp.hpp"
#include "matching/scanning.hpp"

namespace slam {
namespace {

constexpr int kKeyframes = 30;

struct Fixture {
  test::Room room{.length = 9.0, .width = 7.0, .range_sigma = 0.012};
  std::mt19937 random{1};
  Reference reference;
  std::vector<ScanPoints> scans;
  std::vector<Pose2> guesses;

  Fixture() {
    std::uniform_real_distribution<double> place(-2.0, 2.0), turn(-3.0, 3.0), off(-0.03, 0.03);
    for (int i = 0; i < kKeyframes; ++i) {
      const Pose2 pose{place(random), place(random), turn(random)};
      reference.add(pose, test::scanPoints(room, pose, random));
    }
    for (int i = 0; i < 64; ++i) {
      const Pose2 pose{place(random), place(random), turn(random)};
      scans.push_back(test::scanPoints(room, pose, random));
      guesses.push_back(pose * Pose2{off(random), off(random), off(random)});
    }
  }
};

template <MatchResult (*kMatch)(const Reference&, std::span<const ScanPoint>, const Pose2&,
                                const MatchConfig&) noexcept>
void match(benchmark::State& state) {
  const auto fixture = std::make_unique<Fixture>();
  std::vector<double> times;
  std::size_t i = 0;
  for (auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(kMatch(fixture->reference, fixture->scans[i % 64], fixture->guesses[i % 64], {}));
    times.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
    ++i;
  }
  std::sort(times.begin(), times.end());
  state.counters["p50_us"] = times[times.size() / 2];
  state.counters["p99_us"] = times[times.size() * 99 / 100];
}
BENCHMARK(match<matchPointToLine>)->Name("PL-ICP match, 360 beams, covariance included")->Unit(benchmark::kMicrosecond);
BENCHMARK(match<matchPointToPoint>)->Name("ICP match, 360 beams")->Unit(benchmark::kMicrosecond);

void normals(benchmark::State& state) {
  const auto fixture = std::make_unique<Fixture>();
  ScanPoints points = fixture->scans[0];
  for (auto _ : state) estimateNormals(points, Eigen::Vector2d::Zero());
}
BENCHMARK(normals)->Name("normals of 360 points")->Unit(benchmark::kMicrosecond);

void addKeyframe(benchmark::State& state) {
  const auto fixture = std::make_unique<Fixture>();
  std::size_t i = 0;
  for (auto _ : state) fixture->reference.add(fixture->guesses[i % 64], fixture->scans[i % 64]), ++i;
}
BENCHMARK(addKeyframe)->Name("keyframe into the reference, 360 points")->Unit(benchmark::kMicrosecond);

void latePose(benchmark::State& state) {
  using namespace std::chrono_literals;
  EkfTimeline timeline({}, {});
  Timestamp now{1s};
  for (auto _ : state) {
    state.PauseTiming();
    for (int i = 0; i < 36; ++i) {  // 180 ms at 200 Hz
      now += 5ms;
      timeline.add(WheelSample{now, {0.2 * toSeconds(now.time_since_epoch()), 0, 0}});
      timeline.add(ImuSample{now, {0, 0, 0.001}, {0, 0, 9.81}});
    }
    state.ResumeTiming();
    timeline.add(PoseMeasurement{now - 180ms, timeline.at(now - 180ms).pose(), 1e-4 * Eigen::Matrix3d::Identity()});
  }
}
BENCHMARK(latePose)->Name("matched scan fused 180 ms late, wheels and IMU at 200 Hz")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace slam
