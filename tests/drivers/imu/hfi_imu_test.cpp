// SPDX-License-Identifier: BSD-3-Clause
// HandsFree's IMUs at their emulators, over a pseudo-terminal.
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/imu/codec/witmotion_frames.hpp"
#include "drivers/imu/imu_protocols.hpp"
#include "drivers/imu/serial_imu.hpp"
#include "drivers/pseudo_terminal.hpp"
#include "drivers/virtual_time.hpp"
#include "firmware_if/robolink.hpp"
#include "tools/sim/board/imu_emulator.hpp"

namespace slam::hfi_imu_test {
namespace {

using std::chrono::milliseconds;
using test::Bytes;
using test::virtual_now;
using test::virtualNow;
using Framing = sim::ImuEmulator::Framing;

constexpr double kGravity = 9.80665;  // [m/s^2]

SerialImuConfig configOf(const std::string& port) { return {.facts = findImu("hfi"), .port = port}; }

/// An emulated unit on a line in virtual time; the rate about x is a ramp, so that each value shows when it was taken.
class UnitOnALine {
 public:
  explicit UnitOnALine(Framing framing)
      : unit_(framing), ramp_(framing == Framing::kA9 ? 0.001 : witmotion::kRadiansPerSecondPerCount) {}

  const std::string& path() const { return line_.path(); }
  /// Sends what was taken until now and has found its way through the line.
  void serve() {
    for (; start_ + (taken_ + 1) * kPeriod + delay_ <= virtual_now; delay_ = delay ? delay() : Duration(0)) {
      ++taken_;
      Bytes out;
      unit_.sample({ramp_ * static_cast<double>(taken_ % 30000), gyro_y, -0.5},
                   {-0.125 * kGravity, 0.0625 * kGravity, kGravity}, out);
      line_.write(out);
    }
  }
  bool inject(std::string_view kind, double value) {
    if (kind != "unplug") return unit_.inject(kind, value);
    value == 0.0 ? line_.plug() : line_.unplug();
    return true;
  }
  /// @param rate [rad/s] about x
  Timestamp takenAt(double rate) const { return start_ + std::lround(rate / ramp_) * kPeriod; }

  std::function<Duration()> delay;
  double gyro_y = 0.25;  ///< [rad/s]

 private:
  static constexpr Duration kPeriod = milliseconds(5);

  test::PseudoTerminal line_;
  sim::ImuEmulator unit_;
  double ramp_;  // [rad/s] from sample to sample
  Timestamp start_ = virtual_now;
  Duration delay_{0};
  std::int64_t taken_ = 0;
};

class HfiImuTest : public testing::TestWithParam<Framing> {
 protected:
  template <typename Condition>
  [[nodiscard]] bool runUntil(Condition&& condition) {
    const auto step = [this] {
      unit_.serve();
      driver_.tick();
      EXPECT_TRUE(driver_.status().state == DeviceState::kStreaming || driver_.status().problem());
    };
    return test::tickUntil(step, condition);
  }
  void runFor(Duration time) {
    const Timestamp end = virtual_now + time;
    ASSERT_TRUE(runUntil([&] { return virtual_now >= end; }));
  }
  bool streaming() { return driver_.status().state == DeviceState::kStreaming; }

  UnitOnALine unit_{GetParam()};
  std::vector<ImuSample> samples_;
  SerialImu driver_{configOf(unit_.path()), virtualNow, [this](const ImuSample& s) { samples_.push_back(s); }};
};

TEST_P(HfiImuTest, RecognisesTheUnitByItself) {
  EXPECT_STREQ(driver_.status().identity.load(), "");
  ASSERT_TRUE(runUntil([&] { return samples_.size() >= 20; }));
  EXPECT_STREQ(driver_.status().identity.load(),
               GetParam() == Framing::kA9 ? "HandsFree A9" : "HandsFree B6, B9 or D6");
  EXPECT_TRUE(streaming());
  EXPECT_EQ(driver_.status().rejects, 0);
}

TEST_P(HfiImuTest, TurnsGravityIntoSpecificForceAndKeepsTheGyro) {
  ASSERT_TRUE(runUntil([&] { return samples_.size() >= 20; }));
  const ImuSample& sample = samples_.back();
  EXPECT_NEAR(sample.accel.z(), kGravity, 1e-6) << "at rest";
  EXPECT_NEAR(sample.accel.x(), -0.125 * kGravity, 1e-6);
  EXPECT_NEAR(sample.accel.y(), 0.0625 * kGravity, 1e-6);
  const double step =
      GetParam() == Framing::kA9 ? 1e-6 : witmotion::kRadiansPerSecondPerCount;  // [rad/s] of the values
  EXPECT_NEAR(sample.gyro.y(), 0.25, step);
  EXPECT_NEAR(sample.gyro.z(), -0.5, step);
}

TEST_P(HfiImuTest, StampsRightToAMillisecondUnderJitteredArrival) {
  std::mt19937 random(6);
  std::exponential_distribution<double> jitter(1.0 / 0.002);
  unit_.delay = [&] { return fromSeconds(std::min(0.02, jitter(random))); };
  runFor(std::chrono::seconds(10));
  samples_.clear();
  runFor(std::chrono::seconds(20));
  ASSERT_GT(samples_.size(), 3500U);
  std::vector<double> errors;  // [s]
  for (const ImuSample& sample : samples_) {
    errors.push_back(std::abs(toSeconds(sample.stamp - unit_.takenAt(sample.gyro.x()))));
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() * 95 / 100], 0.001);
  RecordProperty("p95_us", static_cast<int>(1e6 * errors[errors.size() * 95 / 100]));
}

TEST_P(HfiImuTest, CountsDamageAndUsesTheNextGoodFrame) {
  ASSERT_TRUE(runUntil([&] { return samples_.size() >= 100; }));
  ASSERT_TRUE(unit_.inject("checksum", 1e6));
  runFor(milliseconds(100));
  const std::size_t before = samples_.size();
  EXPECT_GE(driver_.status().rejects.load(), 15);
  ASSERT_TRUE(unit_.inject("checksum", 0));
  runFor(milliseconds(100));
  EXPECT_GE(samples_.size(), before + 15);
}

TEST_P(HfiImuTest, DropsSamplesThatAreNotNumbers) {
  if (GetParam() == Framing::kB6) return;  // integers always are
  ASSERT_TRUE(runUntil([&] { return samples_.size() >= 10; }));
  unit_.gyro_y = std::numeric_limits<double>::quiet_NaN();
  runFor(milliseconds(100));
  for (const ImuSample& sample : samples_) EXPECT_TRUE(sample.gyro.allFinite());
  EXPECT_GT(driver_.status().rejects.load(), 10);
}

TEST_P(HfiImuTest, ReportsWhatIsWrongWithinASecondAndStreamsAgainWithinThree) {
  const std::pair<const char*, const char*> troubles[] = {
      {"silent", "the IMU sends nothing: check its power"},
      {"garbage", "the IMU's frames cannot be read: check baud rate and cable"},
      {"stuck", "the IMU sends frames, but its values never change: restart it"},
      {"unplug", "the port is gone: unplugged?"},
  };
  for (const auto& [kind, words] : troubles) {
    ASSERT_TRUE(runUntil([&] { return streaming(); })) << kind;
    ASSERT_TRUE(unit_.inject(kind, 1));
    const Timestamp begin = virtual_now;
    ASSERT_TRUE(runUntil([&] { return !streaming(); })) << kind;
    EXPECT_LE(virtual_now - begin, std::chrono::seconds(1)) << kind;
    EXPECT_EQ(driver_.status().problem().words(), words);
    const std::size_t before = samples_.size();
    runFor(std::chrono::seconds(6));
    EXPECT_EQ(samples_.size(), before) << kind;
    ASSERT_TRUE(unit_.inject(kind, 0));
    const Timestamp end = virtual_now;
    ASSERT_TRUE(runUntil([&] { return streaming(); })) << kind;
    EXPECT_LE(virtual_now - end, std::chrono::seconds(3)) << kind;
  }
}

INSTANTIATE_TEST_SUITE_P(Of, HfiImuTest, testing::Values(Framing::kA9, Framing::kB6),
                         [](const auto& instance) { return instance.param == Framing::kA9 ? "A9" : "B6"; });

TEST(HfiImu, NeverWaitsInATick) {
  test::PseudoTerminal line;
  SerialImu driver(configOf(line.path()), monotonicNow, [](const ImuSample&) {});
  driver.tick();  // opens
  const Timestamp begin = monotonicNow();
  for (int i = 0; i < 1000; ++i) driver.tick();
  EXPECT_LT(monotonicNow() - begin, std::chrono::seconds(1));
}

TEST(HfiImu, UsesTheTurnRatesOfAB6ThatSendsNoAcceleration) {
  UnitOnALine unit(Framing::kB6);
  ASSERT_TRUE(unit.inject("no_accel", 1));
  std::vector<ImuSample> samples;
  SerialImu driver(configOf(unit.path()), virtualNow, [&](const ImuSample& sample) { samples.push_back(sample); });
  ASSERT_TRUE(test::tickUntil([&] { unit.serve(), driver.tick(); }, [&] { return samples.size() > 300; }));
  EXPECT_EQ(driver.status().state.load(), DeviceState::kStreaming);
  EXPECT_NE(driver.status().problem().words().find("slamd goes on with its turn rate alone"), std::string::npos);
  EXPECT_NEAR(samples.back().gyro.y(), unit.gyro_y, witmotion::kRadiansPerSecondPerCount);
  EXPECT_TRUE(samples.back().accel.isZero());
  ASSERT_TRUE(unit.inject("no_accel", 0));
  samples.clear();
  ASSERT_TRUE(test::tickUntil([&] { unit.serve(), driver.tick(); }, [&] { return samples.size() > 300; }));
  EXPECT_FALSE(samples.back().accel.isZero());
  EXPECT_EQ(driver.status().problem().words(), "");
}

TEST(HfiImu, NamesTheLidarThatIsOnItsPortInstead) {
  test::PseudoTerminal line;
  SerialImu driver(configOf(line.path()), virtualNow, [](const ImuSample&) {});
  const auto step = [&] {
    const Bytes in = line.read(Duration(0)), question{0xA5, 0x50};
    if (std::search(in.begin(), in.end(), question.begin(), question.end()) != in.end()) {
      Bytes answer{0xA5, 0x5A, 0x14, 0, 0, 0, 4};
      answer.resize(27);
      line.write(answer);
    }
    driver.tick();
  };
  const auto said = [&] {
    return driver.status().problem().words().find("an RPLidar is on this port: the imu is missed") == 0;
  };
  ASSERT_TRUE(test::tickUntil(step, said)) << driver.status().problem().words();
  const Timestamp end = virtual_now + std::chrono::seconds(20);
  ASSERT_TRUE(test::tickUntil(
      [&] {
        step();
        EXPECT_TRUE(said() || driver.status().state == DeviceState::kOpening) << driver.status().problem().words();
      },
      [&] { return virtual_now > end; }))
      << "it is said as long as it is so";
}

TEST(HfiImu, NamesTheBoardOnItsPortAlsoWhereAnotherThreadClosesThePort) {
  test::PseudoTerminal line;
  SerialImuConfig config = configOf(line.path());
  config.in_background = true;
  SerialImu driver(config, virtualNow, [](const ImuSample&) {});
  const auto step = [&] {
    const Bytes in = line.read(Duration(0));
    if (in.size() > 6 && in[0] == 0xFF) {  // a frame of RoboLink
      Bytes answer(robolink::kMaxFrame);
      answer.resize(
          robolink::encodeFrame(robolink::kSlave, robolink::kMaster, robolink::Command::kShakingHands, {}, answer));
      line.write(answer);
    }
    driver.tick();
  };
  const auto said = [&] {
    return driver.status().problem().words().find("the HandsFree board is on this port: the imu is missed") == 0;
  };
  // Time is virtual, but the other thread's work is not.
  bool is_said = false;
  for (int i = 0; i < 20 && !is_said; ++i) is_said = test::tickUntil(step, said);
  EXPECT_TRUE(is_said) << driver.status().problem().words();
}

TEST(HfiImu, IsAbsentWithoutAPort) {
  SerialImu driver(configOf("/dev/none"), virtualNow, [](const ImuSample&) {});
  driver.tick();
  EXPECT_EQ(driver.status().state.load(), DeviceState::kAbsent);
  EXPECT_NE(driver.status().problem().words(), "");
}

}  // namespace
}  // namespace slam::hfi_imu_test
