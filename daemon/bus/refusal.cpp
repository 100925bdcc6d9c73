// SPDX-License-Identifier: BSD-3-Clause
#include "bus/refusal.hpp"

#include <algorithm>
#include <numeric>

#include "bus/channels.hpp"

namespace slam {
namespace {

constexpr int kShare = 4, kNoted = 10, kFull = 20;  // good messages: for a refused one; then there are words; at most

struct Meaning {
  const char *name, *cause, *fix;
};
constexpr Meaning kMeanings[kRefusals] = {
    {"none", "", ""},
    {"type", "the messages are of another type, or another version of it",
     "build the sender with the .lcm files of this slamd"},
    {"size", "the lengths in the messages do not fit their size",
     "encode them with lcm-gen's code, with each array as long as its count says"},
    {"stamp", "utime is no time: zero, below zero or far beyond this century",
     "set utime to the microseconds since 1970 at which it was measured"},
    {"limits", "range_min or range_max is not a distance, or range_max is not above range_min",
     "set both in metres; a range_max of 0 means that it is not given"},
    {"values", "a number is not finite, or beyond all that can be measured",
     "send no message where there is no measurement, and numbers in metres, radians and seconds"},
    {"ahead", "a stamp is ahead of all others of this stream", "look after the sender's clock"},
    {"old", "a stamp is seconds behind the others of this stream",
     "look after what delays it on its way, or the sender's clock"}};

const char* fieldsOf(std::string_view channel) {
  if (channel == channel::kWheels) return "x, y or theta is not finite, or beyond all that wheels can drive";
  if (channel == channel::kImu) return "gyro or accel is not finite, or beyond all that is measured";
  if (channel == channel::kDepth) return "bearing_min or bearing_step is no angle";
  if (channel == channel::kDrive) return "vx, vy or omega is not finite";
  return "a number is not finite";
}

std::string causeOf(Refusal refusal, std::string_view channel) {
  return refusal == Refusal::kValues ? fieldsOf(channel) : kMeanings[static_cast<std::size_t>(refusal)].cause;
}

const char* fixOf(Refusal refusal) { return kMeanings[static_cast<std::size_t>(refusal)].fix; }

}  // namespace

const char* nameOf(Refusal refusal) { return kMeanings[static_cast<std::size_t>(refusal)].name; }

const char* meaningOf(Refusal refusal) { return kMeanings[static_cast<std::size_t>(refusal)].cause; }

Problem problemOf(Refusal refusal, std::string_view channel) {
  if (refusal == Refusal::kNone) return {};
  return {problem::kRefused, {}, {channel, causeOf(refusal, channel), fixOf(refusal)}};
}

std::string RefusedMessages::words() const {
  if (last_ == Refusal::kNone) return "";
  const std::uint64_t all = std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0});
  std::string text = std::to_string(all - counts_[0]) + " of " + std::to_string(all) + " " + channel_ + " are rejected";
  for (std::size_t i = 1; i < kRefusals; ++i) {
    if (counts_[i] == 0) continue;
    const auto refusal = static_cast<Refusal>(i);
    text += "; " + std::to_string(counts_[i]) + ": " + causeOf(refusal, channel_) + "; fix: " + fixOf(refusal);
  }
  return text;
}

void RefusalNote::refused(Refusal refusal) {
  ++counts_[static_cast<std::size_t>(refusal)];
  level_ = std::min(level_ + kShare, kFull);
  if (level_ >= kNoted) noted_ = refusal;
}

}  // namespace slam
