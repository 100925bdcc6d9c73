// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/drive_progress.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <slam/scan_t.hpp>
#include <slam/wheels_t.hpp>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "tools/files.hpp"

namespace slam::drive_progress_test {
namespace {

using std::numbers::pi;

class Watched : public testing::Test {
 protected:
  template <typename Message>
  void append(const std::string& channel, const Message& message) {
    std::vector<std::uint8_t> data(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(data.data(), 0, static_cast<int>(data.size()));
    appendRecord(bytes_, number_++, 1000, channel, data);
  }
  void append(const Pose2& pose) {
    wheels_t wheels{};
    wheels.utime = 1'000'000 + number_;
    wheels.x = pose.x, wheels.y = pose.y, wheels.theta = pose.theta;
    wheels.turn_rate_known = true;
    append(channel::kWheels, wheels);
  }
  /// In steps of 5 mm or 0.02 rad, as encoders see them.
  void drive(double way, double turn) {
    std::uniform_real_distribution<double> noise(-0.0005, 0.0005);  // [m], [rad]
    const int steps = static_cast<int>(std::max(std::abs(way) / 0.005, std::abs(turn) / 0.02));
    for (int i = 0; i < steps; ++i) {
      pose_ = pose_ * Pose2{way / steps, 0.0, turn / steps};
      append({pose_.x + noise(random_), pose_.y, wrapAngle(pose_.theta + noise(random_))});
    }
  }
  /// Lets the log grow. @param less [bytes] that are not on the disk yet
  void flush(std::size_t less = 0) {
    std::ofstream(log_, std::ios::binary | std::ios::trunc) << bytes_.substr(0, bytes_.size() - less);
    watch_.look();
  }
  const test::Folder folder_;
  const std::filesystem::path log_ = folder_ / "drive.lcm";
  std::mt19937 random_{5};
  std::string bytes_;
  std::int64_t number_ = 0;
  Pose2 pose_;
  DriveWatch watch_{log_};
};

TEST_F(Watched, GrowsWithTheLogWhateverPartOfItIsWritten) {
  watch_.look();
  EXPECT_FALSE(watch_.hasSensors()) << "there is no log";
  flush();
  append(pose_);
  flush(3);
  EXPECT_FALSE(watch_.hasSensors()) << "no record is whole";
  append(channel::kScan, scan_t{});
  flush();
  EXPECT_TRUE(watch_.hasSensors());
  for (int metre = 0; metre < 4; ++metre) {
    drive(1.0, 0.0);
    flush(17);
  }
  flush();
  EXPECT_NEAR(watch_.driven().way, 4.0, 0.15);
  EXPECT_NEAR(watch_.driven().straight, 4.0, 0.15);
  EXPECT_LT(watch_.driven().left, 0.05) << "noise is not summed";
  EXPECT_LT(watch_.driven().right, 0.05);
}

TEST_F(Watched, SumsTurnsOfEachSideApartFromStraightWay) {
  append(pose_);
  drive(0.0, 2.0 * pi);
  drive(2.0, -1.5 * pi);
  flush();
  EXPECT_NEAR(watch_.driven().left, 2.0 * pi, 0.2);
  EXPECT_NEAR(watch_.driven().right, 1.5 * pi, 0.2);
  EXPECT_NEAR(watch_.driven().way, 2.0, 0.15);
  EXPECT_LT(watch_.driven().straight, 0.15) << "an arc is not straight";
}

TEST_F(Watched, CountsNoJumpOfTheWheelsFrameAndNoAbsurdPose) {
  append(pose_);
  append(Pose2{50.0, 0.0, 3.0});
  append(Pose2{std::nan(""), 0.0, 0.0});
  append(Pose2{50.2, 0.0, 3.0});
  flush();
  EXPECT_NEAR(watch_.driven().way, 0.2, 1e-9);
  EXPECT_EQ(watch_.driven().left, 0.0);
}

}  // namespace
}  // namespace slam::drive_progress_test
