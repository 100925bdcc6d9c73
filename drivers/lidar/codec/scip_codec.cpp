// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/scip_codec.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "core/scan.hpp"
#include "drivers/lidar/codec/lidar_packets.hpp"

namespace slam::scip {
namespace {

constexpr int kSixBits = 0x3F, kZero = 0x30;

/// A number within limits; `outside` where there is none.
int numberOf(const Answer& answer, std::string_view key, int least, int most, bool& good) {
  const std::string text = valueOf(answer, key);
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  good = good && error == std::errc() && end == text.data() + text.size() && value >= least && value <= most;
  return value;
}

}  // namespace

char sumOf(std::string_view text) {
  int sum = 0;
  for (const char c : text) sum += static_cast<unsigned char>(c);
  return static_cast<char>((sum & kSixBits) + kZero);
}

bool sumFits(std::string_view line) {
  return line.size() >= 2 && sumOf(line.substr(0, line.size() - 1)) == line.back();
}

std::uint32_t decode(std::string_view text) {
  std::uint32_t value = 0;
  for (const char c : text) value = value << 6 | (static_cast<std::uint32_t>(c - kZero) & kSixBits);
  return value;
}

std::string encode(std::uint32_t value, std::size_t characters) {
  std::string text(characters, '0');
  for (std::size_t i = characters; i-- > 0; value >>= 6) text[i] = static_cast<char>((value & kSixBits) + kZero);
  return text;
}

std::optional<Answer> findAnswer(std::string_view text, std::string_view command, std::size_t& size) {
  const std::string echo = std::string(command) + "\n";
  std::size_t begin = text.find(echo);
  // At the start of a line: the same characters may stand within an old one.
  while (begin != std::string_view::npos && begin > 0 && text[begin - 1] != '\n') begin = text.find(echo, begin + 1);
  if (begin == std::string_view::npos) return std::nullopt;
  begin += echo.size();
  const std::size_t end = text.find("\n\n", begin);
  if (end == std::string_view::npos) return std::nullopt;
  size = end + 2;
  Answer answer;
  std::string_view rest = text.substr(begin, end - begin);
  while (!rest.empty()) {
    const std::size_t line = std::min(rest.find('\n'), rest.size());
    answer.lines.emplace_back(rest.substr(0, line));
    rest.remove_prefix(std::min(line + 1, rest.size()));
  }
  if (answer.lines.empty()) return answer;
  if (const std::string& status = answer.lines.front(); status.size() == 3 && sumFits(status))
    answer.status = status.substr(0, 2);
  answer.lines.erase(answer.lines.begin());
  return answer;
}

std::string valueOf(const Answer& answer, std::string_view key) {
  for (const std::string& line : answer.lines) {
    const std::size_t end = line.rfind(';');
    if (!line.starts_with(key) || line.size() <= key.size() || line[key.size()] != ':') continue;
    if (end == std::string::npos || end + 2 != line.size()) continue;
    const char sum = line.back();  // the semicolon is in it or not
    if (sumOf(line.substr(0, end)) != sum && sumOf(line.substr(0, end + 1)) != sum) continue;
    return line.substr(key.size() + 1, end - key.size() - 1);
  }
  return {};
}

std::uint16_t Parameters::angleQ6(int step) const {
  constexpr double kTurnQ6 = 360.0 * 64.0;
  return nodeAngle(std::lround(kTurnQ6 * (step - front) / steps_per_turn));
}

std::optional<Parameters> parseParameters(const Answer& answer) {
  constexpr int kMostSteps = LaserScan::kCapacity, kMostRange = 1 << 18, kLeastTurns = 60, kMostTurns = 12000;
  bool good = true;
  Parameters unit;
  unit.model = valueOf(answer, "MODL");
  unit.steps_per_turn = numberOf(answer, "ARES", 16, kMostSteps, good);
  unit.first = numberOf(answer, "AMIN", 0, kMostSteps, good);
  unit.last = numberOf(answer, "AMAX", 1, kMostSteps, good);
  unit.front = numberOf(answer, "AFRT", 0, kMostSteps, good);
  unit.least_mm = numberOf(answer, "DMIN", 0, kMostRange, good);
  unit.most_mm = numberOf(answer, "DMAX", 1, kMostRange, good);
  unit.turns_per_minute = numberOf(answer, "SCAN", kLeastTurns, kMostTurns, good);
  good = good && unit.first < unit.last && unit.steps() <= unit.steps_per_turn && unit.least_mm < unit.most_mm;
  return good ? std::optional(unit) : std::nullopt;
}

std::string scanCommand(const Parameters& parameters) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "MD%04d%04d01000", parameters.first, parameters.last);
  return text.data();
}

}  // namespace slam::scip
