// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_stream.hpp"

#include <cstring>
#include <gtest/gtest.h>

namespace slam::sim::depth_stream_test {
namespace {

using namespace std::chrono_literals;
constexpr Timestamp kStart{1000s};

World wallAhead() {
  World world;
  world.addWall({3.05, -9.0}, {3.05, 9.0});
  return world;
}

struct Arrival {
  Timestamp stamp;
  DepthFrameHeader header;
};

/// Steps the stream each millisecond from `from` to `to`.
std::vector<Arrival> run(DepthStream& stream, Timestamp from, Timestamp to) {
  std::vector<Arrival> arrivals;
  for (Timestamp now = from; now < to; now += 1ms) {
    stream.capture(now);
    const auto bytes = stream.take(now);
    if (bytes.empty()) continue;
    arrivals.push_back({now, {}});
    std::memcpy(&arrivals.back().header, bytes.data(), sizeof(DepthFrameHeader));
    EXPECT_EQ(bytes.size(), sizeof(DepthFrameHeader) + arrivals.back().header.size);
  }
  return arrivals;
}

std::optional<DepthViewpoint> standing(Timestamp) { return DepthViewpoint{}; }

class DepthStreamMode : public testing::TestWithParam<DepthMode> {};

TEST_P(DepthStreamMode, KeepsItsRateAndItsDelay) {
  const DepthMode mode = GetParam();
  DepthStream stream(wallAhead(), mode, 3, kStart, standing);
  const auto arrivals = run(stream, kStart, kStart + 2s);
  ASSERT_NEAR(static_cast<double>(arrivals.size()), 2.0 * mode.rate, 3.0);
  Duration least = 1s, most{};
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    const auto& [stamp, header] = arrivals[i];
    ASSERT_EQ(header.frame, i + 1);
    EXPECT_EQ(header.time, 1000000U * (i + 1) / static_cast<unsigned>(mode.rate));
    EXPECT_EQ(header.magic, DepthFrameHeader::kMagic);
    EXPECT_EQ(static_cast<int>(header.width), mode.width);
    EXPECT_FLOAT_EQ(header.horizontal_fov, 1.0226F);
    const Duration delay = stamp - stream.captureTime(header.frame);
    least = std::min(least, delay);
    most = std::max(most, delay);
  }
  EXPECT_GE(least, DepthStream::kMinDelay);
  EXPECT_LE(most, DepthStream::kMaxDelay + 1ms);
  EXPECT_GT(most - least, 5ms);  // jitter
}

INSTANTIATE_TEST_SUITE_P(Modes, DepthStreamMode, testing::ValuesIn(kDepthModes));

TEST(DepthStream, ItsClockDriftsByTheSeed) {
  double least = 1.0, most = -1.0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const DepthStream stream(wallAhead(), {320, 240, 30}, seed, kStart, standing);
    const double drift = 1000.0 / toSeconds(stream.captureTime(30000) - kStart) - 1.0;
    least = std::min(least, drift);
    most = std::max(most, drift);
  }
  EXPECT_GE(least, -50e-6);
  EXPECT_LT(least, -30e-6);
  EXPECT_GT(most, 30e-6);
  EXPECT_LE(most, 50e-6);
}

TEST(DepthStream, LooksFromWhereTheRobotWasAtTheCapture) {
  std::vector<Timestamp> asked;
  DepthStream stream(wallAhead(), {320, 240, 30}, 3, kStart, [&](Timestamp stamp) {
    asked.push_back(stamp);
    return std::optional(DepthViewpoint{{toSeconds(stamp - kStart), 0.0, 0.0}, 0.0});  // 1 m/s to the wall
  });
  for (Timestamp now = kStart; now < kStart + 1s; now += 1ms) {
    stream.capture(now);
    const auto bytes = stream.take(now);
    if (bytes.empty()) continue;
    DepthFrameHeader header;
    std::memcpy(&header, bytes.data(), sizeof header);
    std::uint16_t depth = 0;  // ahead of the camera, where there is data
    for (std::size_t i = 100 * 320 + 160; depth == 0; ++i) {
      std::memcpy(&depth, bytes.data() + sizeof header + 2 * i, sizeof depth);
    }
    EXPECT_NEAR(depth, 2900.0 - 1e-3 * static_cast<double>(header.time), 60.0);
    EXPECT_EQ(asked[header.frame - 1], stream.captureTime(header.frame));
  }
}

TEST(DepthStream, WaitsForTheSimulationAndLosesWhatIsMissed) {
  Timestamp simulated = kStart;
  DepthStream stream(wallAhead(), {320, 240, 30}, 3, kStart, [&](Timestamp stamp) -> std::optional<DepthViewpoint> {
    if (stamp > simulated) return std::nullopt;
    return DepthViewpoint{};
  });
  EXPECT_TRUE(run(stream, kStart, kStart + 60ms).empty());
  simulated = kStart + 10s;
  auto late = run(stream, kStart + 60ms, kStart + 100ms);
  ASSERT_FALSE(late.empty());
  EXPECT_EQ(late.front().header.frame, 1U);
  late = run(stream, kStart + 600ms, kStart + 700ms);
  ASSERT_GE(late.size(), 2U);
  EXPECT_GE(late.back().header.frame, 18U);
  EXPECT_LE(late.size(), 7U);  // not made up for
  EXPECT_GT(stream.next(), kStart + 699ms);
}

}  // namespace
}  // namespace slam::sim::depth_stream_test
