// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/csv.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "tools/convert/auto.hpp"
#include "tools/files.hpp"
#include "tools/recorded_log.hpp"

namespace slam {
namespace {

using test::Log;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;

class CsvInMetres : public testing::Test {
 protected:
  Log convert(const std::string& content, CsvInput in = {}) {
    in.scans = folder_.write("in.csv", content);
    recording_ = convertCsv(in, folder_ / "out.lcm");
    return test::readLog(folder_ / "out.lcm");
  }
  /// Rows of ranges between walls; every seventh beam sees nothing.
  static std::string rows(int count, int beams, const std::string& stamps, const char* none, char separator = ',') {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> range(0.3, 8.0);
    std::string text;
    for (int i = 0; i < count; ++i) {
      if (!stamps.empty()) {
        char stamp[40];
        std::snprintf(stamp, sizeof(stamp), stamps.c_str(), 0.1 * i);
        text += stamp + std::string(1, separator);
      }
      for (int k = 0; k < beams; ++k) {
        text +=
            (k % 7 == 3 ? none : std::to_string(range(random))) + (k + 1 < beams ? std::string(1, separator) : "\n");
      }
    }
    return text;
  }
  const test::Folder folder_;
  Recording recording_;
};

TEST_F(CsvInMetres, IsReadWithAndWithoutStamps) {
  for (const char* none : {"inf", "nan", "", "-1", "0", "Infinity"}) {
    for (const char* stamps : {"", "%.3f", "170000%.3f"}) {
      SCOPED_TRACE(std::string(none) + " " + stamps);
      const Log log = convert(rows(65, 181, stamps, none));
      EXPECT_EQ(recording_.rejected, 0) << recording_.first_rejection;
      ASSERT_EQ(log.scans.size(), 65U);
      const auto beams = log.scans[10].beams();
      ASSERT_EQ(beams.size(), 181U);
      EXPECT_NEAR(beams[0].bearing, -90 * kDegree, 1e-5);
      EXPECT_NEAR(beams[180].bearing, 90 * kDegree, 1e-5);
      for (std::size_t k = 0; k < 181; ++k) EXPECT_EQ(log.scans[10].isReturn(beams[k]), k % 7 != 3) << k;
      EXPECT_EQ(log.scan_utimes[10] - log.scan_utimes[0], 1'000'000);
      EXPECT_NO_THROW(test::configOf(recording_));
    }
  }
}

TEST_F(CsvInMetres, IsReadWithOtherSeparators) {
  for (const char separator : {';', '\t', ' '}) {
    EXPECT_EQ(convert(rows(20, 181, "%.3f", "nan", separator)).scans.size(), 20U) << separator;
    EXPECT_EQ(convertAny(folder_ / "in.csv", folder_ / "any.lcm").scans, 20) << separator;
  }
}

TEST_F(CsvInMetres, DoesNotTakeARangeThatGrowsForAStamp) {
  std::string text;  // the robot backs away from the first beam's wall
  for (int i = 0; i < 40; ++i) {
    for (int k = 0; k < 181; ++k) text += std::to_string(1.0 + 0.01 * i + 0.002 * k) + (k < 180 ? "," : "\n");
  }
  const Log log = convert(text);
  EXPECT_EQ(log.scans.at(0).size, 181);
  EXPECT_EQ(log.scan_utimes.at(10) - log.scan_utimes[0], 1'000'000);
}

TEST_F(CsvInMetres, HasItsColumnsFromTheHeader) {
  std::string header = "theta,y,x,timestamp_ms,battery";
  for (int k = 0; k < 5; ++k) header += ",range_" + std::to_string(k);
  const Log log =
      convert(header + "\n0.1,2,3,5000,12.5,1,2,inf,4,5\n0.2,2,4,5100,12.5,1,2,3,4,5\n", {.field_of_view = -200.0});
  EXPECT_THAT(log.scan_utimes, ElementsAre(6'000'000, 6'100'000));
  ASSERT_EQ(log.wheels.size(), 2U);
  EXPECT_EQ(log.wheels[1].T_wheels_base, (Pose2{4, 2, 0.2}));
  const auto beams = log.scans[0].beams();
  ASSERT_EQ(beams.size(), 5U);
  EXPECT_NEAR(beams[0].bearing, 100 * kDegree, 1e-5) << "clockwise";
  EXPECT_NEAR(beams[4].bearing, -100 * kDegree, 1e-5);
  EXPECT_FALSE(log.scans[0].isReturn(beams[2]));
}

TEST_F(CsvInMetres, HasItsBearingsFromTheHeader) {
  const auto bearing = [&](const std::string& content, std::size_t k) {
    const Log log = convert(content);
    return static_cast<double>(log.scans.at(0).beams()[k].bearing);
  };
  EXPECT_NEAR(bearing("t,-30,-10,10,30\n1,2,2.5,3,3.5\n2,2,2.5,3,3.6\n", 0), -30 * kDegree, 1e-5);
  EXPECT_NEAR(bearing("t,-0.5,0.25,1.5\n1,2,2.5,3\n2,2,2.5,3.1\n", 2), 1.5, 1e-5);
  EXPECT_NEAR(bearing("t,angle_min,angle_max,r0,r1,r2\n1,-1,1.5,2,2.5,3\n2,-1,1.5,2,2.5,3.1\n", 2), 1.5, 1e-5);
}

TEST_F(CsvInMetres, HasItsColumnsFromOptions) {
  const std::string content = "7,1.0,2,3,4\n7,1.1,2,3,4.5\n";
  EXPECT_THAT(convert(content, {.stamp_column = "2", .first_range = "3", .field_of_view = 90.0}).scan_utimes,
              ElementsAre(2'000'000, 2'100'000));
  EXPECT_EQ(test::readLog(folder_ / "out.lcm").scans[0].size, 3);
  EXPECT_THAT(test::refusalOf([&] { convert(content, {.stamp_column = "stamp"}); }), HasSubstr("no column stamp"));
}

TEST_F(CsvInMetres, FindsTheCodeOfNoReturn) {
  const Log log = convert(rows(65, 181, "%.3f", "12.0"));
  for (std::size_t k = 0; k < 181; ++k) EXPECT_EQ(log.scans[3].isReturn(log.scans[3].beams()[k]), k % 7 != 3);
  EXPECT_NEAR(test::configOf(recording_).front_end.lidar.range_max, 11.999, 1e-6);
}

TEST_F(CsvInMetres, CountsRowsThatAreNone) {
  const Log log = convert(rows(10, 181, "%.3f", "inf") + "1.5,2,3\n" + rows(10, 181, "9%.3f", "inf") + "x,y\n");
  EXPECT_EQ(log.scans.size(), 20U);
  EXPECT_EQ(recording_.rejected, 2);
  EXPECT_THAT(recording_.first_rejection, HasSubstr("in.csv:11"));
}

TEST_F(CsvInMetres, RefusesTablesOfAnythingElse) {
  const auto refused = [&](const std::string& content) {
    const auto file = folder_.write("other.csv", content);
    return test::refusalOf([&] { convertAny(file, folder_ / "none.lcm"); });
  };
  std::string imu = "t_s,ax_g,ay_g,az_g,wx,wy,wz\n", bare, large;
  for (int i = 0; i < 50; ++i) {
    const std::string row = std::to_string(0.01 * i) + ",0.01,-0.02,-1,0.1,-0.2,-0.3\n";
    imu += row;
    bare += row;
    large += std::to_string(0.01 * i) + ",512.5,1024.25,2000\n";
  }
  EXPECT_THAT(refused(imu), HasSubstr("no columns of ranges"));
  EXPECT_THAT(refused(bare), HasSubstr("no ranges"));
  EXPECT_THAT(refused(large), HasSubstr("--unit"));
  std::string map = "-5 -5 200 200 0.05\n";
  for (int i = 0; i < 50; ++i) map += "0 0 127 -1 0 40 127\n";
  EXPECT_THAT(refused(map), HasSubstr("without a single fraction"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "none.lcm"));
}

TEST(CsvEncoders, KeepTheirTicksAsAngles) {
  const test::Folder folder;
  CsvInput in;
  in.encoders = folder.write("encoders.csv", "1.0,1,2,1,2\n1.1,3,4,3,4\n");
  in.metres_per_tick = 0.01;
  in.wheel_radius = 0.1;
  const Recording recording = convertCsv(in, folder / "out.lcm");
  const Log log = test::readLog(folder / "out.lcm");
  ASSERT_EQ(log.angles.size(), 2U);
  ASSERT_EQ(log.angles[1].size(), 2U);
  EXPECT_NEAR(log.angles[1][0], 0.6, 1e-9);
  EXPECT_NEAR(log.angles[1][1], 0.4, 1e-9);
  EXPECT_NEAR(test::configOf(recording).base_device.geometry.wheel_radius, 0.1, 1e-9);
}

}  // namespace
}  // namespace slam
