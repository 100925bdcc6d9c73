// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/replay.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "app/recorded_drive.hpp"
#include "build_paths.hpp"
#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "config/loader.hpp"
#include "mapping/map_files.hpp"
#include "store/map_store.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/convert/formats.hpp"
#include "tools/eval/metrics.hpp"
#include "tools/files.hpp"

namespace slam::replay_test {
namespace {

using test::contentOf;
using test::Folder;
using test::recorded;

constexpr double kPi = std::numbers::pi;
constexpr std::int64_t kStart = 1'700'000'000'000'000;
constexpr double kHalfRoom = 3.0;    // [m] half a side of the square room
constexpr double kScanPeriod = 0.1;  // [s]
constexpr double kSeconds = 10.0;
constexpr int kBeams = 360;
const Eigen::Vector3d kBend(0.25, 0.0, 0.15);

/// A drive off the room's middle: at rest for a second, then along a bend. Pose of base in the room.
Pose2 truthAt(double seconds) {
  const double driven = std::max(0.0, seconds - 1.0);
  return Pose2{-1.5, -1.2, 0.1} * exp(driven * kBend);
}

/// A square room with one block in a corner, so that it is not symmetric.
test::Place blockedRoom() {
  test::Place place{.name = "Blocked", .low = {-3, -3}, .high = {3, 3}};
  test::addWalls(place.world, {{-3, -3}, {3, -3}, {3, 1.5}, {2, 1.5}, {2, 3}, {-3, 3}});
  return place;
}

std::int64_t utimeOf(double seconds) { return kStart + std::llround(seconds * 1e6); }

struct DriveWriter {
  EventLogWriter log;
  const std::function<std::int64_t(int)>& stamp_of;
  const std::function<void(int, LaserScan&)>& edit;
  int number = 0;

  void add(const WheelSample& sample) {
    const std::int64_t utime = toMicroseconds(sample.stamp);
    log.writeMessage(utime, channel::kWheels, toMessage(sample, utime));
  }
  void add(LaserScan scan) {
    const std::int64_t utime = toMicroseconds(scan.stamp + fromSeconds(kScanPeriod));
    if (edit) edit(number, scan);
    log.writeMessage(utime, channel::kScan, toMessage(scan, stamp_of(number++)));
  }
};

/// What the robot records on its drive. Wheels measure 3 % too far and drift in heading; ranges have 1 cm noise.
/// @param stamp_of gives the stamp that scan number i is recorded with
/// @param edit changes scan number i
void writeDrive(const std::filesystem::path& path, const std::function<std::int64_t(int)>& stamp_of,
                double seconds = kSeconds, const std::function<void(int, LaserScan&)>& edit = {}) {
  test::SimulatedRobot robot(blockedRoom(), truthAt(0.0), 7);
  robot.now = fromMicroseconds(kStart);
  robot.wheels.scale = 1.03;
  robot.wheels.turn_scale = 1.037;
  robot.lidar.every = 5;
  robot.lidar.sweep = kScanPeriod;
  robot.lidar.first = -kPi;
  DriveWriter writer{EventLogWriter(path), stamp_of, edit};
  robot.run(1.0, {0, 0, 0}, writer);
  robot.run(seconds - 1.0, kBend, writer);
}

std::int64_t trueStamp(int scan) { return utimeOf(scan * kScanPeriod); }

Config driveConfig() {
  Config config;
  config.front_end.lidar.range_sigma = 0.01;
  return config;
}

ReplayOptions outputsIn(const Folder& folder, const std::string& name) {
  ReplayOptions options;
  options.logs = {folder / "drive.lcm"};
  options.trajectory = folder / (name + ".tum");
  options.causal = folder / (name + "_causal.tum");
  options.odometry = folder / (name + "_odometry.tum");
  options.estimates = folder / (name + ".csv");
  options.map = folder / name;
  return options;
}

std::vector<std::int64_t> stampsOf(const std::filesystem::path& tum) {
  std::istringstream in(contentOf(tum));
  std::vector<std::int64_t> stamps;
  for (std::string line; std::getline(in, line);) {
    const auto digits = line.substr(0, line.find(' '));
    const auto point = digits.find('.');
    stamps.push_back(std::stoll(digits.substr(0, point)) * 1'000'000 + std::stoll(digits.substr(point + 1, 6)));
  }
  return stamps;
}

/// Largest error of the motion since the first row.
void expectMotion(const std::filesystem::path& tum, double metres, double radians) {
  const Trajectory rows = readTrajectory(tum);
  double worst_metres = 0.0, worst_radians = 0.0;
  for (const StampedPose& row : rows) {
    const double seconds = toSeconds(row.stamp - fromMicroseconds(kStart));
    const Pose2 error = between(between(truthAt(0.0), truthAt(seconds)), between(rows.front().pose, row.pose));
    worst_metres = std::max(worst_metres, error.translation().norm());
    worst_radians = std::max(worst_radians, std::abs(error.theta));
  }
  EXPECT_LT(worst_metres, metres) << tum;
  EXPECT_LT(worst_radians, radians) << tum;
}

TEST(Replay, RecoversTheMotionThatTheWheelsMisjudge) {
  const Folder folder;
  writeDrive(folder / "drive.lcm", trueStamp);
  const ReplayStats stats = replay(driveConfig(), outputsIn(folder, "a"));
  EXPECT_EQ(stats.front_end.scans, 100U);
  EXPECT_NEAR(stats.log_s, kSeconds, 0.2);
  EXPECT_EQ(stats.rejected_messages, 0U);
  EXPECT_FALSE(stats.truncated);
  expectMotion(folder / "a.tum", 0.03, 0.01);
  expectMotion(folder / "a_causal.tum", 0.03, 0.01);
  expectMotion(folder / "a_odometry.tum", 0.30, 0.15);
}

TEST(Replay, DrawsTheWallsOfTheRoom) {
  const Folder folder;
  writeDrive(folder / "drive.lcm", trueStamp);
  replay(driveConfig(), outputsIn(folder, "a"));
  EXPECT_GT(std::filesystem::file_size(folder / "a.png"), 0U);
  const MapImage map = readMapFiles(folder / "a.yaml");
  const Pose2 T_map_room = readTrajectory(folder / "a.tum").front().pose * truthAt(0.0).inverse();
  const auto cellAt = [&](const Eigen::Vector2d& p_room, int by_column, int by_row) {
    const Eigen::Vector2d p = T_map_room * p_room;
    const int column = static_cast<int>(std::floor((p.x() - map.origin_x) / map.resolution)) + by_column;
    const int row = static_cast<int>(std::floor((p.y() - map.origin_y) / map.resolution)) + by_row;
    const bool inside = column >= 0 && row >= 0 && column < map.width && row < map.height;
    return inside ? map.at(column, row) : MapImage::kUnknown;
  };
  int walls = 0, drawn = 0;
  for (double along = -2.9; along < 1.4; along += 0.05) {
    for (const Eigen::Vector2d& p : {Eigen::Vector2d(along, -kHalfRoom), Eigen::Vector2d(along, kHalfRoom),
                                     Eigen::Vector2d(-kHalfRoom, along), Eigen::Vector2d(kHalfRoom, along)}) {
      bool occupied = false;
      for (int dc = -1; dc <= 1; ++dc) {
        for (int dr = -1; dr <= 1; ++dr) occupied |= cellAt(p, dc, dr) == MapImage::kOccupied;
      }
      ++walls;
      drawn += occupied;
    }
  }
  EXPECT_GT(drawn, 0.9 * walls);
  EXPECT_EQ(cellAt({0.0, 0.0}, 0, 0), MapImage::kFree);
  EXPECT_EQ(cellAt({2.6, 2.4}, 0, 0), MapImage::kUnknown) << "inside the block";
}

TEST(Replay, OfTheSameLogGivesTheSameBytes) {
  const Folder folder;
  writeDrive(folder / "drive.lcm", trueStamp);
  replay(driveConfig(), outputsIn(folder, "a"));
  replay(driveConfig(), outputsIn(folder, "b"));
  for (const char* end : {".tum", "_causal.tum", "_odometry.tum", ".csv", ".pgm", ".png"}) {
    EXPECT_TRUE(contentOf(folder / (std::string("a") + end)) == contentOf(folder / (std::string("b") + end))) << end;
  }
  std::string yaml = contentOf(folder / "b.yaml");
  yaml.at(yaml.find("b.pgm")) = 'a';
  EXPECT_EQ(contentOf(folder / "a.yaml"), yaml);
}

TEST(Replay, DrawsFramesByLogTimeAndOneAtTheEnd) {
  const Folder folder;
  writeDrive(folder / "drive.lcm", trueStamp);
  ReplayOptions options;
  options.logs = {folder / "drive.lcm"};
  options.viewer_period = 4.0;
  for (const char* name : {"a", "b"}) {
    options.viewer_frames = folder / name;
    replay(driveConfig(), options);
  }
  std::istringstream index(contentOf(folder / "a/index.csv"));
  std::vector<double> seconds;
  std::string line;
  std::getline(index, line);
  for (std::string name, second; std::getline(std::getline(index, name, ','), second, ','); std::getline(index, line)) {
    EXPECT_TRUE(contentOf(folder / ("a/" + name)) == contentOf(folder / ("b/" + name))) << name;
    seconds.push_back(std::stod(second));
  }
  EXPECT_THAT(seconds, testing::ElementsAre(testing::DoubleNear(0.08, 0.01), testing::DoubleNear(4.08, 0.1),
                                            testing::DoubleNear(8.08, 0.1), testing::DoubleNear(9.98, 0.01)));
  EXPECT_EQ(contentOf(folder / "a/index.csv"), contentOf(folder / "b/index.csv"));
  options.viewer_frames = folder / "drive.lcm";
  EXPECT_THROW(replay(driveConfig(), options), std::runtime_error) << "a file is in the way";
}

TEST(Replay, WritesARowAScanWithTheStampAsRecorded) {
  const Folder folder;
  const auto disturbed = [](int scan) {  // one stamp goes back, one repeats, one jumps ahead
    return trueStamp(scan) - (scan == 30) * 150'000 - (scan == 50) * 100'000 + (scan == 70) * 40'000;
  };
  writeDrive(folder / "drive.lcm", disturbed);
  replay(driveConfig(), outputsIn(folder, "a"));
  std::vector<std::int64_t> recorded_stamps;
  for (int scan = 0; scan < 100; ++scan) recorded_stamps.push_back(disturbed(scan));
  for (const char* end : {".tum", "_causal.tum", "_odometry.tum"}) {
    EXPECT_EQ(stampsOf(folder / (std::string("a") + end)), recorded_stamps) << end;
  }
}

/// The rows of --estimates, each by the columns' names.
std::vector<std::map<std::string, std::string>> estimatesIn(const std::filesystem::path& csv) {
  std::istringstream in(contentOf(csv));
  std::string line, field;
  std::vector<std::string> names;
  std::getline(in, line);
  for (std::istringstream columns(line); std::getline(columns, field, ',');) names.push_back(field);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(in, line)) {
    auto& row = rows.emplace_back();
    std::istringstream fields(line);
    for (const std::string& name : names) std::getline(fields, row[name], ',');
    EXPECT_TRUE(fields.eof()) << line;
  }
  return rows;
}

TEST(Replay, WritesAnEstimateAScanThatAgreesWithPosesAndOdometryAsKnown) {
  const Folder folder;
  const auto disturbed = [](int scan) {  // one stamp goes back, one jumps ahead, and some scans are copies
    return trueStamp(scan) - (scan == 30) * 150'000 + (scan == 70) * 40'000 - (scan == 50) * 99'000;
  };
  auto before = std::make_unique<LaserScan>();
  writeDrive(folder / "drive.lcm", disturbed, kSeconds, [&](int number, LaserScan& scan) {
    if (number == 50) scan = *before;
    if (number > 80) scan.size = 0;  // the lidar sees nothing any more
    *before = scan;
  });
  const ReplayStats stats = replay(driveConfig(), outputsIn(folder, "a"));
  EXPECT_EQ(stats.front_end.scans_repeated, 1U);
  const auto rows = estimatesIn(folder / "a.csv");
  std::istringstream causal(contentOf(folder / "a_causal.tum")), odometry(contentOf(folder / "a_odometry.tum"));
  ASSERT_EQ(rows.size(), 100U);
  std::map<std::string, int> states, statuses;
  for (const auto& row : rows) {
    const auto number = [&](const char* column) { return std::stod(row.at(column)); };
    const auto expectPose = [&](std::istream& tum, const std::string& prefix) {
      std::string t;
      double x, y, z, qx, qy, qz, qw;
      ASSERT_TRUE(tum >> t >> x >> y >> z >> qx >> qy >> qz >> qw);
      EXPECT_EQ(row.at("t"), t);
      EXPECT_NEAR(number((prefix + "x").c_str()), x, 1e-6) << t;
      EXPECT_NEAR(number((prefix + "y").c_str()), y, 1e-6) << t;
      EXPECT_NEAR(wrapAngle(number((prefix + "theta").c_str()) - 2.0 * std::atan2(qz, qw)), 0.0, 1e-8) << t;
    };
    expectPose(causal, "");
    expectPose(odometry, "odom_");
    Eigen::Matrix3d covariance;
    covariance << number("sxx"), number("sxy"), number("sxt"), number("sxy"), number("syy"), number("syt"),
        number("sxt"), number("syt"), number("stt");
    EXPECT_GT(covariance.llt().matrixL().toDenseMatrix().diagonal().minCoeff(), 0.0) << row.at("t");
    EXPECT_EQ(covariance.llt().info(), Eigen::Success) << row.at("t");
    EXPECT_LT(std::sqrt(std::max(covariance(0, 0), covariance(1, 1))), 0.2) << row.at("t");
    ++states[row.at("state")];
    ++statuses[row.at("status")];
    const bool sure = row.at("status") == "converged";
    EXPECT_TRUE(sure ? number("overlap") > 0.5 : number("overlap") == 0.0) << row.at("t");
  }
  EXPECT_THAT(states, testing::ElementsAre(testing::Pair("degraded", 9), testing::Pair("initialising", 1),
                                           testing::Pair("localised", 90)));
  EXPECT_THAT(statuses, testing::ElementsAre(testing::Pair("converged", 78), testing::Pair("none", 3),
                                             testing::Pair("too_few_pairs", 19)))
      << "none: the one before the first wheel sample, the first keyframe and the copy";
}

TEST(Replay, WarnsOfAStuckLidarAndBlamesNoOtherSensorForIt) {
  const Folder folder;
  constexpr int kFirstStuck = 40;
  constexpr double kLonger = 70.0;  // [s] enough for wheels and scans to contradict each other, were the scans believed
  for (const int kept : {kBeams, kBeams * 9 / 10}) {  // beams that show the same again and again
    auto shown = std::make_unique<LaserScan>();
    writeDrive(folder / "drive.lcm", trueStamp, kLonger, [&](int number, LaserScan& scan) {
      if (number < kFirstStuck) return;
      if (number == kFirstStuck) *shown = scan;
      for (int i = 0; i < kept; ++i) {
        const auto beam = static_cast<std::size_t>(i * 37 % kBeams);
        scan.storage[beam].range = shown->storage[beam].range;
      }
    });
    const ReplayStats stats = replay(driveConfig(), outputsIn(folder, "a"));
    EXPECT_GT(stats.front_end.scans_repeated, 640U) << kept;
    EXPECT_THAT(stats.warnings, testing::ElementsAre(testing::HasSubstr("the lidar was stuck"))) << kept;
    EXPECT_EQ(estimatesIn(folder / "a.csv").at(100).at("status"), "none");
  }
}

TEST(Replay, ReportsThatNearlyNothingMatched) {
  const Folder folder;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> anything(0.3F, 9.0F);
  for (const int good : {0, 5}) {  // scans before those of another lidar, or with other bearings
    writeDrive(folder / "drive.lcm", trueStamp, kSeconds, [&](int number, LaserScan& scan) {
      if (number < good) return;
      for (int i = 0; i < scan.size; ++i) scan.storage[static_cast<std::size_t>(i)].range = anything(random);
    });
    const ReplayStats stats = replay(driveConfig(), outputsIn(folder, "a"));
    const std::string words = good == 0 ? "no scan was matched" : " of 100 scans were matched; poses and map are not";
    EXPECT_THAT(stats.warnings, testing::Contains(testing::HasSubstr(words)));
    EXPECT_GT(stats.notMatched(), 80U);
  }
  writeDrive(folder / "drive.lcm", trueStamp);
  EXPECT_THAT(replay(driveConfig(), outputsIn(folder, "a")).warnings, testing::IsEmpty());
}

TEST(Replay, GoesOnBehindDamageAndCountsIt) {
  const Folder folder;
  writeDrive(folder / "drive.lcm", trueStamp);
  std::string bytes = contentOf(folder / "drive.lcm");
  bytes.insert(bytes.size() / 2, 5000, 'x');  // inside a scan
  bytes.resize(bytes.size() - 100);
  folder.write("drive.lcm", bytes);
  const ReplayStats stats = replay(driveConfig(), outputsIn(folder, "a"));
  EXPECT_GE(stats.front_end.scans, 97U);
  EXPECT_GE(stats.skipped_bytes, 5000U);
  EXPECT_TRUE(stats.truncated);
  expectMotion(folder / "a.tum", 0.03, 0.01);
}

TEST(Replay, WarnsOfSensorsThatContradictEachOther) {
  const Folder folder;
  writeDrive(folder / "drive.lcm", trueStamp);
  EXPECT_THAT(replay(driveConfig(), outputsIn(folder, "a")).warnings, testing::IsEmpty());
  Config wrong = driveConfig();
  wrong.front_end.lidar.upside_down = true;
  const ReplayStats stats = replay(wrong, outputsIn(folder, "a"));
  ASSERT_THAT(stats.warnings, testing::ElementsAre(testing::HasSubstr("upside down")));
  EXPECT_THAT(stats.json(), testing::HasSubstr("\"warnings\": [\"" + stats.warnings[0] + "\"]"));
}

TEST(Replay, WarnsOfDisturbancesOfASimulatedLogAndOfNothingElse) {
  const Folder folder;
  {
    test::RecordedDrive drive(test::hallWithPillars(), {-9.0, 0.5, 0.0});
    drive.run(1.0, {0, 0, 0});
    for (int i = 0; i < 6; ++i) {
      for (const double turn_rate : {0.8, -0.8, -0.8, 0.8}) drive.run(1.0, {0.4, 0, turn_rate});
      drive.run(3.0, {0.4, 0, 0});
    }
    drive.save(folder / "sound.lcm");
  }
  const auto warnings = [&](const Disturbance& disturbance) {
    disturbLog(folder / "sound.lcm", folder / "drive.lcm", disturbance);
    ReplayOptions options;
    options.logs = {folder / "drive.lcm"};
    return replay(driveConfig(), options).warnings;
  };
  using testing::ElementsAre;
  using testing::HasSubstr;
  EXPECT_THAT(warnings({}), testing::IsEmpty());
  EXPECT_THAT(warnings({.lidar = {.upside_down = true}}),
              ElementsAre(HasSubstr("lidar turns opposite to gyro and wheels")));
  EXPECT_THAT(warnings({.imu = {.down = true}}), ElementsAre(HasSubstr("the gyro turns opposite")));
  EXPECT_THAT(warnings({.wheels = {.swapped = true}}), ElementsAre(HasSubstr("left and right swapped")));
  EXPECT_THAT(warnings({.double_scans = true}), ElementsAre(HasSubstr("repeat the one before")));
  EXPECT_THAT(warnings({.time_backwards = true}), ElementsAre(HasSubstr("stamped before the one before")));
}

TEST(ReplayOfRecordedData, WarnsOfWhatIsWrongAndOfNothingElse) {
  SLAM_SKIP_WITHOUT(recorded("mbot/maebot_convex.lcm.gz"));
  const Folder folder;
  convertMbot(recorded("mbot/maebot_convex.lcm.gz"), folder / "sound.lcm");
  const Config config = loadConfig(std::filesystem::path(SLAMD_SOURCE_DIR) / "config/maebot.toml");
  const auto warnings = [&](const Disturbance& disturbance) {
    disturbLog(folder / "sound.lcm", folder / "drive.lcm", disturbance);
    ReplayOptions options;
    options.logs = {folder / "drive.lcm"};
    return replay(config, options).warnings;
  };
  using testing::ElementsAre;
  using testing::HasSubstr;
  EXPECT_THAT(warnings({}), testing::IsEmpty());
  EXPECT_THAT(warnings({.lidar = {.upside_down = true}}),
              ElementsAre(HasSubstr("lidar turns opposite to gyro and wheels")));
  EXPECT_THAT(warnings({.lidar = {.turned = true}}), ElementsAre(HasSubstr("lidar.yaw")));
  EXPECT_THAT(warnings({.imu = {.down = true}}), ElementsAre(HasSubstr("the gyro turns opposite")));
  EXPECT_THAT(warnings({.wheels = {.swapped = true}}), ElementsAre(HasSubstr("left and right swapped")));
  EXPECT_THAT(warnings({.wheels = {.backwards = true}}), ElementsAre(HasSubstr("count backwards")));
  EXPECT_THAT(warnings({.double_scans = true}), ElementsAre(HasSubstr("repeat the one before")));
  EXPECT_THAT(warnings({.time_backwards = true}), ElementsAre(HasSubstr("stamped before the one before")));
  EXPECT_THAT(warnings({.wheels = {.distance_scale = 1.0}}), ElementsAre(HasSubstr("base.wheel_radius")));
}

TEST(Replay, CountsMessagesThatDoNotDecode) {
  const Folder folder;
  {
    EventLogWriter log(folder / "drive.lcm");
    const std::vector<std::uint8_t> nonsense(34, 0x7F);
    for (const char* name : {channel::kScan, channel::kWheels, channel::kImu}) log.write(kStart, name, nonsense);
    log.write(kStart, "SOMETHING_ELSE", nonsense);
    log.writeMessage(kStart, channel::kScan, toMessage(LaserScan{}, kStart));
  }
  const ReplayStats stats = replay(driveConfig(), outputsIn(folder, "a"));
  EXPECT_EQ(stats.rejected_messages, 3U);
  EXPECT_EQ(stats.front_end.scans, 1U);
}

TEST(Replay, RefusesALogWithoutScansAndOutputsItCannotWrite) {
  const Folder folder;
  EXPECT_THROW(replay(driveConfig(), outputsIn(folder, "a")), std::runtime_error) << "no log";
  {
    EventLogWriter log(folder / "drive.lcm");
    log.writeMessage(kStart, channel::kWheels, toMessage(WheelSample{}, kStart));
  }
  EXPECT_THROW(replay(driveConfig(), outputsIn(folder, "a")), std::runtime_error) << "no scan";
  writeDrive(folder / "drive.lcm", trueStamp);
  ReplayOptions options;
  options.logs = {folder / "drive.lcm"};
  options.trajectory = "/dev/null/a.tum";
  EXPECT_THROW(replay(driveConfig(), options), std::runtime_error);
  options.trajectory.clear();
  options.estimates = "/dev/null/a.csv";
  EXPECT_THROW(replay(driveConfig(), options), std::runtime_error);
  options.estimates.clear();
  options.map = "/dev/null/a";
  EXPECT_THROW(replay(driveConfig(), options), std::runtime_error);
}

TEST(Replay, MakesTheFoldersOfItsOutputsAndRefusesOthersBeforeItReadsTheLog) {
  const Folder folder;
  writeDrive(folder / "drive.lcm", trueStamp);
  ReplayOptions options;
  options.logs = {folder / "drive.lcm"};
  options.map = folder / "out/of/the/way/room";
  options.trajectory = folder / "poses/a.tum";
  options.save_map = folder / "store/of/room";
  int read = 0;
  const auto count = [&](double, bool) { ++read; };
  replay(driveConfig(), options, count);
  EXPECT_GT(read, 0);
  EXPECT_EQ(readMapFiles(folder / "out/of/the/way/room.yaml").resolution, driveConfig().map.resolution);
  EXPECT_FALSE(contentOf(folder / "poses/a.tum").empty());
  EXPECT_EQ(MapStore::newest(folder / "store/of"), "room");
  read = 0;
  for (auto ReplayOptions::*output :
       {&ReplayOptions::map, &ReplayOptions::trajectory, &ReplayOptions::causal, &ReplayOptions::estimates,
        &ReplayOptions::odometry, &ReplayOptions::wheels, &ReplayOptions::save_map, &ReplayOptions::viewer_frames}) {
    ReplayOptions bad;
    bad.logs = options.logs;
    bad.*output = folder / "drive.lcm/a";
    EXPECT_NE(test::refusalOf([&] { replay(driveConfig(), bad, count); }), "");
    EXPECT_EQ(read, 0) << "hours of work would be lost";
  }
}

/// A map made by the drive, and options that begin in it.
ReplayOptions beginInMapOf(const Folder& folder, const std::string& name, double seconds = kSeconds) {
  writeDrive(folder / "drive.lcm", trueStamp, seconds);
  ReplayOptions first = outputsIn(folder, "first"), next = outputsIn(folder, name);
  first.save_map = next.load_map = folder / "maps/room";
  replay(driveConfig(), first);
  return next;
}

std::map<std::string, std::string> filesOf(const std::filesystem::path& path) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path)) {
    if (entry.is_regular_file()) files[entry.path()] = contentOf(entry.path());
  }
  return files;
}

TEST(Replay, FollowsTheRobotInAGivenMapAndLeavesTheMapAlone) {
  const Folder folder;
  const ReplayOptions options = beginInMapOf(folder, "second");
  const auto before = filesOf(folder / "maps");
  ASSERT_EQ(before.size(), 8U);
  Config config = driveConfig();
  config.mode = RunMode::kLocalise;
  replay(config, options);
  EXPECT_EQ(filesOf(folder / "maps"), before);
  const Trajectory first = readTrajectory(folder / "first.tum"), second = readTrajectory(folder / "second.tum");
  ASSERT_EQ(second.size(), first.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    worst = std::max(worst, between(first[i].pose, second[i].pose).translation().norm());
  }
  EXPECT_LT(worst, 0.03) << "in the map's own frame, from the first scan on";
  expectMotion(folder / "second.tum", 0.03, 0.02);
}

TEST(Replay, GoesOnInALoadedMap) {
  const Folder folder;
  ReplayOptions options = beginInMapOf(folder, "second", 2.0 * kSeconds);
  options.save_map = folder / "maps/longer";
  const ReplayStats stats = replay(driveConfig(), options);
  const MapState first = MapStore::load(folder / "maps", "room", {}).state;
  const MapState longer = MapStore::load(folder / "maps", "longer", {}).state;
  const int added = static_cast<int>(stats.front_end.keyframes);
  EXPECT_EQ(longer.keyframes.size(), first.keyframes.size() + added);
  EXPECT_LT(added, first.keyframes.size());
  EXPECT_THAT(longer.in_map, testing::Each(testing::Ne(0)));
  const Pose2 end = readTrajectory(folder / "first.tum").back().pose;
  EXPECT_LT(between(end, longer.T_map_base).translation().norm(), 0.03);
  options.load_map = options.save_map;  // and on
  options.save_map.clear();
  EXPECT_LT(replay(driveConfig(), options).front_end.keyframes, first.keyframes.size());
}

TEST(Replay, ChangesNoMapThatTheRobotHasHardlyDrivenIn) {
  const Folder folder;
  ReplayOptions options = beginInMapOf(folder, "second");
  options.save_map = folder / "maps/longer";
  const ReplayStats stats = replay(driveConfig(), options);
  EXPECT_GT(stats.front_end.keyframes, 0U);
  const MapState first = MapStore::load(folder / "maps", "room", {}).state;
  const MapState longer = MapStore::load(folder / "maps", "longer", {}).state;
  ASSERT_GT(longer.keyframes.size(), first.keyframes.size());
  for (int id = 0; id < longer.keyframes.size(); ++id) {
    const bool given = id < first.keyframes.size();
    EXPECT_EQ(longer.in_map[static_cast<std::size_t>(id)] != 0, given) << id;
    EXPECT_TRUE(!given || longer.keyframes.pose(id) == first.keyframes.pose(id)) << id;
  }
  for (const Edge& edge : longer.keyframes.graph().edges()) {
    const bool ties = edge.from < first.keyframes.size() && edge.to >= first.keyframes.size();
    EXPECT_TRUE(!ties || edge.revoked || edge.information.norm() < 1e-5);
  }
}

TEST(Replay, ReportsInOneLineWhatIsWrongWithAMap) {
  const Folder folder;
  ReplayOptions options = beginInMapOf(folder, "second");
  Config config = driveConfig();
  const auto refusal = [&] {
    const std::string text = test::refusalOf([&] { replay(config, options); });
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return text;
  };
  using testing::HasSubstr;
  const auto map = options.load_map;
  options.load_map = folder / "maps/missing";
  EXPECT_THAT(refusal(), HasSubstr("maps/missing: holds no map"));
  options.load_map = folder / "first.yaml";
  EXPECT_THAT(refusal(), HasSubstr("a picture of a map cannot be extended"));
  options.load_map = map;
  config.front_end.lidar.T_base_lidar.theta = 0.5;
  EXPECT_THAT(refusal(), HasSubstr("fix [lidar]"));
  config = driveConfig();
  options.load_map.clear();
  config.mode = RunMode::kLocalise;
  EXPECT_THAT(refusal(), HasSubstr("give --load-map"));
  config.mode = RunMode::kSlam;
  options.save_map = folder / "drive.lcm/map";
  EXPECT_NE(refusal(), "");
  options.save_map = folder / "maps/a name";
  EXPECT_THAT(refusal(), HasSubstr("is no name of a map"));
}

TEST(ReplayStats, NameEveryFieldOfTheContract) {
  const std::string json = ReplayStats{}.json();
  for (const char* key : {"scans", "keyframes", "loop_closures", "log_s", "wall_s", "cpu_s", "peak_rss_mb", "match_us",
                          "scan_us", "optimise_ms", "p50", "p99", "max", "warnings"}) {
    EXPECT_THAT(json, testing::HasSubstr('"' + std::string(key) + '"')) << key;
  }
  EXPECT_THAT(json, testing::Not(testing::HasSubstr("nan")));
}

TEST(ReplayStats, TakeQuantilesOfAllValues) {
  std::vector<double> values;
  for (int i = 100; i >= 1; --i) values.push_back(i);
  const Quantiles result = quantiles(values);
  EXPECT_NEAR(result.p50, 50.5, 0.5);
  EXPECT_NEAR(result.p99, 99.0, 1.0);
  EXPECT_EQ(result.max, 100.0);
  EXPECT_EQ(quantiles({}).max, 0.0);
}

TEST(ReplayOfRecordedData, MeetsTheRelationsOfIntel) {
  SLAM_SKIP_WITHOUT(recorded("intel/intel.clf.gz"));
  SLAM_SKIP_WITHOUT(recorded("intel/intel.relations"));
  const Folder folder;
  convertCarmen(recorded("intel/intel.clf.gz"), folder / "intel.lcm");
  ReplayOptions options;
  options.logs = {folder / "intel.lcm"};
  options.trajectory = folder / "intel.tum";
  const Config config = loadConfig(std::filesystem::path(SLAMD_SOURCE_DIR) / "config/carmen.toml");
  EXPECT_EQ(replay(config, options).front_end.scans, 5505U);
  EXPECT_EQ(stampsOf(folder / "intel.tum").size(), 5505U);
  const RelationErrors errors =
      relationErrors(readTrajectory(folder / "intel.tum"), readRelations(recorded("intel/intel.relations")));
  EXPECT_GE(errors.used, 1030);
  EXPECT_LE(errors.translation.mean, 0.0185) << "[m]; measured 0.0149";
  EXPECT_LE(errors.rotation.mean, 0.30) << "[deg]; measured 0.2595";
}

TEST(ReplayOfRecordedData, IsNotLedAstrayByVeryNoisyWheels) {
  SLAM_SKIP_WITHOUT(recorded("intel/intel.clf.gz"));
  SLAM_SKIP_WITHOUT(recorded("intel/intel.relations"));
  const Folder folder;
  convertCarmen(recorded("intel/intel.clf.gz"), folder / "intel.lcm");
  disturbLog(folder / "intel.lcm", folder / "noisy.lcm", {.wheels = {.noise = 0.4}, .seed = 1});
  const Config config = loadConfig(std::filesystem::path(SLAMD_SOURCE_DIR) / "config/carmen.toml");
  replay(config, {.logs = {folder / "noisy.lcm"}, .trajectory = folder / "noisy.tum"});
  const RelationErrors errors =
      relationErrors(readTrajectory(folder / "noisy.tum"), readRelations(recorded("intel/intel.relations")));
  EXPECT_LE(errors.translation.mean, 0.03) << "[m]";
  EXPECT_LE(errors.rotation.mean, 0.4) << "[deg]";
}

}  // namespace
}  // namespace slam::replay_test
