// SPDX-License-Identifier: BSD-3-Clause
// slamd as a user runs it, with each base of the table; a navigation program drives the robot through slamd.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <slam/drive_t.hpp>
#include <thread>

#include "drivers/base/base_facts.hpp"
#include "drivers/speed_command.hpp"
#include "integration/live_faults.hpp"
#include "tools/sim/base/emulated_base.hpp"

namespace slam::live_bases_test {
namespace {

using namespace std::chrono_literals;
using test::kPatience;

class LiveBases : public test::LiveFaults {
 protected:
  /// Sends that twist at 20 Hz for so long. @return when it was sent last
  std::int64_t drive(const Twist2& twist, std::chrono::milliseconds time) {
    std::int64_t last = 0;
    for (const auto end = test::Clock::now() + time; test::Clock::now() < end;) {
      drive_t message{};
      message.utime = last = now();
      message.vx = twist.vx;
      message.omega = twist.omega;
      listener_.lcm().publish(channel::kDrive, &message);
      worstStateFor(50ms);
    }
    return last;
  }
  /// Starts a robot with that base, and slamd. @return whether slamd localises it
  bool begin(const std::string& base) {
    startSimulator("600", "meeting-room", {"--base", base, "--obey"});
    const sim::SimulatedGeometry geometry = sim::geometryOf(base);
    startDaemon({"base.driver='" + base + "'", "base.counts_per_turn=" + std::to_string(geometry.counts_per_turn),
                 "base.wheel_radius=" + std::to_string(geometry.base.wheel_radius),
                 "base.half_track=" + std::to_string(geometry.base.half_track), "base.speed_commands=true",
                 std::string("imu.driver='") + (findBase(base)->gyro ? "base" : "hfi") + "'", "depth.driver='none'"});
    return listener_.until([&] { return poseState() == kLocalised && isWell("base"); }, kPatience * 20s);
  }
  static std::int64_t now() {
    return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
        .count();
  }
  /// Farthest that the robot got from where it was at the first of two instants [us]. @return [m], [rad] as if metres
  static double moved(const Trajectory& truth, std::int64_t from, std::int64_t to) {
    const auto begin = poseAt(truth, Timestamp(Duration(1000 * from)));
    double farthest = begin ? 0.0 : 1e9;
    for (std::int64_t t = from; begin && t < to; t += 20000) {
      const auto at = poseAt(truth, Timestamp(Duration(1000 * t)));
      if (!at) continue;
      const Pose2 way = between(*begin, *at);
      farthest = std::max({farthest, std::hypot(way.x, way.y), std::abs(way.theta)});
    }
    return farthest;
  }
};

struct Cell {
  const char* name;
  const char* fault;
  const char* end;
  const char* words;
};
constexpr Cell kCells[] = {{"pulled", "unplug 1", "unplug 0", "no such port"},
                           {"silent", "silent 1", "silent 0", "base: the board does not answer"},
                           {"half a frame", "lose 3;insert 3;flip 3", "lose 0", ""},
                           {"lifted", "lifted 1", "lifted 0", "base: a wheel hangs in the air"}};

class EachLiveBase : public LiveBases, public testing::WithParamInterface<std::string> {};
INSTANTIATE_TEST_SUITE_P(OfTheTable, EachLiveBase, testing::ValuesIn([] {
                           std::vector<std::string> names = sim::baseNames();
                           std::erase(names, "handsfree");  // FaultMatrix.Board, Stop
                           return names;
                         }()),
                         [](const auto& device) { return device.param; });

TEST_P(EachLiveBase, DrivesAsCommandedAndStopsAndItsFaultsAreNamed) {
  ASSERT_TRUE(listener_.good());
  const std::string& base = GetParam();
  ASSERT_TRUE(begin(base)) << daemonLog();
  const std::int64_t idle = now();
  worstStateFor(3s);
  const std::int64_t driven = now();
  drive({.vx = 0.2}, 3s);
  drive({.omega = -0.8}, 4s);  // away from the wall, so that the robot has room
  drive({.vx = 0.2, .omega = 0.5}, 5s);
  drive({.vx = -0.2}, 2s);
  const std::int64_t end = drive({.vx = 0.2, .omega = -0.5}, 3s);
  worstStateFor(3s);
  const std::int64_t stood = now();
  const std::size_t calm = poses_.size();
  for (const Cell& cell : kCells) {
    const bool no_sensor = base == "text" || base == "roboclaw" || base == "opencr" || base == "vesc";
    if (std::string_view(cell.name) == "lifted" && no_sensor) continue;
    inject("board", cell.fault);
    EXPECT_TRUE(
        listener_.until([&] { return poseState(), summary().find(cell.words) != std::string::npos; }, kPatience * 5s))
        << cell.name << ": " << summary();
    std::printf("%s, %s: %s\n", base.c_str(), cell.name, summary().c_str());
    drive({.omega = 0.5}, 500ms);
    inject("board", cell.end);
    EXPECT_TRUE(listener_.until([&] { return poseState() == kLocalised && streams("base"); }, kPatience * 12s))
        << cell.name << ": " << summary();
    worstStateFor(700ms);           // it counts as put down
    drive({.omega = -0.5}, 500ms);  // a Create that was lifted drives by a new command
    EXPECT_TRUE(listener_.until([&] { return poseState() == kLocalised && isWell("base"); }, kPatience * 8s))
        << cell.name << ": " << summary();
  }
  drive({.vx = 0.2}, 1s);
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(5s), 0) << daemonLog();
  const std::int64_t over = now() + 300000;
  std::this_thread::sleep_for(1500ms);
  const std::int64_t last = now() - 100000;
  const Trajectory truth = endDrive();
  const Compared before = compare(truth, 0, calm, kLocalised), all = compare(truth, 0, poses_.size(), kLocalised);
  const auto runs_out = std::chrono::duration_cast<std::chrono::microseconds>(SpeedCommand::kLasts).count();
  std::printf("%s: off by at most %.3f m in %d poses, with the faults %.3f m in %d\n", base.c_str(), before.worst,
              before.poses, all.worst, all.poses);
  EXPECT_GT(before.poses, 100);
  constexpr double kOff = 0.15;  // [m] 0.01, and up to 0.06 where the gyro is pulled out with the wheels
  EXPECT_LT(before.worst, kOff);
  EXPECT_LT(all.worst, kOff);
  constexpr double kStands = 1e-9;  // [m], [rad] of rounding
  EXPECT_LT(moved(truth, idle, driven), kStands) << "nothing moves without a command";
  EXPECT_GT(moved(truth, driven, end), 0.3);
  EXPECT_LT(moved(truth, end + runs_out + 300000, stood), kStands)
      << "it stands within 0.3 s of the end of its command";
  EXPECT_LT(moved(truth, over, last), kStands) << "and when slamd has ended";
}

/// Those whose own time-out slamd sets, or relies upon.
class LiveBaseWithTimeOut : public LiveBases, public testing::WithParamInterface<std::string> {};
INSTANTIATE_TEST_SUITE_P(OfTheTable, LiveBaseWithTimeOut, testing::Values("roboclaw", "vesc"),
                         [](const auto& device) { return device.param; });

TEST_P(LiveBaseWithTimeOut, StandsByItselfWhenSlamdIsKilled) {
  ASSERT_TRUE(listener_.good());
  const std::string& base = GetParam();
  ASSERT_TRUE(begin(base)) << daemonLog();
  const std::int64_t begun = now(), driven = drive({.omega = 0.5}, 2s);
  slamd_->signal(SIGKILL);
  ASSERT_TRUE(slamd_->wait(5s));
  const std::int64_t stands = now() + static_cast<std::int64_t>(1e6 * (findBase(base)->stops_after + 0.3));
  listener_.listenFor(3s);
  const std::int64_t last = now() - 100000;
  const Trajectory truth = endDrive();
  constexpr double kStands = 1e-9;  // [m], [rad] of rounding
  EXPECT_GT(moved(truth, begun, driven), 0.3);
  EXPECT_GT(moved(truth, driven + 100000, stands), 0.02) << "nobody has stopped it at once";
  EXPECT_LT(moved(truth, stands, last), kStands);
}

}  // namespace
}  // namespace slam::live_bases_test
