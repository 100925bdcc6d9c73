// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "tools/convert/formats.hpp"
#include "tools/files.hpp"
#include "tools/recorded_log.hpp"

namespace slam::csv_test {
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

/// A table of 40 scans at 5 Hz over 271 beams from -120 to 120 degrees.
struct Sweep {
  static constexpr int kScans = 40, kBeams = 271;
  static double degrees(int k) { return -120.0 + 240.0 * k / (kBeams - 1); }
  static double range(int i, int k) { return 2.0 + std::sin(0.05 * k + 0.03 * i); }
  static std::string number(const char* format, double value) {
    char text[64];
    std::snprintf(text, sizeof(text), format, value);
    return text;
  }
  /// @param stamp of each row, from its seconds; empty: none @param range format of ranges
  static std::string rows(const std::function<std::string(double)>& stamp, const std::string& separator = ",",
                          const char* range_format = "%.4f") {
    std::string text;
    for (int i = 0; i < kScans; ++i) {
      if (stamp) text += stamp(0.2 * i) + separator;
      for (int k = 0; k < kBeams; ++k) text += (k > 0 ? separator : "") + number(range_format, range(i, k));
      text += "\n";
    }
    return text;
  }
  static std::string row(const std::string& corner, const std::function<std::string(int)>& cell,
                         const std::string& separator = ",") {
    std::string text = corner;
    for (int k = 0; k < kBeams; ++k) text += (k > 0 || !corner.empty() ? separator : "") + cell(k);
    return text + "\n";
  }
};

TEST_F(CsvInMetres, HasItsBearingsFromTheFirstRow) {
  const auto seconds = [](double t) { return Sweep::number("%.1f", t); };
  const auto deg = [](int k) { return Sweep::number("%.2f", Sweep::degrees(k)); };
  const auto rad = [](int k) { return Sweep::number("%.4f", Sweep::degrees(k) * kDegree); };
  const std::pair<const char*, std::string> tables[] = {
      {"corner NaN", Sweep::row("NaN", rad) + Sweep::rows(seconds)},
      {"corner 0, degrees", Sweep::row("0", deg) + Sweep::rows(seconds)},
      {"corner empty", Sweep::row(" ", rad, ";") + Sweep::rows(seconds, ";")},
      {"corner named", Sweep::row("angle", rad) + Sweep::rows(seconds)},
      {"corner named for the time", Sweep::row("t", deg, "\t") + Sweep::rows(seconds, "\t")},
      {"no times", Sweep::row("", rad) + Sweep::rows({})},
  };
  for (const auto& [name, text] : tables) {
    SCOPED_TRACE(name);
    const Log log = convert(text);
    EXPECT_EQ(recording_.rejected, 0) << recording_.first_rejection;
    ASSERT_EQ(log.scans.size(), static_cast<std::size_t>(Sweep::kScans));
    ASSERT_EQ(log.scans[0].size, Sweep::kBeams);
    EXPECT_NEAR(log.scans[0].beams()[0].bearing, -120 * kDegree, 1e-4);
    EXPECT_NEAR(log.scans[0].beams()[270].bearing, 120 * kDegree, 1e-4);
    EXPECT_NEAR(log.scans[7].beams()[100].range, Sweep::range(7, 100), 1e-4);
    EXPECT_EQ(log.scan_utimes[5] - log.scan_utimes[0], name == std::string("no times") ? 500'000 : 1'000'000);
  }
}

TEST_F(CsvInMetres, FindsTheTimesWhereverTheyAre) {
  int row = 0;
  const std::pair<const char*, std::function<std::string(double)>> stamps[] = {
      {"s", [](double t) { return Sweep::number("%.3f", 1.7e9 + t); }},
      {"ms", [](double t) { return Sweep::number("%.0f", 1e3 * (1.7e9 + t)); }},
      {"us", [](double t) { return Sweep::number("%.0f", 1e6 * (1.7e9 + t)); }},
      {"ns", [](double t) { return Sweep::number("%.0f", 1e9 * (1.7e9 + t)); }},
      {"number and time", [&](double t) { return std::to_string(++row) + "," + Sweep::number("%.3f", 1.7e9 + t); }},
      {"time and number", [&](double t) { return Sweep::number("%.3f", 1.7e9 + t) + "," + std::to_string(++row); }},
  };
  for (const auto& [name, stamp] : stamps) {
    SCOPED_TRACE(name);
    const Log log = convert(Sweep::rows(stamp));
    ASSERT_EQ(log.scans.at(0).size, Sweep::kBeams);
    EXPECT_EQ(log.scan_utimes[5] - log.scan_utimes[0], 1'000'000);
  }
  std::string behind, numbered;
  for (int i = 0; i < Sweep::kScans; ++i) {
    for (int k = 0; k < Sweep::kBeams; ++k) behind += Sweep::number("%.4f,", Sweep::range(i, k));
    behind += Sweep::number("%.1f\n", 0.2 * i);
  }
  EXPECT_EQ(convert(behind).scan_utimes.at(5) - 1'000'000, 1'000'000);
  EXPECT_EQ(test::readLog(folder_ / "out.lcm").scans[0].size, Sweep::kBeams);
  row = 0;
  convert(Sweep::rows([&](double) { return std::to_string(row++); }));
  EXPECT_THAT(recording_.notes, testing::Contains(HasSubstr("no stamps"))) << "rows that are numbered have no times";
}

TEST_F(CsvInMetres, ReadsDecimalCommasListsAndMillimetresThatAreNamed) {
  std::string commas = Sweep::rows([](double t) { return Sweep::number("%.1f", t); }, ";");
  std::replace(commas.begin(), commas.end(), '.', ',');
  EXPECT_NEAR(convert(commas).scans.at(7).beams()[100].range, Sweep::range(7, 100), 1e-4);
  std::string lists = "time,ranges\n";
  for (int i = 0; i < 10; ++i) {
    lists += std::to_string(0.2 * i) + ",\"[";
    for (int k = 0; k < 90; ++k) lists += (k > 0 ? ", " : "") + Sweep::number("%.4f", Sweep::range(i, k));
    lists += "]\"\n";
  }
  EXPECT_EQ(convert(lists).scans.at(9).size, 90);
  EXPECT_NEAR(test::readLog(folder_ / "out.lcm").scans[9].beams()[89].range, Sweep::range(9, 89), 1e-4);
  EXPECT_NEAR(convert("t,r0_mm,r1_mm\n1,1500,2500\n1.1,1500,2500\n").scans.at(0).beams()[1].range, 2.5, 1e-6);
  EXPECT_NEAR(convert("t,r0 [cm],r1 [cm]\n1,150,250\n1.1,150,250\n").scans.at(0).beams()[1].range, 2.5, 1e-6);
}

TEST_F(CsvInMetres, ReadsWhatToolsOfRosWrite) {
  const auto ranges = [](const char* format) { return [format](int k) { return Sweep::number(format, k); }; };
  std::string echo = Sweep::row(
      "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.angle_min,"
      "field.angle_max,field.angle_increment,field.time_increment,field.scan_time,"
      "field.range_min,field.range_max",
      ranges("field.ranges%.0f"));
  echo.back() = ',';
  echo += Sweep::row("", ranges("field.intensities%.0f"));
  std::string echo2, bagpy =
                         "Time,header.seq,header.stamp.secs,header.stamp.nsecs,header.frame_id,angle_min,"
                         "angle_max,angle_increment,time_increment,scan_time,range_min,range_max";
  bagpy = Sweep::row(bagpy, ranges("ranges_%.0f"));
  for (int i = 0; i < 3; ++i) {
    const std::string fields = "laser,-2.0943951,2.0943951,0.01551404,0.0005,0.2,0.1,2.9";
    const auto cell = [&](int k) { return Sweep::number("%.4f", Sweep::range(i, k)); };
    const std::string nanoseconds = std::to_string(200'000'000 * i);
    echo += Sweep::row(std::to_string(1'700'000'000'500'000'000 + 210'000'000 * i) + ",7," +
                           std::to_string(1'700'000'000'000'000'000 + 200'000'000 * i) + "," + fields,
                       cell);
    echo.back() = ',';
    echo += Sweep::row("", [](int) { return std::string("47"); });
    echo2 += Sweep::row("1700000000," + nanoseconds + "," + fields, cell);
    bagpy += Sweep::row(Sweep::number("%.3f", 1.7e9 + 0.2 * i) + ",7,1700000000," + nanoseconds + "," + fields, cell);
  }
  for (const std::string& text : {echo, echo2, bagpy}) {
    SCOPED_TRACE(text.substr(0, 60));
    const Log log = convert(text);
    EXPECT_EQ(recording_.rejected, 0) << recording_.first_rejection;
    ASSERT_EQ(log.scans.size(), 3U);
    EXPECT_EQ(log.scan_utimes[2], 1'700'000'001'400'000);
    const auto beams = log.scans[0].beams();
    ASSERT_EQ(beams.size(), static_cast<std::size_t>(Sweep::kBeams));
    EXPECT_NEAR(beams[270].bearing, 120 * kDegree, 1e-4);
    for (int k = 0; k < Sweep::kBeams; ++k)
      EXPECT_EQ(log.scans[0].isReturn(beams[static_cast<std::size_t>(k)]), Sweep::range(0, k) < 2.9) << k;
    EXPECT_NEAR(beams[100].time_offset, 0.05, 1e-6);
    const std::string one_row = text.substr(0, text.find('\n', text.find("\n170") + 1) + 1);
    EXPECT_EQ(convert(text == echo2 ? text.substr(0, text.find('\n') + 1) : one_row).scan_utimes.at(0),
              1'700'000'001'000'000)
        << "of one row alone";
  }
}

TEST_F(CsvInMetres, TakesAnglesOfEachRowInDegrees) {
  const Log log = convert("t,angle_min,angle_increment,r0,r1,r2\n1,-90,90,2,2.5,3\n2,-90,90,2,2.5,3.1\n");
  EXPECT_NEAR(log.scans.at(0).beams()[0].bearing, -90 * kDegree, 1e-6);
  EXPECT_NEAR(log.scans.at(0).beams()[2].bearing, 90 * kDegree, 1e-6);
}

TEST_F(CsvInMetres, RefusesRowsThatAreNoScans) {
  const auto refused = [&](const std::string& text) {
    const auto file = folder_.write("other.csv", text);
    return test::refusalOf([&] { convertAny(file, folder_ / "none.lcm"); });
  };
  std::string side, beams, dates, poses;
  for (int k = 0; k < Sweep::kBeams; ++k) {
    side += Sweep::number("%.2f", Sweep::degrees(k));
    for (int i = 0; i < Sweep::kScans; ++i) side += Sweep::number(",%.4f", Sweep::range(i, k));
    side += "\n";
    beams += Sweep::number("%.2f,", 0.001 * k) + Sweep::number("%.1f,", 7 * k % 90) +
             Sweep::number("%.4f\n", Sweep::range(0, k));
  }
  std::string times = "0.0", names = "angle";
  for (int i = 1; i <= Sweep::kScans; ++i) {
    times += Sweep::number(",%.1f", 0.2 * i);
    names += ",scan" + std::to_string(i);
  }
  dates = Sweep::rows([](double t) { return "2024-01-01 12:00:" + Sweep::number("%06.3f", t); });
  poses = Sweep::rows([](double t) { return Sweep::number("%.1f", t) + ",0.5,-0.25,-0.1"; });
  EXPECT_THAT(refused(side), HasSubstr("stands on its side"));
  EXPECT_THAT(refused(times + "\n" + side), HasSubstr("stands on its side"));
  EXPECT_THAT(refused(names + "\n" + side), HasSubstr("stands on its side"));
  EXPECT_THAT(refused("t,angle,range_0\n" + beams), HasSubstr("one bearing"));
  EXPECT_THAT(refused(beams), HasSubstr("each row of one beam"));
  EXPECT_THAT(refused(dates), HasSubstr("time in seconds"));
  EXPECT_THAT(refused(poses), HasSubstr("--first-range"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "none.lcm"));
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

TEST(CsvSpeed, HasAHeaderBehindCommentsAndNoRowWithoutATime) {
  const test::Folder folder;
  const Recording recording = convertCsv(
      {.speed = folder.write("speed.csv", "# of the wheels\nt_s,v_m_s\n-5.0,1\n1.0,1\n1.5,1\n")}, folder / "out.lcm");
  EXPECT_EQ(recording.wheels, 2);
  EXPECT_EQ(recording.rejected, 1) << "slamd takes no stamp before 0";
  EXPECT_THAT(recording.first_rejection, HasSubstr("speed.csv:3"));
}

TEST(CsvEncoders, KeepTheirTicksAsAnglesAndTurnByTheTrack) {
  const test::Folder folder;
  CsvInput in;
  in.encoders = folder.write("encoders.csv", "1.0,1,2,1,2\n1.1,3,4,3,4\n");
  in.metres_per_tick = 0.01;
  in.wheel_radius = 0.1;
  in.half_track = 0.05;
  const Recording recording = convertCsv(in, folder / "out.lcm");
  const Log log = test::readLog(folder / "out.lcm");
  ASSERT_EQ(log.angles.size(), 2U);
  ASSERT_EQ(log.angles[1].size(), 2U);
  EXPECT_NEAR(log.angles[1][0], 0.6, 1e-9);
  EXPECT_NEAR(log.angles[1][1], 0.4, 1e-9);
  EXPECT_NEAR(log.wheels[1].T_wheels_base.theta, (0.04 - 0.06) / 0.1, 1e-9) << "right less left, by the whole track";
  EXPECT_NEAR(test::configOf(recording).base_device.geometry.wheel_radius, 0.1, 1e-9);
}

}  // namespace
}  // namespace slam::csv_test
