// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

/// RoboLink V2, the serial link of the HandsFree controller board; README.md is its specification. Bytes to raw values
/// and back: std only, no heap, no I/O.
namespace slam::robolink {

inline constexpr int kBaud = 921600;           ///< [bit/s]
inline constexpr std::uint8_t kMaster = 0x01;  ///< id of the computer
inline constexpr std::uint8_t kSlave = 0x11;   ///< id of the board

enum class Command : std::uint8_t {
  kShakingHands = 0,
  kGetSystemInfo = 1,
  kSetRobotSpeed = 12,
  kGetMotorSpeed = 15,
  kGetMotorMileage = 16,
  kClearCoordinateData = 19,
  kGetImu = 24,
  kReadChassisParameters = 28,
  kSetSystemInfo = 31,
};

inline constexpr std::size_t kMaxPayload = 1022;  ///< the length field counts the command too and may say 1023
inline constexpr std::size_t kOverhead = 8;       ///< FF FF sender receiver LEN_high LEN_low command ... checksum
inline constexpr std::size_t kMaxFrame = kMaxPayload + kOverhead;

/// Sum of all bytes of the frame before the checksum, modulo 255 (not 256).
std::uint8_t checksum(std::span<const std::uint8_t> bytes);

/// Writes a frame into `out`. @return its size, or 0 when the payload is too long or `out` too small
std::size_t encodeFrame(std::uint8_t sender, std::uint8_t receiver, Command command,
                        std::span<const std::uint8_t> payload, std::span<std::uint8_t> out);

/// A question of the computer's, whole.
inline constexpr std::size_t kQuestionSize = kOverhead;
std::array<std::uint8_t, kQuestionSize> question(Command command);

/// One received frame; the payload lives in the decoder until the next push().
struct Frame {
  std::uint8_t sender = 0, receiver = 0;
  std::uint8_t command = 0;  ///< may be a value that Command does not name
  std::span<const std::uint8_t> payload;
};

struct DecoderCounters {
  std::uint32_t frames = 0;  ///< good ones for this receiver
  std::uint32_t bad_checksums = 0;
  std::uint32_t bad_lengths = 0;     ///< 0 or above 1023
  std::uint32_t foreign_frames = 0;  ///< good ones of or for somebody else
  std::uint32_t skipped_bytes = 0;   ///< outside of frames
};

/// Finds frames in a stream of bytes. After damage it looks for the next FF FF inside what it holds already, so that a
/// good frame right behind a damaged one is not lost; a stray FF before a frame does no harm.
class Decoder {
 public:
  /// @param own     id of this side: frames for others are counted and dropped
  /// @param sender  id of the other side
  explicit Decoder(std::uint8_t own = kMaster, std::uint8_t sender = kSlave) : own_(own), sender_(sender) {}

  /// Takes one byte. @return a frame when this byte completes one. Damage that begins with a false header can hold more
  /// than one frame back; the others come with the next calls, or from flush().
  std::optional<Frame> push(std::uint8_t byte);
  /// The next frame among the bytes held already, without new input.
  std::optional<Frame> flush();

  void reset() { size_ = delivered_ = 0; }
  const DecoderCounters& counters() const { return counters_; }

 private:
  void drop(std::size_t bytes);

  std::uint8_t own_, sender_;
  std::array<std::uint8_t, kMaxFrame> buffer_{};  // begins with FF FF or a prefix of it
  std::size_t size_ = 0;
  std::size_t delivered_ = 0;  // bytes of the frame handed out last, still at the front
  DecoderCounters counters_;
};

/// Payloads. Little-endian, packed; each parse function returns std::nullopt for a wrong size or values that are not
/// finite.
struct Coordinate {
  float x = 0.0F, y = 0.0F, z = 0.0F;  ///< [m, m, rad] or [m/s, m/s, rad/s]; z is about the vertical
};
inline constexpr std::size_t kCoordinateSize = 12;
std::array<std::uint8_t, kCoordinateSize> encodeCoordinate(const Coordinate& value);
std::optional<Coordinate> parseCoordinate(std::span<const std::uint8_t> payload);

/// Four values of servo 1..4: accumulated angle [rad] (mileage) or speed [rad/s]; unused ones are 0.
using MotorVector = std::array<float, 4>;
inline constexpr std::size_t kMotorVectorSize = 16;
std::array<std::uint8_t, kMotorVectorSize> encodeMotorVector(const MotorVector& value);
std::optional<MotorVector> parseMotorVector(std::span<const std::uint8_t> payload);

/// First block of the IMU answer; the second is not filled by the open firmware.
struct Imu {
  std::uint8_t online = 0;                      ///< bit 0: 6-axis unit, 1: magnetometer, 2: barometer
  std::array<std::uint16_t, 3> update_rates{};  ///< of these three
  std::array<float, 3> gyro{};                  ///< [rad/s]
  std::array<float, 3> accel{};                 ///< [m/s^2]
};
inline constexpr std::size_t kImuSize = 174;
std::array<std::uint8_t, kImuSize> encodeImu(const Imu& value);
std::optional<Imu> parseImu(std::span<const std::uint8_t> payload);

/// Local time of the computer, for the board's log; all zero when it is not known.
struct LocalTime {
  bool valid = false;
  std::uint16_t year = 0;
  std::uint8_t month = 0, day = 0;  ///< from 1
  std::uint8_t weekday = 0;         ///< 1 Monday to 7 Sunday, as the controller's own clock counts
  std::uint8_t hour = 0, minute = 0, second = 0;
  bool operator==(const LocalTime&) const = default;
};
/// @param seconds of local time since 1970 (UTC and the zone's offset)
LocalTime localTimeAt(std::int64_t seconds);

struct SystemInfo {
  float system_time = 0.0F;      ///< [us] since the board's start, as a float: resolution 64 us after 10 minutes
  float cpu_temperature = 0.0F;  ///< [deg C]
  float cpu_usage = 0.0F;        ///< [%]
  float battery = 0.0F;          ///< [V]
  float power_remain = 0.0F;     ///< [%]
  LocalTime local_time = {};
};
inline constexpr std::size_t kSystemInfoSize = 37;
std::array<std::uint8_t, kSystemInfoSize> encodeSystemInfo(const SystemInfo& value);
std::optional<SystemInfo> parseSystemInfo(std::span<const std::uint8_t> payload);

enum class ChassisType : std::uint8_t {
  kDifferential2 = 0,
  kDifferential4 = 1,
  kOmni3 = 2,
  kOmni4 = 3,
  kMecanum4 = 4,
  kCarLike = 5,
};

struct ChassisParameters {
  ChassisType type = ChassisType::kDifferential2;  ///< may be a value without a name
  float wheel_radius = 0.0F;                       ///< [m]
  float body_radius = 0.0F;                        ///< [m] half the track of a differential base
  float speed_low_filter = 0.0F;                   ///< [1] share of a new speed in the filtered one
  std::uint8_t imu_fusion = 0, control_enable = 0;
  std::array<float, 3> max_speed{};         ///< [m/s, m/s, rad/s]
  std::array<float, 3> max_acceleration{};  ///< [m/s^2, m/s^2, rad/s^2]
};
inline constexpr std::size_t kChassisSize = 39;
std::array<std::uint8_t, kChassisSize> encodeChassis(const ChassisParameters& value);
std::optional<ChassisParameters> parseChassis(std::span<const std::uint8_t> payload);

}  // namespace slam::robolink
