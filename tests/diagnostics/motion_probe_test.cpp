// SPDX-License-Identifier: BSD-3-Clause
#include "diagnostics/motion_probe.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>

#include "support/allocations.hpp"
#include "support/simulated/robot.hpp"

namespace slam::motion_probe_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using enum SensorFault;

const test::Room kRoom{.length = 8.0, .width = 5.0, .range_sigma = 0.01};

/// A robot that drives bends in a room, and what may be wrong with it.
struct Drive {
  bool upside_down = false, turned = false, twice = false, frozen = false, gyro = true;
  double renewed = 0.0;         // [1] share of the beams that a frozen lidar measures anew
  bool also_localiser = false;  // the scans come as in slamd and slam-replay
  double wheel_turn = 1.0, turn_rate = 0.6;
  Duration copied_after{0};
  FrontEndConfig config = {};
  std::unique_ptr<MotionProbe> probe = {};
  std::unique_ptr<FrontEnd> front_end = {};
  test::SimulatedRobot robot{kRoom, {-1.0, -0.5, 0.0}};
  LaserScan seen = {};
  int stuck = 0;

  void run(double seconds) {
    if (!probe) probe = std::make_unique<MotionProbe>(config);
    if (also_localiser && !front_end) front_end = std::make_unique<FrontEnd>(config);
    robot.wheels.turn_scale = wheel_turn;
    robot.gyro.bias = 0.01;
    robot.lidar.every = 8;
    for (const Timestamp end = robot.now + fromSeconds(seconds); robot.now < end;) {
      const double rate = std::sin(toSeconds(robot.now.time_since_epoch())) > 0.0 ? turn_rate : -0.3 * turn_rate;
      robot.step({0.25, 0.0, rate}, *this);
    }
  }
  void add(const WheelSample& sample) {
    if (front_end) front_end->add(sample);
    probe->add(sample);
  }
  void add(const ImuSample& sample) {
    if (front_end) front_end->add(sample);
    if (gyro) probe->add(sample);
  }
  void add(LaserScan scan) {
    if (seen.size == 0 || !frozen) seen = scan;
    for (int i = 0; i < static_cast<int>(renewed * seen.size); ++i) {
      const auto beam = static_cast<std::size_t>(i * 37 % seen.size);
      seen.storage[beam] = scan.storage[beam];
    }
    scan.storage = seen.storage;
    for (int i = 0; i < scan.size; ++i) {
      float& bearing = scan.storage[static_cast<std::size_t>(i)].bearing;
      if (upside_down) bearing = -bearing;
      if (turned) bearing = static_cast<float>(wrapAngle(bearing + std::numbers::pi));
    }
    for (int copy = 0; copy < (twice ? 2 : 1); ++copy) {
      if (front_end) {
        const ScanOutcome outcome = front_end->add(scan);
        stuck += outcome.stuck;
        probe->add(outcome, Duration(0));
      } else {
        probe->add(scan);
      }
      probe->work();
      scan.stamp += copied_after;
    }
  }
  std::vector<SensorFault> faults(double seconds = 40.0) {
    run(seconds);
    std::vector<SensorFault> faults;
    for (const SensorFinding& finding : probe->findings().all()) faults.push_back(finding.fault);
    return faults;
  }
};

TEST(MotionProbe, ReportsNothingOfASoundRobot) {
  EXPECT_THAT(Drive{}.faults(), IsEmpty());
  EXPECT_THAT((Drive{.gyro = false}).faults(), IsEmpty());
}

TEST(MotionProbe, FindsALidarThatHangsTopDownAlsoInFastTurns) {
  EXPECT_THAT((Drive{.upside_down = true}).faults(), ElementsAre(kLidarUpsideDown));
  EXPECT_THAT((Drive{.upside_down = true, .turn_rate = 2.0}).faults(), ElementsAre(kLidarUpsideDown));
  EXPECT_THAT((Drive{.upside_down = true, .gyro = false}).faults(), ElementsAre(kLidarAgainstWheels));
  Drive known{.upside_down = true};
  known.config.lidar.upside_down = true;
  EXPECT_THAT(known.faults(), IsEmpty());
}

TEST(MotionProbe, FindsATurnedLidarAndSwappedWheels) {
  EXPECT_THAT((Drive{.turned = true, .turn_rate = 0.3}).faults(), ElementsAre(kLidarYawOff));
  EXPECT_THAT((Drive{.wheel_turn = -1.0}).faults(), ElementsAre(kWheelsSwapped));
}

TEST(MotionProbe, FindsScansThatComeTwice) {
  EXPECT_THAT((Drive{.twice = true}).faults(), ElementsAre(kScansRepeated));
  for (const Duration after : {Duration(2ms), Duration(60ms)}) {
    Drive drive{.twice = true, .copied_after = after};
    ASSERT_THAT(drive.faults(), ElementsAre(kScansRepeated));
    EXPECT_NEAR(drive.probe->findings().storage[0].value, 250, 2) << "all of them";
  }
}

TEST(MotionProbe, FindsALidarThatIsFrozenWhileTheRobotDrivesStraight) {
  EXPECT_THAT((Drive{.frozen = true, .turn_rate = 0.0}).faults(), testing::Contains(kScansRepeated));
}

TEST(MotionProbe, GetsNoScansOfAStuckLidarToBlameTheOthersFor) {
  // Some of its beams are measured anew, so that no two scans are the same to the last bit.
  EXPECT_THAT((Drive{.frozen = true, .renewed = 0.1}).faults(100.0), testing::Not(IsEmpty()))
      << "the scans show no motion";
  Drive drive{.frozen = true, .renewed = 0.1, .also_localiser = true};
  EXPECT_THAT(drive.faults(100.0), IsEmpty());
  EXPECT_GT(drive.stuck, 600) << "of 625 scans";
}

TEST(MotionProbe, GetsAllScansOfASoundLidar) {
  EXPECT_THAT((Drive{.also_localiser = true}).faults(), IsEmpty());
  EXPECT_THAT((Drive{.upside_down = true, .also_localiser = true}).faults(), ElementsAre(kLidarUpsideDown));
  EXPECT_THAT((Drive{.twice = true, .also_localiser = true}).faults(), ElementsAre(kScansRepeated)) << "copies, too";
}

TEST(MotionProbe, TakesEqualScansOfARobotAtRestForWhatTheyAre) {
  Drive drive;
  drive.run(1.0);
  LaserScan scan = kRoom.scan(drive.robot.truth, drive.robot.random);
  for (int i = 0; i < 100; ++i) {
    scan.stamp = drive.robot.now += 100ms;
    drive.probe->add(WheelSample{scan.stamp, drive.robot.wheels.pose});
    drive.probe->add(ImuSample{scan.stamp, {0, 0, 0.001}, {0, 0, 9.81}});
    drive.probe->add(scan);
  }
  EXPECT_EQ(drive.probe->findings().size, 0U);
}

TEST(MotionProbe, GoesOnAfterAClockWasSetBack) {
  Drive drive{.upside_down = true};
  drive.run(2.0);
  drive.robot.now -= 60s;
  EXPECT_THAT(drive.faults(), ElementsAre(kLidarUpsideDown, kTimeBackwards));
}

TEST(MotionProbe, DoesNotAllocateAfterStartUp) {
  Drive drive;
  drive.run(1.0);
  EXPECT_EQ(test::allocationsDuring([&] { drive.run(20.0); }), 0U);
}

}  // namespace
}  // namespace slam::motion_probe_test
