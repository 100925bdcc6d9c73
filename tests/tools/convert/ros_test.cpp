// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "tools/bag_bytes.hpp"
#include "tools/convert/formats.hpp"
#include "tools/files.hpp"
#include "tools/recorded_log.hpp"

namespace slam::ros_test {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::int64_t kBegin = 1'700'000'000'000'000;
constexpr int kScans = 30;

enum class Kind { kBag, kBagBz2, kBagLz4, kMcap, kMcapLz4, kMcapZstd, kDb3, kDb3Definitions };

/// A drive: scans at 10 Hz, odometry and IMU at 20 Hz, frames.
struct Drive {
  std::vector<BagTopic> topics;
  std::vector<BagMessage> messages;
};

bool isCdr(Kind kind) { return kind >= Kind::kMcap; }

Drive drive(bool cdr) {
  const std::string msg = cdr ? "/msg/" : "/";
  Drive d;
  d.topics = {{"/scan", "sensor_msgs" + msg + "LaserScan", kScanDefinition},
              {"/odom", "nav_msgs" + msg + "Odometry"},
              {"/imu", "sensor_msgs" + msg + "Imu"},
              {"/tf_static", "tf2_msgs" + msg + "TFMessage"},
              {"/camera", "sensor_msgs" + msg + "Image"}};
  d.messages.push_back({3, kBegin, tfBytes(cdr, kBegin, "base_link", "mast", 0.1, 0.05, 0.0)});
  d.messages.push_back({3, kBegin, tfBytes(cdr, kBegin, "/mast", "laser", 0.2, 0.0, 1.5)});
  d.messages.push_back({3, kBegin, tfBytes(cdr, kBegin, "base_link", "imu", 0.0, 0.0, 0.0, M_PI)});
  for (int i = 0; i < kScans; ++i) {
    const std::int64_t us = kBegin + 100'000 * i;
    const float none = std::numeric_limits<float>::infinity();
    d.messages.push_back(
        {0, us + 2'000, scanBytes(cdr, us, {1.0F, none, 2.5F, 10.0F, 0.05F + 0.01F * static_cast<float>(i % 3)})});
    for (int k = 0; k < 2; ++k) {
      const std::int64_t at = us + 50'000 * k;
      d.messages.push_back({1, at + 1'000, odometryBytes(cdr, at, 0.01 * (2 * i + k), 0.002 * (2 * i + k))});
      d.messages.push_back({2, at + 1'000, imuBytes(cdr, at, 0.25)});
    }
    d.messages.push_back({4, us, "not to be read"});
  }
  return d;
}

std::filesystem::path write(const Folder& folder, Kind kind, const Drive& d, const std::string& name = "in") {
  switch (kind) {
    case Kind::kBag:
      return folder.write(name + ".bag", rosBag(d.topics, d.messages));
    case Kind::kBagBz2:
      return folder.write(name + ".bag", rosBag(d.topics, d.messages, 20, "bz2"));
    case Kind::kBagLz4:
      return folder.write(name + ".bag", rosBag(d.topics, d.messages, 20, "lz4"));
    case Kind::kMcap:
      return folder.write(name + ".mcap", mcapFile(d.topics, d.messages));
    case Kind::kMcapLz4:
      return folder.write(name + ".mcap", mcapFile(d.topics, d.messages, 20, "lz4"));
    case Kind::kMcapZstd:
      return folder.write(name + ".mcap", mcapFile(d.topics, d.messages, 20, "zstd"));
    default:
      writeDb3(folder / (name + ".db3"), d.topics, d.messages, kind == Kind::kDb3Definitions);
      return folder / (name + ".db3");
  }
}

class RosOfKind : public testing::TestWithParam<Kind> {
 protected:
  Recording convert(const std::filesystem::path& in, const RosOptions& options = {}) {
    return convertRos(in, folder_ / "out.lcm", options);
  }
  Log log() const { return readLog(folder_ / "out.lcm"); }
  const Folder folder_;
};

TEST_P(RosOfKind, GivesScansWheelsImuAndTheMount) {
  const Recording recording = convert(write(folder_, GetParam(), drive(isCdr(GetParam()))));
  EXPECT_EQ(recording.rejected, 0) << recording.first_rejection;
  EXPECT_EQ(recording.doubt(), "");
  const Log log = this->log();
  ASSERT_EQ(log.scans.size(), static_cast<std::size_t>(kScans));
  ASSERT_EQ(log.wheels.size(), 2U * kScans);
  ASSERT_EQ(log.imu_samples.size(), 2U * kScans);
  EXPECT_EQ(log.scan_utimes[3], kBegin + 300'000);
  EXPECT_EQ(log.scan_events[3], kBegin + 302'000);
  const auto beams = log.scans[0].beams();
  ASSERT_EQ(beams.size(), 5U);
  EXPECT_NEAR(beams[2].bearing, 0.0, 1e-6);
  EXPECT_NEAR(beams[4].time_offset, 0.004, 1e-6);
  const std::vector<bool> returns = {true, false, true, false, false};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(log.scans[0].isReturn(beams[i]), returns[i]) << i;
  EXPECT_NEAR(log.wheels[5].T_wheels_base.x, 0.05, 1e-9);
  EXPECT_NEAR(log.wheels[5].T_wheels_base.theta, 0.01, 1e-9);
  EXPECT_NEAR(log.imu_samples[0].gyro.z(), -0.25, 1e-9) << "upside down in tf";
  EXPECT_NEAR(log.imu_samples[0].accel.z(), -9.81, 1e-9);
  const Config config = configOf(recording);
  EXPECT_NEAR(config.front_end.lidar.T_base_lidar.x, 0.3, 1e-6);
  EXPECT_NEAR(config.front_end.lidar.T_base_lidar.y, 0.05, 1e-6);
  EXPECT_NEAR(config.front_end.lidar.T_base_lidar.theta, 1.5, 1e-6);
  EXPECT_FALSE(config.front_end.lidar.upside_down);
  EXPECT_NEAR(config.front_end.lidar.range_max, 10.0, 1e-6);
  EXPECT_EQ(config.imu_device.driver, ImuDriver::kLcm);
  EXPECT_THAT(reportText(recording, "out", true), HasSubstr("not used: /camera"));
}

TEST_P(RosOfKind, IsRecognisedByItsContent) {
  const auto file = write(folder_, GetParam(), drive(isCdr(GetParam())));
  std::filesystem::rename(file, folder_ / "drive");
  EXPECT_EQ(convertAny(folder_ / "drive", folder_ / "out.lcm").scans, kScans);
}

TEST_P(RosOfKind, UsesWhatIsThereOfATruncatedFile) {
  const auto file = write(folder_, GetParam(), drive(isCdr(GetParam())));
  std::filesystem::resize_file(file, std::filesystem::file_size(file) * 7 / 10);
  try {
    const Recording recording = convert(file);
    EXPECT_GT(recording.rejected, 0);
    EXPECT_NE(recording.first_rejection, "");
    EXPECT_GT(recording.scans, kScans / 4);
    EXPECT_LT(recording.scans, kScans);
  } catch (const std::runtime_error& error) {
    EXPECT_TRUE(GetParam() == Kind::kDb3 || GetParam() == Kind::kDb3Definitions) << error.what();
  }
}

TEST_P(RosOfKind, UsesTheRowsAroundADamage) {
  const auto file = write(folder_, GetParam(), drive(isCdr(GetParam())));
  std::string content = contentOf(file);
  for (std::size_t i = content.size() / 2; i < content.size() / 2 + 64; ++i) content[i] = '\xFF';
  std::ofstream(file, std::ios::binary) << content;
  const Recording recording = convert(file);
  EXPECT_EQ(recording.rejected > 0, !recording.first_rejection.empty());
  EXPECT_GE(recording.scans, kScans / 2);
  EXPECT_LE(recording.scans, kScans);
}

TEST_P(RosOfKind, IsReadWholeFromAFolderOfParts) {
  const Drive whole = drive(isCdr(GetParam()));
  std::filesystem::create_directories(folder_ / "split");
  for (std::size_t part = 0; part < 12; ++part) {
    Drive d{whole.topics, {}};
    for (std::size_t i = part; i < whole.messages.size(); i += 12) d.messages.push_back(whole.messages[i]);
    const auto file = write(folder_, GetParam(), d, "bag_" + std::to_string(part));
    std::filesystem::rename(file, folder_ / "split" / file.filename());
  }
  EXPECT_EQ(convert(folder_ / "split").scans, kScans);
  EXPECT_EQ(log().wheels.size(), 2U * kScans);
}

INSTANTIATE_TEST_SUITE_P(Bags, RosOfKind,
                         testing::Values(Kind::kBag, Kind::kBagBz2, Kind::kBagLz4, Kind::kMcap, Kind::kMcapLz4,
                                         Kind::kMcapZstd, Kind::kDb3, Kind::kDb3Definitions),
                         [](const auto& kind) { return "Kind" + std::to_string(static_cast<int>(kind.param)); });

class Ros : public testing::Test {
 protected:
  Recording convert(const Drive& d, const RosOptions& options = {}) {
    return convertRos(write(folder_, Kind::kBag, d), folder_ / "out.lcm", options);
  }
  const Folder folder_;
};

TEST_F(Ros, HasALidarUpsideDownFromTf) {
  Drive d = drive(false);
  d.messages[1].data = tfBytes(false, 0, "mast", "laser", 0.2, 0.0, 0.5, M_PI);
  const Config config = configOf(convert(d));
  EXPECT_TRUE(config.front_end.lidar.upside_down);
  EXPECT_NEAR(config.front_end.lidar.T_base_lidar.theta, 0.5, 1e-6);
}

TEST_F(Ros, TakesTheLidarThatIsAskedFor) {
  Drive d = drive(false);
  d.topics.push_back({"/scan_rear", "sensor_msgs/LaserScan"});
  for (int i = 0; i < 40; ++i) d.messages.push_back({5, kBegin + i, scanBytes(false, kBegin + 10'000 * i, {1, 2, 3})});
  const Recording front = convert(d);
  EXPECT_EQ(front.scans, kScans);
  EXPECT_THAT(reportText(front, "out", true), HasSubstr("--scan /scan_rear"));
  EXPECT_EQ(convert(d, {.scan = "/scan_rear"}).scans, 40);
  EXPECT_THAT(refusalOf([&] { convert(d, {.scan = "/nothing"}); }), HasSubstr("/scan /scan_rear"));
}

TEST_F(Ros, TakesAGreatestRangeThatIsNoneForNotGiven) {
  for (const float range_max : {0.0F, -1.0F, 0.1F, std::numeric_limits<float>::quiet_NaN()}) {
    Drive d = drive(false);
    int i = 0;
    for (BagMessage& message : d.messages) {
      const float none = std::numeric_limits<float>::infinity();
      const float wall = 3.0F + 0.1F * static_cast<float>(i % 7);
      if (message.topic == 0)
        message.data = scanBytes(false, kBegin + 100'000 * i++, {wall, none, 2.5F, 12.0F, 0.05F}, "laser", range_max);
    }
    const Recording recording = convert(d);
    EXPECT_EQ(recording.scans, kScans) << range_max;
    EXPECT_EQ(recording.rejected, 0) << recording.first_rejection;
    const Log log = readLog(folder_ / "out.lcm");
    const std::vector<bool> returns = {true, false, true, true, false};
    for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(log.scans[0].isReturn(log.scans[0].beams()[k]), returns[k]) << k;
    EXPECT_NEAR(configOf(recording).front_end.lidar.range_max, 12.01, 1e-6) << "what the scans show";
  }
}

/// Every other scan is of a second driver on the same topic, and some more are of the first.
Drive driveOfTwo(const std::string& other_frame, std::int64_t other_clock, const std::string& other_node = {}) {
  Drive d = drive(false);
  d.topics[0].node = "/lidar";
  d.topics.push_back({"/scan", "sensor_msgs/LaserScan", kScanDefinition, "*", other_node});
  for (int i = 0; i < kScans - 5; ++i) {
    const std::int64_t us = kBegin + 100'000 * i + 50'000;
    d.messages.push_back({other_node.empty() ? 0 : 5, us, scanBytes(false, us + other_clock, {7, 7, 7}, other_frame)});
  }
  std::sort(d.messages.begin(), d.messages.end(), [](const auto& a, const auto& b) { return a.us < b.us; });
  return d;
}

TEST_F(Ros, TakesOneOfTwoDriversOnATopicAndReportsIt) {
  const auto said = [&](const Drive& d) {
    const Recording recording = convert(d);
    EXPECT_EQ(recording.scans, kScans);
    EXPECT_EQ(recording.rejected, 0) << recording.first_rejection;
    const Log log = readLog(folder_ / "out.lcm");
    for (const LaserScan& scan : log.scans) EXPECT_EQ(scan.size, 5);
    EXPECT_EQ(log.scan_utimes.back(), kBegin + 100'000 * (kScans - 1));
    return reportText(recording, "out", true);
  };
  EXPECT_THAT(said(driveOfTwo("other", -900'000'000)), HasSubstr("left out: frame other, clock -900.0 s off, 25"));
  EXPECT_THAT(said(driveOfTwo("laser", 90'000'000)), HasSubstr("left out: frame laser, clock +90.0 s off, 25"));
  EXPECT_THAT(said(driveOfTwo("other", 0)), HasSubstr("left out: frame other, 25"));
  EXPECT_THAT(said(driveOfTwo("laser", 0, "/second")), HasSubstr("left out: frame laser, node /second, 25"));
}

TEST_F(Ros, KeepsTheScansOfADriverThatIsStartedAnew) {
  Drive d = drive(false);
  d.topics[0].node = "/lidar_1";
  d.topics.push_back({"/scan", "sensor_msgs/LaserScan", kScanDefinition, "*", "/lidar_2"});
  int i = 0;
  for (BagMessage& message : d.messages) {
    if (message.topic != 0 || ++i <= kScans / 3) continue;
    message.topic = 5;
    if (i > kScans / 2) message.data = scanBytes(false, message.us + 3'000'000, {1, 2, 3});  // its clock is set
  }
  const Recording recording = convert(d);
  EXPECT_EQ(recording.scans, kScans);
  EXPECT_THAT(recording.notes, testing::Not(testing::Contains(HasSubstr("drivers"))));
}

TEST_F(Ros, TakesTheTimeOfReceiptForStampsOfZero) {
  Drive d = drive(false);
  for (BagMessage& message : d.messages) {
    if (message.topic == 0) message.data = scanBytes(false, 0, {1, 2, 3});
  }
  const Recording recording = convert(d);
  EXPECT_EQ(recording.scans, kScans);
  EXPECT_EQ(readLog(folder_ / "out.lcm").scan_utimes[1], kBegin + 102'000);
  EXPECT_THAT(reportText(recording, "out", true), HasSubstr("no stamp"));
}

TEST_F(Ros, BringsSensorsOfOtherClocksToTheLidars) {
  Drive d = drive(false);
  for (BagMessage& message : d.messages) {
    if (message.topic == 2) message.data = imuBytes(false, message.us - kBegin + 5'000'000, 0.25);
  }
  EXPECT_EQ(convert(d).imu, 2 * kScans);
  const Log log = readLog(folder_ / "out.lcm");
  for (const ImuSample& sample : log.imu_samples) EXPECT_GE(toMicroseconds(sample.stamp), kBegin - 10'000);
}

TEST_F(Ros, RefusesAnUnknownDefinition) {
  Drive d = drive(false);
  std::string changed = kScanDefinition;
  changed.replace(changed.find("float32 range_min"), 7, "float64");
  d.topics[0].definition = changed;
  EXPECT_THAT(refusalOf([&] { convert(d); }), HasSubstr("float64 range_min where float32 range_min"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.lcm"));
  d.topics[0].definition = "std_msgs/Header header\nmy_msgs/Angles angles\n";
  EXPECT_THAT(refusalOf([&] { convert(d); }), HasSubstr("lacks my_msgs/Angles"));
  d = drive(false);
  d.topics[2].definition = "std_msgs/Header header\nfloat64 rate\n";
  EXPECT_THAT(convert(d).doubt(), HasSubstr("/imu"));
}

TEST_F(Ros, MakesOdometryOfTfAndOfJoints) {
  Drive d = drive(false);
  d.topics[1] = {"/tf", "tf/tfMessage"};
  for (BagMessage& message : d.messages) {
    if (message.topic == 1) {
      message.data =
          tfBytes(false, message.us, "odom", "base_link", 1e-6 * static_cast<double>(message.us - kBegin), 0, 0);
    }
  }
  EXPECT_EQ(convert(d).wheels, 2 * kScans);
  EXPECT_NEAR(readLog(folder_ / "out.lcm").wheels.back().T_wheels_base.x, 2.951, 1e-6);

  d = drive(false);
  d.topics[1] = {"/joint_states", "sensor_msgs/JointState"};
  for (BagMessage& message : d.messages) {
    if (message.topic == 1)
      message.data = jointBytes(false, message.us, 1e-6 * static_cast<double>(message.us - kBegin), 0);
  }
  const Recording recording = convert(d, {.wheel_radius = 0.1, .half_track = 0.2});
  EXPECT_EQ(recording.wheels, 2 * kScans);
  const Log log = readLog(folder_ / "out.lcm");
  ASSERT_EQ(log.angles.back().size(), 2U);
  EXPECT_NEAR(log.angles.back()[0], 2.951, 1e-9);
  EXPECT_NEAR(log.wheels.back().T_wheels_base.theta, -0.1 * 2.95 / 0.4, 1e-3);
  EXPECT_NEAR(configOf(recording).base_device.geometry.wheel_radius, 0.1, 1e-9);
}

TEST_F(Ros, CountsMessagesThatDoNotDecode) {
  Drive d = drive(false);
  int cut = 0, scan = 0;
  for (BagMessage& message : d.messages) {
    if (message.topic != 0 || scan++ % 3 == 0) continue;
    message.data.resize(message.data.size() - 3);
    ++cut;
  }
  const Recording recording = convert(d);
  EXPECT_EQ(recording.scans, kScans - cut);
  EXPECT_EQ(recording.rejected, cut);
  EXPECT_THAT(recording.doubt(), HasSubstr("only 10 of 30 rows of /scan"));
}

TEST_F(Ros, RefusesWhatIsNoBag) {
  for (const char* content : {"", "#ROSBAG V2.0\n", "\x89MCAP0\r\n", "SQLite format 3", "hello"}) {
    const auto file = folder_.write("bad", content);
    EXPECT_THROW(convertRos(file, folder_ / "out.lcm"), std::runtime_error) << content;
    EXPECT_THROW(convertAny(file, folder_ / "out.lcm"), std::runtime_error) << content;
  }
  EXPECT_THROW(convertRos(folder_ / "missing", folder_ / "out.lcm"), std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.lcm"));
}

}  // namespace
}  // namespace slam::ros_test
