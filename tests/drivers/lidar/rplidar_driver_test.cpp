// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "drivers/lidar/lidar_line.hpp"
#include "drivers/lidar/rplidar.hpp"

namespace slam::rplidar_driver_test {
namespace {

using namespace rplidar;
using std::chrono::milliseconds;
using test::virtual_now;

class RplidarDriverTest : public testing::Test {
 protected:
  /// An A1 without a list of modes, unless it is another unit.
  void start(const sim::LidarIdentity& unit = sim::a1Firmware122(),
             rplidar::ModeWish mode = rplidar::ModeWish::kDensest) {
    lidar_ = std::make_unique<test::VirtualLidar>(unit);
    driver_ = std::make_unique<test::Rplidar>(
        "", RplidarConfig{.scan_mode = mode, .limits = {0.2F, 9.0F}}, test::virtualNow,
        [this](const LaserScan& scan) {
          scans_.push_back(scan);
          arrivals_.push_back(virtual_now);
        },
        lidar_->line().opener());
  }
  bool connect() { return driver_->connect(cancel_); }
  std::string reason() { return driver_->status().problem().words(); }
  DeviceState state() { return driver_->status().state.load(); }

  /// Polls until so many scans have come. @return false when the connection or the patience ended first
  bool collect(std::size_t count) {
    const Timestamp deadline = virtual_now + std::chrono::seconds(20);
    while (scans_.size() < count) {
      if (!driver_->poll(milliseconds(50)) || virtual_now > deadline) return false;
    }
    return true;
  }
  /// Polls until poll() says that the connection is over.
  bool pollUntilOver() {
    const Timestamp deadline = virtual_now + std::chrono::seconds(20);
    while (driver_->poll(milliseconds(50))) {
      if (virtual_now > deadline) return false;
    }
    return true;
  }

  /// Whole turns with the right walls, whose beams lie one sample apart and were stamped shortly before they came.
  void expectRightGeometry(double sample_time) {
    for (std::size_t n = 0; n < scans_.size(); ++n) {
      const LaserScan& scan = scans_[n];
      EXPECT_NEAR(scan.size, 1.0 / (test::kLidarTurns * sample_time), 2);
      EXPECT_EQ(scan.range_min, 0.2F);
      EXPECT_EQ(scan.range_max, 9.0F);
      int wrong = 0;
      for (const Beam& beam : scan.beams()) {
        const double corner = std::abs(std::abs(beam.bearing) - 1.57);  // [rad]
        wrong += corner > 0.02 && std::abs(beam.range - test::lidarRoom({}, beam.bearing)) > 0.002;
      }
      EXPECT_EQ(wrong, 0);
      if (scan.size < 2) continue;
      const double turn = (scan.size - 1) * sample_time;
      EXPECT_NEAR(scan.beams().front().time_offset, 0.0, 1e-6);
      EXPECT_NEAR(scan.beams().back().time_offset, turn, 0.001);
      EXPECT_TRUE(std::is_sorted(scan.beams().begin(), scan.beams().end(),
                                 [](const Beam& a, const Beam& b) { return a.time_offset < b.time_offset; }));
      EXPECT_LT(scan.stamp, arrivals_[n]);
      EXPECT_GT(scan.stamp, arrivals_[n] - std::chrono::seconds(2));
      EXPECT_TRUE(n == 0 || scan.stamp > scans_[n - 1].stamp);
    }
  }

  std::atomic<bool> cancel_{false};
  std::unique_ptr<test::VirtualLidar> lidar_;
  std::unique_ptr<test::Rplidar> driver_;
  std::vector<LaserScan> scans_;
  std::vector<Timestamp> arrivals_;
};

TEST_F(RplidarDriverTest, GivesExpressScansWhenTheDeviceCan) {
  start();
  ASSERT_TRUE(connect()) << reason();
  ASSERT_TRUE(collect(4));
  EXPECT_EQ(lidar_->count(Request::kExpressScan), 1);
  EXPECT_EQ(state(), DeviceState::kStreaming);
  EXPECT_GE(driver_->status().samples.load(), 4);
  EXPECT_GT(driver_->status().last_sample_ns.load(), 0);
  expectRightGeometry(254e-6);
}

TEST_F(RplidarDriverTest, GivesStandardScansOnRequest) {
  start(sim::a1Firmware122(), ModeWish::kStandard);
  ASSERT_TRUE(connect()) << reason();
  ASSERT_TRUE(collect(4));
  EXPECT_EQ(lidar_->count(Request::kExpressScan), 0);
  expectRightGeometry(508e-6);
}

TEST_F(RplidarDriverTest, FallsBackToStandardScansOnOldFirmware) {
  start(sim::a1Firmware115());  // before GET_SAMPLERATE and EXPRESS_SCAN
  ASSERT_TRUE(connect()) << reason();
  ASSERT_TRUE(collect(2));
  expectRightGeometry(476e-6);
  EXPECT_DOUBLE_EQ(driver_->mode().sample_time, 476e-6) << "what the manual says of firmware that cannot be asked";
}

TEST_F(RplidarDriverTest, IsNotMisledByTheStreamOfAPreviousRun) {
  start();
  lidar_->line().opener()("", 0).stream->write(encodeRequest(Request::kScan));
  lidar_->line().pass(std::chrono::seconds(1));
  ASSERT_TRUE(connect()) << reason();
  ASSERT_TRUE(collect(2));
  expectRightGeometry(254e-6);
}

TEST_F(RplidarDriverTest, KeepsScanningWhileBytesGetLost) {
  start();
  ASSERT_TRUE(connect()) << reason();
  while (scans_.size() < 30) {
    ASSERT_TRUE(lidar_->inject("lose", 1));
    ASSERT_TRUE(collect(scans_.size() + 6));
  }
  EXPECT_GT(driver_->status().rejects.load(), 0) << "damage is counted";
  EXPECT_TRUE(collect(scans_.size() + 2));
}

TEST_F(RplidarDriverTest, SendsNoPwmToTheMotorOfAnA1) {
  start();
  ASSERT_TRUE(connect()) << reason();
  driver_->stop();
  EXPECT_EQ(lidar_->count(Request::kSetMotorPwm), 0);
}

TEST_F(RplidarDriverTest, RunsTheMotorOfAnA2ByPwmAndStopsIt) {
  start(sim::a2());
  ASSERT_TRUE(connect()) << reason();
  ASSERT_TRUE(collect(1));
  EXPECT_GT(lidar_->pwm(), 0);
  driver_->stop();
  EXPECT_EQ(lidar_->pwm(), 0);
}

TEST_F(RplidarDriverTest, StopsTheScanAtTheEnd) {
  start();
  ASSERT_TRUE(connect()) << reason();
  ASSERT_TRUE(collect(1));
  const int before = lidar_->count(Request::kStop);
  driver_->stop();
  EXPECT_GT(lidar_->count(Request::kStop), before);
}

TEST_F(RplidarDriverTest, PollsInVainWithoutAConnection) {
  start();
  EXPECT_FALSE(driver_->poll(milliseconds(1))) << "before connect()";
  ASSERT_TRUE(connect()) << reason();
  driver_->stop();
  EXPECT_FALSE(driver_->poll(milliseconds(1))) << "after stop()";
}

TEST_F(RplidarDriverTest, CanConnectAgainAfterItsStop) {
  start();
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(connect()) << reason();
    scans_.clear();
    arrivals_.clear();
    ASSERT_TRUE(collect(2));
    expectRightGeometry(254e-6);
    driver_->stop();
  }
}

TEST_F(RplidarDriverTest, CallsProtectionStopAFault) {
  start();
  ASSERT_TRUE(lidar_->inject("health", 2));
  EXPECT_FALSE(connect());
  EXPECT_EQ(state(), DeviceState::kFault);
  EXPECT_NE(reason(), "");
  EXPECT_GE(lidar_->count(Request::kReset), 1) << "only a reset leaves Protection Stop";
  EXPECT_LE(lidar_->count(Request::kReset), 3) << "do not hammer";
  EXPECT_EQ(lidar_->count(Request::kScan) + lidar_->count(Request::kExpressScan), 0);
}

TEST_F(RplidarDriverTest, LeavesProtectionStopByAReset) {
  start();
  ASSERT_TRUE(lidar_->inject("health", 2));
  lidar_->line().meanwhile = [&] {
    if (lidar_->count(Request::kReset) > 0) lidar_->inject("health", 0);
  };
  const bool connected = connect() || connect();  // the reset may end the first attempt
  ASSERT_TRUE(connected) << reason();
  EXPECT_TRUE(collect(1));
}

TEST_F(RplidarDriverTest, WorksWithAWarning) {
  start();
  ASSERT_TRUE(lidar_->inject("health", 1));
  ASSERT_TRUE(connect()) << reason();
  EXPECT_TRUE(collect(1));
  EXPECT_EQ(state(), DeviceState::kStreaming);
  EXPECT_NE(reason().find("clean its window"), std::string::npos) << reason();
}

TEST_F(RplidarDriverTest, GivesUpADeviceThatNeverAnswers) {
  start();
  ASSERT_TRUE(lidar_->inject("silent", 1));
  const Timestamp begin = virtual_now;
  EXPECT_FALSE(connect());
  EXPECT_LT(virtual_now - begin, std::chrono::seconds(15)) << "up to some seconds";
  EXPECT_TRUE(state() == DeviceState::kFault || state() == DeviceState::kAbsent);
  EXPECT_NE(reason(), "");

  ASSERT_TRUE(lidar_->inject("silent", 0));
  ASSERT_TRUE(connect()) << reason();
  EXPECT_TRUE(collect(1));
}

TEST_F(RplidarDriverTest, GivesUpEarlyWhenCancelled) {
  start();
  ASSERT_TRUE(lidar_->inject("silent", 1));
  lidar_->line().meanwhile = [&] { cancel_ = lidar_->count(Request::kStop) + lidar_->count(Request::kGetInfo) > 0; };
  const Timestamp begin = virtual_now;
  EXPECT_FALSE(connect());
  EXPECT_LT(virtual_now - begin, std::chrono::seconds(2));
}

TEST_F(RplidarDriverTest, ReportsWhyThereIsNoPort) {
  test::Rplidar driver("/dev/no_such_lidar", {}, test::virtualNow, [](const LaserScan&) {});
  EXPECT_FALSE(driver.connect(cancel_));
  EXPECT_EQ(driver.status().state.load(), DeviceState::kAbsent);
  EXPECT_NE(driver.status().problem().words(), "");
}

TEST_F(RplidarDriverTest, NoticesAHangUp) {
  start();
  ASSERT_TRUE(connect()) << reason();
  ASSERT_TRUE(collect(1));
  lidar_->line().unplug();
  ASSERT_TRUE(pollUntilOver());
  EXPECT_NE(state(), DeviceState::kStreaming);
  EXPECT_NE(reason(), "");
}

TEST_F(RplidarDriverTest, NoticesThatTheMotorStoppedAndRecovers) {
  start();
  ASSERT_TRUE(connect()) << reason();
  ASSERT_TRUE(collect(1));
  ASSERT_TRUE(lidar_->inject("stall", 1));
  ASSERT_TRUE(pollUntilOver());
  EXPECT_NE(state(), DeviceState::kStreaming);
  EXPECT_NE(reason(), "");

  ASSERT_TRUE(lidar_->inject("stall", 0));
  ASSERT_TRUE(connect()) << reason();
  EXPECT_TRUE(collect(scans_.size() + 2));
  EXPECT_EQ(state(), DeviceState::kStreaming);
}

}  // namespace
}  // namespace slam::rplidar_driver_test
