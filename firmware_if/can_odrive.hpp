// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "firmware_if/can_frame.hpp"

/// ODrive CANSimple, the motor controllers of the two wheels; README.md is its specification. Frames to raw values and
/// back: std only, no heap, no I/O. A parse function returns std::nullopt for a frame of another id or kind, of a wrong
/// size, or with a value that is not finite.
namespace slam::can::odrive {

inline constexpr std::uint8_t kLeftNode = 0x10, kRightNode = 0x18;  ///< clear of the IMU's ids and of CANopen
inline constexpr int kMaxNode = 0x3F;

enum class Command : std::uint8_t {
  kVersion = 0x00,  ///< firmware 0.6
  kHeartbeat = 0x01,
  kReadParameter = 0x04,  ///< firmware 0.6: RxSdo
  kParameter = 0x05,      ///< firmware 0.6: TxSdo
  kSetAxisState = 0x07,
  kEncoderEstimates = 0x09,
  kControllerMode = 0x0B,
  kInputVelocity = 0x0D,
  kClearErrors = 0x18,
};

/// 11-bit identifier: six bits of node, five of command.
constexpr std::uint32_t idOf(int node, Command command) {
  return static_cast<std::uint32_t>(node) << 5 | static_cast<std::uint32_t>(command);
}

enum class AxisState : std::uint8_t { kIdle = 1, kCalibration = 3, kClosedLoop = 8 };

/// What the last three bytes of a heartbeat mean, and the bits of its axis error: 0.5 is of ODrive 3, 0.6 of S1, Pro
/// and Micro.
enum class Dialect : std::uint8_t { kUnknown, k05, k06 };

struct Version {
  std::uint8_t protocol = 2;
  std::array<std::uint8_t, 3> hardware{}, firmware{};  ///< product line, version, variant; major, minor, revision
  bool unreleased = false;
  Dialect dialect() const { return firmware[0] == 0 && firmware[1] < 6 ? Dialect::k05 : Dialect::k06; }
  friend bool operator==(const Version&, const Version&) = default;
};
Frame encodeVersion(int node, const Version& value);
std::optional<Version> parseVersion(int node, const Frame& frame);
/// Firmware 0.6 answers it with its version; 0.5 does not know it.
Frame requestVersion(int node);

/// One of the drive's settings, firmware 0.6. Its number is in the flat_endpoints.json of just that firmware and board.
struct Parameter {
  std::uint16_t endpoint = 0;
  std::uint32_t value = 0;  ///< as many of its lower bytes as the setting's type has
  friend bool operator==(const Parameter&, const Parameter&) = default;
};
Frame encodeParameter(int node, const Parameter& value);
std::optional<Parameter> parseParameter(int node, const Frame& frame);
/// Firmware 0.6 answers it with the parameter; 0.5 does not know it.
Frame requestParameter(int node, std::uint16_t endpoint);

struct Heartbeat {
  std::uint32_t axis_error = 0;  ///< bits of the axis; 0: none
  std::uint8_t state = 0;        ///< an AxisState, or a value that it does not name
  bool motor_error = false, encoder_error = false, controller_error = false;  ///< 0.5
  bool trajectory_done = false;
  std::uint8_t procedure_result = 0;  ///< 0.6: 0 success, 1 busy (as long as closed loop lasts), 3 disarmed ...
  friend bool operator==(const Heartbeat&, const Heartbeat&) = default;
};
Frame encodeHeartbeat(int node, const Heartbeat& value, Dialect dialect = Dialect::k05);
/// @param dialect kUnknown is read as 0.5, whose flags are then not to be believed
std::optional<Heartbeat> parseHeartbeat(int node, const Frame& frame, Dialect dialect = Dialect::k05);
/// The dialect that alone can have sent these bytes; kUnknown where both can, or none.
Dialect dialectOf(const Frame& heartbeat);
/// Bits of the axis error: in 0.5 that the encoder failed; that no frame has come for the watchdog's time.
inline constexpr std::uint32_t kEncoderFailed05 = 0x100, kWatchdogExpired05 = 0x800, kWatchdogExpired06 = 0x01000000;

struct EncoderEstimates {
  float position = 0.0F;  ///< [turns] since the controller's start; a single: coarser as it grows
  float velocity = 0.0F;  ///< [turns/s]
  friend bool operator==(const EncoderEstimates&, const EncoderEstimates&) = default;
};
Frame encodeEncoderEstimates(int node, const EncoderEstimates& value);
std::optional<EncoderEstimates> parseEncoderEstimates(int node, const Frame& frame);

struct InputVelocity {
  float velocity = 0.0F;  ///< [turns/s]
  float torque = 0.0F;    ///< [Nm] fed forward
  friend bool operator==(const InputVelocity&, const InputVelocity&) = default;
};
Frame encodeInputVelocity(int node, const InputVelocity& value);
std::optional<InputVelocity> parseInputVelocity(int node, const Frame& frame);

Frame encodeAxisState(int node, AxisState state);
std::optional<std::uint32_t> parseAxisState(int node, const Frame& frame);
Frame encodeClearErrors(int node);

}  // namespace slam::can::odrive
