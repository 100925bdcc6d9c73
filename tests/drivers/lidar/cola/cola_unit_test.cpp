// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/cola/cola_unit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdexcept>

#include "drivers/lidar/unit_rig.hpp"
#include "tools/sim/lidar/cola_emulator.hpp"
#include "tools/sim/lidar/scip_emulator.hpp"

namespace slam::cola_unit_test {
namespace {

using namespace std::chrono_literals;
using test::UnitRig;
using testing::HasSubstr;

const std::string kAddress = "tcp://192.168.0.1:2112";

const sim::ColaModel& modelOf(std::string_view name) {
  for (const sim::ColaModel& model : sim::colaModels()) {
    if (name == model.name) return model;
  }
  throw std::invalid_argument("no such model");
}

class Sick : public testing::TestWithParam<const char*> {
 protected:
  UnitRig rig_{std::make_unique<sim::ColaEmulator>(test::lidarRoom, modelOf(GetParam())),
               std::make_unique<ColaUnit>(RangeLimits{0.05F, 25.0F}, test::virtualNow), LineDevice::kUnknown, kAddress};
};

TEST_P(Sick, GivesWholeScansOfTheRoom) {
  const sim::ColaModel& model = modelOf(GetParam());
  ASSERT_TRUE(rig_.stream(10)) << rig_.words();
  EXPECT_EQ(rig_.words(), "");
  EXPECT_THAT(std::string(rig_.lidar.status().identity.load()), HasSubstr(model.identity));
  const double turn = 1.0 / model.turns_per_second;  // [s]
  for (std::size_t i = 0; i < rig_.scans.size(); ++i) {
    const LaserScan& scan = rig_.scans[i];
    ASSERT_EQ(scan.size, model.beams);
    EXPECT_EQ(test::wrongBeams(scan), 0);
    EXPECT_NEAR(scan.beams().front().bearing, -2.35619, 2e-4);
    EXPECT_NEAR(scan.beams().back().bearing, 2.35619, 2e-4);
    EXPECT_NEAR(scan.beams().back().time_offset, 0.75 * turn, 0.01 * turn);
    if (i == 0) continue;
    EXPECT_NEAR(toSeconds(scan.stamp - rig_.scans[i - 1].stamp), turn, 0.02 * turn);
  }
  EXPECT_EQ(rig_.lidar.status().rejects.load(), 0);
}

TEST_P(Sick, GoesOnWhileBytesAreLostInsertedAndFlipped) {
  ASSERT_TRUE(rig_.stream());
  for (const char* fault : {"lose", "insert", "flip", "checksum"}) {
    ASSERT_TRUE(rig_.emulator->inject(fault, 3.0));
    ASSERT_TRUE(rig_.collect(5)) << fault << ": " << rig_.words();
  }
  for (const LaserScan& scan : rig_.scans) EXPECT_EQ(scan.size, modelOf(GetParam()).beams);
}

TEST_P(Sick, IsNamedWhenItFallsSilentAndComesBack) {
  ASSERT_TRUE(rig_.stream());
  ASSERT_TRUE(rig_.emulator->inject("silent", 1.0));
  EXPECT_LT(rig_.pollUntilOver(), 3s);
  EXPECT_EQ(rig_.state(), DeviceState::kStale);
  EXPECT_THAT(rig_.words(), HasSubstr(kAddress + " takes the connection, but sends nothing"));
  ASSERT_TRUE(rig_.emulator->inject("silent", 0.0));
  EXPECT_TRUE(rig_.stream()) << rig_.words();
}

TEST_P(Sick, ReportsItsStateWhenItsScanStops) {
  ASSERT_TRUE(rig_.stream());
  ASSERT_TRUE(rig_.emulator->inject("stall", 1.0));
  ASSERT_TRUE(rig_.emulator->inject("health", 2.0));
  EXPECT_LT(rig_.pollUntilOver(), 2s);
  EXPECT_THAT(rig_.words(), HasSubstr("it reports: an error"));
  EXPECT_FALSE(rig_.connect());
  EXPECT_TRUE(rig_.lidar.status().problem().is(problem::kLidarNoScan)) << rig_.words();
}

TEST_P(Sick, WarnsOfItsWindow) {
  ASSERT_TRUE(rig_.emulator->inject("health", 1.0));
  ASSERT_TRUE(rig_.stream());
  EXPECT_TRUE(rig_.lidar.status().problem().is(problem::kLidarWarns)) << rig_.words();
}

TEST_P(Sick, NamesTheEndOfItsConnection) {
  ASSERT_TRUE(rig_.stream());
  rig_.line.unplug();
  EXPECT_LT(rig_.pollUntilOver(), 1s);
  EXPECT_EQ(rig_.state(), DeviceState::kAbsent);
  EXPECT_THAT(rig_.words(), HasSubstr("has closed the connection"));
}

INSTANTIATE_TEST_SUITE_P(Of, Sick, testing::Values("sick-tim", "sick-lms"),
                         [](const auto& test) { return std::string(test.param).substr(5); });

TEST(ColaUnit, DoesNotTakeAnotherLidarForItsOwn) {
  UnitRig rig(std::make_unique<sim::ScipEmulator>(test::lidarRoom, sim::scipModels()[1]),
              std::make_unique<ColaUnit>(RangeLimits{}, test::virtualNow), LineDevice::kUnknown, kAddress);
  EXPECT_FALSE(rig.connect());
  EXPECT_EQ(rig.state(), DeviceState::kFault);
  EXPECT_THAT(rig.words(), HasSubstr("check lidar.driver and lidar.port"));
}

}  // namespace
}  // namespace slam::cola_unit_test
