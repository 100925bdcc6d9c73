// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "core/scan.hpp"
#include "drivers/lidar/rplidar_stream.hpp"
#include "drivers/lidar/scan_assembler.hpp"
#include "timing/sample_clock.hpp"

namespace slam::rplidar {

/// Looks for a text among bytes. The text must not begin again within itself but for its first character.
class TextWatch {
 public:
  explicit constexpr TextWatch(std::string_view text) : text_(text) {}
  /// @return true with the byte that completes the text
  bool push(std::uint8_t byte) {
    const char c = static_cast<char>(byte);
    if (c != text_[matched_]) matched_ = 0;
    if (c == text_[matched_]) ++matched_;
    if (matched_ < text_.size()) return false;
    matched_ = 0;
    return true;
  }

 private:
  std::string_view text_;
  std::size_t matched_ = 0;
};

inline constexpr std::string_view kBootText = "RP LIDAR";   ///< begins the banner that a unit sends after its reset
inline constexpr std::string_view kBootEndText = "Model:";  ///< in its last line

/// From the bytes of a running scan, with their arrival, to LaserScans whose beams carry the time of their sampling.
/// Pure: time comes with the bytes. Does not allocate after construction.
class ScanStream {
 public:
  struct Format {
    AnswerType type = AnswerType::kStandardNodes;
    double sample_time = 508e-6;         ///< [s] per sample
    double byte_time = 10.0 / 115200.0;  ///< [s] on the line
    RangeLimits limits{};                ///< written into the scans
  };
  using Sink = std::function<void(const LaserScan&)>;

  explicit ScanStream(const Format& format);

  /// @param arrival of the last of `bytes`. @return nodes decoded
  int push(std::span<const std::uint8_t> bytes, Timestamp arrival, const Sink& sink);
  /// Begins anew behind a gap: the turn under way has a hole, and its stamps are doubtful.
  void restart();
  /// Takes nothing from bytes that are too old but whether the unit restarted.
  void skip(std::span<const std::uint8_t> bytes);
  bool sawBootText() const { return saw_boot_text_; }
  std::int64_t rejects() const;                                  ///< nodes and capsules refused, turns given up
  std::uint32_t turns() const { return assembler_.turns(); }     ///< that the head has made, given up or not
  std::int64_t thinned() const { return assembler_.thinned(); }  ///< measurements left out evenly
  int stride() const { return assembler_.stride(); }             ///< of the last finished turn
  const DecoderCounters& counters() const { return decoder_.counters(); }

 private:
  Format format_;
  StreamDecoder decoder_;
  SampleClock clock_;
  ScanAssembler assembler_;
  std::vector<TimedNode> nodes_;
  TextWatch boot_text_{kBootText};
  bool saw_boot_text_ = false;
  std::uint32_t encoder_resets_ = 0, restarts_ = 0;
};

}  // namespace slam::rplidar
