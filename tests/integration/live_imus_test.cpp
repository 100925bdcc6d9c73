// SPDX-License-Identifier: BSD-3-Clause
// slamd as a user runs it, with each IMU of the table that is no HandsFree (FaultMatrix.Imu).
#include <chrono>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <slam/odometry_t.hpp>

#include "core/pose2.hpp"
#include "drivers/imu/imu_facts.hpp"
#include "integration/live_faults.hpp"

namespace slam::live_imus_test {
namespace {

using namespace std::chrono_literals;
using test::kPatience;

struct Cell {
  const char* name;
  const char* fault;
  const char* end;
  const char* words;
};
constexpr Cell kCells[] = {{"pulled", "unplug 1", "unplug 0", "no such port"},
                           {"silent", "silent 1", "silent 0", "the IMU sends nothing"},
                           {"noise", "garbage 1", "garbage 0", "the IMU's frames cannot be read"},
                           {"stuck", "stuck 1", "stuck 0", "never change"},
                           {"half a frame", "lose 3;insert 3;flip 3", "lose 0", ""}};

class LiveImu : public test::LiveFaults, public testing::WithParamInterface<std::string> {
 protected:
  struct Headings {
    double worst = 0.0;  // [rad]
    int poses = 0;
  };
  /// Headings of the fused odometry, which has no lidar, against the truth from the first one on.
  Headings headings(const Trajectory& truth) const {
    Headings result;
    std::optional<double> offset;
    for (const auto& [stamp, theta] : odometry_) {
      const auto at = poseAt(truth, stamp);
      if (!at) continue;
      const double difference = wrapAngle(theta - at->theta);
      if (!offset) offset = difference;
      result.worst = std::max(result.worst, std::abs(wrapAngle(difference - *offset)));
      ++result.poses;
    }
    return result;
  }
  void driveFor(std::chrono::milliseconds time) {
    listener_.until(
        [&] {
          poseState();
          const auto odometry = listener_.last<odometry_t>(channel::kOdometry);
          if (odometry) odometry_.emplace_back(Timestamp(Duration(1000 * odometry->utime)), odometry->theta);
          return false;
        },
        time);
  }

  std::vector<std::pair<Timestamp, double>> odometry_;
};

INSTANTIATE_TEST_SUITE_P(OfTheTable, LiveImu, testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const ImuFacts& facts : imuTable()) {
                             if (facts.driver != std::string_view("hfi")) names.emplace_back(facts.driver);
                           }
                           return names;
                         }()),
                         [](const auto& device) { return test::nameOf(device.param); });

TEST_P(LiveImu, TurnsWithTheRobotAndItsFaultsAreNamed) {
  ASSERT_TRUE(listener_.good());
  const std::string& imu = GetParam();
  startSimulator("600", "meeting-room", {"--speed", "0.3", "--imu", imu});
  startDaemon({"imu.driver='" + imu + "'", "depth.driver='none'"});
  ASSERT_TRUE(listener_.until([&] { return poseState() == kLocalised && isWell("imu"); }, kPatience * 20s))
      << daemonLog();
  driveFor(25s);
  const std::size_t driven = poses_.size();
  for (const Cell& cell : kCells) {
    inject("imu", cell.fault);
    EXPECT_TRUE(
        listener_.until([&] { return poseState(), summary().find(cell.words) != std::string::npos; }, kPatience * 3s))
        << cell.name << ": " << summary();
    std::printf("%s, %s: %s\n", imu.c_str(), cell.name, summary().c_str());
    worstStateFor(1s);
    inject("imu", cell.end);
    EXPECT_TRUE(listener_.until([&] { return poseState() == kLocalised && isWell("imu"); }, kPatience * 8s))
        << cell.name << ": " << summary();
  }
  worstStateFor(2s);
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(5s), 0) << daemonLog();
  const Trajectory truth = endDrive();
  const Compared calm = compare(truth, 0, driven, kLocalised), all = compare(truth, 0, poses_.size(), kLocalised);
  const Headings heading = headings(truth);
  std::printf(
      "%s: heading of the odometry off by at most %.4f rad in %d; pose by %.3f m in %d, with the faults %.3f m "
      "in %d\n",
      imu.c_str(), heading.worst, heading.poses, calm.worst, calm.poses, all.worst, all.poses);
  EXPECT_GT(heading.poses, 100);
  EXPECT_LT(heading.worst, 0.05) << "[rad] with a gyro of 1 % scale error";
  EXPECT_GT(calm.poses, 100);
  constexpr double kOff = 0.15;  // [m] as LiveBases
  EXPECT_LT(calm.worst, kOff);
  EXPECT_LT(all.worst, kOff);
}

}  // namespace
}  // namespace slam::live_imus_test
