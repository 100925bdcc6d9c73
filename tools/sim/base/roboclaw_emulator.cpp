// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>

#include "firmware_if/roboclaw.hpp"
#include "tools/sim/base/counting_base.hpp"

namespace slam::sim {
namespace {

constexpr std::uint8_t kAddress = roboclaw::kFirstAddress;

/// A RoboClaw as delivered: it keeps the last speed for ever, unless its serial timeout is set. It has a battery of its
/// own.
class RoboclawEmulator : public CountingBase {
 public:
  RoboclawEmulator() : CountingBase(geometryOf("roboclaw"), {4294967200, 40}) {}  // both soon wrap

 protected:
  void restart() override {
    setCountsBack();
    packet_.clear();
    wanted_ = {};
    tenths_ = 0;
  }
  void take(std::uint8_t byte, Bytes& out) override {
    if (isTimedOut()) wanted_ = {};
    if (toSeconds(now() - last_byte_) > roboclaw::kPacketGap) packet_.clear();
    last_byte_ = now();
    packet_.push_back(byte);
    const std::size_t size = roboclaw::sizeOf(packet_);
    if (packet_.size() < size) return;
    if (size > 0 && packet_[0] == kAddress) obey(out);
    packet_.clear();
  }
  SideSpeeds sides() const override { return isTimedOut() ? SideSpeeds{} : wanted_; }

 private:
  bool isTimedOut() const { return tenths_ > 0 && toSeconds(now() - obeyed_) > 0.1 * tenths_; }
  void obey(Bytes& out) {
    use();
    obeyed_ = now();
    switch (static_cast<roboclaw::Command>(packet_[1])) {
      case roboclaw::Command::kVersion:
        return deliver(roboclaw::encodeVersion(kAddress), out);
      case roboclaw::Command::kCounts:
        return deliver(roboclaw::encodeCounts(kAddress, {static_cast<std::uint32_t>(counts()[0]),
                                                         static_cast<std::uint32_t>(counts()[1])}),
                       out);
      case roboclaw::Command::kSpeeds: {
        const auto speeds = roboclaw::parseSpeeds(packet_);
        if (!speeds) return;  // a damaged packet gets no answer
        const double count = 2.0 * std::numbers::pi * geometry().base.wheel_radius / geometry().counts_per_turn;  // [m]
        wanted_ = {count * (*speeds)[0], count * (*speeds)[1]};
        return deliver({roboclaw::kDone}, out);
      }
      case roboclaw::Command::kTimeout: {
        const auto tenths = roboclaw::parseTimeout(packet_);
        if (!tenths) return;
        tenths_ = *tenths;
        return deliver({roboclaw::kDone}, out);
      }
    }
  }

  Bytes packet_;  // that is not whole yet
  Timestamp last_byte_{}, obeyed_{};
  int tenths_ = 0;  // [0.1 s] its serial timeout; 0: none
  SideSpeeds wanted_;
};

}  // namespace

std::unique_ptr<EmulatedBase> makeRoboclaw() { return std::make_unique<RoboclawEmulator>(); }

}  // namespace slam::sim
