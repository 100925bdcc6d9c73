// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/rplidar_modes.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "drivers/lidar/rplidar_stream.hpp"

namespace slam::rplidar {
namespace {

constexpr std::size_t kEntrySize = 4;
constexpr auto kStandard = static_cast<std::uint8_t>(AnswerType::kStandardNodes);
constexpr auto kExpress = static_cast<std::uint8_t>(AnswerType::kExpressCapsules);

std::optional<double> parseQ8(std::span<const std::uint8_t> payload) {
  if (payload.size() != 4) return std::nullopt;
  const std::uint32_t q8 = payload[0] | static_cast<std::uint32_t>(payload[1]) << 8 |
                           static_cast<std::uint32_t>(payload[2]) << 16 | static_cast<std::uint32_t>(payload[3]) << 24;
  return q8 / 256.0;
}

}  // namespace

std::uint16_t comparableFirmware(const DeviceInfo& info) {
  const int series = info.model >> 4;
  return series >= 1 && series <= 3 ? info.firmware : 0xFFFF;
}

std::string modelName(std::uint8_t model) {
  const int series = model >> 4;
  std::array<char, 32> text{};
  const char letter = series >= 1 && series <= 3 ? 'A' : series == 4 ? 'C' : series >= 6 && series <= 8 ? 'S' : '\0';
  const int number = letter == 'A' ? series : letter == 'C' ? series - 3 : series - 5;
  const auto code = static_cast<unsigned>(model);
  letter != '\0' ? std::snprintf(text.data(), text.size(), "RPLidar %c%d (model 0x%02x)", letter, number, code)
                 : std::snprintf(text.data(), text.size(), "RPLidar (model 0x%02x)", code);
  return text.data();
}

double longestRange(std::uint8_t model) {
  constexpr double kC1 = 12.0;  // [m] its data sheet
  return model >> 4 == 4 ? kC1 : 0.0;
}

std::vector<std::uint8_t> encodeConfigurationRequest(ConfigurationEntry entry, std::optional<std::uint16_t> mode) {
  const auto type = static_cast<std::uint32_t>(entry);
  std::vector<std::uint8_t> payload;
  for (std::size_t i = 0; i < kEntrySize; ++i) payload.push_back(static_cast<std::uint8_t>(type >> 8 * i));
  if (mode) payload.insert(payload.end(), {static_cast<std::uint8_t>(*mode), static_cast<std::uint8_t>(*mode >> 8)});
  return encodeRequest(Request::kGetConfiguration, payload);
}

std::optional<std::span<const std::uint8_t>> parseConfiguration(ConfigurationEntry entry,
                                                                std::span<const std::uint8_t> data) {
  if (data.size() < kEntrySize) return std::nullopt;
  const std::uint32_t type = data[0] | static_cast<std::uint32_t>(data[1]) << 8 |
                             static_cast<std::uint32_t>(data[2]) << 16 | static_cast<std::uint32_t>(data[3]) << 24;
  if (type != static_cast<std::uint32_t>(entry)) return std::nullopt;
  return data.subspan(kEntrySize);
}

std::optional<std::uint16_t> parseModeNumber(std::span<const std::uint8_t> payload) {
  if (payload.size() != 2) return std::nullopt;
  return static_cast<std::uint16_t>(payload[0] | payload[1] << 8);
}

std::optional<double> parseSampleTime(std::span<const std::uint8_t> payload) {
  const auto us = parseQ8(payload);
  constexpr double kLeast = 5.0, kMost = 5000.0;  // [us] beyond, it is no lidar of this family
  return us && *us >= kLeast && *us <= kMost ? std::optional(1e-6 * *us) : std::nullopt;
}

std::optional<double> parseMaxDistance(std::span<const std::uint8_t> payload) { return parseQ8(payload); }

std::optional<std::uint8_t> parseAnswerType(std::span<const std::uint8_t> payload) {
  return payload.size() == 1 ? std::optional(payload[0]) : std::nullopt;
}

ModeName parseModeName(std::span<const std::uint8_t> payload) {
  ModeName name{};
  for (std::size_t i = 0; i < std::min(payload.size(), kModeNameSize - 1) && payload[i] != 0; ++i) {
    name[i] = payload[i] >= 0x20 && payload[i] < 0x7F ? static_cast<char>(payload[i]) : '?';
  }
  return name;
}

std::vector<ScanMode> modesToTry(ModeWish wish, std::uint16_t firmware, const SampleRate& rate,
                                 std::span<const ScanMode> listed, std::optional<std::uint16_t> typical) {
  ScanMode standard{.answer_type = kStandard, .sample_time = 1e-6 * rate.standard_us};
  ScanMode express{.by_express = true, .answer_type = kExpress, .sample_time = 1e-6 * rate.express_us};
  std::vector<ScanMode> dense;
  for (const ScanMode& mode : listed) {
    if (mode.answer_type == kStandard) {
      standard = mode;
      standard.by_express = false;
    } else if (packetFormat(mode.answer_type)) {
      dense.push_back(mode);
      dense.back().by_express = true;
    }
    if (mode.answer_type == kExpress) express = dense.back();
  }
  if (wish == ModeWish::kStandard) return {standard};
  if (wish == ModeWish::kExpress) return {express};

  if (dense.empty() && firmware >= kFirmwareWithExpress) dense.push_back(express);
  std::stable_sort(dense.begin(), dense.end(), [&](const ScanMode& a, const ScanMode& b) {
    if (a.sample_time != b.sample_time) return a.sample_time < b.sample_time;
    return typical && a.id == *typical && b.id != *typical;
  });
  dense.push_back(standard);
  return dense;
}

}  // namespace slam::rplidar
