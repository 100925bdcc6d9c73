// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/// The frames between slamd and a base with the reference firmware: docs/base-frame.md is their specification. One file
/// for the microcontroller, slamd's driver and slam-sim, so C++11 with C's headers alone: no heap, no I/O, no double.
namespace slamd_base {

const uint32_t kBaud = 115200;       ///< [bit/s]
const uint16_t kStateRate = 100;     ///< [Hz] of STATE
const uint16_t kCommandLasts = 200;  ///< [ms] without SPEEDS: the firmware stops the motors

enum : uint8_t { kFirst = 0xC3, kSecond = 0x9E };
enum : uint8_t { kHead = 4, kMostPayload = 32, kLongestFrame = kHead + kMostPayload + 2 };  // [bytes]
enum FrameType : uint8_t { kStateType = 0x01, kSpeedsType = 0x81 };

/// Of State::flags; the other bits are 0.
enum Flag : uint8_t {
  kHasGyro = 0x01,  ///< turn_rate is a measurement
  kLifted = 0x02,   ///< a wheel hangs in the air
  kBumped = 0x04,   ///< a bumper is pressed
  kDriven = 0x08,   ///< the last SPEEDS still lasts
};

/// From the base.
struct State {
  uint32_t stamp;     ///< [us] of the base's own clock when it read the counters; wraps after 71 min
  int32_t counts[2];  ///< of the encoders: left, right; up driving forward; they wrap
  int32_t turn_rate;  ///< [urad/s] counter-clockwise, of its gyro
  uint16_t battery;   ///< [mV]; 0: not measured
  uint8_t speeds;     ///< number of the SPEEDS that it has received last; 0: none since its start
  uint8_t flags;      ///< of Flag
};
/// To the base.
struct Speeds {
  uint8_t number;     ///< 1..255, then 1 again; comes back in STATE
  int32_t speeds[2];  ///< [counts/s] of the wheels: left, right; forward up
};

/// CRC-16, highest bit first, neither reflected nor inverted. @param start of the register
uint16_t crc16(const uint8_t* bytes, size_t size, uint16_t start, uint16_t polynomial = 0x1021);

/// @param out of kLongestFrame bytes @return its size [bytes]
uint8_t encodeState(const State& state, uint8_t* out);
uint8_t encodeSpeeds(const Speeds& speeds, uint8_t* out);
/// @param frame of a Receiver @return false: it is of another type, or too short for it
bool parseState(const uint8_t* frame, State* state);
bool parseSpeeds(const uint8_t* frame, Speeds* speeds);

/// Finds the frames in a stream of bytes. After damage it looks for the next one inside the bytes that it holds.
class Receiver {
 public:
  /// Takes one byte. @param take(frame) gets each frame that it completes; the frame lives until take() returns
  template <typename Take>
  void push(uint8_t byte, const Take& take) {
    held_[size_++] = byte;
    for (uint8_t frame = search(); frame > 0; frame = search()) {
      take(static_cast<const uint8_t*>(held_));
      drop(frame);
    }
  }
  void reset() { size_ = 0; }
  uint32_t damaged() const { return damaged_; }  ///< frames with a wrong checksum

 private:
  /// Drops what is no frame. @return size of the frame that is held [bytes]; 0: none yet
  uint8_t search();
  void drop(uint8_t count);

  uint8_t held_[kLongestFrame] = {};
  uint8_t size_ = 0;
  uint32_t damaged_ = 0;
};

}  // namespace slamd_base
