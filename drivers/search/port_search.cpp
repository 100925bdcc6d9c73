// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/search/port_search.hpp"

#include <algorithm>
#include <array>

#include "drivers/base/base_facts.hpp"
#include "drivers/imu/codec/xsens_messages.hpp"
#include "drivers/imu/imu_facts.hpp"
#include "drivers/search/driver_row.hpp"
#include "drivers/tcp_port.hpp"
#include "firmware_if/arduino_bridge.hpp"
#include "firmware_if/create_oi.hpp"
#include "firmware_if/opencr.hpp"
#include "firmware_if/roboclaw.hpp"
#include "firmware_if/robolink.hpp"
#include "firmware_if/vesc/vesc_packets.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr int kRplidarBaud = 115200;                                 // [bit/s] of lidar.driver = "rplidar" by itself
constexpr std::array kRarely = {9600, 57600, 38400, 19200, 460800};  // [bit/s] that IMUs can be set to
constexpr Duration kListen = 400ms;
constexpr Duration kAnswer = 300ms;
constexpr int kRounds = 2;  // of all questions: opening the port may have reset a device, which boots for 2 s
constexpr int kTimes = 3;   // a question is repeated: a byte of the first may be lost

/// An answer that only an Arduino with ros_arduino_bridge gives: two numbers to each question, and nothing unasked.
bool answersCounts(std::span<const std::uint8_t> bytes) {
  arduino_bridge::LineDecoder lines;
  int counts = 0;
  for (const std::uint8_t byte : bytes) {
    const auto answer = lines.push(byte);
    counts += answer && answer->kind == arduino_bridge::Answer::kCounts ? 1 : 0;
  }
  return counts >= 2 && counts <= kTimes && lines.damaged() == 0;
}

Outgoing askCreate() {
  Outgoing bytes = create_oi::start();
  bytes.add(create_oi::askForStream().bytes());
  return bytes;
}
Outgoing askBoard() {
  Outgoing bytes;
  bytes.add(robolink::question(robolink::Command::kGetSystemInfo));
  return bytes;
}

constexpr std::array kCreateBauds = {create_oi::kBaud};
constexpr std::array kBoardBauds = {robolink::kBaud};
constexpr std::array kRoboclawBauds = {roboclaw::kBaud};
constexpr std::array kVescBauds = {vesc::kBaud};
constexpr std::array kXsensBauds = {115200};
constexpr std::array kOpencrBauds = {opencr::kBaud};
constexpr std::array kArduinoBauds = {arduino_bridge::kBaud, 115200};

}  // namespace

struct PortSearch::Question {
  LineDevice line_device;  // who answers it
  std::span<const int> bauds;
  Outgoing question, farewell{};
};

PortFinding PortSearch::find(const std::atomic<bool>& cancel) {
  found_ = {};
  LidarSearch lidars(path_, 0, open_, now_);
  const bool serial = !isTcp(path_);
  bool has_bytes = false;  // unasked: no lidar that waits for its start
  if (serial) {
    const LidarFinding lidar = lidars.listen(cancel);
    has_bytes = lidar.has_bytes;
    if (take(lidar) || (lidar.has_bytes && listen(kRarely, cancel))) {
      // A port of USB's own carries any rate: then the usual one is to be written down.
      const BaseFacts* base = findBase(found_.driver);
      if (base != nullptr && !found_.is_usual_baud) listen(std::array{base->baud}, cancel);
      return found_;
    }
  }
  for (int round = 0; round < kRounds && !cancel; ++round) {
    const bool known =
        (serial && ask({LineDevice::kCreate, kCreateBauds, askCreate(), create_oi::stop()}, cancel)) ||
        (serial && ask({LineDevice::kBoard, kBoardBauds, askBoard()}, cancel)) ||
        (serial && ask({LineDevice::kVesc, kVescBauds, vesc::askVersion()}, cancel)) ||
        (serial && ask({LineDevice::kXsens, kXsensBauds, xsens::encode(xsens::kAskId)}, cancel)) ||
        take(lidars.ask(cancel)) ||
        (serial &&
         ask({LineDevice::kRoboclaw, kRoboclawBauds, roboclaw::askVersion(roboclaw::kFirstAddress)}, cancel)) ||
        (serial && ask({LineDevice::kOpencr, kOpencrBauds, opencr::ping()}, cancel)) ||
        (serial && ask({LineDevice::kArduino, kArduinoBauds, arduino_bridge::askCounts()}, cancel));
    if (known || !found_.is_open) return found_;
  }
  if (serial && !cancel && !has_bytes) take(lidars.wake(cancel));
  return found_;
}

/// @return whether it is known what is there, or that nothing can be
bool PortSearch::take(const LidarFinding& lidar) {
  found_.problem = lidar.problem;
  found_.is_open = lidar.is_open;
  if (lidar.family == LidarFinding::kNone) return take(lidar.other) || !lidar.is_open;
  found_.kind = PortFinding::kLidar;
  found_.baud = lidar.baud;
  switch (lidar.family) {
    case LidarFinding::kPackets:
      found_.driver = lidar.facts->driver;
      found_.name = "a lidar as the " + std::string(lidar.facts->name);
      found_.is_usual_baud = lidar.baud == lidar.facts->baud;
      break;
    case LidarFinding::kRplidar:
      found_.driver = "rplidar";
      found_.name = nameOf(LineDevice::kRplidar);
      found_.is_usual_baud = lidar.baud == kRplidarBaud;
      break;
    case LidarFinding::kHokuyo:
      found_.driver = "hokuyo";
      found_.name = nameOf(LineDevice::kHokuyo);
      break;
    default:
      found_.driver = "sick";
      found_.name = "a lidar of SICK";
  }
  return true;
}

bool PortSearch::take(const RecognisedDevice& sender) {
  if (!isOtherDevice(sender.line_device)) return false;
  found_.kind = PortFinding::kForeign;
  found_.name = nameOf(sender.line_device);
  found_.baud = sender.baud;
  if (const BaseFacts* base = rowOfLineDevice(baseTable(), sender.line_device)) {
    found_.kind = PortFinding::kBase;
    found_.driver = base->driver;
    found_.is_usual_baud = sender.baud == base->baud;
  } else if (sender.line_device == LineDevice::kBoard) {
    found_.kind = PortFinding::kBase;
    found_.driver = "handsfree";
    found_.is_usual_baud = sender.baud == kBoardBauds.front();
  } else if (const ImuFacts* imu = rowOfLineDevice(imuTable(), sender.line_device)) {
    found_.kind = PortFinding::kImu;
    found_.driver = imu->driver;
    const auto bauds = std::span(imu->bauds).first(imu->baudCount());
    found_.is_usual_baud = std::find(bauds.begin(), bauds.end(), sender.baud) != bauds.end();
  }
  return true;
}

bool PortSearch::listen(std::span<const int> bauds, const std::atomic<bool>& cancel) {
  for (const int baud : bauds) {
    OpenedPort port = open_(path_, baud);
    if (cancel || !port.stream) return false;
    port.stream->discardInput();
    rplidar::Dialogue dialogue(*port.stream, now_, &cancel);
    for (const Timestamp end = now_() + kListen; now_() < end && !dialogue.hungUp() && !cancel;)
      dialogue.readOn(end - now_());
    RecognisedDevice sender = lineDeviceOf(dialogue.recent());
    sender.baud = baud;
    if (take(sender)) return true;
  }
  return false;
}

/// @return whether it was answered
bool PortSearch::ask(const Question& question, const std::atomic<bool>& cancel) {
  for (const int baud : question.bauds) {
    OpenedPort port = open_(path_, baud);
    if (cancel || !port.stream) return false;
    port.stream->discardInput();
    rplidar::Dialogue dialogue(*port.stream, now_, &cancel);
    bool answered = false;
    for (int time = 0; time < kTimes && !answered && !cancel && !dialogue.hungUp(); ++time) {
      dialogue.send(question.question.bytes());
      for (const Timestamp end = now_() + kAnswer; now_() < end && !dialogue.hungUp();) dialogue.readOn(end - now_());
      const bool counts = question.line_device == LineDevice::kArduino && answersCounts(dialogue.recent());
      answered = counts || lineDeviceOf(dialogue.recent()).line_device == question.line_device;
    }
    // Also of one whose answer was lost: else it took the next question for pressed buttons.
    if (!question.farewell.empty()) dialogue.send(question.farewell.bytes());
    if (answered) return take(RecognisedDevice{.line_device = question.line_device, .baud = baud});
  }
  return false;
}

}  // namespace slam
