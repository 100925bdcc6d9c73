// SPDX-License-Identifier: BSD-3-Clause
#include "tools/faults/stream_fault.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>

namespace slam::stream_fault_test {
namespace {

/// A second of each stream: scans at 10 Hz of one beam each, wheels at 50 Hz, IMU at 100 Hz.
std::vector<LogSample> streams(double seconds) {
  std::vector<LogSample> samples;
  const Timestamp begin{std::chrono::seconds(100)};
  for (int i = 0; i < static_cast<int>(100 * seconds); ++i) {
    const Timestamp stamp = begin + i * std::chrono::milliseconds(10);
    samples.emplace_back(ImuSample{stamp, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
    if (i % 2 == 0) samples.emplace_back(WheelSample{stamp, {}});
    if (i % 10 == 0) {
      auto scan = std::make_unique<LaserScan>();
      scan->stamp = stamp;
      scan->size = 1;
      scan->storage[0].range = static_cast<float>(1 + i);
      samples.emplace_back(std::move(scan));
    }
  }
  return samples;
}

std::vector<const LaserScan*> scansOf(const std::vector<LogSample>& samples) {
  std::vector<const LaserScan*> scans;
  for (const LogSample& sample : samples) {
    if (const auto* scan = std::get_if<std::unique_ptr<LaserScan>>(&sample)) scans.push_back(scan->get());
  }
  return scans;
}

/// Samples of each kind whose stamp is not what it was.
std::array<int, 3> moved(const char* fault, double seconds) {
  std::vector<LogSample> samples = streams(seconds);
  const std::vector<LogSample> before = streams(seconds);
  streamFault(fault).add(samples);
  std::array<int, 3> count{};
  for (std::size_t i = 0; i < before.size(); ++i) count[before[i].index()] += stampOf(samples[i]) != stampOf(before[i]);
  return count;
}

TEST(StreamFault, StampsSufferAsTheFaultIsSet) {
  EXPECT_EQ(moved("-", 4.0), (std::array{0, 0, 0}));
  EXPECT_EQ(moved("far-ahead", 4.0), (std::array{0, 1, 0}));
  EXPECT_EQ(moved("scans-ahead", 4.0), (std::array{2, 0, 0}));
  EXPECT_EQ(moved("wheels-ahead", 4.0), (std::array{0, 2, 0}));
  EXPECT_EQ(moved("set-back", 4.0), (std::array{20, 100, 200}));
  EXPECT_EQ(moved("imu-set-back", 4.0), (std::array{0, 0, 200}));
  EXPECT_EQ(moved("out-of-order", 4.0), (std::array{8, 0, 0}));
  EXPECT_EQ(moved("wheel-jitter", 4.0), (std::array{0, 49, 0}));
}

TEST(StreamFault, CopiesComeBehindTheirScans) {
  std::vector<LogSample> samples = streams(1.0);
  streamFault("copies").add(samples);
  const auto scans = scansOf(samples);
  ASSERT_EQ(scans.size(), 20U);
  for (std::size_t i = 0; i < scans.size(); i += 2) {
    EXPECT_EQ(scans[i]->storage[0].range, scans[i + 1]->storage[0].range);
    EXPECT_EQ(scans[i + 1]->stamp - scans[i]->stamp, std::chrono::milliseconds(10));
  }
}

TEST(StreamFault, AStuckLidarRepeatsATurnAndGoesOn) {
  std::vector<LogSample> samples = streams(60.0);
  streamFault("stuck").add(samples);
  const auto scans = scansOf(samples);
  int repeated = 0;
  for (std::size_t i = 1; i < scans.size(); ++i) {
    repeated += scans[i]->storage[0].range == scans[i - 1]->storage[0].range;
    EXPECT_GT(scans[i]->stamp, scans[i - 1]->stamp);
  }
  EXPECT_NEAR(repeated, 2 * 50, 2);
  EXPECT_EQ(scans.back()->storage[0].range, 1.0F + 5990.0F);
}

TEST(StreamFault, LateScansComeBehindTheWheelsOfTheirTime) {
  std::vector<LogSample> samples = streams(30.0);
  streamFault("late").add(samples);
  Timestamp wheels;
  Duration latest{0};
  for (const LogSample& sample : samples) {
    if (const auto* wheel = std::get_if<WheelSample>(&sample)) wheels = wheel->stamp;
    if (std::holds_alternative<std::unique_ptr<LaserScan>>(sample)) latest = std::max(latest, wheels - stampOf(sample));
  }
  EXPECT_NEAR(toSeconds(latest), 1.5, 0.03);
}

TEST(StreamFault, AnUnknownFaultIsRefusedWithTheKnownOnes) {
  EXPECT_EQ(streamFault("copies").name, "copies");
  try {
    streamFault("copied");
    FAIL() << "nothing thrown";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("copies"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace slam::stream_fault_test
