// SPDX-License-Identifier: BSD-3-Clause
// Cost of the lidar's path from bytes to scans: one second of an A1's densest stream (Boost or Sensitivity, 8000
// samples a second in ultra capsules), in the chunks that a USB adapter delivers.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>
#include <memory>
#include <numbers>
#include <time.h>

#include "drivers/lidar/lidar_line.hpp"
#include "drivers/lidar/rplidar.hpp"
#include "drivers/lidar/rplidar_scan_stream.hpp"
#include "tools/sim/lidar/lidar_emulator.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kSecond = 1s;

std::vector<std::uint8_t> secondOfBytes() {
  sim::LidarEmulator lidar([](Timestamp, double bearing) { return 2.0 + std::cos(bearing); }, 5.5);
  std::vector<std::uint8_t> bytes;
  lidar.receive(rplidar::encodeExpressScan(3), Timestamp{}, bytes);
  bytes.clear();
  lidar.stream(Timestamp{kSecond}, bytes);
  return bytes;
}

void decodeSecond(benchmark::State& state) {
  const auto bytes = secondOfBytes();
  const auto chunk = static_cast<std::size_t>(state.range(0));
  std::int64_t scans = 0, nodes = 0;
  Timestamp now{};
  for (auto _ : state) {
    state.PauseTiming();
    auto stream = std::make_unique<rplidar::ScanStream>(
        rplidar::ScanStream::Format{.type = rplidar::AnswerType::kUltraCapsules, .sample_time = 127e-6});
    state.ResumeTiming();
    for (std::size_t at = 0; at < bytes.size(); at += chunk) {
      const std::size_t size = std::min(chunk, bytes.size() - at);
      now += kSecond * static_cast<std::int64_t>(size) / static_cast<std::int64_t>(bytes.size());
      nodes += stream->push({bytes.data() + at, size}, now, [&](const LaserScan&) { ++scans; });
    }
  }
  const auto seconds = static_cast<double>(state.iterations());
  state.counters["nodes_per_s"] = static_cast<double>(nodes) / seconds;
  state.counters["scans_per_s"] = static_cast<double>(scans) / seconds;
  // Time of one second of stream [s]: the share of a core.
  state.counters["core_share"] = benchmark::Counter(seconds, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(decodeSecond)
    ->Name("one second at 8000 samples/s, chunks of [bytes]")
    ->Arg(12)
    ->Arg(32)
    ->Arg(132)
    ->Unit(benchmark::kMillisecond);

Duration threadTime() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

/// The driver's thread, reading from a pseudo-terminal into which the unit's bytes come at least every millisecond.
void runDriver(benchmark::State& state) {
  test::LidarLine lidar(sim::a1Firmware129());
  std::int64_t scans = 0;
  test::Rplidar driver(lidar.path(), {}, monotonicNow, [&](const LaserScan&) { ++scans; });
  const std::atomic<bool> cancel{false};
  if (!driver.connect(cancel)) return state.SkipWithError(driver.status().problem().words().c_str());
  Duration used{0}, passed{0};
  std::int64_t reads = 0;
  for (auto _ : state) {
    const Duration before = threadTime();
    const Timestamp begin = monotonicNow();
    while (monotonicNow() - begin < 5s) reads += driver.poll(100ms);
    used += threadTime() - before;
    passed += monotonicNow() - begin;
  }
  state.counters["core_share_percent"] = 100.0 * toSeconds(used) / toSeconds(passed);
  state.counters["reads_per_s"] = static_cast<double>(reads) / toSeconds(passed);
  state.counters["scans_per_s"] = static_cast<double>(scans) / toSeconds(passed);
}
BENCHMARK(runDriver)->Name("driver's thread on a pseudo-terminal, 8000 samples/s")->Iterations(1)->UseRealTime();

}  // namespace
}  // namespace slam
