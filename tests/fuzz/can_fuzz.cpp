// SPDX-License-Identifier: BSD-3-Clause
// The input is a row of frames on the bus, 15 bytes each: time since the one before, id, size and kind, data.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "drivers/can/can_imu.hpp"
#include "drivers/can/can_wheels.hpp"
#include "firmware_if/can_odrive.hpp"
#include "firmware_if/can_xsens.hpp"
#include "fuzz/fuzzing.hpp"

namespace slam {
namespace {

namespace odrive = can::odrive;
namespace xsens = can::xsens;
using can::Frame;

constexpr int kEnough = 3;
constexpr std::array<int, 2> kNodes = {odrive::kLeftNode, odrive::kRightNode};

/// The ids that somebody listens to are as likely as all others together.
constexpr std::array<std::uint32_t, 11> kIds = {
    odrive::idOf(odrive::kLeftNode, odrive::Command::kHeartbeat),
    odrive::idOf(odrive::kRightNode, odrive::Command::kHeartbeat),
    odrive::idOf(odrive::kLeftNode, odrive::Command::kEncoderEstimates),
    odrive::idOf(odrive::kRightNode, odrive::Command::kEncoderEstimates),
    odrive::idOf(odrive::kLeftNode, odrive::Command::kInputVelocity),
    odrive::idOf(odrive::kLeftNode, odrive::Command::kSetAxisState),
    odrive::idOf(odrive::kLeftNode, odrive::Command::kParameter),
    xsens::kSampleTime,
    xsens::kQuaternion,
    xsens::kRateOfTurn,
    xsens::kAcceleration,
};

Frame takeFrame(fuzz::Input& input) {
  Frame frame;
  const auto id = input.take<std::uint32_t>();
  const auto kind = input.take<std::uint8_t>();
  frame.id = (id & 0x80000000U) != 0 ? id & 0x1FFFFFFFU : kIds[id % kIds.size()];
  frame.size = std::min<std::uint8_t>(kind & 0x0F, 8);
  frame.extended = (kind & 0x30) == 0x10;
  frame.remote = (kind & 0x30) == 0x20;
  frame.error = (kind & 0x30) == 0x30;
  std::ranges::copy(input.takeBytes(frame.data.size()), frame.data.begin());
  return frame;
}

/// A frame that is understood is a data frame, and says the same again when it is written.
template <typename Value, typename Encode>
void checkAgain(const Frame& frame, const std::optional<Value>& value, const Encode& encode, bool exact = true) {
  if (!value) return;
  FUZZ_CHECK(!frame.extended && !frame.remote && !frame.error);
  const Frame again = encode(*value);
  FUZZ_CHECK(again.id == frame.id && again.size == frame.size);
  FUZZ_CHECK(!exact || std::ranges::equal(again.payload(), frame.payload()));
}

void checkFrame(const Frame& frame) {
  for (const int node : kNodes) {
    const auto of = [&](const auto& encode) { return [&](const auto& value) { return encode(node, value); }; };
    for (const odrive::Dialect dialect : {odrive::Dialect::k05, odrive::Dialect::k06}) {
      const auto again = [&](const odrive::Heartbeat& value) { return odrive::encodeHeartbeat(node, value, dialect); };
      const auto heartbeat = odrive::parseHeartbeat(node, frame, dialect);
      checkAgain(frame, heartbeat, again, false);  // bits without a name
      if (heartbeat) FUZZ_CHECK(odrive::parseHeartbeat(node, again(*heartbeat), dialect) == heartbeat);
    }
    checkAgain(frame, odrive::parseVersion(node, frame), of(odrive::encodeVersion), false);
    const auto parameter = odrive::parseParameter(node, frame);  // its value may be shorter than ours
    if (parameter) FUZZ_CHECK(odrive::parseParameter(node, odrive::encodeParameter(node, *parameter)) == parameter);
    const auto estimates = odrive::parseEncoderEstimates(node, frame);
    if (estimates) FUZZ_CHECK(std::isfinite(estimates->position) && std::isfinite(estimates->velocity));
    checkAgain(frame, estimates, of(odrive::encodeEncoderEstimates));
    checkAgain(frame, odrive::parseInputVelocity(node, frame), of(odrive::encodeInputVelocity));
    checkAgain(frame, odrive::parseAxisState(node, frame), [&](std::uint32_t state) {
      return state <= 0xFF ? odrive::encodeAxisState(node, static_cast<odrive::AxisState>(state)) : frame;
    });
  }
  checkAgain(frame, xsens::parseSampleTime(frame), xsens::encodeSampleTime);
  checkAgain(frame, xsens::parseRateOfTurn(frame), xsens::encodeRateOfTurn);
  checkAgain(frame, xsens::parseAcceleration(frame), xsens::encodeAcceleration);
}

/// What the driver makes of wheels and IMU, but for its port.
class Bus {
 public:
  void receive(const Frame& frame) {
    for (std::size_t side = 0; side < kNodes.size(); ++side) {
      if (const auto estimates = odrive::parseEncoderEstimates(kNodes[side], frame)) {
        if (const auto pair = wheels_.add(side, now, *estimates)) take(*pair);
      }
    }
    if (const auto sample = imu_.add(frame, now)) take(*sample);
    FUZZ_CHECK(wheels_.rejects() >= rejects_[0] && imu_.rejects() >= rejects_[1]);
    rejects_ = {wheels_.rejects(), imu_.rejects()};
  }

  Timestamp now{std::chrono::seconds(1000)};
  int pairs = 0, samples = 0;

 private:
  void take(const CanWheels::Pair& pair) {
    FUZZ_CHECK(std::isfinite(pair.angles[0]) && std::isfinite(pair.angles[1]) && pair.stamp <= now);
    ++pairs;
  }
  void take(const ImuSample& sample) {
    FUZZ_CHECK(sample.gyro.allFinite() && sample.accel.allFinite());
    FUZZ_CHECK(sample.stamp > last_sample_ && sample.stamp <= now);
    last_sample_ = sample.stamp;
    ++samples;
  }

  CanWheels wheels_{CanWheelsConfig{}};
  CanImu imu_;
  std::array<std::int64_t, 2> rejects_{};
  Timestamp last_sample_{};
};

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam;
  using namespace std::chrono_literals;
  fuzz::Input input({data, size});
  Bus bus;
  while (!input.atEnd()) {
    const auto pause = input.take<std::uint16_t>();
    bus.now += pause < 0x8000 ? std::chrono::microseconds(pause) : std::chrono::milliseconds(pause - 0x8000);
    const Frame frame = takeFrame(input);
    checkFrame(frame);
    bus.receive(frame);
  }
  // Whatever came before: within a second of good frames pairs and samples come, and go on to come.
  bus.now += 10ms;
  bus.pairs = bus.samples = 0;
  for (int i = 0; i < 100 && (bus.pairs < kEnough || bus.samples < kEnough); ++i, bus.now += 10ms) {
    const float turns = 0.01F * static_cast<float>(i);
    for (const int node : kNodes) bus.receive(odrive::encodeEncoderEstimates(node, {turns, 1.0F}));
    bus.receive(xsens::encodeSampleTime(static_cast<std::uint32_t>(5000 + 100 * i)));
    bus.receive(xsens::encodeRateOfTurn({0.0F, 0.0F, 0.5F}));
    bus.receive(xsens::encodeAcceleration({0.0F, 0.0F, 9.75F}));
  }
  FUZZ_CHECK(bus.pairs >= kEnough && bus.samples >= kEnough);
  return 0;
}
