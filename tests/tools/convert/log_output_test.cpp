// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/log_output.hpp"

#include <gtest/gtest.h>
#include <random>

#include "tools/files.hpp"
#include "tools/recorded_log.hpp"

namespace slam::log_output_test {
namespace {

TEST(LogOutput, IsTheSameWithLittleMemory) {
  const test::Folder folder;
  std::mt19937 random(1);
  LogOutput large, small(1000), tiny(0);
  LaserScan scan;
  scan.push({.range = 1.0F});
  for (int i = 0; i < 300; ++i) {
    const auto arrival = static_cast<std::int64_t>(1'000'000 + random() % 50);  // out of order, many equal
    for (LogOutput* log : {&large, &small, &tiny}) {
      log->add(arrival, scan, 1'000'000 + i);
      log->add(arrival, WheelSample{{}, {0.01 * i, 0.0, 0.0}}, 1'000'000 + i);
    }
  }
  large.write(folder / "large.lcm");
  small.write(folder / "small.lcm");
  tiny.write(folder / "tiny.lcm");
  EXPECT_EQ(test::contentOf(folder / "small.lcm"), test::contentOf(folder / "large.lcm"));
  EXPECT_EQ(test::contentOf(folder / "tiny.lcm"), test::contentOf(folder / "large.lcm"));
  const test::Log log = test::readLog(folder / "small.lcm");
  EXPECT_EQ(log.scans.size(), 300U);
  EXPECT_TRUE(std::is_sorted(log.event_times.begin(), log.event_times.end()));
}

TEST(LogOutput, LeavesOutAndCountsWhatCannotBeMeasured) {
  const test::Folder folder;
  LogOutput out;
  Recording recording;
  out.add(1, WheelSample{{}, {1.0, 0.0, 0.0}}, 1);
  out.add(2, WheelSample{{}, {1e300, 0.0, 0.0}}, 2);
  ImuSample spun;
  spun.gyro.z() = 1e9;
  out.add(3, spun, 3);
  recording.wheels = 2;
  recording.imu = 1;
  out.write(folder / "out.lcm", &recording);
  EXPECT_EQ(test::readLog(folder / "out.lcm").wheels.size(), 1U);
  EXPECT_EQ(recording.wheels, 1);
  EXPECT_EQ(recording.imu, 0);
  EXPECT_EQ(recording.rejected, 2);
}

TEST(LogOutput, RefusesToWriteNothing) {
  const test::Folder folder;
  EXPECT_THROW(LogOutput().write(folder / "out.lcm"), std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(folder / "out.lcm"));
}

}  // namespace
}  // namespace slam::log_output_test
