// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/lidar/codec/rplidar_codec.hpp"

/// What a unit says of its scan modes (GET_LIDAR_CONF, firmware 1.24 and later), and which of them to start. Pure.
namespace slam::rplidar {

inline constexpr std::uint16_t kFirmwareWithExpress = 0x0111;  ///< 1.17, also of GET_SAMPLERATE
inline constexpr std::uint16_t kFirmwareWithModes = 0x0118;    ///< 1.24
/// The unit's firmware as the A series counts, for comparison with these. Other series count from 1.00 anew, and know
/// all of it from their first one.
std::uint16_t comparableFirmware(const DeviceInfo& info);
/// "RPLidar A1 (model 0x18)"
std::string modelName(std::uint8_t model);
/// How far that model measures [m], where its list of modes claims more; 0: the list is right. A C1 lists 40 m.
double longestRange(std::uint8_t model);

enum class ConfigurationEntry : std::uint32_t {
  kModeCount = 0x70,
  kSampleTime = 0x71,   ///< of a mode
  kMaxDistance = 0x74,  ///< of a mode
  kAnswerType = 0x75,   ///< of a mode
  kTypicalMode = 0x7C,
  kModeName = 0x7F,  ///< of a mode
};
std::vector<std::uint8_t> encodeConfigurationRequest(ConfigurationEntry entry, std::optional<std::uint16_t> mode = {});
/// The answer's payload. @return std::nullopt unless the answer echoes `entry`
std::optional<std::span<const std::uint8_t>> parseConfiguration(ConfigurationEntry entry,
                                                                std::span<const std::uint8_t> data);
/// Values of the payload; std::nullopt for a wrong size or a value outside the protocol.
std::optional<std::uint16_t> parseModeNumber(std::span<const std::uint8_t> payload);  ///< kModeCount, kTypicalMode
std::optional<double> parseSampleTime(std::span<const std::uint8_t> payload);         ///< [s]
std::optional<double> parseMaxDistance(std::span<const std::uint8_t> payload);        ///< [m]
std::optional<std::uint8_t> parseAnswerType(std::span<const std::uint8_t> payload);

/// Name of a mode: at most so many printable characters of what the unit sent, zero-terminated.
inline constexpr std::size_t kModeNameSize = 32;
using ModeName = std::array<char, kModeNameSize>;
ModeName parseModeName(std::span<const std::uint8_t> payload);

/// One way to scan.
struct ScanMode {
  std::uint16_t id = 0;
  bool by_express = false;       ///< started by EXPRESS_SCAN with `id`, else by SCAN
  std::uint8_t answer_type = 0;  ///< expected; the descriptor decides
  double sample_time = 508e-6;   ///< [s]
  double max_distance = 0.0;     ///< [m]; 0: not told
  ModeName name{};
};

inline constexpr std::uint16_t kMostModes = 8;  ///< that are asked for

enum class ModeWish : std::uint8_t { kDensest, kExpress, kStandard };

/// Modes to try one after the other: the densest that StreamDecoder reads first, of equally dense ones the typical one;
/// standard last.
/// @param wish   kExpress: legacy express only
/// @param listed what the unit lists; empty when it has no list
std::vector<ScanMode> modesToTry(ModeWish wish, std::uint16_t firmware, const SampleRate& rate,
                                 std::span<const ScanMode> listed, std::optional<std::uint16_t> typical);

}  // namespace slam::rplidar
