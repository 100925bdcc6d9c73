// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/can_odrive.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace slam::can::odrive {
namespace {

constexpr std::size_t kMotorFlagAt = 5, kEncoderFlagAt = 6, kControllerFlagAt = 7;
constexpr std::uint8_t kErrorFlag = 0x01, kTrajectoryDone = 0x80;
constexpr std::size_t kProcedureResultAt = 5, kTrajectoryDoneAt = 6;  // of 0.6
constexpr std::uint32_t kFirstBitOf06 = 0x01000000;                   // of the axis error: 0.5 has none so high

void putWord(Frame& frame, std::size_t offset, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i, value >>= 8) frame.data[offset + i] = static_cast<std::uint8_t>(value);
}

std::uint32_t wordAt(const Frame& frame, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | frame.data[offset + i];
  return value;
}

Frame makeFrame(int node, Command command, std::uint8_t size) { return {.id = idOf(node, command), .size = size}; }

Frame makeFloats(int node, Command command, float first, float second) {
  Frame frame = makeFrame(node, command, 8);
  putWord(frame, 0, std::bit_cast<std::uint32_t>(first));
  putWord(frame, 4, std::bit_cast<std::uint32_t>(second));
  return frame;
}

/// Two finite floats of a frame of eight bytes.
std::optional<std::array<float, 2>> parseFloats(int node, Command command, const Frame& frame) {
  if (!isData(frame, idOf(node, command), 8)) return std::nullopt;
  const std::array<float, 2> values = {std::bit_cast<float>(wordAt(frame, 0)), std::bit_cast<float>(wordAt(frame, 4))};
  if (!std::isfinite(values[0]) || !std::isfinite(values[1])) return std::nullopt;
  return values;
}

}  // namespace

Frame encodeVersion(int node, const Version& value) {
  Frame frame = makeFrame(node, Command::kVersion, 8);
  frame.data[0] = value.protocol;
  std::copy(value.hardware.begin(), value.hardware.end(), frame.data.begin() + 1);
  std::copy(value.firmware.begin(), value.firmware.end(), frame.data.begin() + 4);
  frame.data[7] = value.unreleased ? 1 : 0;
  return frame;
}

std::optional<Version> parseVersion(int node, const Frame& frame) {
  if (!isData(frame, idOf(node, Command::kVersion), 8)) return std::nullopt;
  Version value{.protocol = frame.data[0], .unreleased = frame.data[7] != 0};
  std::copy_n(frame.data.begin() + 1, 3, value.hardware.begin());
  std::copy_n(frame.data.begin() + 4, 3, value.firmware.begin());
  return value;
}

Frame requestVersion(int node) { return {.id = idOf(node, Command::kVersion), .size = 8, .remote = true}; }

Frame encodeParameter(int node, const Parameter& value) {
  Frame frame = makeFrame(node, Command::kParameter, 8);
  frame.data[1] = static_cast<std::uint8_t>(value.endpoint);
  frame.data[2] = static_cast<std::uint8_t>(value.endpoint >> 8);
  putWord(frame, 4, value.value);
  return frame;
}

std::optional<Parameter> parseParameter(int node, const Frame& frame) {
  // A short type makes a short frame; what lies behind it is not sent.
  if (frame.size < 5 || frame.size > 8 || !isData(frame, idOf(node, Command::kParameter), frame.size))
    return std::nullopt;
  Frame whole = frame;
  std::fill(whole.data.begin() + frame.size, whole.data.end(), std::uint8_t{0});
  return Parameter{static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8), wordAt(whole, 4)};
}

Frame requestParameter(int node, std::uint16_t endpoint) {
  Frame frame = makeFrame(node, Command::kReadParameter, 4);
  frame.data[1] = static_cast<std::uint8_t>(endpoint);
  frame.data[2] = static_cast<std::uint8_t>(endpoint >> 8);
  return frame;
}

Frame encodeHeartbeat(int node, const Heartbeat& value, Dialect dialect) {
  Frame frame = makeFrame(node, Command::kHeartbeat, 8);
  putWord(frame, 0, value.axis_error);
  frame.data[4] = value.state;
  if (dialect == Dialect::k06) {
    frame.data[kProcedureResultAt] = value.procedure_result;
    frame.data[kTrajectoryDoneAt] = value.trajectory_done ? 1 : 0;
    return frame;
  }
  frame.data[kMotorFlagAt] = value.motor_error ? kErrorFlag : 0;
  frame.data[kEncoderFlagAt] = value.encoder_error ? kErrorFlag : 0;
  frame.data[kControllerFlagAt] = static_cast<std::uint8_t>((value.controller_error ? kErrorFlag : 0) |
                                                            (value.trajectory_done ? kTrajectoryDone : 0));
  return frame;
}

Dialect dialectOf(const Frame& heartbeat) {
  const std::uint8_t motor = heartbeat.data[kMotorFlagAt], encoder = heartbeat.data[kEncoderFlagAt];
  const std::uint8_t controller = heartbeat.data[kControllerFlagAt];
  constexpr std::uint8_t kLastResult = 31;
  if (motor <= kErrorFlag && encoder <= kErrorFlag && controller != 0 &&
      (controller & ~(kErrorFlag | kTrajectoryDone)) == 0)
    return Dialect::k05;
  const bool result = motor > kErrorFlag && motor <= kLastResult;
  if (controller == 0 && encoder <= 1 && (result || wordAt(heartbeat, 0) >= kFirstBitOf06)) return Dialect::k06;
  return Dialect::kUnknown;
}

std::optional<Heartbeat> parseHeartbeat(int node, const Frame& frame, Dialect dialect) {
  if (!isData(frame, idOf(node, Command::kHeartbeat), 8)) return std::nullopt;
  Heartbeat value;
  value.axis_error = wordAt(frame, 0);
  value.state = frame.data[4];
  if (dialect == Dialect::k06) {
    value.procedure_result = frame.data[kProcedureResultAt];
    value.trajectory_done = frame.data[kTrajectoryDoneAt] != 0;
    return value;
  }
  value.motor_error = (frame.data[kMotorFlagAt] & kErrorFlag) != 0;
  value.encoder_error = (frame.data[kEncoderFlagAt] & kErrorFlag) != 0;
  value.controller_error = (frame.data[kControllerFlagAt] & kErrorFlag) != 0;
  value.trajectory_done = (frame.data[kControllerFlagAt] & kTrajectoryDone) != 0;
  return value;
}

Frame encodeEncoderEstimates(int node, const EncoderEstimates& value) {
  return makeFloats(node, Command::kEncoderEstimates, value.position, value.velocity);
}

std::optional<EncoderEstimates> parseEncoderEstimates(int node, const Frame& frame) {
  const auto values = parseFloats(node, Command::kEncoderEstimates, frame);
  if (!values) return std::nullopt;
  return EncoderEstimates{(*values)[0], (*values)[1]};
}

Frame encodeInputVelocity(int node, const InputVelocity& value) {
  return makeFloats(node, Command::kInputVelocity, value.velocity, value.torque);
}

std::optional<InputVelocity> parseInputVelocity(int node, const Frame& frame) {
  const auto values = parseFloats(node, Command::kInputVelocity, frame);
  if (!values) return std::nullopt;
  return InputVelocity{(*values)[0], (*values)[1]};
}

Frame encodeAxisState(int node, AxisState state) {
  Frame frame = makeFrame(node, Command::kSetAxisState, 4);
  putWord(frame, 0, static_cast<std::uint32_t>(state));
  return frame;
}

std::optional<std::uint32_t> parseAxisState(int node, const Frame& frame) {
  if (!isData(frame, idOf(node, Command::kSetAxisState), 4)) return std::nullopt;
  return wordAt(frame, 0);
}

Frame encodeClearErrors(int node) { return makeFrame(node, Command::kClearErrors, 0); }

}  // namespace slam::can::odrive
