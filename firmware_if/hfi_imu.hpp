// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

/// The stand-alone serial IMUs of HandsFree; README.md is the specification. Bytes to raw values and back: std only, no
/// heap, no I/O. Two framings are in use, one for the A9 and one for B6, B9 and D6.
namespace slam::hfi {

struct DecoderCounters {
  std::uint32_t frames = 0;         ///< good ones
  std::uint32_t bad_checksums = 0;  ///< of frames whose head was right
  std::uint32_t skipped_bytes = 0;  ///< outside of frames
};

/// A9, frame of motion (length 2C).
struct A9Motion {
  std::array<float, 3> gyro{};      ///< [rad/s]
  std::array<float, 3> accel{};     ///< [g], the sign of gravity: (0, 0, -1) at rest
  std::array<float, 3> magnetic{};  ///< unit not known
};
/// A9, frame of attitude (length 14).
struct A9Attitude {
  float roll = 0.0F, pitch = 0.0F, yaw = 0.0F;  ///< [deg]
};

inline constexpr std::uint8_t kA9MotionLength = 0x2C, kA9AttitudeLength = 0x14;
inline constexpr std::size_t kA9Overhead = 5;  ///< AA 55 length ... CRC_low CRC_high
inline constexpr std::size_t kA9MaxFrame = kA9MotionLength + kA9Overhead;

/// CRC-16/MODBUS, over the length and the data.
std::uint16_t crc16(std::span<const std::uint8_t> bytes);

std::array<std::uint8_t, kA9MotionLength + kA9Overhead> encodeA9(const A9Motion& value);
std::array<std::uint8_t, kA9AttitudeLength + kA9Overhead> encodeA9(const A9Attitude& value);
/// @param data of a frame of that length. @return std::nullopt: another length, or a value that is not finite
std::optional<A9Motion> parseA9Motion(std::span<const std::uint8_t> data);
std::optional<A9Attitude> parseA9Attitude(std::span<const std::uint8_t> data);

/// B6, B9, D6: what a frame carries.
enum class B6Type : std::uint8_t { kAccel = 0x51, kGyro = 0x52, kAngle = 0x53, kMagnetic = 0x54 };

struct B6Frame {
  B6Type type = B6Type::kAccel;
  std::array<std::int16_t, 4> raw{};  ///< three axes, and a fourth that is not used
};
inline constexpr std::size_t kB6Frame = 11;  ///< 55 type, 4 x i16, sum
inline constexpr float kB6Accel = 16.0F / 32768.0F;
inline constexpr float kB6Gyro = 2000.0F / 32768.0F * 0.017453292F;
inline constexpr float kB6Angle = 180.0F / 32768.0F;  ///< [g], [rad/s], [deg] per unit

std::array<std::uint8_t, kB6Frame> encodeB6(const B6Frame& value);

/// Bytes held while a frame is being put together. Damage costs the damaged frame alone: the search goes on inside of
/// what is held.
template <std::size_t Size>
class FrameBuffer {
 protected:
  void append(std::uint8_t byte) { buffer_[size_++] = byte; }
  void drop(std::size_t bytes);

  std::array<std::uint8_t, Size> buffer_{};
  std::size_t size_ = 0, delivered_ = 0;  // delivered: of the frame handed out last, still at the front
  DecoderCounters counters_;
};

/// Finds A9 frames in a stream of bytes.
class A9Decoder : FrameBuffer<kA9MaxFrame> {
 public:
  /// Data of a frame, without length and CRC; lives until the next push().
  using Data = std::span<const std::uint8_t>;
  /// Takes one byte. @return the frame it completes; more may be held back by damage, they come from flush()
  std::optional<Data> push(std::uint8_t byte);
  std::optional<Data> flush();
  void reset() { size_ = delivered_ = 0; }
  const DecoderCounters& counters() const { return counters_; }
};

/// Finds B6 frames in a stream of bytes.
class B6Decoder : FrameBuffer<kB6Frame> {
 public:
  std::optional<B6Frame> push(std::uint8_t byte);
  std::optional<B6Frame> flush();
  void reset() { size_ = delivered_ = 0; }
  const DecoderCounters& counters() const { return counters_; }
};

}  // namespace slam::hfi
