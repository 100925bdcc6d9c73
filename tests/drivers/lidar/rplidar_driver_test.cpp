// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "drivers/lidar/codec/rplidar_capsules.hpp"
#include "drivers/lidar/rplidar.hpp"
#include "drivers/virtual_line.hpp"

namespace slam {
namespace {

using namespace rplidar;
using std::chrono::milliseconds;
using test::virtual_now;
using Bytes = test::VirtualLine::Bytes;

constexpr int kTurn = 360 * 64;  // [deg/64]

/// Distance to the walls [mm]: another one in each quarter, seen clockwise.
int distanceAt(int angle_q6) { return 2000 + 1000 * (angle_q6 / (90 * 64)); }

/// How the device behaves.
struct Behaviour {
  Bytes info = {24, 0x1D, 0x01, 7, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  bool knows_express = true;       ///< and the sample rate
  bool scanning_at_start = false;  ///< left so by a program that was killed
  bool reset_heals = false;        ///< health 2 becomes 0
  int lose_every = 0;              ///< [bytes] of the stream, 0: never
  std::uint8_t health = 0;
  bool mute = false;     ///< answers nothing
  bool stalled = false;  ///< motor does not turn: a descriptor but no data
};

/// An A1 in virtual time: answers byte for byte and streams at the pace of its sample rate.
class FakeLidar {
 public:
  explicit FakeLidar(Behaviour& behaviour)
      : behaviour_(behaviour),
        line_(
            [this](std::span<const std::uint8_t> bytes) {
              for (const std::uint8_t byte : bytes) take(byte);
            },
            [this](Bytes& out) {
              stream();
              out.insert(out.end(), sent_.begin(), sent_.end());
              sent_.clear();
            }) {
    if (behaviour.scanning_at_start) startScan(false);
  }

  test::VirtualLine& line() { return line_; }
  int count(Request request) const { return static_cast<int>(std::count(requests_.begin(), requests_.end(), request)); }
  int pwm() const { return pwm_; }

 private:
  enum class Scan : std::uint8_t { kNone, kStandard, kExpress };

  void take(std::uint8_t byte) {
    if (packet_.empty() && byte != 0xA5) return;
    packet_.push_back(byte);
    if (packet_.size() < 2) return;
    if ((packet_[1] & 0x80) != 0) {
      if (packet_.size() < 3 || packet_.size() < packet_[2] + 4U) return;
      std::uint8_t check = 0;
      for (const std::uint8_t b : packet_) check ^= b;
      if (check != 0) ADD_FAILURE() << "request with a wrong checksum";
    }
    const Bytes packet = std::exchange(packet_, {});
    const auto request = static_cast<Request>(packet[1]);
    requests_.push_back(request);
    if (!behaviour_.mute) answer(request, packet);
  }

  void answer(Request request, const Bytes& packet) {
    if (scan_ != Scan::kNone && request != Request::kSetMotorPwm) {
      write(Bytes{0x3E, 0x9B, 0x64, 0xA5});  // data that was on the line already: precedes the answer
      scan_ = Scan::kNone;
    }
    switch (request) {
      case Request::kStop:
        break;
      case Request::kReset:
        if (behaviour_.reset_heals) behaviour_.health = 0;
        say("RP LIDAR System.\r\nFirmware Ver 1.29 - rtm, HW Ver 7\r\nModel: 18\r\n");
        break;
      case Request::kGetInfo:
        reply({0xA5, 0x5A, 0x14, 0, 0, 0, 0x04}, behaviour_.info);
        break;
      case Request::kGetHealth:
        reply({0xA5, 0x5A, 0x03, 0, 0, 0, 0x06}, {behaviour_.health, 0x01, 0x00});
        break;
      case Request::kGetSampleRate:
        if (behaviour_.knows_express) reply({0xA5, 0x5A, 0x04, 0, 0, 0, 0x15}, {0xFC, 0x01, 0xFE, 0x00});
        break;
      case Request::kGetAccessoryBoardFlag:
        reply({0xA5, 0x5A, 0x04, 0, 0, 0, 0xFF}, {1, 0, 0, 0});
        break;
      case Request::kSetMotorPwm:
        pwm_ = packet[3] | packet[4] << 8;
        break;
      case Request::kScan:
        write(Bytes{0xA5, 0x5A, 0x05, 0, 0, 0x40, 0x81});
        startScan(false);
        break;
      case Request::kExpressScan:
        if (!behaviour_.knows_express) break;
        write(Bytes{0xA5, 0x5A, 0x54, 0, 0, 0x40, 0x82});
        startScan(true);
        break;
      default:  // has no list of modes
        break;
    }
  }

  void reply(Bytes descriptor, const Bytes& data) {
    descriptor.insert(descriptor.end(), data.begin(), data.end());
    write(descriptor);
  }
  void say(const std::string& text) { write(Bytes(text.begin(), text.end())); }

  void startScan(bool express) {
    scan_ = express ? Scan::kExpress : Scan::kStandard;
    angle_ = 0;
    first_ = true;
    next_ = virtual_now;
  }

  /// Sends the packets that are due: 360 standard nodes or 720 express samples a turn.
  void stream() {
    if (scan_ == Scan::kNone || behaviour_.mute || behaviour_.stalled) {
      next_ = virtual_now + milliseconds(3);
      return;
    }
    while (next_ <= virtual_now) {
      if (scan_ == Scan::kStandard) {
        const auto node = encodeStandardNode({.angle_q6 = static_cast<std::uint16_t>(angle_),
                                              .distance_q2 = static_cast<std::uint32_t>(4 * distanceAt(angle_)),
                                              .quality = 15,
                                              .start = angle_ == 0});
        send(node);
        angle_ = (angle_ + 64) % kTurn;
        next_ += std::chrono::microseconds(behaviour_.knows_express ? 508 : 476);
      } else {
        ExpressCapsule capsule{.start_angle_q6 = static_cast<std::uint16_t>(angle_), .start = first_};
        for (int k = 0; k < kExpressSamples; ++k) {
          const int raw = (angle_ + 32 * k) % kTurn;
          const int corrected = (raw - 3 * 8 + kTurn) % kTurn;
          capsule.samples[static_cast<std::size_t>(k)] = {static_cast<std::uint16_t>(distanceAt(corrected)), 3};
        }
        send(encodeExpressCapsule(capsule));
        first_ = false;
        angle_ = (angle_ + 32 * kExpressSamples) % kTurn;
        next_ += std::chrono::microseconds(254 * kExpressSamples);
      }
    }
  }
  void write(const Bytes& bytes) { sent_.insert(sent_.end(), bytes.begin(), bytes.end()); }
  void send(std::span<const std::uint8_t> bytes) {
    Bytes kept;
    for (const std::uint8_t byte : bytes) {
      if (behaviour_.lose_every == 0 || ++streamed_ % behaviour_.lose_every != 0) kept.push_back(byte);
    }
    write(kept);
  }

  Behaviour& behaviour_;
  int pwm_ = -1;
  std::vector<Request> requests_;
  Bytes packet_, sent_;
  Scan scan_ = Scan::kNone;
  int angle_ = 0, streamed_ = 0;
  bool first_ = true;
  Timestamp next_;
  test::VirtualLine line_;
};

class RplidarDriverTest : public testing::Test {
 protected:
  /// Behaviour must be set before.
  void start(rplidar::ModeWish mode = rplidar::ModeWish::kDensest) {
    lidar_ = std::make_unique<FakeLidar>(behaviour_);
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
  void expectRightGeometry(int beams, double sample_time) {
    for (std::size_t n = 0; n < scans_.size(); ++n) {
      const LaserScan& scan = scans_[n];
      EXPECT_NEAR(scan.size, beams, 2);
      EXPECT_EQ(scan.range_min, 0.2F);
      EXPECT_EQ(scan.range_max, 9.0F);
      int wrong = 0;
      for (const Beam& beam : scan.beams()) {
        const double clockwise = std::fmod(4.0 * std::numbers::pi - beam.bearing, 2.0 * std::numbers::pi);
        const auto angle_q6 = static_cast<int>(clockwise * kTurn / (2.0 * std::numbers::pi));
        const bool at_corner = (angle_q6 + 64) % (90 * 64) < 128;  // within a degree
        wrong += !at_corner && std::abs(beam.range - 1e-3 * distanceAt(angle_q6)) > 0.002 ? 1 : 0;
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

  Behaviour behaviour_;
  std::atomic<bool> cancel_{false};
  std::unique_ptr<FakeLidar> lidar_;
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
  expectRightGeometry(720, 254e-6);
}

TEST_F(RplidarDriverTest, GivesStandardScansOnRequest) {
  start(rplidar::ModeWish::kStandard);
  ASSERT_TRUE(connect()) << reason();
  ASSERT_TRUE(collect(4));
  EXPECT_EQ(lidar_->count(Request::kExpressScan), 0);
  expectRightGeometry(360, 508e-6);
}

TEST_F(RplidarDriverTest, FallsBackToStandardScansOnOldFirmware) {
  behaviour_.info[1] = 15;  // 1.15: before GET_SAMPLERATE and EXPRESS_SCAN
  behaviour_.knows_express = false;
  start();
  ASSERT_TRUE(connect()) << reason();
  ASSERT_TRUE(collect(2));
  expectRightGeometry(360, 476e-6);
  EXPECT_DOUBLE_EQ(driver_->mode().sample_time, 476e-6) << "what the manual says of firmware that cannot be asked";
}

TEST_F(RplidarDriverTest, IsNotMisledByTheStreamOfAPreviousRun) {
  behaviour_.scanning_at_start = true;
  start();
  lidar_->line().pass(std::chrono::seconds(1));
  ASSERT_TRUE(connect()) << reason();
  ASSERT_TRUE(collect(2));
  expectRightGeometry(720, 254e-6);
}

TEST_F(RplidarDriverTest, KeepsScanningWhileBytesGetLost) {
  behaviour_.lose_every = 20'011;  // about one capsule in 238
  start();
  ASSERT_TRUE(connect()) << reason();
  ASSERT_TRUE(collect(30));
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
  behaviour_.info[0] = 0x28;
  start();
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
    expectRightGeometry(720, 254e-6);
    driver_->stop();
  }
}

TEST_F(RplidarDriverTest, CallsProtectionStopAFault) {
  behaviour_.health = 2;
  start();
  EXPECT_FALSE(connect());
  EXPECT_EQ(state(), DeviceState::kFault);
  EXPECT_NE(reason(), "");
  EXPECT_GE(lidar_->count(Request::kReset), 1) << "only a reset leaves Protection Stop";
  EXPECT_LE(lidar_->count(Request::kReset), 3) << "do not hammer";
  EXPECT_EQ(lidar_->count(Request::kScan) + lidar_->count(Request::kExpressScan), 0);
}

TEST_F(RplidarDriverTest, LeavesProtectionStopByAReset) {
  behaviour_.health = 2;
  behaviour_.reset_heals = true;
  start();
  const bool connected = connect() || connect();  // the reset may end the first attempt
  ASSERT_TRUE(connected) << reason();
  EXPECT_TRUE(collect(1));
}

TEST_F(RplidarDriverTest, WorksWithAWarning) {
  behaviour_.health = 1;
  start();
  ASSERT_TRUE(connect()) << reason();
  EXPECT_TRUE(collect(1));
  EXPECT_EQ(state(), DeviceState::kStreaming);
  EXPECT_NE(reason().find("clean its window"), std::string::npos) << reason();
}

TEST_F(RplidarDriverTest, GivesUpADeviceThatNeverAnswers) {
  behaviour_.mute = true;
  start();
  const Timestamp begin = virtual_now;
  EXPECT_FALSE(connect());
  EXPECT_LT(virtual_now - begin, std::chrono::seconds(15)) << "up to some seconds";
  EXPECT_TRUE(state() == DeviceState::kFault || state() == DeviceState::kAbsent);
  EXPECT_NE(reason(), "");

  behaviour_.mute = false;
  ASSERT_TRUE(connect()) << reason();
  EXPECT_TRUE(collect(1));
}

TEST_F(RplidarDriverTest, GivesUpEarlyWhenCancelled) {
  behaviour_.mute = true;
  start();
  lidar_->line().meanwhile = [&] { cancel_ = lidar_->count(Request::kStop) + lidar_->count(Request::kGetInfo) > 0; };
  const Timestamp begin = virtual_now;
  EXPECT_FALSE(connect());
  EXPECT_LT(virtual_now - begin, std::chrono::seconds(2));
}

TEST_F(RplidarDriverTest, SaysWhyThereIsNoPort) {
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
  behaviour_.stalled = true;
  ASSERT_TRUE(pollUntilOver());
  EXPECT_NE(state(), DeviceState::kStreaming);
  EXPECT_NE(reason(), "");

  behaviour_.stalled = false;
  ASSERT_TRUE(connect()) << reason();
  EXPECT_TRUE(collect(scans_.size() + 2));
  EXPECT_EQ(state(), DeviceState::kStreaming);
}

}  // namespace
}  // namespace slam
