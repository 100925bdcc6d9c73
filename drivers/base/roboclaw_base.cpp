// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/base/base_protocols.hpp"
#include "drivers/base/polled_protocol.hpp"
#include "firmware_if/roboclaw.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kRoboclawPeriod = 20ms;           // of asking for the counts: an answer takes 3 ms at 38400 bit/s
constexpr Duration kTimeoutPeriod = 1s;              // of setting its serial timeout
constexpr double kMostRoboclawSpeed = 2147483647.0;  // [counts/s] of a 32-bit number

/// An answer says neither what it answers nor how long it is: both follow from what was asked.
class RoboclawProtocol : public PolledProtocol {
 public:
  explicit RoboclawProtocol(const BaseProtocolConfig& config)
      : PolledProtocol(kRoboclawPeriod),
        may_drive_(config.may_drive),
        counts_per_metre_(config.counts_per_turn / (2.0 * std::numbers::pi * config.wheel_radius)),
        address_(config.address) {}

  void begin(Timestamp now) override {
    PolledProtocol::begin(now);
    next_timeout_ = now;
  }
  void push(std::uint8_t byte, Timestamp, const Take& take) override {
    if (!pending()) {
      ++unasked_;
      return;
    }
    if (size_ == held_.size()) {
      std::copy(held_.begin() + 1, held_.end(), held_.begin());
      --size_;
    }
    held_[size_++] = byte;
    switch (*pending()) {
      case Request::kSync:
        if (!roboclaw::endsWithVersion(address_, held())) return;
        if (end(Request::kSync)) take({.stamp = taken()});
        return;
      case Request::kCounts: {
        if (size_ != roboclaw::kCountsSize) return;
        const auto counts = roboclaw::parseCounts(address_, held());
        if (!counts) return;  // it is asked again when its time is up
        if (end(Request::kCounts)) take({.stamp = taken(), .counts = *counts});
        return;
      }
      case Request::kSpeeds:
        if (size_ == 1 && byte == roboclaw::kDone && end(Request::kSpeeds)) take({.stamp = taken(), .has_speed = true});
        return;
      case Request::kOther:
        if (size_ == 1 && byte == roboclaw::kDone) end(Request::kOther);
        return;
    }
  }
  std::uint32_t damage() const override { return unasked_ + unanswered(); }

 protected:
  Outgoing encode(Request question) override {
    return question == Request::kSync ? roboclaw::askVersion(address_) : roboclaw::askCounts(address_);
  }
  Outgoing encodeSpeeds(const SideSpeeds& wanted) override {
    return roboclaw::encodeSpeeds(address_, {countsOf(wanted.left), countsOf(wanted.right)});
  }
  /// Its own watchdog, which it has not as delivered: set again and again, since nothing shows that its power was away.
  /// One that somebody else drives keeps what it has.
  Outgoing encodeOther(Timestamp now) override {
    if (!may_drive_ || now < next_timeout_) return {};
    next_timeout_ = now + kTimeoutPeriod;
    return roboclaw::encodeTimeout(address_, roboclaw::kTenths);
  }
  void forget() override { size_ = 0; }

 private:
  std::span<const std::uint8_t> held() const { return {held_.data(), size_}; }
  bool end(Request request) {
    size_ = 0;
    return settle(request);
  }
  std::int32_t countsOf(double speed) const {
    return static_cast<std::int32_t>(
        std::lround(std::clamp(counts_per_metre_ * speed, -kMostRoboclawSpeed, kMostRoboclawSpeed)));
  }

  bool may_drive_;
  Timestamp next_timeout_{};
  double counts_per_metre_;
  std::uint8_t address_;
  std::array<std::uint8_t, roboclaw::kLongestVersion> held_{};  // of the answer
  std::size_t size_ = 0;
  std::uint32_t unasked_ = 0;  // bytes that answer nothing
};

}  // namespace

std::unique_ptr<BaseProtocol> makeRoboclawProtocol(const BaseProtocolConfig& config) {
  return std::make_unique<RoboclawProtocol>(config);
}

}  // namespace slam
