// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/scan_interpreter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

namespace slam::scan_interpreter_test {
namespace {

TEST(ScanInterpreter, DistinguishesABeamThatSawNothingFromOneThatIsBlocked) {
  LidarModel lidar;
  lidar.mask = {{10.0, 20.0}};
  ScanInterpreter interpreter({}, lidar);
  LaserScan scan;
  scan.range_min = 0.15F;
  scan.range_max = 12.0F;
  constexpr float kDegree = std::numbers::pi_v<float> / 180.0F, kInfinite = std::numeric_limits<float>::infinity();
  int bearing = 0;
  for (const float range : {0.0F, 5.0F, 0.1F, 13.0F, kInfinite}) {
    scan.push({.range = range, .bearing = kDegree * static_cast<float>(bearing++)});
  }
  for (const float range : {0.0F, 5.0F}) scan.push({.range = range, .bearing = 15.0F * kDegree});  // masked

  const LaserScan& interpreted = interpreter.interpret(scan, {}, 0.0, EkfTimeline({}, {}));
  EXPECT_THAT(interpreter.open(), testing::ElementsAre(true, false, false, true, true, false, false));
  EXPECT_EQ(interpreted.beams()[1].range, 5.0F);
  EXPECT_EQ(interpreted.beams()[6].range, 0.0F) << "masked";
}

}  // namespace
}  // namespace slam::scan_interpreter_test
