// SPDX-License-Identifier: BSD-3-Clause
#include "base_control.hpp"

namespace slamd_base {
namespace {

const uint32_t kMicroseconds = 1000;  // in a millisecond
const float kPerSecond = 1e6F;        // [us] in a second

float limited(float value) { return value > 1.0F ? 1.0F : value < -1.0F ? -1.0F : value; }

}  // namespace

void BaseControl::command(const Speeds& speeds, uint32_t now) {
  speeds_ = speeds;
  commanded_ = now;
  driven_ = true;
}

void BaseControl::step(uint32_t now, const int32_t counts[2]) {
  // Held as false from then on: the clock wraps, and an old command must not come to life.
  driven_ = driven_ && now - commanded_ < kCommandLasts * kMicroseconds;
  const float elapsed = static_cast<float>(now - stepped_) / kPerSecond;
  for (uint8_t side = 0; side < 2; ++side) {
    const int32_t turned =
        static_cast<int32_t>(static_cast<uint32_t>(counts[side]) - static_cast<uint32_t>(counts_[side]));
    counts_[side] = counts[side];
    if (started_ && elapsed > 0.0F) duty_[side] = dutyFor(side, static_cast<float>(turned) / elapsed, elapsed);
  }
  stepped_ = now;
  started_ = true;
}

float BaseControl::dutyFor(uint8_t side, float measured, float elapsed) {
  if (wanted(side) == 0) return integral_[side] = 0.0F;  // no current into a motor that shall stand
  const float speed = static_cast<float>(wanted(side));
  const float error = (speed - measured) / gains_.most;
  integral_[side] = limited(integral_[side] + gains_.integral * elapsed * error);
  return limited(speed / gains_.most + gains_.proportional * error + integral_[side]);
}

}  // namespace slamd_base
