// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware_if/outgoing.hpp"

/// The text protocol of ros_arduino_bridge, which diffdrive_arduino speaks, too: README.md is its specification. Bytes
/// to raw values and back: std only, no heap, no I/O.
namespace slam::arduino_bridge {

inline constexpr int kBaud = 57600;        ///< [bit/s] of the firmware as published
inline constexpr double kLoopRate = 30.0;  ///< [Hz] of its speed control: `m` takes counts per turn of that loop
inline constexpr double kAutoStop = 2.0;   ///< [s] without `m`: it stops the motors
inline constexpr double kBoot = 2.0;       ///< [s] from the reset, which opening the port makes by DTR, to the sketch
inline constexpr std::int32_t kMostCounts = 32767;  ///< per loop: the sketch reads arguments as long, and keeps doubles

/// What a line of the board is.
struct Answer {
  enum Kind : std::uint8_t {
    kCounts,   ///< of `e`: left, right
    kDone,     ///< of `m`
    kNumber,   ///< of `b`: the baud rate
    kRefused,  ///< a command that it does not know: it was damaged on its way
  } kind = kRefused;
  std::array<std::int32_t, 2> counts{};  ///< left, right; or the number, twice
};

/// @param line without its end @return nullopt: no line of this protocol
std::optional<Answer> parseLine(std::string_view line);

/// Lines of bytes. A line that is too long, or that cannot be read, is damage.
class LineDecoder {
 public:
  static constexpr std::size_t kLongest = 40;

  std::optional<Answer> push(std::uint8_t byte);
  void reset() {
    size_ = 0;
    too_long_ = false;
  }
  std::uint32_t damaged() const { return damaged_; }

 private:
  std::array<char, kLongest> line_{};
  std::size_t size_ = 0;
  bool too_long_ = false;
  std::uint32_t damaged_ = 0;
};

Outgoing askCounts();    ///< `e`
Outgoing askBaudRate();  ///< `b`: harmless, and answered by nothing else
/// `m`: closed loop. @param left, right [counts per loop], limited to kMostCounts
Outgoing encodeSpeeds(std::int32_t left, std::int32_t right);

}  // namespace slam::arduino_bridge
