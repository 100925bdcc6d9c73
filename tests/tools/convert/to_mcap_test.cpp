// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tools/common/trajectory.hpp"
#include "tools/convert/bags/ros_source.hpp"
#include "tools/convert/formats.hpp"
#include "tools/files.hpp"
#include "tools/recorded_log.hpp"

namespace slam::to_mcap_test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr std::int64_t kBegin = 1'700'000'000'000'000;  // [us]
constexpr int kScans = 5;

scan_t scanAt(std::int64_t utime) {
  auto scan = std::make_unique<LaserScan>();
  scan->range_min = 0.1F;
  scan->range_max = 10.0F;
  scan->size = 3;
  scan->storage[0] = {.range = 2.0F, .bearing = 0.0F};
  scan->storage[1] = {.range = 1.0F, .bearing = static_cast<float>(std::numbers::pi / 2)};
  scan->storage[2] = {.range = 0.0F, .bearing = 1.0F};  // no return
  return toMessage(*scan, utime);
}

pose_estimate_t poseAt(std::int64_t utime, const Pose2& pose) {
  PoseEstimate estimate;
  estimate.T_map_base = pose;
  estimate.state = LocalisationState::kLocalised;
  return toMessage(estimate, utime, 1);
}

map_tile_t tileAt(std::int32_t column, std::int8_t cell) {
  map_tile_t tile{};
  tile.utime = kBegin;
  tile.map_id = 1;
  tile.column = column;
  tile.side = 2;
  tile.ncells = 4;
  tile.cells.assign(4, static_cast<std::uint8_t>(cell));
  return tile;
}

/// All messages of a file by topic.
std::map<std::string, std::vector<json>> messagesOf(const std::filesystem::path& file) {
  std::map<std::string, std::vector<json>> messages;
  const auto source = openMcap(file);
  for (RosMessage message; source->next(message);)
    messages[message.topic->name].push_back(json::parse(message.data.begin(), message.data.end()));
  EXPECT_EQ(source->damages(), 0) << source->firstDamage();
  return messages;
}

std::string decoded(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char digit : text) {
    if (digit == '=') break;
    bits = bits << 6 | static_cast<unsigned>(digits.find(digit));
    if ((count += 6) >= 8) bytes.push_back(static_cast<char>(bits >> (count -= 8) & 0xFF));
  }
  return bytes;
}

class ToMcap : public testing::Test {
 protected:
  void writeLog(bool poses) {
    EventLogWriter log(folder_ / "in.lcm");
    config_t config{};
    config.utime = kBegin;
    config.configuration = "[lidar]\nx = 0.2\nyaw = 1.5\nupside_down = true\n";
    log.writeMessage(kBegin, channel::kConfig, config);
    for (int i = 0; i < kScans; ++i) {
      const std::int64_t t = kBegin + 200'000 * i;
      log.writeMessage(t + 1000, channel::kScan, scanAt(t));
      if (poses) log.writeMessage(t + 2000, channel::kSlamPose, poseAt(t, {0.1 * i, 0.0, 0.5}));
      log.writeMessage(t + 3000, channel::kWheels, toMessage(WheelSample{fromMicroseconds(t), {0.1 * i, 0, 0}}, t));
      log.writeMessage(t + 3000, channel::kImu, toMessage(ImuSample{fromMicroseconds(t), {0, 0, 0.5}, {}}, t));
    }
    log.write(kBegin + 2'000'000, "CAMERA", std::vector<std::uint8_t>{1, 2, 3});
    log.write(kBegin + 2'000'000, channel::kScan, std::vector<std::uint8_t>{1, 2, 3});
  }
  test::Folder folder_;
};

TEST_F(ToMcap, HasScansAsPointsWithTheFramesThatPlaceThem) {
  writeLog(true);
  const Recording recording = convertToMcap(folder_ / "in.lcm", folder_ / "out.mcap", "");
  EXPECT_EQ(recording.scans, kScans);
  EXPECT_EQ(recording.rejected, 1);
  EXPECT_TRUE(recording.notes.empty());
  EXPECT_THAT(recording.unused, testing::ElementsAre(HasSubstr("CAMERA")));
  auto messages = messagesOf(folder_ / "out.mcap");
  ASSERT_EQ(messages["/scan"].size(), static_cast<std::size_t>(kScans));
  const json& scan = messages["/scan"][1];
  EXPECT_EQ(scan["timestamp"]["sec"], kBegin / 1'000'000);
  EXPECT_EQ(scan["timestamp"]["nsec"], 200'000'000);
  const std::string points = decoded(scan["data"].get<std::string>());
  ASSERT_EQ(points.size(), 2 * 16U);  // two returns
  float values[8];
  std::memcpy(values, points.data(), sizeof values);
  EXPECT_FLOAT_EQ(values[0], 2.0F);
  EXPECT_FLOAT_EQ(values[5], -1.0F);  // its bearings grow clockwise
  std::map<std::string, json> last;
  for (const json& transform : messages["/tf"]) last[transform["child_frame_id"].get<std::string>()] = transform;
  EXPECT_EQ(last["lidar"]["parent_frame_id"], "base");
  EXPECT_DOUBLE_EQ(last["lidar"]["translation"]["x"], 0.2);
  EXPECT_NEAR(last["lidar"]["rotation"]["z"], std::sin(0.75), 1e-6);
  EXPECT_EQ(last["base"]["parent_frame_id"], "map");
  EXPECT_NEAR(last["base"]["translation"]["x"], 0.4, 1e-9);
  EXPECT_EQ(messages["/wheels"].size(), static_cast<std::size_t>(kScans));
  EXPECT_EQ(messages["/imu"][0]["gyro"][2], 0.5);
  EXPECT_EQ(messages["/estimate"][0]["state"], 1);
}

TEST_F(ToMcap, TakesThePosesOfATrajectory) {
  writeLog(false);
  EXPECT_THAT(convertToMcap(folder_ / "in.lcm", folder_ / "out.mcap", "").notes,
              testing::ElementsAre(HasSubstr("no pose in it")));
  TrajectoryWriter poses(folder_ / "poses.tum");
  for (int i = 0; i < kScans; ++i) poses.write(kBegin + 200'000 * i, {0.3 * i, 1.0, 0.0});
  poses.close();
  EXPECT_TRUE(convertToMcap(folder_ / "in.lcm", folder_ / "out.mcap", folder_ / "poses.tum").notes.empty());
  double farthest = 0.0;
  const auto transforms = messagesOf(folder_ / "out.mcap")["/tf"];
  for (const json& transform : transforms) {
    if (transform["child_frame_id"] == "base") farthest = transform["translation"]["x"];
  }
  EXPECT_NEAR(farthest, 1.2, 1e-6);
}

TEST_F(ToMcap, HasTheMapAsOnePicture) {
  {
    EventLogWriter log(folder_ / "in.lcm");
    map_meta_t meta{};
    meta.utime = kBegin;
    meta.map_id = 1;
    meta.resolution = 0.05;
    meta.origin[0] = -1.0;
    meta.tile_side = 2;
    log.writeMessage(kBegin, channel::kMapMeta, meta);
    log.writeMessage(kBegin + 1, channel::kMapTile, tileAt(-1, 100));
    log.writeMessage(kBegin + 3'000'000, channel::kMapTile, tileAt(1, 0));
  }
  convertToMcap(folder_ / "in.lcm", folder_ / "out.mcap", "");
  const auto grids = messagesOf(folder_ / "out.mcap")["/map"];
  ASSERT_FALSE(grids.empty());
  const json& grid = grids.back();
  EXPECT_EQ(grid["column_count"], 6);
  EXPECT_DOUBLE_EQ(grid["pose"]["position"]["x"], -1.1);
  EXPECT_EQ(decoded(grid["data"].get<std::string>()), std::string("dd\xFF\xFF\0\0dd\xFF\xFF\0\0", 12));
}

TEST_F(ToMcap, RefusesALogWithoutAMessageOfSlamd) {
  {
    EventLogWriter log(folder_ / "in.lcm");
    log.write(kBegin, "OTHER", std::vector<std::uint8_t>{1});
  }
  EXPECT_THAT(test::refusalOf([&] { convertToMcap(folder_ / "in.lcm", folder_ / "out.mcap", ""); }),
              HasSubstr("no message of slamd"));
}

}  // namespace
}  // namespace slam::to_mcap_test
