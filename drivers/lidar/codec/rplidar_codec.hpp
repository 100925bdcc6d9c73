// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/lidar/lidar_decoder.hpp"

/// RPLidar A-series serial protocol: requests, answers and standard nodes (Slamtec, "Interface Protocol and Application
/// Notes"). Pure: no I/O, no clock. Capsules are in rplidar_capsules.hpp, damaged streams in rplidar_stream.hpp.
namespace slam::rplidar {

enum class Request : std::uint8_t {
  kStop = 0x25,
  kReset = 0x40,
  kScan = 0x20,
  kGetInfo = 0x50,
  kGetHealth = 0x52,
  kGetSampleRate = 0x59,
  kExpressScan = 0x82,
  kGetConfiguration = 0x84,
  kSetMotorSpeed = 0xA8,
  kSetMotorPwm = 0xF0,
  kGetAccessoryBoardFlag = 0xFF,
};

/// `A5 cmd` and, when bit 7 of cmd is set, `size payload... checksum`; the checksum is the XOR of all bytes before it.
std::vector<std::uint8_t> encodeRequest(Request request, std::span<const std::uint8_t> payload = {});
std::vector<std::uint8_t> encodeExpressScan(std::uint8_t mode = 0);
std::vector<std::uint8_t> encodeMotorPwm(std::uint16_t pwm);
std::vector<std::uint8_t> encodeMotorSpeed(std::uint16_t rpm);  ///< S series

enum class AnswerType : std::uint8_t {
  kInfo = 0x04,
  kHealth = 0x06,
  kSampleRate = 0x15,
  kConfiguration = 0x20,
  kStandardNodes = 0x81,
  kExpressCapsules = 0x82,
  kUltraCapsules = 0x84,
  kDenseCapsules = 0x85,
  kUltraDenseCapsules = 0x86,
  kAccessoryBoardFlag = 0xFF,
};

/// Announces an answer: `A5 5A`, u32 LE (30 bits length, 2 bits send mode), type.
struct Descriptor {
  std::uint32_t length = 0;  ///< [bytes] of one answer
  bool stream = false;       ///< answers of that length follow without end
  std::uint8_t type = 0;     ///< AnswerType, or a value that it does not name
};
inline constexpr std::size_t kDescriptorSize = 7;
std::array<std::uint8_t, kDescriptorSize> encodeDescriptor(const Descriptor& descriptor);
/// @param bytes exactly kDescriptorSize; std::nullopt unless they begin with A5 5A
std::optional<Descriptor> parseDescriptor(std::span<const std::uint8_t> bytes);

struct DeviceInfo {
  std::uint8_t model = 0;      ///< major id in the high nibble
  std::uint16_t firmware = 0;  ///< high byte major, low byte minor
  std::uint8_t hardware = 0;
  std::array<std::uint8_t, 16> serial{};
};
enum class HealthStatus : std::uint8_t { kOk = 0, kWarning = 1, kError = 2 };
struct Health {
  HealthStatus status = HealthStatus::kOk;  ///< kError: Protection Stop, only a reset leaves it
  std::uint16_t error_code = 0;
};
struct SampleRate {
  std::uint16_t standard_us = 0, express_us = 0;  ///< [us] per sample
};
/// Each returns std::nullopt for a wrong size or a value outside the protocol.
std::optional<DeviceInfo> parseInfo(std::span<const std::uint8_t> data);
std::optional<Health> parseHealth(std::span<const std::uint8_t> data);
std::optional<SampleRate> parseSampleRate(std::span<const std::uint8_t> data);

using Node = LidarNode;  ///< its angle is clockwise seen from above

/// Standard node `81`, 5 bytes: no sync word and weak check bits.
inline constexpr std::size_t kStandardNodeSize = 5;
std::array<std::uint8_t, kStandardNodeSize> encodeStandardNode(const Node& node);
std::optional<Node> parseStandardNode(std::span<const std::uint8_t> bytes);

}  // namespace slam::rplidar
