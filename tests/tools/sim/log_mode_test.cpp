// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/log_mode.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "tools/common/trajectory.hpp"

namespace slam::sim::log_mode_test {
namespace {

namespace fs = std::filesystem;

struct Played {
  std::vector<scan_t> scans;
  std::vector<wheels_t> wheels;
  std::vector<imu_t> imu;
  Trajectory truth;
};

Played play(const std::string& scene, double seconds, std::initializer_list<const char*> kinds) {
  const fs::path folder = fs::path(testing::TempDir()) / ("log_mode_" + std::to_string(getpid()));
  fs::create_directories(folder);
  SimOptions options{.scene = scene, .seed = 2, .seconds = seconds, .truth = folder / "truth.tum"};
  for (const char* kind : kinds) addTo(options.situation, kind);
  writeLog(options, folder / "log.lcm");
  Played played;
  EventLogReader log(folder / "log.lcm");
  for (LogEvent event; log.next(event);) {
    if (event.channel == channel::kScan) played.scans.push_back(decodeChecked<scan_t>(event.data).value());
    if (event.channel == channel::kWheels) played.wheels.push_back(decodeChecked<wheels_t>(event.data).value());
    if (event.channel == channel::kImu) played.imu.push_back(decodeChecked<imu_t>(event.data).value());
  }
  played.truth = readTrajectory(folder / "truth.tum");
  fs::remove_all(folder);
  return played;
}

double seconds(std::int64_t utime) { return 1e-6 * static_cast<double>(utime - 1700000000000000); }

TEST(LogMode, WheelsAreAwayForTheirTime) {
  const Played played = play("home", 10.0, {"wheels-away=4,7"});
  EXPECT_NEAR(static_cast<double>(played.wheels.size()), 7.0 * 50, 3);
  for (const wheels_t& row : played.wheels) EXPECT_FALSE(seconds(row.utime) > 4.01 && seconds(row.utime) < 6.99);
  EXPECT_NEAR(static_cast<double>(played.imu.size()), 10.0 * 50, 3);
}

TEST(LogMode, DeadWheelsStandForTheirTimeAndLeaveOutItsWay) {
  const Played dead = play("home", 20.0, {"wheels-dead=8,12"}), sound = play("home", 20.0, {});
  ASSERT_EQ(dead.wheels.size(), sound.wheels.size());
  const auto way = [](const Played& played, double from, double to) {
    double sum = 0.0;
    for (std::size_t i = 1; i < played.wheels.size(); ++i) {
      const double at = seconds(played.wheels[i].utime);
      const double step =
          std::hypot(played.wheels[i].x - played.wheels[i - 1].x, played.wheels[i].y - played.wheels[i - 1].y);
      if (at > from && at < to) sum += step;
    }
    return sum;
  };
  EXPECT_LT(way(dead, 8.05, 11.95), 1e-9);
  EXPECT_GT(way(sound, 8.05, 11.95), 0.5);
  EXPECT_NEAR(way(dead, 12.05, 20.0), way(sound, 12.05, 20.0), 1e-6);
}

TEST(LogMode, ALogThatStartsMovingHasNoStandstill) {
  const Played played = play("home", 10.0, {"start=moving"});
  for (std::size_t i = 1; i < played.truth.size(); ++i) {
    const Pose2 moved = between(played.truth[i - 1].pose, played.truth[i].pose);
    EXPECT_GT(moved.translation().norm() + std::abs(moved.theta), 0.002) << i;
  }
  EXPECT_GT(played.truth.front().pose.translation().norm(), 0.3);
}

TEST(LogMode, BeamTimesAreThereUnlessTheyAreNot) {
  EXPECT_GT(play("home", 2.0, {}).scans.at(1).time_offsets.at(300), 0.1F);
  for (const scan_t& scan : play("home", 2.0, {"beam-times=none"}).scans) {
    for (const float offset : scan.time_offsets) EXPECT_EQ(offset, 0.0F);
  }
}

TEST(LogMode, ScansHaveTheirBeamsTurnRateAndReach) {
  const Played played = play("home", 4.0, {"beams=180", "turn-rate=5", "field-of-view=58", "range-max=4"});
  ASSERT_GE(played.scans.size(), 19U);
  for (std::size_t i = 1; i < played.scans.size(); ++i) {
    EXPECT_NEAR(seconds(played.scans[i].utime) - seconds(played.scans[i - 1].utime), 0.2, 1e-5);
    EXPECT_EQ(played.scans[i].nbeams, 180);
    EXPECT_EQ(played.scans[i].range_max, 4.0F);
  }
}

TEST(LogMode, AKidnappedRobotIsElsewhereAndItsLidarCoveredMeanwhile) {
  const Played played = play("home", 30.0, {"kidnapped=15,covered"});
  const auto at = [&](double time) {
    return poseAt(played.truth, Timestamp(fromSeconds(1700000000.0 + time)))->translation();
  };
  EXPECT_GT((at(18.5) - at(14.9)).norm(), 2.0);
  int covered = 0;
  for (const scan_t& scan : played.scans) {
    const auto returns =
        std::count_if(scan.ranges.begin(), scan.ranges.end(), [](float range) { return range > 0.0F; });
    const double time = seconds(scan.utime);
    if (time > 15.01 && time < 17.8) {
      EXPECT_EQ(returns, 0) << time;
      ++covered;
    } else if (time < 14.8 || time > 18.2) {
      EXPECT_GT(returns, 300) << time;
    }
  }
  EXPECT_GT(covered, 10);
}

TEST(LogMode, AGyroFaultIsInTheImuMessages) {
  double plain = 0.0, degrees = 0.0;
  for (const imu_t& row : play("home", 20.0, {}).imu) plain = std::max(plain, std::abs(row.gyro[2]));
  for (const imu_t& row : play("home", 20.0, {"gyro-unit=deg"}).imu) degrees = std::max(degrees, std::abs(row.gyro[2]));
  EXPECT_NEAR(degrees / plain, 57.2958, 1e-3);
}

}  // namespace
}  // namespace slam::sim::log_mode_test
