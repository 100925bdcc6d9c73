// SPDX-License-Identifier: BSD-3-Clause
#include "integration/fault_matrix.hpp"

#include <algorithm>
#include <cstdio>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slam::test {

const std::vector<Row>& FaultMatrix::rows() {
  static const std::vector<Row> rows = {
      Row{"lidar",
          "lidar",
          {{"off", "unplug 1", "unplug 0", "no such port", kDegraded, 0.1,
            "goes on by wheels and IMU; opens the port again every second at most, spins the motor up, goes on"},
           {"stuck", "stuck 1", "stuck 0", "every turn shows the same ranges", kDegraded, 0.1,
            "leaves repeated turns out while wheels or gyro move: they would hold the robot in place", 1.3},
           {"garbage", "garbage 1", "garbage 0", "lidar: ", kDegraded, 0.1,
            "refuses and counts packets; stops the scan after half a second without a good one, asks the unit how it "
            "is, starts "
            "again"},
           {"wrong", "wrong 1.3", "wrong 1", "", kLost, 0.3,
            "scans that do not fit are not believed: degraded at once, lost when it lasts; no pose is published as "
            "valid; found "
            "again in the map",
            1.1, 0, 5.0, kDegraded},
           {"slow", "turn 400", "turn 182", "Hz where", kDegraded, 0.1,
            "each beam has its own time: a slow turn is only a rarer one", 2.6},
           {"crowded turns", "turn 600", "turn 182", "every second one is used", kDegraded, 0.1,
            "thins a turn with more measurements than a scan holds evenly, counts what it leaves out", 2.6},
           {"another unit", "unit 3", "unit 0", "RPLidar S3 (model 0x81), firmware 1.02", kDegraded, 0.1,
            "asks the unit again what it is and knows; compares firmware numbers within a series alone", 4.0},
           {"another make's", "other 1", "other 0", "a lidar of LDROBOT", kDegraded, 0.1,
            "knows it by its header; goes on by wheels and IMU; asks again every second at most", 4.0},
           {"delayed", "delay 300", "delay 0", "", kDegraded, 0.1,
            "cannot be told from a lidar that turned later; slam-replay tells a constant delay from a log"},
           {"intermittent", "pause 900", "pause 1", "lidar: ", kDegraded, 0.1, "as off: stops, asks, starts again", 1.1,
            2}}},
      Row{"depth",
          "depth",
          {{"off", "unplug 1", "unplug 0", "depth: ", kLocalised, 0.1,
            "the map goes on by the lidar; the camera is looked for every second at most, at once when the USB tells "
            "of it"},
           {"stuck", "stuck 1", "stuck 0", "every image is the same", kLocalised, 0.1,
            "leaves repeated images out while the robot moves"},
           {"garbage", "garbage 1", "garbage 0", "images are not used", kLocalised, 0.1,
            "images whose floor is not where it must be are refused and counted"},
           {"wrong", "wrong 1.3", "wrong 1", "images are not used", kLocalised, 0.1,
            "the same: depths that are off move the floor"},
           {"slow", "slow 10", "slow 1", "Hz where", kLocalised, 0.1, "uses what comes", 2.6},
           {"delayed", "delay 300", "delay 0", "", kLocalised, 0.1,
            "stamps by the camera's own clock and the least delay seen, so that late images are drawn where they were "
            "taken"},
           {"intermittent", "freeze 1", "freeze 0", "depth: ", kLocalised, 0.1,
            "opens a camera that is silent for 0.9 s anew", 1.1, 2}}},
      Row{"board",
          "base",
          {{"off", "unplug 1", "unplug 0", "no such port", kLocalised, 0.1,
            "scan matching alone, with the IMU where it is another's"},
           // The first match behind false zeros tells a speed five times the true one, for a scan and within its sigma.
           {"stuck", "stuck 1", "stuck 0", "renews nothing", kDegraded, 0.2,
            "the same: the board's time stands still, so wheels that stand are no news; degraded until that is known"},
           {"garbage", "garbage 1", "garbage 0", "cannot be read", kLocalised, 0.1,
            "refuses and counts frames, opens the port anew"},
           {"wrong", "wrong 1.5", "wrong 1", "", kLocalised, 0.1,
            "scans outweigh the wheels at once; that they count too much is said when enough of a drive shows it"},
           {"slow", "slow 150", "slow 0", "come too late", kLocalised, 0.1,
            "answers that come after the next request are not used: their age is not known"},
           {"delayed", "delay 60", "delay 0", "", kLocalised, 0.1,
            "stamps between request and answer; a lower rate is said"},
           {"intermittent", "silent 1", "silent 0", "does not answer", kLocalised, 0.1, "as off, each time", 1.1, 2}}},
      Row{"imu",
          "imu",
          {{"off", "unplug 1", "unplug 0", "no such port", kLocalised, 0.1, "the wheels give the turn rate"},
           {"stuck", "stuck 1", "stuck 0", "never change", kLocalised, 0.1, "leaves the values out"},
           {"garbage", "garbage 1", "garbage 0", "cannot be read", kLocalised, 0.1,
            "refuses and counts bytes, opens the port anew"},
           {"wrong", "wrong 3", "wrong 1", "", kLocalised, 0.1, "scans outweigh the gyro"},
           {"slow", "slow 20", "slow 1", "", kLocalised, 0.1, "uses what comes; the wheels bridge what is missing"},
           {"delayed", "delay 300", "delay 0", "", kLocalised, 0.1,
            "stamps by the least delay seen, as far as a jump lets it"},
           {"intermittent", "silent 1", "silent 0", "sends nothing", kLocalised, 0.1, "as off, each time", 1.1, 2}}},
      Row{"can",
          "base",
          {{"off", "silent 1", "silent 0", "no frames of the left wheel", kDegraded, 0.1,
            "scan matching alone; frames are used again as they come"},
           {"stuck", "stuck 1", "stuck 0", "its position never changes", kDegraded, 0.1,
            "leaves a position out that stands still while the drive reports speed"},
           {"garbage", "garbage 1", "garbage 0", "", kDegraded, 0.1,
            "refuses and counts frames of wrong length or impossible values; believes a wheel again after ten "
            "estimates in line"},
           {"wrong", "wrong 1.5", "wrong 1", "", kLocalised, 0.1, "as with the board: for the scans to outweigh"},
           {"slow", "slow 5", "slow 1", "", kLocalised, 0.1, "uses what comes; SLAM_HEALTH tells the rate"},
           {"delayed", "delay 300", "delay 0", "", kLocalised, 0.1,
            "the kernel's stamps are of the arrival; a constant delay is base.time_offset"},
           {"firmware 0.6", "firmware 0.6", "firmware 0.5", "", kLocalised, 0.1,
            "takes its procedure result for no error: tells versions apart by what only one sends, and by asking where "
            "it may send; else the axis error alone decides"},
           {"seldom", "estimates 200", "estimates 10", "every 200 ms", kLocalised, 0.1,
            "pairs the wheels by the period that it learns, and names the setting", 2.1},
           {"intermittent", "bus_off 1", "bus_off 0", "bus-off", kDegraded, 0.1,
            "waits for the controller's restart, goes on with the same socket"}}},
      Row{"can",
          "imu",
          {{"no acceleration", "imu_acceleration 0", "imu_acceleration 1", "no acceleration", kLocalised, 0.1,
            "uses the turn rates alone"},
           {"no sample time", "imu_time 0", "imu_time 1", "no sample time", kLocalised, 0.1,
            "stamps the turn rates by their arrival"},
           {"mixed rates", "imu_acceleration 4", "imu_acceleration 1", "fewer accelerations", kLocalised, 0.1,
            "uses each turn rate", 2.6}}},
      Row{"network",
          "system",
          {Cell{.fault = "no route",
                .inject = "no_route 1",
                .heal = "no_route 0",
                .words = "LCM: no multicast route",
                .pose = kLocalised,
                .error = 0.1,
                .meaning = "pose, map and store go on; the local socket takes commands; sends again by itself",
                .notice = 4.0,
                .recovery = "LCM messages are sent again"},
           Cell{.fault = "second publisher",
                .inject = "rival 1",
                .heal = "rival 0",
                .words = "another program publishes SLAM_POSE",
                .pose = kLocalised,
                .error = 0.1,
                .meaning = "goes on, and names it; so does the other slamd",
                .notice = 2.1,
                .recovery = "SLAM_POSE is ours alone again"}}},
      Row{"clock",
          "system",
          {Cell{.fault = "set ahead by a day",
                .inject = "set 86400",
                .heal = "",
                .words = "the wall clock was set ahead by 86400 s",
                .pose = kLocalised,
                .error = 0.1,
                .meaning = "stamps of messages follow the clock at once, those of logs go on without the step",
                .notice = 1.1},
           Cell{.fault = "set back by a minute",
                .inject = "set -60",
                .heal = "set 60",
                .words = "the wall clock was set back",
                .pose = kLocalised,
                .error = 0.1,
                .meaning = "stamps go on, for they never go back; says so until the clock has reached them",
                .notice = 1.1,
                .recovery = "the wall clock has reached the stamps"}}},
      Row{"disk",
          "system",
          {Cell{.fault = "full",
                .inject = "full 1",
                .heal = "full 0",
                .words = "no space on",
                .pose = kLocalised,
                .error = 0.1,
                .meaning = "the map stays in memory and is written when there is room; what is lost at the end is said",
                .notice = 20.0,
                .recovery = "map: the disk takes it again"},
           Cell{.fault = "read-only after errors",
                .inject = "read_only 1",
                .heal = "read_only 0",
                .words = "is read-only",
                .pose = kLocalised,
                .error = 0.1,
                .meaning = "the same",
                .notice = 20.0,
                .recovery = "map: the disk takes it again"},
           Cell{.fault = "gone and back",
                .inject = "gone 1",
                .heal = "gone 0",
                .words = "map not written since",
                .pose = kLocalised,
                .error = 0.1,
                .meaning = "the same; goes on in the same map",
                .notice = 20.0,
                .recovery = "map: the disk takes it again"},
           Cell{.fault = "hangs",
                .inject = "hang 1",
                .heal = "hang 0",
                .words = "map: the disk does not answer",
                .pose = kLocalised,
                .error = 0.1,
                .meaning = "no thread of the pose waits; what is new is written when it answers",
                .notice = 20.0,
                .recovery = "map: the disk answers again"}}}};
  return rows;
}

void FaultMatrix::runCell(const Row& row, const Cell& cell) {
  constexpr double kBusy = 0.7;  // [1] of a core: slamd needs a tenth of it, a thread that spins all
  const auto allIsWell = [&] { return poseState() == kLocalised && isWell(row.status); };
  ASSERT_TRUE(listener_.until(allIsWell, 20s)) << summary() << "\n" << daemonLog();
  const auto rejects_before = device(row.status)->rejects;
  lidar_ailed_ = false;

  inject(row.device, cell.inject);
  const auto begin = Clock::now();
  const std::string words = cell.words;
  const auto own = [&] {  // what is said of this device, as far as the next one's
    const std::string text = summary(), name = std::string("; ") + row.status + ": ";
    return text.substr(std::min(text.find(name), text.size()));
  };
  std::string text;
  const bool said =
      words.empty() || listener_.until([&] { return poseState(), (text = own()).find(words) != text.npos; }, 4s);
  const double noticed = std::chrono::duration<double>(Clock::now() - begin).count();
  EXPECT_TRUE(said) << summary();
  EXPECT_LT(noticed, cell.notice) << summary();
  if (!words.empty()) {
    EXPECT_THAT(text, testing::ContainsRegex(kConsequence));
    EXPECT_THAT(text, testing::ContainsRegex(kFix));
  }
  int worst = worstStateFor(std::chrono::milliseconds(static_cast<int>(1000 * cell.seconds)));
  EXPECT_GE(worst, cell.at_least) << summary();
  EXPECT_LT(listener_.last<health_t>(channel::kHealth)->cpu, kBusy) << "a thread spins";
  for (int i = 0; i < cell.repeats; ++i) {  // on and off, and on again
    inject(row.device, cell.heal);
    worst = std::max(worst, worstStateFor(700ms));
    inject(row.device, cell.inject);
    worst = std::max(worst, worstStateFor(700ms));
  }
  EXPECT_EQ(simulatorLog().find("no fault"), std::string::npos) << simulatorLog();
  std::printf("%-6s %-12s noticed after %.1f s, pose state %d, rejected %lld: %s\n", row.device, cell.fault, noticed,
              worst, static_cast<long long>(device(row.status)->rejects - rejects_before), summary().c_str());

  inject(row.device, cell.heal);
  const auto healed = Clock::now();
  const auto since = [&] { return std::chrono::duration<double>(Clock::now() - healed).count(); };
  EXPECT_TRUE(listener_.until([&] { return poseState(), streams(row.status); }, 5s)) << summary();
  const double streaming = since();
  EXPECT_LT(streaming, 3.1) << "[s] until it streams again, and says so";
  const bool well = listener_.until(allIsWell, 20s);
  std::printf("       streams again after %.1f s, well after %.1f s\n", streaming, since());
  EXPECT_TRUE(well) << summary() << "\n" << daemonLog();
  // A machine with too much to do starves the simulated lidar, too, and then the pose is right to be degraded.
  EXPECT_LE(worst, lidar_ailed_ ? std::max<int>(cell.pose, kDegraded) : cell.pose) << summary();
}

void FaultMatrix::run(const Row& row) {
  std::vector<std::size_t> begins;  // among the poses, of each cell
  for (const Cell& cell : row.cells) {
    SCOPED_TRACE(std::string(row.device) + " " + cell.fault);
    begins.push_back(poses_.size());
    ASSERT_NO_FATAL_FAILURE(runCell(row, cell));
  }
  begins.push_back(poses_.size());
  const Trajectory truth = endDrive();
  for (std::size_t i = 0; i < row.cells.size(); ++i) {
    const Cell& cell = row.cells[i];
    const Compared localised = compare(truth, begins[i], begins[i + 1], kLocalised);
    const Compared degraded = compare(truth, begins[i], begins[i + 1], kDegraded);
    std::printf("%-6s %-12s off by at most %.3f m in %d poses localised, %.3f m in %d degraded\n", row.device,
                cell.fault, localised.worst, localised.poses, degraded.worst, degraded.poses);
    EXPECT_LT(localised.worst, cell.error) << row.device << " " << cell.fault;
    EXPECT_GT(localised.poses, 5) << row.device << " " << cell.fault;
  }
}

}  // namespace slam::test
