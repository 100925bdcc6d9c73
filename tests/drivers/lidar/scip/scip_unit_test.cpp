// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/scip/scip_unit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <numbers>
#include <stdexcept>

#include "drivers/lidar/unit_rig.hpp"
#include "tools/sim/lidar/packet_emulator.hpp"
#include "tools/sim/lidar/scip_emulator.hpp"

namespace slam::scip_unit_test {
namespace {

using namespace std::chrono_literals;
using test::UnitRig;
using test::virtual_now;
using testing::AllOf;
using testing::HasSubstr;

const sim::ScipModel& modelOf(std::string_view name) {
  for (const sim::ScipModel& model : sim::scipModels()) {
    if (name == model.name) return model;
  }
  throw std::invalid_argument("no such model");
}

class Hokuyo : public testing::TestWithParam<const char*> {
 protected:
  UnitRig rig_{std::make_unique<sim::ScipEmulator>(test::lidarRoom, modelOf(GetParam())),
               std::make_unique<ScipUnit>(ScipConfig{.limits = {0.05F, 60.0F}}, test::virtualNow), LineDevice::kHokuyo};
};

TEST_P(Hokuyo, GivesWholeScansOfTheRoomAsSoonAsTheyAreMeasured) {
  const sim::ScipModel& model = modelOf(GetParam());
  ASSERT_TRUE(rig_.stream(10)) << rig_.words();
  EXPECT_EQ(rig_.words(), "");
  EXPECT_THAT(std::string(rig_.lidar.status().identity.load()),
              AllOf(HasSubstr(model.product), HasSubstr("serial number H0000001")));
  const double turn = 60.0 / model.turns_per_minute, step = turn / model.steps_per_turn;  // [s]
  for (std::size_t i = 0; i < rig_.scans.size(); ++i) {
    const LaserScan& scan = rig_.scans[i];
    ASSERT_EQ(scan.size, model.last - model.first + 1);
    EXPECT_EQ(test::wrongBeams(scan), 0);
    const double first = 2.0 * std::numbers::pi * (model.first - model.front) / model.steps_per_turn;
    EXPECT_NEAR(scan.beams().front().bearing, first, 2e-4);
    EXPECT_NEAR(scan.beams().back().time_offset, (scan.size - 1) * step, 0.01 * turn);
    EXPECT_FLOAT_EQ(scan.range_max, std::min(60.0F, 1e-3F * static_cast<float>(model.most_mm)));
    if (i == 0) continue;
    EXPECT_NEAR(toSeconds(scan.stamp - rig_.scans[i - 1].stamp), turn, 0.02 * turn);
  }
  const LaserScan& last = rig_.scans.back();
  EXPECT_LT(toSeconds(virtual_now - last.stamp) - last.beams().back().time_offset, 0.01) << "no turn is waited for";
  EXPECT_EQ(rig_.lidar.status().rejects.load(), 0);
}

TEST_P(Hokuyo, PlacesNoBeamWithoutEchoAnew) {
  ASSERT_TRUE(rig_.stream());
  ASSERT_TRUE(rig_.emulator->inject("echoes", 0.3));
  ASSERT_TRUE(rig_.collect(5));
  const LaserScan &whole = rig_.scans.front(), &holed = rig_.scans.back();
  ASSERT_EQ(whole.size, holed.size);
  for (std::size_t i = 0; i < whole.beams().size(); ++i)
    ASSERT_EQ(whole.beams()[i].bearing, holed.beams()[i].bearing) << i;
}

TEST_P(Hokuyo, GoesOnWhileBytesAreLostInsertedAndFlipped) {
  ASSERT_TRUE(rig_.stream());
  for (const char* fault : {"lose", "insert", "flip", "checksum"}) {
    ASSERT_TRUE(rig_.emulator->inject(fault, 3.0));
    ASSERT_TRUE(rig_.collect(5)) << fault << ": " << rig_.words();
    EXPECT_EQ(test::wrongBeams(rig_.scans.back()), 0);
  }
  EXPECT_GT(rig_.lidar.status().rejects.load(), 2);
}

TEST_P(Hokuyo, IsNamedWhenItFallsSilentAndComesBack) {
  ASSERT_TRUE(rig_.stream());
  ASSERT_TRUE(rig_.emulator->inject("silent", 1.0));
  EXPECT_LT(rig_.pollUntilOver(), 2s);
  EXPECT_EQ(rig_.state(), DeviceState::kStale);
  EXPECT_THAT(rig_.words(), HasSubstr("no answer"));
  EXPECT_FALSE(rig_.connect());
  ASSERT_TRUE(rig_.emulator->inject("silent", 0.0));
  EXPECT_TRUE(rig_.stream()) << rig_.words();
}

TEST_P(Hokuyo, ReportsItsStateWhenItsScanStops) {
  ASSERT_TRUE(rig_.stream());
  ASSERT_TRUE(rig_.emulator->inject("stall", 1.0));
  ASSERT_TRUE(rig_.emulator->inject("health", 2.0));
  EXPECT_LT(rig_.pollUntilOver(), 2s);
  EXPECT_THAT(rig_.words(), HasSubstr("it reports: Sensor stops working: laser is in trouble."));
  EXPECT_FALSE(rig_.connect());
  EXPECT_TRUE(rig_.lidar.status().problem().is(problem::kLidarNoScan)) << rig_.words();
}

TEST_P(Hokuyo, ScansAgainBehindARestart) {
  ASSERT_TRUE(rig_.stream());
  ASSERT_TRUE(rig_.emulator->inject("reboot", 1.0));
  EXPECT_LT(rig_.pollUntilOver(), 3s);
  bool again = false;
  for (int i = 0; i < 3 && !again; ++i) again = rig_.stream();
  EXPECT_TRUE(again) << rig_.words();
}

INSTANTIATE_TEST_SUITE_P(Of, Hokuyo, testing::Values("hokuyo-urg", "hokuyo-ust", "hokuyo-utm"),
                         [](const auto& test) { return std::string(test.param).substr(7); });

/// It answers each command with `answers[command]`, or not at all.
class Scripted : public sim::EmulatedLidar {
 public:
  explicit Scripted(std::map<std::string, std::string> answers) : answers_(std::move(answers)) {}
  void receive(std::span<const std::uint8_t> bytes, Timestamp, std::vector<std::uint8_t>& out) override {
    for (const std::uint8_t byte : bytes) {
      if (byte != '\n') {
        command_ += static_cast<char>(byte);
        continue;
      }
      const auto found = answers_.find(std::exchange(command_, {}));
      if (found != answers_.end()) out.insert(out.end(), found->second.begin(), found->second.end());
    }
  }
  void stream(Timestamp, std::vector<std::uint8_t>&) override {}
  bool inject(std::string_view, double) override { return false; }
  bool scanning() const override { return false; }

 private:
  std::map<std::string, std::string> answers_;
  std::string command_;
};

TEST(ScipUnit, RefusesAUnitWhoseParametersCannotBe) {
  UnitRig rig(std::make_unique<Scripted>(std::map<std::string, std::string>{
                  {"VV", "VV\n00P\nVEND:Hokuyo Automatic Co.,Ltd.;[\n\n"}, {"PP", "PP\n00P\nARES:0;O\n\n"}}),
              std::make_unique<ScipUnit>(ScipConfig{}, test::virtualNow), LineDevice::kHokuyo);
  EXPECT_FALSE(rig.connect());
  EXPECT_TRUE(rig.lidar.status().problem().is(problem::kLidarUnknown)) << rig.words();
}

TEST(ScipUnit, NamesTheNetworkWhereItIsThere) {
  UnitRig rig(std::make_unique<Scripted>(std::map<std::string, std::string>{}),
              std::make_unique<ScipUnit>(ScipConfig{}, test::virtualNow), LineDevice::kHokuyo,
              "tcp://192.168.0.10:10940");
  EXPECT_FALSE(rig.connect());
  EXPECT_THAT(rig.words(), AllOf(HasSubstr("tcp://192.168.0.10:10940 takes the connection"),
                                 HasSubstr("check lidar.driver and lidar.port")));
  rig.line.meanwhile = [&] { rig.line.unplug(); };
  EXPECT_FALSE(rig.connect());
  EXPECT_THAT(rig.words(), HasSubstr("has closed the connection"));
}

TEST(ScipUnit, NamesAnotherLidarInItsPlace) {
  UnitRig rig(std::make_unique<sim::PacketEmulator>(test::lidarRoom, "ld19"),
              std::make_unique<ScipUnit>(ScipConfig{}, test::virtualNow), LineDevice::kHokuyo);
  EXPECT_FALSE(rig.connect());
  EXPECT_THAT(rig.words(), AllOf(HasSubstr("LDROBOT"), HasSubstr("set lidar.driver")));
}

TEST(ScipUnit, GivesUpEarlyWhenCancelled) {
  UnitRig rig(std::make_unique<Scripted>(std::map<std::string, std::string>{}),
              std::make_unique<ScipUnit>(ScipConfig{}, test::virtualNow), LineDevice::kHokuyo);
  rig.line.meanwhile = [&, at = virtual_now + 150ms] {
    if (virtual_now > at) rig.cancel = true;
  };
  const Timestamp begin = virtual_now;
  EXPECT_FALSE(rig.connect());
  EXPECT_LT(virtual_now - begin, 500ms);
  EXPECT_EQ(rig.state(), DeviceState::kAbsent);
}

}  // namespace
}  // namespace slam::scip_unit_test
