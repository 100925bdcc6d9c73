// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/opencr.hpp"
#include "tools/sim/base/counting_base.hpp"

namespace slam::sim {
namespace {

using namespace std::chrono_literals;

/// TurtleBot3's board: half a second without another heartbeat, and it drives by its remote control, which is off.
class OpencrEmulator : public CountingBase {
 public:
  OpencrEmulator() : CountingBase(geometryOf("opencr"), {4294967200, 40}) {}  // both soon wrap

 protected:
  void restart() override {
    setCountsBack();
    frames_.reset();
    wanted_ = {};
    beaten_ = {};
    started_ = now();
  }
  void take(std::uint8_t byte, Bytes& out) override {
    frames_.push(byte, [&](std::span<const std::uint8_t> frame) {
      const auto packet = opencr::parse(frame);
      if (packet && opencr::isForBoard(*packet)) obey(*packet, out);
    });
  }
  SideSpeeds sides() const override {
    return now() - beaten_ < fromSeconds(opencr::kHeartbeatLasts) ? wanted_ : SideSpeeds{};
  }

 private:
  void obey(const opencr::Packet& packet, Bytes& out) {
    use();
    switch (packet.instruction) {
      case opencr::Instruction::kPing:
        return deliver(opencr::encodePong(), out);
      case opencr::Instruction::kRead:
        return deliver(opencr::encodeTable({.millis = static_cast<std::uint32_t>((now() - started_) / 1ms),
                                            .battery = 11.8,
                                            .bumped = bumped(),
                                            .turn_rate = static_cast<float>(turnRate()),
                                            .counts = {static_cast<std::uint32_t>(counts()[0]),
                                                       static_cast<std::uint32_t>(counts()[1])}}),
                       out);
      default:
        break;
    }
    if (const auto heartbeat = opencr::parseBeat(packet)) {
      if (*heartbeat != heartbeat_) beaten_ = now();
      heartbeat_ = *heartbeat;
    }
    if (const auto speeds = opencr::parseSpeeds(packet)) {
      const double turn = geometry().base.half_track * (*speeds)[1];
      wanted_ = {(*speeds)[0] - turn, (*speeds)[0] + turn};
    }
    deliver(opencr::encodeDone(), out);
  }

  opencr::Decoder frames_;
  SideSpeeds wanted_;
  std::uint8_t heartbeat_ = 0;
  Timestamp beaten_{}, started_{};
};

}  // namespace

std::unique_ptr<EmulatedBase> makeOpencr() { return std::make_unique<OpencrEmulator>(); }

}  // namespace slam::sim
