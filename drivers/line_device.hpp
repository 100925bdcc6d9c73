// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/byte_stream.hpp"

namespace slam {

/// Who sends bytes on a serial line.
enum class LineDevice : std::uint8_t {
  kUnknown,
  kRplidar,
  kBoard,    ///< HandsFree, RoboLink
  kArduino,  ///< ros_arduino_bridge
  kCreate,   ///< iRobot Create, Roomba
  kKobuki,
  kFrameBase,  ///< the reference firmware
  kRoboclaw,
  kOpencr,  ///< TurtleBot3
  kVesc,
  kImu,        ///< HandsFree, stand-alone
  kBno08x,     ///< in UART-RVC mode
  kWitmotion,  ///< or a HandsFree B6, B9, D6, which send the same frames
  kXsens,
  kLdrobot,
  kYdlidar,
  kNeato,
  kCamsense,
  kHokuyo,
  kGps,
  kPackets,  ///< of one length that begin alike, of nobody who is known
};

/// With its article: "a Kobuki".
const char* nameOf(LineDevice line_device);
/// A base, an IMU or a GPS: one that is known, and no lidar.
bool isOtherDevice(LineDevice line_device);

struct RecognisedDevice {
  LineDevice line_device = LineDevice::kUnknown;
  std::array<std::uint8_t, 2> header{};  ///< that its packets begin with, where they have one
  int baud = 0;                          ///< [bit/s] at which it was understood
};

/// Judges by frames that no other sender makes: checksums where the sender is one of ours, headers at the distance that
/// its packets have where it is another's.
RecognisedDevice lineDeviceOf(std::span<const std::uint8_t> bytes);

/// Finds out who is at the other end of a port where the expected device does not answer: at each baud rate that these
/// devices use it asks what the others answer to, and listens. Its port must be closed meanwhile. No call waits.
class LineDeviceSearch {
 public:
  explicit LineDeviceSearch(PortOpener open = openPort) : open_(std::move(open)) { bytes_.reserve(kMostBytes); }

  /// @param baud of the device that is expected: tried first @param expected it: a Create is asked nothing, because it
  /// takes the questions for pressed buttons
  void begin(const std::string& path, int baud, Timestamp now, LineDevice expected = LineDevice::kUnknown);
  /// @return whether it goes on
  bool tick(Timestamp now);
  bool running() const { return stream_ != nullptr || next_ < bauds_.size(); }
  void rest(Duration time) {
    if (stream_) stream_->rest(time);
  }
  /// Once it has ended.
  const RecognisedDevice& found() const { return found_; }

 private:
  static constexpr std::size_t kMostBytes = 2048;
  void listen(Timestamp now);

  PortOpener open_;
  std::string path_;
  LineDevice expected_ = LineDevice::kUnknown;
  std::array<int, 10> bauds_{};
  std::size_t next_ = bauds_.size();
  std::unique_ptr<ByteStream> stream_;
  Timestamp until_{};
  std::vector<std::uint8_t> bytes_;
  RecognisedDevice found_;
};

/// The device that a port is for.
enum class PortOf : std::uint8_t { kLidar, kBoard, kImu };

/// The search for one port, made once and then remembered.
class WrongDevice {
 public:
  /// @param own which device it is; without: the RPLidar, the HandsFree board or IMU
  WrongDevice(PortOf expected, std::string path, int baud, PortOpener open = openPort,
              LineDevice own = LineDevice::kUnknown)
      : expected_(expected),
        own_(own == LineDevice::kUnknown ? usualOf(expected) : own),
        path_(std::move(path)),
        baud_(baud),
        search_(std::move(open)) {}

  /// The device did not answer. Does nothing when that was asked before. The search begins with the next tick, before
  /// which the port must have been closed.
  void ask() { wanted_ = wanted_ || !std::exchange(asked_, true); }
  /// Bytes that came at the right baud rate. @return whether somebody is known by them who is not expected here
  bool recognises(std::span<const std::uint8_t> bytes);
  /// @return whether the search goes on
  bool tick(Timestamp now);
  bool running() const { return wanted_ || search_.running(); }
  /// Lets time pass until more may have come.
  void rest(Duration time) { search_.rest(time); }
  /// The device answers, or the port is another one's now.
  void forget() { asked_ = known_ = wanted_ = false; }
  /// Who is there instead; `otherwise` where that is not known.
  Problem found(const Problem& otherwise) const { return known_ ? problem_ : otherwise; }

 private:
  void describe(const RecognisedDevice& found);
  /// Some units of HandsFree send as WitMotion's do.
  bool isOwn(LineDevice found) const {
    return found == own_ || (own_ == LineDevice::kImu && found == LineDevice::kWitmotion);
  }

  static LineDevice usualOf(PortOf port) {
    return port == PortOf::kLidar   ? LineDevice::kRplidar
           : port == PortOf::kBoard ? LineDevice::kBoard
                                    : LineDevice::kImu;
  }

  PortOf expected_;
  LineDevice own_;  // the device that it is for, and which uses another baud rate perhaps
  std::string path_;
  int baud_;
  LineDeviceSearch search_;
  bool asked_ = false, known_ = false;
  bool wanted_ = false;  // the search, which has not begun
  Problem problem_;      // where it is known
};

}  // namespace slam
