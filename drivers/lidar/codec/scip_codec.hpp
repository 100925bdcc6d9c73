// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// SCIP 2.0, the protocol of Hokuyo's lidars: lines of text, of which most end with the sum of their characters. Pure.
namespace slam::scip {

inline constexpr std::size_t kLineData = 64;  ///< [characters] of a data line, at most; behind them stands the sum
inline constexpr std::size_t kRangeSize = 3;  ///< [characters] of a range in the answers of MD
inline constexpr std::size_t kStampSize = 4;  ///< [characters] of a time stamp [ms], which wraps with kStampWrap
inline constexpr std::uint32_t kStampWrap = 1U << 24;  ///< [ms]
inline constexpr std::string_view kScanStatus = "99b",
                                  kStartStatus = "00P";  ///< of a scan; of the command that began it

char sumOf(std::string_view text);
/// Its last character is the sum of those before it.
bool sumFits(std::string_view line);
/// Six bits a character, the highest first. @param text five characters at most
std::uint32_t decode(std::string_view text);
std::string encode(std::uint32_t value, std::size_t characters);

/// What an answer to a command consists of behind its echo.
struct Answer {
  std::string status;              ///< two characters; empty: its sum was wrong
  std::vector<std::string> lines;  ///< behind the status, as they came
};
/// @param text whatever came, old bytes before the echo too. @param size [bytes] out: up to the end of the answer
/// @return std::nullopt while it is not whole
std::optional<Answer> findAnswer(std::string_view text, std::string_view command, std::size_t& size);
/// Value of a line `KEY:value;s`. @return empty where no line with a right sum has that key
std::string valueOf(const Answer& answer, std::string_view key);

/// What the unit is and measures: its answer to PP.
struct Parameters {
  std::string model;
  int steps_per_turn = 0;         ///< ARES
  int first = 0, last = 0;        ///< AMIN, AMAX: steps that it measures
  int front = 0;                  ///< AFRT: the step that looks ahead
  int least_mm = 0, most_mm = 0;  ///< DMIN, DMAX: what lies outside is no range but a code for no echo
  int turns_per_minute = 0;       ///< SCAN

  int steps() const { return last - first + 1; }
  double turnTime() const { return 60.0 / turns_per_minute; }      ///< [s]
  double stepTime() const { return turnTime() / steps_per_turn; }  ///< [s]
  std::uint16_t angleQ6(int step) const;                           ///< [deg * 64] counter-clockwise
};
/// @return std::nullopt where one is missing or cannot be
std::optional<Parameters> parseParameters(const Answer& answer);
/// The command for scans without end, of all steps.
std::string scanCommand(const Parameters& parameters);

}  // namespace slam::scip
