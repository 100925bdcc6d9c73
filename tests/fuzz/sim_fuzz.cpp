// SPDX-License-Identifier: BSD-3-Clause
// The input is a byte that chooses what the rest is: slam-sim's --faults, a script; the same in numbers, each of a
// device, a kind of fault and its value; or --with, one situation a line. The faults of a script are handed to the
// emulated devices before these run for 0.05 s.
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

#include "core/scan.hpp"
#include "drivers/lidar/codec/rplidar_codec.hpp"
#include "fuzz/fuzzing.hpp"
#include "tools/sim/board/board_emulator.hpp"
#include "tools/sim/board/imu_emulator.hpp"
#include "tools/sim/can/can_emulator.hpp"
#include "tools/sim/depth/depth_faults.hpp"
#include "tools/sim/faults/fault_script.hpp"
#include "tools/sim/faults/line_faults.hpp"
#include "tools/sim/lidar/lidar_emulator.hpp"
#include "tools/sim/situation/situation.hpp"

namespace slam::sim {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

constexpr Timestamp kStart{1000s};
constexpr auto kStep = 10ms;
constexpr int kSteps = 5;
constexpr std::array kDevices = {"lidar", "board", "imu", "can", "depth"};
constexpr std::array kKinds = {
    "unplug",     "garbage",       "delay",  "silent",   "stuck",      "slow",        "wrong",
    "checksum",   "freeze",        "health", "stall",    "lose",       "insert",      "flip",
    "pause",      "turn",          "reboot", "stale",    "unit",       "other",       "echoes",
    "dust",       "encoder_reset", "reset",  "bus_off",  "gyro_wrong", "imu_offline", "watchdog",
    "axis_error", "idle",          "deaf",   "firmware", "estimates",  "imu_time",    "imu_acceleration",
    "quaternion"};

/// The devices that faults are for, each behind its line.
class Devices {
 public:
  Devices() {
    Bytes descriptor;
    lidar_.receive(rplidar::encodeRequest(rplidar::Request::kScan), kStart, descriptor);
  }
  void inject(const Fault& fault) {
    const auto& [device, kind, value] = fault;
    if (device == "can") can_.inject(kind, value);
    if (device == "depth") depth_.inject(kind, value);
    if (line_.inject(kind, value)) return;
    if (device == "lidar") lidar_.inject(kind, value);
    if (device == "board") board_.inject(kind, value);
    if (device == "imu") imu_.inject(kind, value);
  }
  /// Whatever is wrong with them, no device sends more than its line can bear.
  void run() {
    constexpr std::size_t kMost = 32768;  // [bytes] far more than 10 ms of any, and what was delayed
    Bytes frame(256);
    for (int i = 0; i < kSteps; ++i) {
      const Timestamp now = kStart + i * kStep;
      Bytes bytes;
      lidar_.stream(now, bytes);
      const double uptime = 1.0 + toSeconds(i * kStep);
      board_.renew(0.01 * i, 0.02 * i, {}, uptime);
      board_.receive({}, uptime, bytes);
      imu_.sample({0.0, 0.0, 0.1}, {0.0, 0.0, 9.8}, bytes);
      FUZZ_CHECK(line_.pass(std::move(bytes), now).size() <= kMost);
      std::vector<can::Frame> frames;
      can_.step(now, {.angles = {0.01 * i, 0.02 * i}}, frames);
      FUZZ_CHECK(frames.size() <= kMost);
      for (const can::Frame& sent : frames) FUZZ_CHECK(sent.size <= 8);
      depth_.spoil(frame);
    }
  }

 private:
  LidarEmulator lidar_{[](Timestamp, double bearing) { return 2.0 + std::cos(bearing); }, 5.5};
  BoardEmulator board_;
  ImuEmulator imu_{ImuEmulator::Framing::kA9};
  CanEmulator can_;
  DepthFaults depth_;
  LineFaults line_;
};

void checkScript(const std::string& text) {
  std::istringstream in(text);
  const auto script = readFaultScript(in, "fuzz");
  FUZZ_CHECK(script.size() <= text.size());
  Devices devices;
  for (std::size_t i = 0; i < script.size(); ++i) {
    FUZZ_CHECK(script[i].at >= Duration(0) && (i == 0 || script[i - 1].at <= script[i].at));
    devices.inject(script[i].fault);
  }
  if (!script.empty()) devices.run();
}

std::string scriptOf(fuzz::Input& input) {
  std::ostringstream script;
  script.precision(17);
  while (!input.atEnd()) {
    script << input.take<std::uint16_t>() << ' ' << kDevices[input.take<std::uint8_t>() % kDevices.size()] << ' ';
    script << kKinds[input.take<std::uint8_t>() % kKinds.size()] << ' ' << input.take<double>() << '\n';
  }
  return script.str();
}

void checkSituation(const std::string& text) {
  Situation situation;
  std::istringstream lines(text);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) addTo(situation, line);
  constexpr std::size_t kMostPosts = 36;
  FUZZ_CHECK(situation.bodies.size() <= kMostPosts * static_cast<std::size_t>(count));
  for (const BodyArc& body : situation.bodies) {
    FUZZ_CHECK(std::abs(body.middle) <= 3.15 && body.half_width > 0.0 && body.half_width <= 3.15 && body.range > 0.0);
  }
  FUZZ_CHECK(situation.beams >= 2 && situation.beams <= LaserScan::kCapacity);
  FUZZ_CHECK(situation.turn_rate > 0.0 && situation.field_of_view > 0.0 && situation.lidar.range_max > 0.0);
  FUZZ_CHECK(situation.walkers >= 0 && situation.walkers <= 100 && situation.scene.laps >= 1);
  FUZZ_CHECK(!situation.no_return.ranges.empty());
  FUZZ_CHECK(!situation.wheels_dead || situation.wheels_dead->begin < situation.wheels_dead->end);
  FUZZ_CHECK(!situation.wheels_away || situation.wheels_away->begin < situation.wheels_away->end);
}

}  // namespace
}  // namespace slam::sim

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam;
  fuzz::Input input({data, size});
  const int kind = input.take<std::uint8_t>() % 3;
  const bool situation = kind == 2;
  const std::string text = kind == 1 ? sim::scriptOf(input) : fuzz::textOf(input.rest());
  try {
    situation ? sim::checkSituation(text) : sim::checkScript(text);
  } catch (const std::invalid_argument& error) {
    FUZZ_CHECK(situation);
    FUZZ_CHECK(*error.what() != '\0');
  } catch (const std::runtime_error& error) {
    FUZZ_CHECK(!situation && std::string(error.what()).starts_with("fuzz:"));
  }
  return 0;
}
