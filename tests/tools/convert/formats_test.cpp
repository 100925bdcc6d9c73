// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/formats.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "core/pose2.hpp"
#include "tools/convert/log_output.hpp"
#include "tools/convert/text_file.hpp"
#include "tools/files.hpp"
#include "tools/recorded_log.hpp"

namespace slam::formats_test {
namespace {

using test::Folder;
using test::Log;
using test::readLog;
using test::recorded;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;

/// @param ranges as text, so that a test can write anything
std::string flaser(const std::vector<std::string>& ranges, const std::string& stamp, const std::string& odometry) {
  std::string line = "FLASER " + std::to_string(ranges.size());
  for (const std::string& range : ranges) line += " " + range;
  return line + " 9 9 9 " + odometry + " " + stamp + " host 0.1\n";
}
std::string flaser(std::size_t beams, const std::string& stamp, const std::string& odometry = "1 2 0.5") {
  return flaser(std::vector<std::string>(beams, "3.25"), stamp, odometry);
}

class Carmen : public testing::Test {
 protected:
  Log convert(const std::string& text) {
    report_ = convertCarmen(folder_.write("in.clf", text), folder_ / "out.lcm");
    return readLog(folder_ / "out.lcm");
  }
  const Folder folder_;
  Recording report_;
};

TEST_F(Carmen, TakesTheOdometryOfFlaserLinesNotTheirFirstPose) {
  const Log log = convert(flaser(180, "100.5") + "ODOM 3 4 -0.5 0.1 0.2 0 101.25 host 0.2\n");
  EXPECT_EQ(report_.scans, 1);
  EXPECT_EQ(report_.wheels, 2);
  EXPECT_EQ(report_.rejected, 0);
  ASSERT_EQ(log.wheels.size(), 2U);
  EXPECT_EQ(log.wheels[0].T_wheels_base, (Pose2{1, 2, 0.5}));
  EXPECT_EQ(log.wheels[1].T_wheels_base, (Pose2{3, 4, -0.5}));
  EXPECT_EQ(log.wheels[1].stamp, fromMicroseconds(101'250'000));
  EXPECT_THAT(log.scan_utimes, ElementsAre(100'500'000));
}

TEST_F(Carmen, SpreadsTheBeamsOver180Degrees) {
  const struct {
    std::size_t beams;
    double step;  // [deg]
  } cases[] = {{180, 1.0}, {181, 1.0}, {360, 0.5}, {361, 0.5}};
  for (const auto& [beams, step] : cases) {
    const Log log = convert(flaser(beams, "100.5"));
    ASSERT_EQ(log.scans.size(), 1U) << beams;
    const auto scan = log.scans[0].beams();
    ASSERT_EQ(scan.size(), beams);
    EXPECT_NEAR(scan[0].bearing, -90 * kDegree, 1e-5) << beams;
    for (std::size_t i = 1; i < beams; ++i) EXPECT_NEAR(scan[i].bearing - scan[i - 1].bearing, step * kDegree, 1e-5);
    EXPECT_FLOAT_EQ(scan[7].range, 3.25F);
    EXPECT_TRUE(log.scans[0].isReturn(scan[7]));
  }
}

TEST_F(Carmen, TakesTheBearingsOfRobotLaserLinesFromThem) {
  // type first fov step max accuracy remission_mode n ranges
  const std::string front = "ROBOTLASER1 0 -2.0 3.0 1.5 29.9 0.01 0 3 1.5 30.0 2.5 ";
  const std::string laser = "1.2 2 0.5 ", robot = "1 2 0.5 ", tail = "100.5 host 0.1\n";
  for (const std::string& line : {front + "0 " + laser + robot + "0.1 0.2 0.3 0.4 0 " + tail,           // as of now
                                  front + "3 7 8 9 " + laser + robot + "0.1 0.2 0.3 0.4 1e10 " + tail,  // intensities
                                  front + laser + robot + "0.1 0.2 0.3 0.4 " + tail}) {                 // as once
    SCOPED_TRACE(line);
    const Log log = convert(line);
    ASSERT_EQ(log.scans.size(), 1U);
    ASSERT_EQ(log.wheels.size(), 1U);
    EXPECT_EQ(log.wheels[0].T_wheels_base, (Pose2{1, 2, 0.5}));
    EXPECT_THAT(log.scan_utimes, ElementsAre(100'500'000));
    const auto beams = log.scans[0].beams();
    ASSERT_EQ(beams.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(beams[i].bearing, -2.0 + 1.5 * static_cast<double>(i), 1e-6);
    EXPECT_FLOAT_EQ(beams[2].range, 2.5F);
    EXPECT_FALSE(log.scans[0].isReturn(beams[1])) << "beyond the line's own greatest range";
  }
}

TEST_F(Carmen, RefusesLinesThatCannotBe) {
  const std::string robot = "ROBOTLASER1 0 ", tail = " 1 2 0.5 1 2 0.5 0 0 0 0 100.5 host 0.1\n";
  for (const std::string& bad :
       {robot + "-2.0 3.0 0 29.9 0.01 0 2 1 1" + tail,      // no step
        robot + "-2.0 3.0 4.0 29.9 0.01 0 3 1 1 1" + tail,  // more than a turn
        robot + "nan 3.0 0.1 29.9 0.01 0 2 1 1" + tail, robot + "0 3.0 0.1 29.9 0.01 0 4000 1 1" + tail,
        flaser(1, "100.5"),                              // one beam has no bearing
        "FLASER 170" + flaser(180, "100.5").substr(10),  // more numbers than its count says
        flaser(180, "8176052857.1"),                     // no message may carry it
        std::string("ODOM 1 2 0.5 0 0 0 8176052857.1 host 0\n")}) {
    const Log log = convert(flaser(180, "99.5") + bad);
    EXPECT_EQ(report_.rejected, 1) << bad;
    ASSERT_EQ(log.scans.size(), 1U) << bad;
    EXPECT_EQ(log.scans[0].size, 180) << bad;
  }
}

TEST_F(Carmen, TakesCodesAndNonsenseForNoReturn) {
  for (const char* word : {"81.83", "81.91", "0", "0.00", "-1", "nan", "-nan", "inf", "1e999"}) {
    std::vector<std::string> ranges(180, "3.25");
    ranges[5] = word;
    const Log log = convert(flaser(ranges, "100.5", "0 0 0"));
    ASSERT_EQ(log.scans.size(), 1U) << word;
    const auto beams = log.scans[0].beams();
    EXPECT_EQ(beams[5].range, 0.0F) << word;
    EXPECT_TRUE(log.scans[0].isReturn(beams[4]) && log.scans[0].isReturn(beams[6])) << word;
  }
}

TEST_F(Carmen, CountsLinesThatItDoesNotUnderstandAndGoesOn) {
  std::string cut = flaser(180, "100.1");
  cut = cut.substr(0, cut.size() / 2) + "\n";
  const Log log = convert("# comment\nPARAM robot_front_laser_max 81.9\n" + flaser(180, "100.0") + cut +
                          "FLASER\nFLASER -5 1 2\nFLASER 99999999999 1 2\nFLASER x\nODOM 1 2\n"
                          "ODOM nan 2 3 0 0 0 100.2 host 0\n" +
                          flaser(180, "1e999") + flaser(180, "101.0"));
  EXPECT_EQ(report_.scans, 2);
  EXPECT_EQ(report_.rejected, 8);
  EXPECT_THAT(report_.first_rejection, HasSubstr("in.clf:4"));
  EXPECT_THAT(log.scan_utimes, ElementsAre(100'000'000, 101'000'000));
}

TEST_F(Carmen, KeepsTheOrderOfTheFileAndTheStampsAsRecorded) {
  const Log log = convert(flaser(180, "100.0") + flaser(180, "100.3") + flaser(180, "100.1") + flaser(180, "100.1") +
                          flaser(180, "100.4"));
  EXPECT_THAT(log.scan_utimes, ElementsAre(100'000'000, 100'300'000, 100'100'000, 100'100'000, 100'400'000));
  EXPECT_TRUE(std::is_sorted(log.event_times.begin(), log.event_times.end()));
}

TEST_F(Carmen, ReadsLineEndsOfWindows) {
  std::string text = flaser(180, "100.5");
  text.insert(text.size() - 1, "\r");
  EXPECT_EQ(convert(text).scans.size(), 1U);
}

TEST_F(Carmen, RefusesAFileWithoutSamples) {
  EXPECT_THROW(convert(""), std::runtime_error);
  EXPECT_THROW(convert("# nothing here\n"), std::runtime_error);
  EXPECT_THROW(convertCarmen(folder_ / "missing.clf", folder_ / "out.lcm"), std::runtime_error);
  EXPECT_THROW(convertCarmen(folder_.write("a.clf", flaser(180, "1")), "/nonexistent/out.lcm"), std::runtime_error);
}

/// A log of one scan with returns at some bearings [rad], at ranges that tell them apart.
void writeScan(const std::filesystem::path& log, std::span<const double> bearings) {
  LaserScan scan;
  scan.stamp = fromMicroseconds(5'000'000);
  scan.range_max = 12.0F;
  for (std::size_t i = 0; i < bearings.size(); ++i) {
    scan.push({.range = 1.0F + 0.01F * static_cast<float>(i), .bearing = static_cast<float>(bearings[i])});
  }
  LogOutput out;
  out.add(5'000'000, scan, 5'000'000);
  out.write(log);
}

TEST_F(Carmen, BringsScansWiderThanHalfATurnBack) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> jitter(-0.3, 0.3);  // [1] of the step
  const struct {
    double first, step;  // [rad]
    int beams;
    double uneven, off;                                             // [1], [rad] the bearings may come back so much off
  } cases[] = {{std::numbers::pi, -2.0 * kDegree, 180, 0.0, 1e-4},  // a whole turn, clockwise
               {-std::numbers::pi, kDegree, 360, 0.0, 1e-4},        // the same, another lidar
               {std::numbers::pi, -kDegree, 360, 1.0, 0.14 * kDegree},
               {-135.0 * kDegree, 0.25 * kDegree, 1081, 0.0, 1e-4},
               {-2.0, 4.0, 2, 0.0, 1e-4}};
  for (const auto& [first, step, beams, uneven, off] : cases) {
    SCOPED_TRACE(beams);
    std::vector<double> bearings;
    for (int i = 0; i < beams; ++i) bearings.push_back(wrapAngle(first + step * (i + uneven * jitter(random))));
    writeScan(folder_ / "wide.lcm", bearings);
    convertToCarmen(folder_ / "wide.lcm", folder_ / "wide.clf");
    const Log log = convert(test::contentOf(folder_ / "wide.clf"));
    ASSERT_EQ(log.scans.size(), 1U);
    int returns = 0;
    for (const Beam& beam : log.scans[0].beams()) {
      if (!log.scans[0].isReturn(beam)) continue;
      ++returns;
      const auto i = static_cast<std::size_t>(std::lround((beam.range - 1.0F) * 100.0F));
      ASSERT_LT(i, bearings.size());
      EXPECT_NEAR(wrapAngle(beam.bearing - bearings[i]), 0.0, off) << i;
    }
    EXPECT_EQ(returns, beams);
  }
}

TEST_F(Carmen, ComesBackFromOurLogAsItWent) {
  std::string text;
  for (int i = 0; i < 5; ++i) {
    std::vector<std::string> ranges;
    for (int k = 0; k < 180; ++k) ranges.push_back(k % 50 == 7 ? "81.83" : std::to_string(1 + 0.01 * k + 0.1 * i));
    text +=
        flaser(ranges, "976052857." + std::to_string(278'917 + 100'000 * i), "1.5 -2.25 " + std::to_string(0.1 * i));
  }
  const Log before = convert(text);
  const Recording back = convertToCarmen(folder_ / "out.lcm", folder_ / "back.clf");
  EXPECT_EQ(back.scans, 5);
  EXPECT_EQ(back.rejected, 0);
  const Log after = convert(test::contentOf(folder_ / "back.clf"));
  EXPECT_EQ(after.scan_utimes, before.scan_utimes);
  ASSERT_EQ(after.scans.size(), 5U);
  ASSERT_EQ(after.wheels.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(after.wheels[i].T_wheels_base.x, 1.5, 1e-6);
    EXPECT_NEAR(after.wheels[i].T_wheels_base.y, -2.25, 1e-6);
    EXPECT_NEAR(after.wheels[i].T_wheels_base.theta, 0.1 * static_cast<double>(i), 1e-6);
    const auto a = before.scans[i].beams(), b = after.scans[i].beams();
    ASSERT_EQ(b.size(), a.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      EXPECT_NEAR(b[k].bearing, a[k].bearing, 1e-4);
      EXPECT_EQ(after.scans[i].isReturn(b[k]), before.scans[i].isReturn(a[k]));
      if (before.scans[i].isReturn(a[k])) {
        EXPECT_NEAR(b[k].range, a[k].range, 0.0051);
      }
    }
  }
}

TEST(ConvertCsv, UnpacksRangeAndIntensityOfAWord) {
  const Folder folder;
  std::string scan = "# t_s then words\n1.5";
  for (int i = 0; i < 361; ++i) scan += i == 10 ? ",8191" : i == 20 ? ",25026" : ",100";  // 25026 = (3 << 13) + 450
  CsvInput in;
  in.scans = folder.write("scans.csv", scan + "\n");
  in.speed = folder.write("speed.csv", "t_s,v_m_s\n1.0,0\n1.5,1\n2.0,1\n2.5,1\n");
  const Recording report = convertCsv(in, folder / "out.lcm");
  EXPECT_EQ(report.scans, 1);
  EXPECT_EQ(report.wheels, 4);
  EXPECT_EQ(report.rejected, 0);
  const Log log = readLog(folder / "out.lcm");
  ASSERT_EQ(log.scans.size(), 1U);
  const auto beams = log.scans[0].beams();
  ASSERT_EQ(beams.size(), 361U);
  EXPECT_NEAR(beams[0].bearing, -90 * kDegree, 1e-5);
  EXPECT_NEAR(beams[360].bearing, 90 * kDegree, 1e-5);
  EXPECT_FALSE(log.scans[0].isReturn(beams[10]));
  EXPECT_NEAR(beams[20].range, 4.5, 1e-5);
  EXPECT_EQ(beams[20].intensity, 3.0F);
  ASSERT_EQ(log.wheels.size(), 4U);
  EXPECT_FALSE(log.wheels[0].turn_rate_known);
  EXPECT_NEAR(log.wheels[3].T_wheels_base.x - log.wheels[2].T_wheels_base.x, 0.5, 1e-6);
}

// What shared/data/README.md says of each recording.

double pathLength(const std::vector<WheelSample>& wheels) {
  double metres = 0.0;
  for (std::size_t i = 1; i < wheels.size(); ++i) {
    metres += between(wheels[i - 1].T_wheels_base, wheels[i].T_wheels_base).translation().norm();
  }
  return metres;
}

void expectHandfulRejected(const Recording& report) { EXPECT_LE(report.rejected, 5) << report.first_rejection; }

TEST_F(Carmen, KeepsEachScansOdometryWhereStampsGoBack) {
  std::string text;
  for (int i = 0; i < 40; ++i) {
    text += flaser(180, std::to_string(100 + i - (i % 4 == 3 ? 2 : 0)) + ".5", std::to_string(0.3 * i) + " 0 0.02");
  }
  const Log recorded = convert(text);
  disturbLog(folder_ / "out.lcm", folder_ / "same.lcm", Disturbance{});
  convertToCarmen(folder_ / "out.lcm", folder_ / "back.clf");
  const Log same = readLog(folder_ / "same.lcm"), back = convert(test::contentOf(folder_ / "back.clf"));
  ASSERT_EQ(same.wheels.size(), 40U);
  ASSERT_EQ(back.wheels.size(), 40U);
  for (std::size_t i = 1; i < 40; ++i) {
    const auto step = [i](const Log& log) {
      return between(log.wheels[i - 1].T_wheels_base, log.wheels[i].T_wheels_base).x;
    };
    EXPECT_NEAR(step(same), step(recorded), 1e-9) << i;
    EXPECT_NEAR(step(back), step(recorded), 2e-6) << i;
  }
}

TEST_F(Carmen, CanBeDisturbedByFalseMotionsOfTheWheels) {
  std::string text;
  for (int i = 0; i < 100; ++i) text += flaser(180, std::to_string(2 + i), std::to_string(0.01 * i) + " 0 0");
  const auto clean = convert(text);
  Disturbance disturbance{.wheels = {.jumps = 1, .jump_translation = 0.5, .jump_rotation = 0.0}, .seed = 4};
  disturbLog(folder_ / "out.lcm", folder_ / "jumped.lcm", disturbance);
  const Log jumped = readLog(folder_ / "jumped.lcm");
  ASSERT_EQ(jumped.wheels.size(), clean.wheels.size());
  int jumps = 0;
  for (std::size_t i = 1; i < jumped.wheels.size(); ++i) {
    const Pose2 step = between(jumped.wheels[i - 1].T_wheels_base, jumped.wheels[i].T_wheels_base);
    jumps += std::abs(step.x - 0.01) > 1e-9 || std::abs(step.y) > 1e-9;
  }
  EXPECT_EQ(jumps, 1);
  EXPECT_EQ(jumped.scans.size(), clean.scans.size());
}

TEST_F(Carmen, CanBeDisturbedByWheelsThatReportLate) {
  std::string text;
  for (int i = 0; i < 50; ++i) text += flaser(180, std::to_string(2 + i), std::to_string(0.01 * i) + " 0 0");
  convert(text);
  disturbLog(folder_ / "out.lcm", folder_ / "late.lcm", {.wheels = {.lag = 1.0}});
  const Log late = readLog(folder_ / "late.lcm");
  EXPECT_NEAR(late.wheels[30].T_wheels_base.x, 0.29, 1e-9);  // a second is one line
}

TEST_F(Carmen, CanBeDisturbedByWrongMountsAndClocks) {
  std::string text;
  for (int i = 0; i < 40; ++i) {
    text += flaser(180, std::to_string(102 + i), std::to_string(0.01 * i) + " 0 " + std::to_string(0.02 * i));
  }
  const auto clean = convert(text);
  const auto disturbed = [&](const Disturbance& disturbance) {
    disturbLog(folder_ / "out.lcm", folder_ / "wrong.lcm", disturbance);
    return readLog(folder_ / "wrong.lcm");
  };
  const auto bearing = [](const Log& log) { return log.scans[0].beams()[30].bearing; };
  EXPECT_NEAR(bearing(disturbed({.lidar = {.upside_down = true}})), -bearing(clean), 1e-6);
  EXPECT_NEAR(std::abs(bearing(disturbed({.lidar = {.turned = true}})) - bearing(clean)), std::numbers::pi, 1e-5);

  const Pose2 told = clean.wheels[20].T_wheels_base;
  const Pose2 swapped = disturbed({.wheels = {.swapped = true}}).wheels[20].T_wheels_base;
  EXPECT_NEAR(swapped.theta, -told.theta, 1e-9);
  EXPECT_NEAR(swapped.x, told.x, 1e-9);
  const Pose2 backwards = disturbed({.wheels = {.backwards = true}}).wheels[1].T_wheels_base;
  EXPECT_NEAR(backwards.theta, -0.02, 1e-9);
  EXPECT_LT(backwards.x, -0.009);

  const Log twice = disturbed({.double_scans = true});
  ASSERT_EQ(twice.scans.size(), 80U);
  EXPECT_EQ(twice.scans[40].stamp, twice.scans[41].stamp);
  const Log back = disturbed({.time_backwards = true});
  EXPECT_EQ(back.scan_utimes[8], clean.scan_utimes[8]);
  EXPECT_EQ(back.scan_utimes[9], clean.scan_utimes[9] - 300'000);
  EXPECT_EQ(back.scan_utimes[38], clean.scan_utimes[38] - 30'000'000);
  EXPECT_EQ(back.event_times, clean.event_times);
}

TEST(RecordedData, OfIntelHas5505Scans) {
  SLAM_SKIP_WITHOUT(recorded("intel/intel.clf.gz"));
  const Folder folder;
  const Recording report = convertCarmen(recorded("intel/intel.clf.gz"), folder / "out.lcm");
  EXPECT_EQ(report.scans, 5505);
  EXPECT_EQ(report.rejected, 0) << report.first_rejection;
}

TEST(RecordedData, OfTheUnswVehicleHas8292Scans) {
  SLAM_SKIP_WITHOUT(recorded("unsw_ugv/scans.csv.gz"));
  const Folder folder;
  CsvInput in;
  in.scans = recorded("unsw_ugv/scans.csv.gz");
  in.speed = recorded("unsw_ugv/speed.csv.gz");
  in.imu = recorded("unsw_ugv/imu.csv.gz");
  in.imu_sign_z = -1.0;
  const Recording report = convertCsv(in, folder / "out.lcm");
  EXPECT_EQ(report.scans, 8292);
  EXPECT_NEAR(report.wheels, 222.8 * 200, 100);
  EXPECT_NEAR(report.imu, 222.8 * 200, 100);
  expectHandfulRejected(report);
  const Log log = readLog(folder / "out.lcm");
  EXPECT_NEAR(pathLength(log.wheels), 26.0, 0.5);
}

/// The least and the greatest range of the log's first scan as it is written: a reader of its own may not check it.
std::pair<float, float> rangesOf(const std::filesystem::path& file) {
  EventLogReader reader(file);
  for (LogEvent event; reader.next(event);) {
    if (event.channel != channel::kScan) continue;
    const auto message = decodeChecked<scan_t>(event.data);
    const auto [least, most] = std::ranges::minmax(message.value().ranges);
    return {least, most};
  }
  throw std::runtime_error("no scan");
}

TEST(RangesThatNoLidarMeasures, CountAsNoReturn) {
  const Folder folder;
  std::string mines = "1000000";
  for (int i = 1; i < 706; ++i) mines += i == 200 ? " -40" : i == 201 ? " 1e300" : " 1500";
  convertMines(folder.write("mines.dat", mines + "\n"), folder / "mines.lcm");
  EXPECT_EQ(rangesOf(folder / "mines.lcm"), std::pair(0.0F, 1.5F));

  std::string wean = "L 0 0 0 0 0 0";
  for (int i = 0; i < 180; ++i) wean += i == 20 ? " -40" : i == 21 ? " 1e300" : " 150";
  convertWean(folder.write("wean.log", wean + " 1.5\n"), folder / "wean.lcm");
  EXPECT_EQ(rangesOf(folder / "wean.lcm"), std::pair(0.0F, 1.5F));
}

TEST(RecordedData, OfTheMinesRoverHas756Scans) {
  SLAM_SKIP_WITHOUT(recorded("mines/exp1.dat.gz"));
  const Folder folder;
  const Recording report = convertMines(recorded("mines/exp1.dat.gz"), folder / "out.lcm");
  EXPECT_EQ(report.scans, 756);
  expectHandfulRejected(report);
  const Log log = readLog(folder / "out.lcm");
  ASSERT_EQ(log.scans.size(), 756U);
  EXPECT_NEAR(toSeconds(log.scans.back().stamp - log.scans.front().stamp), 74.6, 0.2);
  EXPECT_NEAR(pathLength(log.wheels), 46.0, 2.0);
}

TEST(RecordedData, OfWeanHallHas2251Scans) {
  SLAM_SKIP_WITHOUT(recorded("wean/robotdata2.log.gz"));
  const Folder folder;
  const Recording report = convertWean(recorded("wean/robotdata2.log.gz"), folder / "out.lcm");
  EXPECT_EQ(report.scans, 2251);
  expectHandfulRejected(report);
  const Log log = readLog(folder / "out.lcm");
  ASSERT_FALSE(log.scans.empty());
  EXPECT_NEAR(toSeconds(log.scans.back().stamp - log.scans.front().stamp), 239.6, 1.0);
  EXPECT_NEAR(log.scans[0].beams()[0].range, 0.64, 1e-5);
  EXPECT_NEAR(log.wheels[0].T_wheels_base.x, 0.49022, 1e-5);
}

TEST(RecordedData, OfTheMaebotHas459Scans) {
  SLAM_SKIP_WITHOUT(recorded("mbot/maebot_convex.lcm.gz"));
  const Folder folder;
  const Recording report = convertMbot(recorded("mbot/maebot_convex.lcm.gz"), folder / "out.lcm");
  EXPECT_EQ(report.scans, 459);
  expectHandfulRejected(report);
  const Log log = readLog(folder / "out.lcm");
  ASSERT_EQ(log.scans.size(), 459U);
  EXPECT_TRUE(std::is_sorted(log.event_times.begin(), log.event_times.end()));
  for (const LaserScan& scan : log.scans) {
    EXPECT_GE(scan.size, 286);
    EXPECT_LE(scan.size, 310);
  }
  const auto beams = log.scans[100].beams();
  EXPECT_LT(std::remainder(beams[101].bearing - beams[100].bearing, 2 * std::numbers::pi), 0.0) << "turns clockwise";
  EXPECT_NEAR(beams.back().time_offset, 1.0 / 6.6, 0.02);
  double turned = 0.0;
  for (std::size_t i = 1; i < log.wheels.size(); ++i) {
    turned += std::abs(between(log.wheels[i - 1].T_wheels_base, log.wheels[i].T_wheels_base).theta) / kDegree;
  }
  EXPECT_NEAR(turned, 2357, 120);
  EXPECT_NEAR(pathLength(log.wheels), 6.2, 0.6);
}

}  // namespace
}  // namespace slam::formats_test
