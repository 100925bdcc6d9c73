// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/scip_emulator.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <utility>

#include "drivers/lidar/codec/scip_codec.hpp"

namespace slam::sim {
namespace {

using Pair = std::pair<const char*, std::string>;

constexpr double kTurn = 2.0 * std::numbers::pi;

TurnEmulator::Turn fullTurn(const ScipModel& model) {
  return {.beams = model.last - model.first + 1,
          .first = kTurn * (model.first - model.front) / model.steps_per_turn,
          .step = kTurn / model.steps_per_turn,
          .time = fromSeconds(60.0 / model.turns_per_minute)};
}

std::string withSum(const std::string& line) { return line + scip::sumOf(line) + "\n"; }

std::string linesOf(std::initializer_list<Pair> pairs) {
  std::string text;
  for (const auto& [key, value] : pairs) {
    const std::string line = std::string(key) + ":" + value;
    text += line + ";" + scip::sumOf(line) + "\n";
  }
  return text;
}

}  // namespace

std::span<const ScipModel> scipModels() {
  static constexpr ScipModel kModels[] = {{"hokuyo-urg", "URG-04LX", 1024, 44, 725, 384, 20, 5600, 600},
                                          {"hokuyo-ust", "UST-10LX", 1440, 0, 1080, 540, 20, 30000, 2400},
                                          {"hokuyo-utm", "UTM-30LX", 1440, 0, 1080, 540, 23, 60000, 2400}};
  return kModels;
}

ScipEmulator::ScipEmulator(Measure measure, const ScipModel& model)
    : TurnEmulator(std::move(measure), fullTurn(model), '\n'), model_(model) {}

std::string ScipEmulator::answerTo(std::string_view command) {
  const std::string echo = std::string(command) + "\n";
  const bool works = faults().health < 2;
  const std::string parameters = linesOf({{"MODL", model_.product},
                                          {"DMIN", std::to_string(model_.least_mm)},
                                          {"DMAX", std::to_string(model_.most_mm)},
                                          {"ARES", std::to_string(model_.steps_per_turn)},
                                          {"AMIN", std::to_string(model_.first)},
                                          {"AMAX", std::to_string(model_.last)},
                                          {"AFRT", std::to_string(model_.front)},
                                          {"SCAN", std::to_string(model_.turns_per_minute)}});
  if (command == "VV")
    return echo + withSum("00") +
           linesOf({{"VEND", "Hokuyo Automatic Co.,Ltd."},
                    {"PROD", std::string("SOKUIKI Sensor ") + model_.product},
                    {"FIRM", "3.4.03(17/Dec./2012)"},
                    {"PROT", "SCIP 2.0"},
                    {"SERI", "H0000001"}}) +
           "\n";
  if (command == "PP") return echo + withSum("00") + parameters + "\n";
  if (command == "II")
    return echo + withSum("00") +
           linesOf({{"MODL", model_.product},
                    {"LASR", scanning() ? "ON" : "OFF"},
                    {"STAT", works ? "Sensor works well." : "Sensor stops working: laser is in trouble."}}) +
           "\n";
  if (command == "QT" || command == "RS") setScanning(false);
  if (command == "QT" || command == "RS") return echo + withSum("00") + "\n";
  if (command == "BM") return echo + withSum(works ? scanning() ? "02" : "00" : "01") + "\n";
  if (command.size() == 15 && command.starts_with("MD")) {
    if (!works) return echo + withSum("0L") + "\n";
    setScanning(true);
    scan_ = command;
    return echo + withSum("00") + "\n";
  }
  return echo + withSum("0E") + "\n";
}

std::string ScipEmulator::encode(std::span<const double> ranges, Duration began, std::uint32_t) {
  const auto ms = static_cast<std::uint32_t>(began / std::chrono::milliseconds(1) % scip::kStampWrap);
  std::string data, text = scan_ + "\n" + withSum("99") + withSum(scip::encode(ms, scip::kStampSize));
  for (const double range : ranges) {
    const long mm = std::lround(1000.0 * range);
    const bool echo = mm >= model_.least_mm && mm <= model_.most_mm;
    data += scip::encode(echo ? static_cast<std::uint32_t>(mm) : 1U, scip::kRangeSize);  // 1: too little light
  }
  for (std::size_t at = 0; at < data.size(); at += scip::kLineData) text += withSum(data.substr(at, scip::kLineData));
  return text + "\n";
}

}  // namespace slam::sim
