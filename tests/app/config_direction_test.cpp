// SPDX-License-Identifier: BSD-3-Clause
// In which direction the keys act that a sign could be wrong of: offsets of clocks, places and directions of sensors.
#include <cmath>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <vector>

#include "app/device_configs.hpp"
#include "app/recorded_drive.hpp"
#include "config/loader.hpp"
#include "drivers/can/can_wheels.hpp"
#include "mapping/map_files.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/files.hpp"
#include "tools/replay/replay.hpp"

namespace slam::config_direction_test {
namespace {

using test::Folder;
using test::RecordedDrive;

constexpr double kPi = std::numbers::pi;
const Pose2 kStart{-2.0, -0.3, 0.2};  // in the room

/// A bend through the furnished room, and what slam-replay makes of it.
class Drive {
 public:
  explicit Drive(const std::function<void(RecordedDrive&)>& disturb) {
    RecordedDrive drive(test::furnishedRoom(), kStart);
    drive.has_depth = true;
    disturb(drive);
    drive.run(1.2, {0, 0, 0});
    drive.run(3.0, {0.4, 0, 0.35});
    drive.run(2.0, {0.2, 0, -1.0});
    drive.save(folder_ / "drive.lcm");
  }
  struct Result {
    std::vector<Pose2> poses;
    MapImage map;
  };
  Result replayed(const std::vector<std::string>& settings) const {
    ReplayOptions options;
    options.logs = {folder_ / "drive.lcm"};
    options.causal = folder_ / "causal.tum";
    options.map = folder_ / "map";
    replay(parseConfig("", "given", settings), options);
    Result result;
    for (const StampedPose& row : readTrajectory(options.causal)) result.poses.push_back(row.pose);
    result.map = readMapFiles(folder_ / "map.yaml");
    return result;
  }

 private:
  Folder folder_;
};

/// Largest distance between poses of the same row [m].
double apart(const std::vector<Pose2>& a, const std::vector<Pose2>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const Pose2 error = between(a[i], b[i]);
    largest = std::max(largest, std::hypot(error.x, error.y) + std::abs(error.theta));
  }
  return largest;
}

/// Cells that differ.
int differing(const MapImage& a, const MapImage& b) {
  if (a.cells.size() != b.cells.size()) return static_cast<int>(std::max(a.cells.size(), b.cells.size()));
  int count = 0;
  for (std::size_t i = 0; i < a.cells.size(); ++i) count += a.cells[i] != b.cells[i];
  return count;
}

TEST(TimeOffset, IsAddedToTheStampsOfItsSensor) {
  const Drive::Result right = Drive([](RecordedDrive&) {}).replayed({});
  const auto expectMadeGood = [&](const char* key, const std::function<void(RecordedDrive&)>& late) {
    const Drive drive(late);  // its stamps are 40 ms too late
    EXPECT_LT(apart(drive.replayed({std::string(key) + "=-0.04"}).poses, right.poses), 1e-4) << key;
    EXPECT_GT(apart(drive.replayed({}).poses, right.poses), 1e-3) << key;
    EXPECT_GT(apart(drive.replayed({std::string(key) + "=0.04"}).poses, right.poses), 1e-3) << key;
  };
  expectMadeGood("lidar.time_offset", [](RecordedDrive& drive) { drive.lidar_error = 40'000; });
  expectMadeGood("base.time_offset", [](RecordedDrive& drive) { drive.wheel_error = 40'000; });
  expectMadeGood("imu.time_offset", [](RecordedDrive& drive) { drive.imu_error = 40'000; });
}

TEST(TimeOffset, OfTheLidarIsFoundWhileTheRobotTurns) {
  const auto swerving = [](std::int64_t late) {
    RecordedDrive drive(test::furnishedRoom(), kStart);
    drive.lidar_error = late;
    drive.run(2.0, {0, 0, 0});
    for (int i = 0; i < 6; ++i) drive.run(1.5, {0.2, 0, i % 2 == 0 ? 0.9 : -0.9});
    return drive;
  };
  const Folder folder;
  swerving(180'000).save(folder / "late.lcm");
  swerving(0).save(folder / "right.lcm");
  const auto lastPose = [&](const char* log) {
    ReplayOptions options;
    options.logs = {folder / log};
    options.causal = folder / "causal.tum";
    replay(parseConfig("", "given", {}), options);
    return readTrajectory(options.causal).back().pose;
  };
  const Pose2 error = between(lastPose("late.lcm"), lastPose("right.lcm"));
  EXPECT_LT(error.translation().norm(), 0.03);
  EXPECT_LT(std::abs(error.theta), 0.02);
}

TEST(TimeOffset, OfTheCameraPutsWhatItSawWhereTheRobotWas) {
  const Drive::Result right = Drive([](RecordedDrive&) {}).replayed({});
  const Drive drive([](RecordedDrive& late) { late.depth_error = 150'000; });
  EXPECT_LE(differing(drive.replayed({"depth.time_offset=-0.15"}).map, right.map), 5);
  EXPECT_GT(differing(drive.replayed({}).map, right.map), 50);
}

/// [1] share of the occupied cells further from anything in the room than a cell and its error.
double falseShare(const MapImage& map) {
  const test::Place room = test::furnishedRoom();
  int occupied = 0, wrong = 0;
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      if (map.at(column, row) != MapImage::kOccupied) continue;
      const Eigen::Vector2d at(map.origin_x + (column + 0.5) * map.resolution,
                               map.origin_y + (row + 0.5) * map.resolution);
      ++occupied;
      wrong += !room.world.occupied(kStart * at, 0.1, 0.3, 0.10);
    }
  }
  EXPECT_GT(occupied, 300);
  return static_cast<double>(wrong) / occupied;
}

TEST(DepthExtrinsicsKeys, PutWhatATurnedCameraSawOntoTheWalls) {
  const Drive drive([](RecordedDrive& turned) { turned.T_base_camera = {0.15, -0.25, 0.8}; });
  EXPECT_LT(falseShare(drive.replayed({"depth.x=0.15", "depth.y=-0.25", "depth.yaw=0.8"}).map), 0.01);
  for (const auto& wrong : std::vector<std::vector<std::string>>{{"depth.x=0.15", "depth.y=-0.25", "depth.yaw=-0.8"},
                                                                 {"depth.x=0.15", "depth.y=0.25", "depth.yaw=0.8"},
                                                                 {"depth.x=-0.15", "depth.y=-0.25", "depth.yaw=0.8"},
                                                                 {"depth.x=-0.25", "depth.y=0.15", "depth.yaw=0.8"},
                                                                 {}}) {
    EXPECT_GT(falseShare(drive.replayed(wrong).map), 0.05) << testing::PrintToString(wrong);
  }
}

TEST(ImuKeys, TurnTheUnitsAxesIntoTheBase) {
  using Vector = Eigen::Vector3d;
  const auto turned = [](double roll, double pitch, double yaw, const Vector& v) {
    ImuDeviceConfig imu;
    imu.roll = roll;
    imu.pitch = pitch;
    imu.yaw = yaw;
    const ImuSample sample = inBase(imuRotation(imu), {Timestamp{std::chrono::seconds(5)}, v, 2.0 * v});
    EXPECT_EQ(sample.stamp, Timestamp{std::chrono::seconds(5)});
    EXPECT_LT((sample.accel - 2.0 * sample.gyro).norm(), 1e-12) << "both turn alike";
    return sample.gyro;
  };
  const Vector ahead(1, 0, 0), left(0, 1, 0), up(0, 0, 1);
  EXPECT_LT((turned(kPi / 2, 0, 0, left) - up).norm(), 1e-12) << "right side down";
  EXPECT_LT((turned(0, kPi / 2, 0, ahead) + up).norm(), 1e-12) << "front down";
  EXPECT_LT((turned(0, 0, kPi / 2, ahead) - left).norm(), 1e-12) << "to the left";
  EXPECT_LT((turned(kPi / 2, 0, kPi / 2, left) - up).norm(), 1e-12) << "first rolled, then turned";
  EXPECT_LT((turned(kPi / 2, kPi / 2, 0, left) - ahead).norm(), 1e-12) << "first rolled, then pitched";
  EXPECT_LT((turned(0, kPi / 2, kPi / 2, ahead) + up).norm(), 1e-12) << "first pitched, then turned";
}

/// Angles of both wheels after one second at one turn of each encoder a second [rad].
std::array<double, 2> oneTurn(const std::vector<std::string>& settings) {
  CanWheels wheels(canBaseConfig(parseConfig("", "given", settings)).wheel);
  std::array<double, 2> first{}, last{};
  for (int i = 0; i <= 100; ++i) {
    const Timestamp now{std::chrono::milliseconds(1000 + 10 * i)};
    const can::odrive::EncoderEstimates estimates{0.01F * static_cast<float>(i), 1.0F};
    wheels.add(0, now, estimates);
    if (const auto pair = wheels.add(1, now, estimates)) {
      if (i == 0) first = pair->angles;
      last = pair->angles;
    }
  }
  return {last[0] - first[0], last[1] - first[1]};
}

TEST(CanKeys, ReverseOneWheelAloneAndTakeTheGearOff) {
  using testing::DoubleNear;
  using testing::ElementsAre;
  constexpr double kTurn = 2.0 * kPi;
  EXPECT_THAT(oneTurn({}), ElementsAre(DoubleNear(kTurn, 1e-3), DoubleNear(kTurn, 1e-3)));
  EXPECT_THAT(oneTurn({"can.right_reversed=true"}), ElementsAre(DoubleNear(kTurn, 1e-3), DoubleNear(-kTurn, 1e-3)));
  EXPECT_THAT(oneTurn({"can.left_reversed=true"}), ElementsAre(DoubleNear(-kTurn, 1e-3), DoubleNear(kTurn, 1e-3)));
  EXPECT_THAT(oneTurn({"can.gear_ratio=4.0"}), ElementsAre(DoubleNear(kTurn / 4, 1e-3), DoubleNear(kTurn / 4, 1e-3)));
}

TEST(RuntimeKeys, GiveEachThreadItsOwnRateAndPriority) {
  const Config config = parseConfig("", "given",
                                    {"runtime.base_priority=11", "runtime.lidar_priority=12",
                                     "runtime.depth_priority=13", "runtime.estimator_priority=14",
                                     "runtime.base_rate=301.0", "runtime.estimator_rate=402.0", "lcm.pose_rate=100.0"});
  EXPECT_EQ(baseWorker(config).priority, 11);
  EXPECT_EQ(lidarWorker(config).priority, 12);
  EXPECT_EQ(depthWorker(config).priority, 13);
  EXPECT_EQ(estimatorWorker(config).priority, 14);
  EXPECT_EQ(baseWorker(config).rate, 301.0);
  EXPECT_EQ(estimatorWorker(config).rate, 402.0);
  EXPECT_EQ(lidarWorker(config).rate, 0.0) << "it waits for its device";
  EXPECT_EQ(depthWorker(config).rate, 0.0);
  EXPECT_EQ(ticksPerPose(config), 4U);
  Config normal = config;
  normal.runtime.realtime = false;
  for (const WorkerConfig& worker :
       {baseWorker(normal), lidarWorker(normal), depthWorker(normal), estimatorWorker(normal)})
    EXPECT_EQ(worker.priority, 0) << worker.name;
}

TEST(DeviceKeys, ChooseTheRowOfAnImu) {
  for (const ImuFacts& facts : imuTable()) {
    const Config config =
        parseConfig("", "given", {std::string("imu.driver='") + facts.driver + "'", "imu.port='/dev/i'"});
    EXPECT_TRUE(config.imu_device.isSerial()) << facts.driver;
    EXPECT_EQ(serialImuConfig(config).facts, &facts);
    EXPECT_EQ(serialImuConfig(config).port, "/dev/i");
    EXPECT_EQ(serialImuConfig(config).baud, 0) << "its family's";
  }
  const Config chip = parseConfig("", "given", {"imu.driver='iio'", "imu.port='mpu6050'"});
  EXPECT_FALSE(chip.imu_device.isSerial());
  EXPECT_EQ(imuFacts(chip), nullptr);
  EXPECT_EQ(iioImuConfig(chip).device, "mpu6050");
}

TEST(DeviceKeys, ReachTheirDriversEachInItsPlace) {
  const Config config =
      parseConfig("", "given",
                  {"lidar.port='/dev/a'", "lidar.baud=256000", "lidar.range_min=0.25", "lidar.range_max=7.0",
                   "base.port='/dev/b'", "base.baud=57600", "base.wheel_radius=0.04", "base.half_track=0.21",
                   "base.mileage_rate=21.0", "base.imu_rate=31.0", "imu.port='/dev/c'", "imu.baud=9600",
                   "can.left_node=5", "can.right_node=6", "depth.width=320", "depth.height=240", "depth.rate=60"});
  const RplidarConfig lidar = rplidarConfig(config);
  EXPECT_EQ(serialLidarConfig(config).port, "/dev/a");
  EXPECT_EQ(serialLidarConfig(config).baud, 256000);
  EXPECT_EQ(lidar.baud, 256000);
  EXPECT_FLOAT_EQ(lidar.limits.min, 0.25F);
  EXPECT_FLOAT_EQ(lidar.limits.max, 7.0F);
  const HandsfreeConfig board = handsfreeConfig(config);
  EXPECT_EQ(board.port, "/dev/b");
  EXPECT_EQ(board.baud, 57600);
  EXPECT_EQ(board.wheel_radius, 0.04);
  EXPECT_EQ(board.body_radius, 0.21);
  EXPECT_EQ(board.mileage_rate, 21.0);
  EXPECT_EQ(board.imu_rate, 31.0);
  EXPECT_FALSE(board.may_drive) << "only where it is allowed";
  EXPECT_EQ(serialImuConfig(config).port, "/dev/c");
  EXPECT_EQ(serialImuConfig(config).baud, 9600);
  EXPECT_EQ(canBaseConfig(config).nodes, (std::array{5, 6}));
  EXPECT_FALSE(canBaseConfig(config).wheels || canBaseConfig(config).imu) << "neither is read from there";
  EXPECT_EQ(openniConfig(config).width, 320);
  EXPECT_EQ(openniConfig(config).height, 240);
  EXPECT_EQ(openniConfig(config).rate, 60);
}

TEST(BaseKeys, NameEachRowOfTheDriversTable) {
  std::size_t rows = 0;
  for (const char* word : kWords<BaseDriver>) {
    const Config config = parseConfig(
        "", "given", {std::string("base.driver='") + word + "'", "base.counts_per_turn=900.0", "imu.driver='none'"});
    const BaseFacts* facts = baseFacts(config);
    rows += facts != nullptr;
    const bool other = config.base_device.driver == BaseDriver::kHandsfree || !config.base_device.isSerial();
    EXPECT_EQ(facts == nullptr, other) << word;
    if (facts == nullptr) continue;
    EXPECT_EQ(serialBaseConfig(config).baud, facts->baud) << word;
    EXPECT_EQ(serialBaseConfig(config).robot.counts_per_turn, 900.0) << word;
    EXPECT_EQ(config.base_device.hasGyro(), facts->gyro) << word;
    EXPECT_EQ(config.base_device.needsCounts(), facts->counts_per_turn == 0.0) << word;
    EXPECT_FALSE(serialBaseConfig(config).robot.may_drive) << word << ": only where it is allowed";
  }
  EXPECT_EQ(rows, baseTable().size());
  EXPECT_EQ(handsfreeConfig(parseConfig("", "given", {})).baud, 921600);
  const Config kobuki =
      parseConfig("", "given", {"base.driver='kobuki'", "imu.driver='base'", "base.baud=9600", "base.port='/dev/k'"});
  EXPECT_EQ(serialBaseConfig(kobuki).robot.counts_per_turn, findBase("kobuki")->counts_per_turn);
  EXPECT_EQ(serialBaseConfig(kobuki).baud, 9600);
  EXPECT_EQ(serialBaseConfig(kobuki).port, "/dev/k");
  EXPECT_TRUE(serialBaseConfig(kobuki).gyro);
}

TEST(BaseKeys, AreRefusedWhereTheyDoNotFitTogether) {
  const auto refused = [](std::vector<std::string> settings, const char* words) {
    try {
      parseConfig("", "given", settings);
      ADD_FAILURE() << words;
    } catch (const std::exception& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  refused({"base.driver='text'", "imu.driver='none'"}, "base.counts_per_turn");
  refused({"base.driver='create'", "imu.driver='base'"}, "imu.driver");
  refused({"base.driver='kobuki'", "imu.driver='base'", "base.type='omni3'"}, "base.type");
  refused({"base.driver='kobuki'"}, "imu.driver");
  refused({"base.driver='roboclaw'", "imu.driver='none'"}, "base.counts_per_turn");
  refused({"base.driver='can'", "imu.driver='none'", "can.protocol='vesc'"}, "can.pole_pairs");
  refused({"base.driver='can'", "imu.driver='none'", "can.left_node=64"}, "can.left_node");
  parseConfig(
      "", "given",
      {"base.driver='can'", "imu.driver='none'", "can.protocol='vesc'", "can.pole_pairs=7", "can.left_node=64"});
}

TEST(LidarKeys, NameEachRowOfTheDriversTable) {
  std::size_t rows = 0;
  for (const char* word : kWords<LidarDriver>) {
    const Config config = parseConfig("", "given", {std::string("lidar.driver='") + word + "'"});
    const LidarFacts* facts = lidarFacts(config);
    rows += facts != nullptr;
    const LidarDriver driver = config.lidar_device.driver;
    const bool other = driver == LidarDriver::kRplidar || driver == LidarDriver::kHokuyo ||
                       driver == LidarDriver::kSick || config.lidar_device.isSearched() ||
                       !config.lidar_device.isRead();
    EXPECT_EQ(facts == nullptr, other) << word;
    if (facts == nullptr) continue;
    EXPECT_EQ(serialLidarConfig(config).baud, facts->baud) << word;
    EXPECT_EQ(packetLidarConfig(config).baud, facts->baud) << word;
    EXPECT_EQ(serialLidarConfig(config).line_device, facts->line_device) << word;
  }
  EXPECT_EQ(rows, lidarTable().size());
  for (const char* model : kWords<LdsModel>) {
    const Config config = parseConfig("", "given", {"lidar.driver='lds'", std::string("lidar.model='") + model + "'"});
    const bool is_auto = config.lidar_device.model == LdsModel::kAuto;
    EXPECT_EQ(config.lidar_device.isSearched(), is_auto) << model;
    ASSERT_EQ(lidarFacts(config) == nullptr, is_auto) << model;
    if (!is_auto) {
      EXPECT_STREQ(lidarFacts(config)->driver, model);
    }
  }
  EXPECT_THROW(parseConfig("", "given", {"lidar.driver='ld19'", "lidar.model='xv11'"}), ConfigError);
  EXPECT_EQ(serialLidarConfig(parseConfig("", "given", {})).baud, 115200) << "an RPLidar A1";
  const Config faster = parseConfig("", "given", {"lidar.driver='ld19'", "lidar.baud=115200"});
  EXPECT_EQ(packetLidarConfig(faster).baud, 115200) << "what is set goes before the model's own";
}

TEST(BaseKeys, NameTheChassisThatTheBoardHas) {
  using robolink::ChassisType;
  const auto chassis = [](const char* type) {
    return handsfreeConfig(parseConfig("", "given", {std::string("base.type='") + type + "'"})).chassis;
  };
  EXPECT_EQ(chassis("differential"), ChassisType::kDifferential2);
  EXPECT_EQ(chassis("omni3"), ChassisType::kOmni3);
  EXPECT_EQ(chassis("mecanum4"), ChassisType::kMecanum4);
}

}  // namespace
}  // namespace slam::config_direction_test
