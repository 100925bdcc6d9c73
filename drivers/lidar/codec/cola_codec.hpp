// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// CoLa A, SICK's protocol of text: telegrams between STX and ETX of fields with a blank between, numbers in
/// hexadecimal. They have no checksum: TCP has. Pure.
namespace slam::cola {

inline constexpr char kBegin = '\x02', kEnd = '\x03';
inline constexpr std::size_t kLongest =
    32768;  ///< [bytes] of a telegram: five times that of 1081 ranges with intensities
inline constexpr std::string_view kScanName = "LMDscandata";

std::string telegram(std::string_view text);
/// The first whole telegram that begins with one of the two texts. @param size out: [bytes] up to its end
std::optional<std::string> findTelegram(std::string_view bytes, std::string_view answer, std::string_view error,
                                        std::size_t& size);

enum class Contamination : std::uint8_t { kNone, kWarning, kError };

/// What a telegram of a scan says before its ranges.
struct Scan {
  Contamination contamination = Contamination::kNone;  ///< of the window
  std::uint32_t began_us = 0;                          ///< [us] by the unit's clock, which wraps
  double turn_time = 0.0;                              ///< [s]
  int per_turn = 0;                                    ///< steps of a whole turn
  double first = 0.0;                                  ///< [deg] of the first beam, counter-clockwise from ahead
  int beams = 0;
  double scale = 1.0;       ///< [mm] of a count
  std::string_view values;  ///< the ranges, as text; within the telegram

  double step() const { return 360.0 / per_turn; }          ///< [deg]
  double stepTime() const { return turn_time / per_turn; }  ///< [s]
  std::uint16_t angleQ6(int beam) const;                    ///< [deg * 64] counter-clockwise
  /// Another scan measures the same beams.
  bool isLike(const Scan& other) const;
};
/// @param text of a telegram. @return std::nullopt for another one, or one with fields that are missing or cannot be
std::optional<Scan> parseScan(std::string_view text);
/// Takes the next number off a text of hexadecimal numbers. @return std::nullopt where none stands, or one above 32
/// bits
std::optional<std::uint32_t> takeNumber(std::string_view& text);

}  // namespace slam::cola
