// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/cola_emulator.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "drivers/lidar/codec/cola_codec.hpp"

namespace slam::sim {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0, kAhead = 90.0;

TurnEmulator::Turn fullTurn(const ColaModel& model) {
  return {.beams = model.beams,
          .first = kDegree * (model.first - kAhead),
          .step = 2.0 * std::numbers::pi / model.per_turn,
          .time = fromSeconds(1.0 / model.turns_per_second)};
}

std::string hex(std::uint32_t value) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%X", value);
  return text.data();
}

}  // namespace

std::span<const ColaModel> colaModels() {
  static constexpr ColaModel kModels[] = {{"sick-tim", "8 TIM571-2 A V2.60-03", 811, 1080, -45.0, 0xD05, 15},
                                          {"sick-lms", "10 LMS10x_FieldEval 10 V1.44", 541, 720, -45.0, 0x1388, 50}};
  return kModels;
}

ColaEmulator::ColaEmulator(Measure measure, const ColaModel& model)
    : TurnEmulator(std::move(measure), fullTurn(model), cola::kEnd), model_(model) {}

std::string ColaEmulator::answerTo(std::string_view command) {
  const std::size_t begin = command.rfind(cola::kBegin);
  if (begin == std::string_view::npos) return {};
  command.remove_prefix(begin + 1);
  const bool works = faults().health < 2;
  if (command == "sRN DeviceIdent") return cola::telegram(std::string("sRA DeviceIdent ") + model_.identity);
  if (command == "sRN SCdevicestate") return cola::telegram(works ? "sRA SCdevicestate 1" : "sRA SCdevicestate 2");
  if (command == "sRN LMDscandata") {  // the scan measured last; its ranges are asked for by nobody
    const std::vector<double> none(static_cast<std::size_t>(model_.beams));
    return works ? scanOf("sRA", none, Duration(0), 0) : cola::telegram("sFA 4");
  }
  if (command == "sEN LMDscandata 1" || command == "sEN LMDscandata 0") {
    if (!works) return cola::telegram("sFA 4");
    setScanning(command.back() == '1');
    return cola::telegram(scanning() ? "sEA LMDscandata 1" : "sEA LMDscandata 0");
  }
  return cola::telegram("sFA 1");
}

std::string ColaEmulator::encode(std::span<const double> ranges, Duration began, std::uint32_t number) {
  return scanOf("sSN", ranges, began, number);
}

std::string ColaEmulator::scanOf(std::string_view kind, std::span<const double> ranges, Duration began,
                                 std::uint32_t number) const {
  const auto us = static_cast<std::uint32_t>(began / std::chrono::microseconds(1));
  const auto state = static_cast<std::uint32_t>(faults().health == 1 ? 2 : 0);
  const std::uint32_t counter = number & 0xFFFF;
  const auto rounded = [](double value) { return static_cast<std::uint32_t>(std::lround(value)); };
  std::array<char, 256> head{};
  std::snprintf(head.data(), head.size(),
                " LMDscandata 1 1 89A27F 0 %X %X %X %X %X 0 0 1 0 0 %X %X 0 1 DIST1 3F800000 00000000 %X %X %X", state,
                counter, counter, us, us, rounded(100.0 * model_.turns_per_second),
                rounded(model_.turns_per_second * model_.per_turn / 100.0), rounded(10000.0 * model_.first),
                model_.step, static_cast<unsigned>(ranges.size()));
  std::string text(kind);
  text += head.data();
  for (const double range : ranges) text.append(" ").append(hex(rounded(1000.0 * range)));
  return cola::telegram(text.append(" 0 0 0 0 0 0"));
}

}  // namespace slam::sim
