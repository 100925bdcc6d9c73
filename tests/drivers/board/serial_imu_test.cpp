// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board/serial_imu.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "drivers/pseudo_terminal.hpp"
#include "drivers/virtual_time.hpp"
#include "firmware_if/robolink.hpp"

namespace slam {
namespace {

using std::chrono::milliseconds;
using test::Bytes;
using test::virtual_now;
using test::virtualNow;
using Framing = SerialImu::Framing;

/// A unit that sends a set of frames each period; what it measures is a ramp, so that each value says when it was
/// taken.
class FakeUnit {
 public:
  explicit FakeUnit(Framing framing) : framing_(framing) {}

  test::PseudoTerminal& line() { return line_; }
  const std::string& path() const { return line_.path(); }
  /// Sends what was taken until now and has found its way through the line.
  void serve() {
    for (; start_ + (taken_ + 1) * period + delay_ <= virtual_now; delay_ = delay ? delay() : Duration(0)) {
      ++taken_;
      if (mute || !line_.plugged()) continue;
      if (babble) {
        line_.write(Bytes{0x00, 0xAA, 0x55, 0x51, 0x13, 0x2C, 0x55, 0x52});
      } else {
        send();
      }
    }
  }
  Timestamp takenAt(std::int64_t count) const { return start_ + count * period; }

  Duration period = milliseconds(5);
  std::function<Duration()> delay;
  bool mute = false, babble = false, stuck = false, damaged = false;
  bool nan = false;
  bool bare = false;  ///< a B6 whose acceleration is switched off

 private:
  void send() {
    if (!stuck) value_ = taken_;
    if (framing_ == Framing::kA9) {
      hfi::A9Motion motion{{static_cast<float>(value_), 0.25F, -0.5F}, {0.125F, -0.0625F, -1.0F}, {}};
      if (nan) motion.gyro[1] = std::numeric_limits<float>::quiet_NaN();
      write(hfi::encodeA9(motion));
      write(hfi::encodeA9(hfi::A9Attitude{1.0F, 2.0F, 3.0F}));
      return;
    }
    const auto x = static_cast<std::int16_t>(value_ % 30000);
    if (!bare) write(hfi::encodeB6({hfi::B6Type::kAccel, {256, -128, -2048, 0}}));
    write(hfi::encodeB6({hfi::B6Type::kGyro, {x, 1000, -2000, 0}}));
    write(hfi::encodeB6({hfi::B6Type::kAngle, {1, 2, 3, 0}}));
    write(hfi::encodeB6({hfi::B6Type::kMagnetic, {1, 2, 3, 0}}));
  }
  template <std::size_t N>
  void write(std::array<std::uint8_t, N> frame) {
    if (damaged) ++frame[7];
    line_.write(frame);
  }

  test::PseudoTerminal line_;
  Framing framing_;
  Timestamp start_ = virtual_now;
  Duration delay_{0};
  std::int64_t taken_ = 0, value_ = 0;
};

class SerialImuTest : public testing::TestWithParam<Framing> {
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
  std::int64_t count(const ImuSample& sample) const {
    const double unit = GetParam() == Framing::kA9 ? 1.0 : static_cast<double>(hfi::kB6Gyro);
    return std::lround(sample.gyro.x() / unit);
  }

  FakeUnit unit_{GetParam()};
  std::vector<ImuSample> samples_;
  SerialImu driver_{{.port = unit_.path()}, virtualNow, [this](const ImuSample& s) { samples_.push_back(s); }};
};

TEST_P(SerialImuTest, RecognisesTheUnitByItself) {
  EXPECT_EQ(driver_.framing(), Framing::kUnknown);
  ASSERT_TRUE(runUntil([&] { return samples_.size() >= 20; }));
  EXPECT_EQ(driver_.framing(), GetParam());
  EXPECT_TRUE(streaming());
  EXPECT_EQ(driver_.status().rejects, 0);
}

TEST_P(SerialImuTest, TurnsGravityIntoSpecificForceAndKeepsTheGyro) {
  ASSERT_TRUE(runUntil([&] { return samples_.size() >= 20; }));
  const ImuSample& sample = samples_.back();
  EXPECT_NEAR(sample.accel.z(), 9.80665, 1e-6) << "at rest";
  EXPECT_LT(sample.accel.x(), 0.0);
  EXPECT_GT(sample.accel.y(), 0.0);
  if (GetParam() == Framing::kA9) {
    EXPECT_TRUE(sample.gyro.tail<2>().isApprox(Eigen::Vector2d(0.25, -0.5)));
    EXPECT_NEAR(sample.accel.x(), -0.125 * 9.80665, 1e-6);
  } else {
    constexpr double kUnit = 2000.0 / 32768.0 * 3.14159265358979 / 180.0;
    EXPECT_TRUE(sample.gyro.tail<2>().isApprox(Eigen::Vector2d(1000 * kUnit, -2000 * kUnit), 1e-6));
    EXPECT_NEAR(sample.accel.x(), -0.125 * 9.80665, 1e-6);
  }
}

TEST_P(SerialImuTest, StampsRightToAMillisecondUnderJitteredArrival) {
  std::mt19937 random(6);
  std::exponential_distribution<double> jitter(1.0 / 0.002);
  unit_.delay = [&] { return fromSeconds(std::min(0.02, jitter(random))); };
  runFor(std::chrono::seconds(10));
  samples_.clear();
  runFor(std::chrono::seconds(20));
  ASSERT_GT(samples_.size(), 3500U);
  std::vector<double> errors;  // [s]
  for (const ImuSample& sample : samples_) {
    const Timestamp taken = unit_.takenAt(count(sample));
    errors.push_back(std::abs(toSeconds(sample.stamp - taken)));
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() * 95 / 100], 0.001);
  RecordProperty("p95_us", static_cast<int>(1e6 * errors[errors.size() * 95 / 100]));
}

TEST_P(SerialImuTest, CountsDamageAndUsesTheNextGoodFrame) {
  ASSERT_TRUE(runUntil([&] { return samples_.size() >= 100; }));
  unit_.damaged = true;
  runFor(milliseconds(100));
  const std::size_t before = samples_.size();
  EXPECT_GE(driver_.status().rejects.load(), 15);
  unit_.damaged = false;
  runFor(milliseconds(100));
  EXPECT_GE(samples_.size(), before + 15);
}

TEST_P(SerialImuTest, DropsSamplesThatAreNotNumbers) {
  if (GetParam() == Framing::kB6) return;  // integers always are
  ASSERT_TRUE(runUntil([&] { return samples_.size() >= 10; }));
  unit_.nan = true;
  runFor(milliseconds(100));
  for (const ImuSample& sample : samples_) EXPECT_TRUE(sample.gyro.allFinite());
  EXPECT_GT(driver_.status().rejects.load(), 10);
}

struct Trouble {
  const char* name;
  std::function<void(FakeUnit&)> begin, end;
  const char* words;
};
const std::vector<Trouble>& troubles() {
  static const std::vector<Trouble> all{
      {"silence", [](FakeUnit& u) { u.mute = true; }, [](FakeUnit& u) { u.mute = false; },
       "the IMU sends nothing: check its power"},
      {"babble", [](FakeUnit& u) { u.babble = true; }, [](FakeUnit& u) { u.babble = false; },
       "the IMU's frames cannot be read: check baud rate and cable"},
      {"stuck", [](FakeUnit& u) { u.stuck = true; }, [](FakeUnit& u) { u.stuck = false; },
       "the IMU sends frames, but its values never change: restart it"},
      {"unplugged", [](FakeUnit& u) { u.line().unplug(); }, [](FakeUnit& u) { u.line().plug(); },
       "the port is gone: unplugged?"},
  };
  return all;
}

TEST_P(SerialImuTest, SaysWhatIsWrongWithinASecondAndStreamsAgainWithinThree) {
  for (const Trouble& trouble : troubles()) {
    ASSERT_TRUE(runUntil([&] { return streaming(); })) << trouble.name;
    trouble.begin(unit_);
    const Timestamp begin = virtual_now;
    ASSERT_TRUE(runUntil([&] { return !streaming(); })) << trouble.name;
    EXPECT_LE(virtual_now - begin, std::chrono::seconds(1)) << trouble.name;
    EXPECT_EQ(driver_.status().problem().words(), trouble.words);
    const std::size_t before = samples_.size();
    runFor(std::chrono::seconds(6));
    EXPECT_EQ(samples_.size(), before) << trouble.name;
    trouble.end(unit_);
    const Timestamp end = virtual_now;
    ASSERT_TRUE(runUntil([&] { return streaming(); })) << trouble.name;
    EXPECT_LE(virtual_now - end, std::chrono::seconds(3)) << trouble.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Of, SerialImuTest, testing::Values(Framing::kA9, Framing::kB6),
                         [](const auto& instance) { return instance.param == Framing::kA9 ? "A9" : "B6"; });

TEST(SerialImu, NeverWaitsInATick) {
  test::PseudoTerminal line;
  SerialImu driver({.port = line.path()}, monotonicNow, [](const ImuSample&) {});
  driver.tick();  // opens
  const Timestamp begin = monotonicNow();
  for (int i = 0; i < 1000; ++i) driver.tick();
  EXPECT_LT(monotonicNow() - begin, std::chrono::seconds(1));
}

TEST(SerialImu, UsesTheTurnRatesOfAB6ThatSendsNoAcceleration) {
  FakeUnit unit(Framing::kB6);
  unit.bare = true;
  std::vector<ImuSample> samples;
  SerialImu driver({.port = unit.path()}, virtualNow, [&](const ImuSample& sample) { samples.push_back(sample); });
  ASSERT_TRUE(test::tickUntil([&] { unit.serve(), driver.tick(); }, [&] { return samples.size() > 300; }));
  EXPECT_EQ(driver.status().state.load(), DeviceState::kStreaming);
  EXPECT_NE(driver.status().problem().words().find("slamd goes on with its turn rate alone"), std::string::npos);
  EXPECT_NEAR(samples.back().gyro.y(), 1000 * static_cast<double>(hfi::kB6Gyro), 1e-6);
  EXPECT_TRUE(samples.back().accel.isZero());
  unit.bare = false;
  samples.clear();
  ASSERT_TRUE(test::tickUntil([&] { unit.serve(), driver.tick(); }, [&] { return samples.size() > 300; }));
  EXPECT_FALSE(samples.back().accel.isZero());
  EXPECT_EQ(driver.status().problem().words(), "");
}

TEST(SerialImu, NamesTheLidarThatIsOnItsPortInstead) {
  test::PseudoTerminal line;
  SerialImu driver({.port = line.path()}, virtualNow, [](const ImuSample&) {});
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

TEST(SerialImu, NamesTheBoardOnItsPortAlsoWhereAnotherThreadClosesThePort) {
  test::PseudoTerminal line;
  SerialImu driver({.port = line.path(), .in_background = true}, virtualNow, [](const ImuSample&) {});
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

TEST(SerialImu, IsAbsentWithoutAPort) {
  SerialImu driver({.port = "/dev/none"}, virtualNow, [](const ImuSample&) {});
  driver.tick();
  EXPECT_EQ(driver.status().state.load(), DeviceState::kAbsent);
  EXPECT_NE(driver.status().problem().words(), "");
}

}  // namespace
}  // namespace slam
