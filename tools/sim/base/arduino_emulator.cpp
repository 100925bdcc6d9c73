// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>
#include <cstdio>
#include <numbers>
#include <string>

#include "firmware_if/arduino_bridge.hpp"
#include "tools/sim/base/counting_base.hpp"

namespace slam::sim {
namespace {

/// An Arduino with ros_arduino_bridge: it has its power from the plug, boots for 2 s, and stops by itself 2 s after
/// `m`.
class ArduinoEmulator : public CountingBase {
 public:
  ArduinoEmulator() : CountingBase(geometryOf("text"), {}) {}
  void loseItsPlug() override { inject("reset", 1.0); }

 protected:
  void restart() override {
    setCountsBack();
    line_.clear();
    wanted_ = {};
    boots_to_ = now() + fromSeconds(arduino_bridge::kBoot);
  }
  void take(std::uint8_t byte, Bytes& out) override {
    if (now() < boots_to_) return;
    if (byte != '\r') {
      if (line_.size() < arduino_bridge::LineDecoder::kLongest) line_ += static_cast<char>(byte);
      return;
    }
    use();
    answer(obey(), out);
    line_.clear();
  }
  SideSpeeds sides() const override {
    return now() - commanded_ < fromSeconds(arduino_bridge::kAutoStop) ? wanted_ : SideSpeeds{};
  }

 private:
  std::string obey() {
    if (line_ == "b") return std::to_string(arduino_bridge::kBaud);
    if (line_ == "e") return std::to_string(word(counts()[0])) + " " + std::to_string(word(counts()[1]));
    if (line_ == "r") return setCountsBack(), "OK";
    int left = 0, right = 0, used = 0;
    const bool speeds =
        std::sscanf(line_.c_str(), "m %d %d%n", &left, &right, &used) == 2 && used == static_cast<int>(line_.size());
    if (!speeds) return "Invalid Command";
    const double count = 2.0 * std::numbers::pi * geometry().base.wheel_radius / geometry().counts_per_turn;  // [m]
    wanted_ = {arduino_bridge::kLoopRate * count * left, arduino_bridge::kLoopRate * count * right};
    commanded_ = now();
    return "OK";
  }
  static std::int32_t word(std::int64_t count) { return static_cast<std::int32_t>(count); }
  void answer(const std::string& text, Bytes& out) {
    Outgoing line;
    for (const char c : text + "\r\n") line.addByte(static_cast<std::uint8_t>(c));
    deliver(line, out);
  }

  std::string line_;  // that is not ended yet
  SideSpeeds wanted_;
  Timestamp commanded_{}, boots_to_{};
};

}  // namespace

std::unique_ptr<EmulatedBase> makeArduino() { return std::make_unique<ArduinoEmulator>(); }

}  // namespace slam::sim
