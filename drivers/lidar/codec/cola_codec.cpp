// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/cola_codec.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>

#include "core/scan.hpp"
#include "drivers/lidar/codec/lidar_packets.hpp"

namespace slam::cola {
namespace {

/// The next field of a text; empty at its end.
std::string_view takeField(std::string_view& text) {
  const std::size_t end = std::min(text.find(' '), text.size());
  const std::string_view field = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return field;
}

/// Fields of which the first bad one spoils all.
class Fields {
 public:
  explicit Fields(std::string_view text) : text_(text) {}

  std::uint32_t number(std::uint32_t least = 0, std::uint32_t most = 0xFFFFFFFF) {
    const auto value = takeNumber(text_);
    good_ = good_ && value && *value >= least && *value <= most;
    return good_ ? *value : least;
  }
  void skip(std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i) good_ = !takeField(text_).empty() && good_;
  }
  void expect(std::string_view text) { good_ = takeField(text_) == text && good_; }
  void expectOneOf(std::string_view a, std::string_view b) {
    const std::string_view field = takeField(text_);
    good_ = (field == a || field == b) && good_;
  }
  bool good() const { return good_; }
  std::string_view rest() const { return text_; }

 private:
  std::string_view text_;
  bool good_ = true;
};

}  // namespace

std::string telegram(std::string_view text) { return kBegin + std::string(text) + kEnd; }

std::optional<std::string> findTelegram(std::string_view bytes, std::string_view answer, std::string_view error,
                                        std::size_t& size) {
  for (std::size_t begin = bytes.find(kBegin); begin != std::string_view::npos; begin = bytes.find(kBegin, begin + 1)) {
    const std::string_view text = bytes.substr(begin + 1);
    if (!text.starts_with(answer) && !text.starts_with(error)) continue;
    const std::size_t end = text.find(kEnd);
    if (end == std::string_view::npos) return std::nullopt;
    size = begin + 1 + end + 1;
    return std::string(text.substr(0, end));
  }
  return std::nullopt;
}

std::optional<std::uint32_t> takeNumber(std::string_view& text) {
  const std::string_view field = takeField(text);
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value, 16);
  const bool good = !field.empty() && error == std::errc() && end == field.data() + field.size();
  return good ? std::optional(value) : std::nullopt;
}

std::uint16_t Scan::angleQ6(int beam) const { return nodeAngle(std::lround(64.0 * (first + beam * step()))); }

bool Scan::isLike(const Scan& other) const {
  return beams == other.beams && per_turn == other.per_turn && first == other.first && turn_time == other.turn_time;
}

std::optional<Scan> parseScan(std::string_view text) {
  constexpr std::uint32_t kMostEncoders = 16, kSlowest = 100, kFastest = 10000;  // [1/100 Hz] of turns
  constexpr double kDegrees = 1e-4, kAhead = 90.0, kMostTurn = 361.0;            // [deg]
  constexpr float kMostScale = 64.0F;
  Fields fields(text);
  fields.expectOneOf("sSN", "sRA");
  fields.expect(kScanName);
  fields.skip(4);  // version, device, serial number, first half of its state
  Scan scan;
  const std::uint32_t state = fields.number();
  if (state == 2) scan.contamination = Contamination::kWarning;
  if (state == 5) scan.contamination = Contamination::kError;
  fields.skip(2);  // counters of telegrams and scans
  scan.began_us = fields.number();
  fields.skip(6);  // time of sending, inputs, outputs, layer
  scan.turn_time = 100.0 / fields.number(kSlowest, kFastest);
  fields.skip(1);  // rate of measurements, in one of two units
  fields.skip(2 * fields.number(0, kMostEncoders));
  fields.number(1, kMostEncoders);  // channels, of which the first is that of the distances
  fields.expect("DIST1");
  const float scale = std::bit_cast<float>(fields.number());
  fields.skip(1);  // offset of the scale
  scan.scale = scale;
  scan.first = kDegrees * static_cast<std::int32_t>(fields.number()) - kAhead;
  const double step = kDegrees * fields.number(1, 0xFFFF);
  scan.beams = static_cast<int>(fields.number(1, LaserScan::kCapacity));
  scan.values = fields.rest();
  // A step is printed rounded: 0.3333 is a third, of which a turn has a whole number.
  scan.per_turn = static_cast<int>(std::lround(360.0 / step));
  const bool possible = scale > 0.0F && scale <= kMostScale && std::abs(scan.first) <= 2.0 * kMostTurn &&
                        scan.beams <= scan.per_turn + 1 && scan.per_turn <= 4 * LaserScan::kCapacity;
  return fields.good() && possible ? std::optional(scan) : std::nullopt;
}

}  // namespace slam::cola
