// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "drivers/imu/codec/xsens_messages.hpp"
#include "tools/sim/imu/faulty_imu.hpp"
#include "tools/sim/imu/imu_emulators.hpp"

namespace slam::sim {
namespace {

class XsensEmulator : public FaultyImu {
 public:
  bool inject(std::string_view kind, double value) override {
    if (kind == "config" && (value == 0.0 || value == 1.0)) {
      measures_ = value == 0.0;
      return true;
    }
    if (kind == "clock" && std::abs(value) <= 1e5) {  // [s] by which its own time jumps
      ticks_ += static_cast<std::uint32_t>(static_cast<std::int64_t>(value * 1e9) / xsens::kTickNanoseconds);
      return true;
    }
    return FaultyImu::inject(kind, value);
  }
  void receive(std::span<const std::uint8_t> in, Bytes& out) override {
    for (const std::uint8_t byte : in) {
      decoder_.push(byte, [&](std::span<const std::uint8_t> bytes) {
        const std::uint8_t id = xsens::parse(bytes).id;
        if (id == xsens::kAskId && !measures_) send(xsens::encode(xsens::kAskId + 1).bytes(), out);
        if (id != xsens::kGoToMeasurement && id != xsens::kGoToConfig) return;
        measures_ = id == xsens::kGoToMeasurement;
        send(xsens::encode(static_cast<std::uint8_t>(id + 1)).bytes(), out);
      });
    }
  }

 protected:
  void renew(const Vector&) override {
    ticks_ += static_cast<std::uint32_t>(kPeriod.count() / xsens::kTickNanoseconds);
  }
  void encode(const Vector& gyro, const Vector& accel, Bytes& out) override {
    if (!measures_) return;
    xsens::Motion motion{.counter = counter_++, .ticks = ticks_};
    if (sendsTurnRate()) motion.turn_rate = gyro;
    if (sendsAcceleration()) motion.acceleration = accel;
    Bytes message;
    xsens::encode(motion, message);
    send(message, out);
  }

 private:
  xsens::Decoder decoder_;
  bool measures_ = true;
  std::uint16_t counter_ = 65000;
  std::uint32_t ticks_ = 4294900000U;  // it wraps soon
};

}  // namespace

std::unique_ptr<EmulatedImu> makeXsens() { return std::make_unique<XsensEmulator>(); }

}  // namespace slam::sim
