// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "tools/convert/formats.hpp"
#include "tools/files.hpp"
#include "tools/recorded_log.hpp"

namespace slam::carmen_test {
namespace {

using test::configOf;
using test::Log;
using testing::ElementsAre;
using testing::HasSubstr;

std::string text(const Pose2& pose) {
  char words[100];
  std::snprintf(words, sizeof(words), "%.6f %.6f %.6f", pose.x, pose.y, pose.theta);
  return words;
}

/// A robot on a circle, in a room whose walls lie at many ranges.
class Drive {
 public:
  explicit Drive(unsigned seed) : random_(seed) {}

  Pose2 pose(int i) const { return {std::sin(0.05 * i), 1.0 - std::cos(0.05 * i), 0.05 * i}; }
  std::vector<std::string> ranges(std::size_t beams) {
    std::uniform_real_distribution<double> range(0.5, 7.5);
    std::vector<std::string> words;
    for (std::size_t i = 0; i < beams; ++i) words.push_back(std::to_string(range(random_)).substr(0, 5));
    return words;
  }
  static std::string flaser(const std::vector<std::string>& ranges, const Pose2& laser, const Pose2& robot,
                            const std::string& stamp, const std::string& logger) {
    std::string line = "FLASER " + std::to_string(ranges.size());
    for (const std::string& range : ranges) line += " " + range;
    return line + " " + text(laser) + " " + text(robot) + " " + stamp + " host " + logger + "\n";
  }
  std::string line(int i, const std::string& stamp, const std::string& logger) {
    return flaser(ranges(181), pose(i), pose(i), stamp, logger);
  }
  /// Line i of a log whose laser sits at `mount`.
  std::string line(int i, const Pose2& mount = {}) {
    return flaser(ranges(181), pose(i) * mount, pose(i), std::to_string(100.0 + 0.1 * i), std::to_string(0.1 * i));
  }

 private:
  std::mt19937 random_;
};

class CarmenLog : public testing::Test {
 protected:
  Log convert(const std::string& content, const CarmenOptions& options = {}) {
    recording_ = convertCarmen(folder_.write("in.clf", content), folder_ / "out.lcm", options);
    return test::readLog(folder_ / "out.lcm");
  }
  std::string notes() const { return reportText(recording_, "out", true); }
  const test::Folder folder_;
  Recording recording_;
};

TEST_F(CarmenLog, HasTheMountFromTheLasersPoses) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.002);
  for (const Pose2& mount : {Pose2{0.04, 0.0, 0.0}, Pose2{-0.3, 0.12, 3.1}, Pose2{0.21, 0.0, -3.14}}) {
    Drive drive(1);
    std::string log;
    for (int i = 0; i < 60; ++i) {
      const Pose2 shaken{mount.x + noise(random), mount.y + noise(random), mount.theta + noise(random)};
      log += drive.line(i, i == 30 ? Pose2{1.0, 1.0, 1.0} : shaken);
    }
    convert(log);
    const LidarModel lidar = configOf(recording_).front_end.lidar;
    EXPECT_NEAR(lidar.T_base_lidar.x, mount.x, 0.002);
    EXPECT_NEAR(lidar.T_base_lidar.y, mount.y, 0.002);
    EXPECT_NEAR(wrapAngle(lidar.T_base_lidar.theta - mount.theta), 0.0, 0.002);
    EXPECT_THAT(notes(), HasSubstr("laser's and the robot's pose"));
  }
}

TEST_F(CarmenLog, HasTheMountFromTheParameterWhereThePosesAreTheSame) {
  Drive drive(2);
  std::string log = "PARAM robot_frontlaser_offset 0.04 100 host 0\n";
  for (int i = 0; i < 20; ++i) log += drive.line(i);
  convert(log);
  EXPECT_NEAR(configOf(recording_).front_end.lidar.T_base_lidar.x, 0.04, 1e-9);
  EXPECT_THAT(notes(), HasSubstr("robot_frontlaser_offset"));
}

TEST_F(CarmenLog, TakesNoMountFromCorrectedPoses) {
  Drive drive(3);
  std::string log = "PARAM robot_frontlaser_offset 0.1 100 host 0\n";
  for (int i = 0; i < 50; ++i) {
    const Pose2 correction{0.02 * i, -0.01 * i, 0.01 * i};
    log += Drive::flaser(drive.ranges(181), correction * drive.pose(i), drive.pose(i), std::to_string(100.0 + 0.1 * i),
                         "0");
  }
  convert(log);
  EXPECT_NEAR(recording_.robot.lidar_x, 0.1, 1e-9);
  EXPECT_THAT(notes(), HasSubstr("corrected"));
}

TEST_F(CarmenLog, FindsCodesOfNoReturnInTheData) {
  const struct {
    std::vector<std::string> codes;
    double range_max;  // [m] of the configuration
  } cases[] = {{{"8.183", "8.187", "8.191"}, 8.18},
               {{"29.99"}, 29.98},
               {{"81.83", "81.91"}, 50.0},
               {{"51.14"}, 50.0},
               {{"12.00", "12.01"}, 11.99}};
  for (const auto& [codes, range_max] : cases) {
    SCOPED_TRACE(codes.front());
    Drive drive(4);
    std::mt19937 random(5);
    std::string log;
    std::vector<std::vector<std::string>> written;
    for (int i = 0; i < 60; ++i) {
      auto ranges = drive.ranges(181);
      for (std::string& range : ranges) {
        if (random() % 10 == 0) range = codes[random() % codes.size()];
      }
      written.push_back(ranges);
      log += Drive::flaser(ranges, drive.pose(i), drive.pose(i), std::to_string(100.0 + 0.1 * i), "0");
    }
    const Log converted = convert(log);
    ASSERT_EQ(converted.scans.size(), 60U);
    for (std::size_t i = 0; i < 60; ++i) {
      const auto beams = converted.scans[i].beams();
      for (std::size_t k = 0; k < beams.size(); ++k) {
        const bool code = std::find(codes.begin(), codes.end(), written[i][k]) != codes.end();
        EXPECT_EQ(converted.scans[i].isReturn(beams[k]), !code) << written[i][k];
      }
    }
    EXPECT_NEAR(configOf(recording_).front_end.lidar.range_max, range_max, 1e-6);
  }
}

TEST_F(CarmenLog, KeepsRealRangesNearTheRim) {
  Drive drive(6);
  std::string log;
  for (int i = 0; i < 60; ++i) log += drive.line(i);
  const Log converted = convert(log);
  for (const LaserScan& scan : converted.scans) {
    for (const Beam& beam : scan.beams()) EXPECT_TRUE(scan.isReturn(beam)) << beam.range;
  }
}

TEST_F(CarmenLog, TakesTheLoggersStampsWhereItsOwnAreNone) {
  for (const char* stamp : {"0", "0.000000", "976052857.5"}) {
    Drive drive(7);
    std::string log;
    for (int i = 0; i < 5; ++i) log += drive.line(i, stamp, std::to_string(0.25 * i));
    const Log converted = convert(log);
    EXPECT_EQ(recording_.rejected, 0) << stamp;
    EXPECT_THAT(converted.scan_utimes, ElementsAre(1'000'000, 1'250'000, 1'500'000, 1'750'000, 2'000'000)) << stamp;
    EXPECT_THAT(notes(), HasSubstr("the logger's stamps"));
  }
}

TEST_F(CarmenLog, TakesAPeriodWhereNoStampsAreTimes) {
  Drive drive(8);
  std::string log;
  for (int i = 0; i < 4; ++i) log += drive.line(i, "0", "7.5");
  EXPECT_THAT(test::refusalOf([&] { convert(log); }), HasSubstr("--period"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.lcm"));
  EXPECT_THAT(convert(log, {.period = 0.2}).scan_utimes, ElementsAre(1'000'000, 1'200'000, 1'400'000, 1'600'000));
}

TEST_F(CarmenLog, FillsASingleStampOfZeroByTheLoggers) {
  Drive drive(9);
  std::string log;
  for (int i = 0; i < 6; ++i) log += drive.line(i, i == 3 ? "0" : std::to_string(100 + i), std::to_string(i));
  EXPECT_THAT(convert(log).scan_utimes,
              ElementsAre(100'000'000, 101'000'000, 102'000'000, 103'000'000, 104'000'000, 105'000'000));
}

TEST_F(CarmenLog, FillsStampsOfZeroAtItsBeginningAndWithoutALogger) {
  Drive drive(10);
  const auto odom = [&](int i, const std::string& stamp, const std::string& logger) {
    return "ODOM " + text(drive.pose(i)) + " 0 0 0 " + stamp + " host " + logger + "\n";
  };
  std::string log = odom(0, "0", "0.5") + odom(0, "0.000000", "0.6");
  for (int i = 0; i < 4; ++i) log += drive.line(i, std::to_string(100 + i), std::to_string(1 + i));
  log += odom(3, "0", "0") + odom(3, "0", "no time");
  const Log converted = convert(log);
  EXPECT_EQ(recording_.rejected, 0) << recording_.first_rejection;
  std::vector<std::int64_t> times;
  for (const WheelSample& sample : converted.wheels) times.push_back(toMicroseconds(sample.stamp));
  EXPECT_THAT(times, ElementsAre(99'500'000, 99'600'000, 100'000'000, 101'000'000, 102'000'000, 103'000'000,
                                 103'000'000, 103'000'000));
}

TEST_F(CarmenLog, LeavesOutOdomLinesOfCorrectedPoses) {
  const auto log = [](const Pose2& drift) {
    Drive drive(10);
    std::string content;
    for (int i = 0; i < 60; ++i) {
      content += drive.line(i);
      const Pose2 odom = Pose2{drift.x * i, drift.y * i, drift.theta * i} * drive.pose(i);
      content += "ODOM " + text(odom) + " 0.1 0 0 " + std::to_string(100.02 + 0.1 * i) + " host 0\n";
    }
    return content;
  };
  EXPECT_EQ(convert(log({})).wheels.size(), 120U);
  EXPECT_EQ(convert(log({0.05, 0.02, 0.01})).wheels.size(), 60U);
  EXPECT_THAT(notes(), HasSubstr("60 ODOM lines"));
  EXPECT_THAT(notes(), HasSubstr("corrected"));
  EXPECT_TRUE(recording_.doubt().empty());
}

TEST_F(CarmenLog, IsDoubtedWhereMostLinesAreRefused) {
  Drive drive(11);
  std::string log = drive.line(0);
  for (int i = 1; i < 4; ++i) log += drive.line(i).substr(0, 400) + "\n";
  convert(log);
  EXPECT_THAT(recording_.doubt(), HasSubstr("only 1 of 4 rows of FLASER"));
}

TEST_F(CarmenLog, NamesLinesThatItDoesNotRead) {
  Drive drive(12);
  convert(drive.line(0) + "RLASER 2 1 1\nRLASER 2 1 1\n" + drive.line(1));
  EXPECT_THAT(notes(), HasSubstr("2 lines RLASER"));
  EXPECT_EQ(recording_.rejected, 0);
}

}  // namespace
}  // namespace slam::carmen_test
