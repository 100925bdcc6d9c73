// SPDX-License-Identifier: BSD-3-Clause
// slamd as a user runs it, with a lidar of each family that it reads.
#include <chrono>
#include <cstdio>
#include <gtest/gtest.h>

#include "integration/live_faults.hpp"

namespace slam::live_lidars_test {
namespace {

using namespace std::chrono_literals;
using test::Clock;
using test::kPatience;

struct Cell {
  const char* name;
  const char* fault;
  const char* end;
  const char* words;
  const char* of_asked = words;  ///< of a lidar that is asked before its silence is named
};
constexpr Cell kCells[] = {{"pulled", "unplug 1", "unplug 0", "no such port"},
                           {"silent", "silent 1", "silent 0", "lidar: port present, but nothing comes", "no answer"},
                           {"noise", "garbage 1", "garbage 0", "lidar: bytes come, but no packet", "no answer"},
                           {"half a packet", "lose 3;insert 3;flip 3", "pause 1", ""}};

struct Lidar {
  const char* name;
  const char* driver;  ///< what lidar.driver is set to
};
void PrintTo(const Lidar& lidar, std::ostream* os) { *os << lidar.name; }

class LiveLidar : public test::LiveFaults, public testing::WithParamInterface<Lidar> {};
INSTANTIATE_TEST_SUITE_P(OfEachFamily, LiveLidar,
                         testing::Values(Lidar{"ld19", "ld19"}, Lidar{"ydlidar-x4", "ydlidar-x4"},
                                         Lidar{"hokuyo-urg", "hokuyo"}, Lidar{"stl19p", "auto"}),
                         [](const auto& device) { return test::nameOf(device.param.name); });

TEST_P(LiveLidar, DrivesAndItsFaultsAreNamed) {
  ASSERT_TRUE(listener_.good());
  const auto& [lidar, driver] = GetParam();
  startSimulator("600", "meeting-room", {"--speed", "0.3", "--lidar", lidar});
  startDaemon({std::string("lidar.driver='") + driver + "'", "imu.driver='hfi'", "depth.driver='none'"});
  ASSERT_TRUE(listener_.until([&] { return poseState() == kLocalised; }, kPatience * 20s)) << daemonLog();
  worstStateFor(12s);
  const std::size_t driven = poses_.size();
  for (const Cell& cell : kCells) {
    const auto begin = Clock::now();
    const std::string words = std::string_view(driver) == "hokuyo" ? cell.of_asked : cell.words;
    inject("lidar", cell.fault);
    EXPECT_TRUE(
        listener_.until([&] { return poseState(), summary().find(words) != std::string::npos; }, kPatience * 5s))
        << cell.name << ": " << summary();
    std::printf("%s, %s: named after %.2f s: %s\n", lidar, cell.name,
                std::chrono::duration<double>(Clock::now() - begin).count(), summary().c_str());
    inject("lidar", cell.end);
    EXPECT_TRUE(listener_.until([&] { return poseState() == kLocalised && isWell("lidar"); }, kPatience * 8s))
        << cell.name << ": " << summary();
  }
  worstStateFor(2s);
  const Trajectory truth = endDrive();
  const Compared calm = compare(truth, 0, driven, kLocalised), all = compare(truth, 0, poses_.size(), kLocalised);
  std::printf("%s: off by at most %.3f m in %d poses, with the faults %.3f m in %d\n", lidar, calm.worst, calm.poses,
              all.worst, all.poses);
  EXPECT_GT(calm.poses, 100);
  EXPECT_LT(calm.worst, 0.1) << "[m]";
  EXPECT_LT(all.worst, 0.1) << "[m]";
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(5s), 0) << daemonLog();
}

}  // namespace
}  // namespace slam::live_lidars_test
