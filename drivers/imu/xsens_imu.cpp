// SPDX-License-Identifier: BSD-3-Clause
#include <optional>
#include <utility>

#include "drivers/companion.hpp"
#include "drivers/imu/codec/xsens_messages.hpp"
#include "drivers/imu/imu_protocols.hpp"
#include "firmware_if/can_xsens.hpp"
#include "problems/devices.hpp"
#include "timing/device_clock.hpp"
#include "timing/stream_clock.hpp"

namespace slam {
namespace {

Eigen::Vector3d toVector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

class XsensProtocol : public ImuProtocol {
 public:
  void begin(int baud) override {
    messages_.reset();
    clock_ = {};
    with_acceleration_ = {};
    damage_ = damage();
    baud_ = baud;
  }

  void push(std::uint8_t byte, Timestamp now, const Take& take) override {
    messages_.push(byte, [&](std::span<const std::uint8_t> bytes) {
      ++good_;
      const xsens::Message message = xsens::parse(bytes);
      if (message.id != xsens::kData2) return;
      if (const auto motion = xsens::parseMotion(message.data)) {
        handle(*motion, now - transferTime(bytes.size(), baud_), take);
      } else {
        ++senseless_;
      }
    });
  }

  /// Back to measuring. One that measures takes it for granted.
  Outgoing wakeUp() override { return xsens::encode(xsens::kGoToMeasurement); }

  std::uint32_t frames() const override { return good_; }
  std::uint32_t damage() const override {
    return messages_.damaged() + messages_.skipped() / static_cast<std::uint32_t>(xsens::kOverhead) + senseless_;
  }
  Problem finding() const override {
    return with_acceleration_.expected() ? Problem() : Problem(problem::kImuNoAcceleration);
  }

 private:
  /// The unit's own time where it sends it, else what its arrivals show.
  struct Clock {
    can::xsens::TickCounter ticks{};
    DeviceClock device{};
    StreamClock stream{};
    std::optional<std::uint16_t> counter{};
  };

  void handle(const xsens::Motion& motion, Timestamp arrival, const Take& take) {
    if (!motion.turn_rate) return;
    const auto before = std::exchange(clock_.counter, motion.counter);
    const bool follows = !before || !motion.counter || static_cast<std::uint16_t>(*before + 1) == *motion.counter;
    const bool lost = std::exchange(damage_, damage()) != damage() || !follows;
    const Timestamp stamp =
        motion.ticks
            ? clock_.device.stamp(clock_.ticks.count(*motion.ticks) * Duration(xsens::kTickNanoseconds), arrival)
            : clock_.stream.stamp(arrival, lost);
    with_acceleration_.note(motion.acceleration.has_value());
    take({stamp, toVector(*motion.turn_rate),
          motion.acceleration ? toVector(*motion.acceleration) : Eigen::Vector3d::Zero()});
  }

  xsens::Decoder messages_;
  int baud_ = 0;
  Clock clock_;
  Companion with_acceleration_;
  std::uint32_t good_ = 0, senseless_ = 0, damage_ = 0;
};

}  // namespace

std::unique_ptr<ImuProtocol> makeXsensProtocol() { return std::make_unique<XsensProtocol>(); }

}  // namespace slam
