// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/line_device.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "drivers/base/base_facts.hpp"
#include "drivers/imu/codec/bno08x_frames.hpp"
#include "drivers/imu/codec/witmotion_frames.hpp"
#include "drivers/imu/codec/xsens_messages.hpp"
#include "drivers/imu/imu_facts.hpp"
#include "drivers/lidar/codec/rplidar_codec.hpp"
#include "drivers/search/driver_row.hpp"
#include "firmware_if/arduino_bridge.hpp"
#include "firmware_if/create_oi.hpp"
#include "firmware_if/hfi_imu.hpp"
#include "firmware_if/kobuki.hpp"
#include "firmware_if/opencr.hpp"
#include "firmware_if/roboclaw.hpp"
#include "firmware_if/robolink.hpp"
#include "firmware_if/slamd_base/base_frame.hpp"
#include "firmware_if/vesc/vesc_packets.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using Bytes = std::span<const std::uint8_t>;

constexpr std::array kLidarBauds = {115200, 256000, 460800, 1000000};
constexpr std::array kOtherBauds = {230400, 128000};
constexpr Duration kDeviceListen = 200ms;
constexpr std::uint32_t kFrames = 3;  // of a weak checksum

bool isRplidar(Bytes bytes) {
  for (std::size_t i = 0; i + rplidar::kDescriptorSize <= bytes.size(); ++i) {
    const auto descriptor = rplidar::parseDescriptor(bytes.subspan(i, rplidar::kDescriptorSize));
    if (!descriptor) continue;
    const auto is = [&](rplidar::AnswerType type, std::uint32_t length) {
      return descriptor->type == static_cast<std::uint8_t>(type) && descriptor->length == length;
    };
    if (is(rplidar::AnswerType::kInfo, 20) || is(rplidar::AnswerType::kHealth, 3)) return true;
  }
  return false;
}

bool isBoard(Bytes bytes) {
  robolink::Decoder decoder;
  bool found = false;
  for (const std::uint8_t byte : bytes) found = decoder.push(byte).has_value() || found;
  return found || decoder.flush().has_value();
}

/// @tparam Decoder a FrameDecoder
template <typename Decoder>
bool hasFrames(Bytes bytes) {
  Decoder decoder;
  std::uint32_t frames = 0;
  for (const std::uint8_t byte : bytes) decoder.push(byte, [&](Bytes) { ++frames; });
  return frames >= kFrames;
}

bool isArduino(Bytes bytes) {
  using arduino_bridge::Answer;
  arduino_bridge::LineDecoder lines;
  constexpr std::array kRates = {9600, 57600, 115200};  // [bit/s] that the board answers with
  for (const std::uint8_t byte : bytes) {
    const auto answer = lines.push(byte);
    if (answer && answer->kind == Answer::kRefused) return true;
    const bool rate = answer && answer->kind == Answer::kNumber &&
                      std::find(kRates.begin(), kRates.end(), answer->counts[0]) != kRates.end();
    if (rate) return true;
  }
  return false;
}

bool isCreate(Bytes bytes) {
  create_oi::StreamDecoder decoder;
  std::uint32_t frames = 0;
  for (const std::uint8_t byte : bytes)
    decoder.push(byte, [&](Bytes frame) { frames += create_oi::parseStream(frame) ? 1 : 0; });
  return frames >= kFrames;
}

bool isFrameBase(Bytes bytes) {
  slamd_base::Receiver receiver;
  std::uint32_t frames = 0;
  for (const std::uint8_t byte : bytes) {
    receiver.push(byte, [&](const std::uint8_t* frame) {
      slamd_base::State state;
      frames += slamd_base::parseState(frame, &state) ? 1 : 0;
    });
  }
  return frames >= kFrames;
}

/// It answers with its version.
bool isRoboclaw(Bytes bytes) {
  for (std::size_t size = 1; size <= bytes.size(); ++size) {
    if (roboclaw::endsWithVersion(roboclaw::kFirstAddress, bytes.first(size))) return true;
  }
  return false;
}

bool isOpencr(Bytes bytes) {
  opencr::Decoder decoder;
  bool found = false;
  for (const std::uint8_t byte : bytes) {
    decoder.push(byte, [&](Bytes frame) {
      const auto packet = opencr::parse(frame);
      found = found || (packet && opencr::isPong(*packet));
    });
  }
  return found;
}

/// It answers with its version, or with values that were asked for before.
bool isVesc(Bytes bytes) {
  vesc::Decoder decoder;
  bool found = false;
  for (const std::uint8_t byte : bytes)
    decoder.push(byte, [&](Bytes frame) { found = found || vesc::isVersion(frame) || vesc::parseValues(frame); });
  return found;
}

bool isKobuki(Bytes bytes) {
  kobuki::Decoder decoder;
  std::uint32_t frames = 0;
  for (const std::uint8_t byte : bytes)
    decoder.push(byte, [&](Bytes frame) { frames += kobuki::parseFeedback(frame) ? 1 : 0; });
  return frames >= kFrames;
}

/// Packets whose begin `lengthAt` recognises, and behind each of them the next. @return its first two bytes
template <typename LengthAt>
std::optional<std::array<std::uint8_t, 2>> packetsIn(Bytes bytes, LengthAt&& lengthAt) {
  constexpr int kInARow = 3;
  for (std::size_t i = 0; i + 1 < bytes.size(); ++i) {
    std::size_t at = i;
    int found = 0;
    while (found < kInARow && at + 4 <= bytes.size()) {
      const std::size_t length = lengthAt(bytes.subspan(at));
      if (length == 0) break;
      ++found;
      at += length;
    }
    if (found == kInARow) return std::array{bytes[i], bytes[i + 1]};
  }
  return std::nullopt;
}

std::size_t ldrobotLength(Bytes b) { return b[0] == 0x54 && b[1] == 0x2C ? 47 : 0; }
/// @param Sample [bytes] of one, with or without its intensity
template <std::size_t Sample>
std::size_t ydlidarLength(Bytes b) {
  return b[0] == 0xAA && b[1] == 0x55 && b[3] > 0 ? 10 + Sample * b[3] : 0;
}
/// @param Size [bytes] of one: the XV-11's or the LDS-01's
template <std::size_t Size>
std::size_t neatoLength(Bytes b) {
  return b[0] == 0xFA && b[1] >= 0xA0 && b[1] <= 0xF9 ? Size : 0;
}
std::size_t camsenseLength(Bytes b) { return b[0] == 0x55 && b[1] == 0xAA && b[2] == 0x03 && b[3] == 0x08 ? 36 : 0; }

bool hasText(Bytes bytes, std::string_view text) {
  return std::search(bytes.begin(), bytes.end(), text.begin(), text.end()) != bytes.end();
}
bool isGps(Bytes bytes) { return hasText(bytes, "$GP") || hasText(bytes, "$GN"); }
/// It answers who it is, or sends scans.
bool isHokuyo(Bytes bytes) { return hasText(bytes, "\nVEND:Hokuyo") || hasText(bytes, "\n99b\n"); }

/// A header that nobody here knows: two bytes that return at one distance, again and again.
std::optional<std::array<std::uint8_t, 2>> repeatedHeader(Bytes bytes) {
  constexpr std::size_t kShortest = 6, kLongest = 128, kTimes = 8;
  for (std::size_t length = kShortest; length <= kLongest && length * kTimes + 1 < bytes.size(); ++length) {
    for (std::size_t begin = 0; begin < length; ++begin) {
      const std::array<std::uint8_t, 2> header{bytes[begin], bytes[begin + 1]};
      // Bytes that are all alike are no packets but a line that is held, or one at another baud rate.
      if (header[0] == header[1] || header[0] == 0 || header[1] == 0) continue;
      std::size_t times = 1;
      for (std::size_t at = begin + length; at + 1 < bytes.size(); at += length, ++times) {
        if (bytes[at] != header[0] || bytes[at + 1] != header[1]) break;
      }
      if (times >= kTimes && begin + times * length + length > bytes.size()) return header;
    }
  }
  return std::nullopt;
}

const char* const kKeys[] = {"lidar", "base", "imu"};

/// What is known of a line_device besides its bytes.
struct LineDeviceRow {
  LineDevice line_device;
  const char* name;
  const char* key;      ///< the device that belongs to a port of the configuration; nullptr: to none
  const char* drivers;  ///< words of lidar.driver, base.driver or imu.driver for it
  bool lidar = false;
};
constexpr const char* kBase = "base";
constexpr const char* kImu = "imu";
constexpr std::array kRows = {
    LineDeviceRow{LineDevice::kRplidar, "an RPLidar", "lidar", "rplidar", true},
    LineDeviceRow{LineDevice::kBoard, "the HandsFree board", kBase, "handsfree"},
    LineDeviceRow{LineDevice::kArduino, "an Arduino with ros_arduino_bridge", kBase, "text"},
    LineDeviceRow{LineDevice::kCreate, "an iRobot Create 2 or Roomba", kBase, "create"},
    LineDeviceRow{LineDevice::kKobuki, "a Kobuki", kBase, "kobuki"},
    LineDeviceRow{LineDevice::kFrameBase, "a base with the reference firmware", kBase, "frame"},
    LineDeviceRow{LineDevice::kRoboclaw, "a RoboClaw", kBase, "roboclaw"},
    LineDeviceRow{LineDevice::kOpencr, "a TurtleBot3 with OpenCR", kBase, "opencr"},
    LineDeviceRow{LineDevice::kVesc, "a VESC", kBase, "vesc"},
    LineDeviceRow{LineDevice::kImu, "a HandsFree IMU", kImu, "hfi"},
    LineDeviceRow{LineDevice::kBno08x, "a BNO08x in UART-RVC mode", kImu, "bno08x"},
    LineDeviceRow{LineDevice::kWitmotion, "a WitMotion IMU", kImu, "witmotion"},
    LineDeviceRow{LineDevice::kXsens, "an Xsens MTi", kImu, "xsens"},
    LineDeviceRow{LineDevice::kLdrobot, "a lidar of LDROBOT (LD06, LD19, STL)", nullptr,
                  "ld06, ld19, stl19p, stl27l, ms200 or lds02", true},
    LineDeviceRow{LineDevice::kYdlidar, "a lidar as of YDLIDAR", nullptr,
                  "ydlidar-x2, -x4, -x4-pro, -g2, -g4, -t-mini or coin-d4", true},
    LineDeviceRow{LineDevice::kNeato, "a lidar as of Neato (XV-11, LDS-01)", nullptr, "xv11, roborock or lds01", true},
    LineDeviceRow{LineDevice::kCamsense, "a lidar of Camsense", nullptr, "camsense-x1", true},
    LineDeviceRow{LineDevice::kHokuyo, "a lidar of Hokuyo", nullptr, "hokuyo", true},
    LineDeviceRow{LineDevice::kGps, "a GPS receiver", nullptr, nullptr},
};

const LineDeviceRow& rowOf(LineDevice line_device) {
  static constexpr LineDeviceRow kNobody{LineDevice::kUnknown, "a device of unknown make", nullptr, nullptr};
  const auto row =
      std::find_if(kRows.begin(), kRows.end(), [&](const auto& one) { return one.line_device == line_device; });
  return row == kRows.end() ? kNobody : *row;
}

}  // namespace

const char* nameOf(LineDevice line_device) { return rowOf(line_device).name; }

bool isOtherDevice(LineDevice line_device) {
  return !rowOf(line_device).lidar && line_device != LineDevice::kUnknown && line_device != LineDevice::kPackets;
}

RecognisedDevice lineDeviceOf(Bytes bytes) {
  if (isBoard(bytes)) return {LineDevice::kBoard};
  if (hasFrames<hfi::A9Decoder>(bytes)) return {LineDevice::kImu};  // an A9
  if (hasFrames<witmotion::Decoder>(bytes)) return {LineDevice::kWitmotion};
  if (hasFrames<bno08x::Decoder>(bytes)) return {LineDevice::kBno08x};
  if (hasFrames<xsens::Decoder>(bytes)) return {LineDevice::kXsens};
  if (isRplidar(bytes)) return {LineDevice::kRplidar};
  if (isFrameBase(bytes)) return {LineDevice::kFrameBase};
  if (isOpencr(bytes)) return {LineDevice::kOpencr};
  if (isRoboclaw(bytes)) return {LineDevice::kRoboclaw};
  if (isVesc(bytes)) return {LineDevice::kVesc};
  if (isKobuki(bytes)) return {LineDevice::kKobuki};
  if (isCreate(bytes)) return {LineDevice::kCreate};
  if (isArduino(bytes)) return {LineDevice::kArduino};
  if (const auto header = packetsIn(bytes, ldrobotLength)) return {LineDevice::kLdrobot, *header};
  if (const auto header = packetsIn(bytes, ydlidarLength<2>)) return {LineDevice::kYdlidar, *header};
  if (const auto header = packetsIn(bytes, ydlidarLength<3>)) return {LineDevice::kYdlidar, *header};
  if (const auto header = packetsIn(bytes, neatoLength<22>)) return {LineDevice::kNeato, *header};
  if (const auto header = packetsIn(bytes, neatoLength<42>)) return {LineDevice::kNeato, *header};
  if (const auto header = packetsIn(bytes, camsenseLength)) return {LineDevice::kCamsense, *header};
  if (isHokuyo(bytes)) return {LineDevice::kHokuyo};
  if (isGps(bytes)) return {LineDevice::kGps};
  if (const auto header = repeatedHeader(bytes)) return {LineDevice::kPackets, *header};
  return {};
}

void LineDeviceSearch::begin(const std::string& path, int baud, Timestamp now, LineDevice expected) {
  path_ = path;
  expected_ = expected;
  found_ = {};
  bauds_ = {baud, robolink::kBaud};
  std::copy(kLidarBauds.begin(), kLidarBauds.end(), bauds_.begin() + 2);
  std::copy(kOtherBauds.begin(), kOtherBauds.end(), bauds_.begin() + 6);
  bauds_[8] = arduino_bridge::kBaud;
  bauds_.back() = roboclaw::kBaud;
  next_ = 0;
  listen(now);
}

void LineDeviceSearch::listen(Timestamp now) {
  stream_.reset();
  bytes_.clear();
  while (next_ < bauds_.size() && std::find(bauds_.begin(), bauds_.begin() + static_cast<std::ptrdiff_t>(next_),
                                            bauds_[next_]) != bauds_.begin() + static_cast<std::ptrdiff_t>(next_))
    ++next_;
  if (next_ >= bauds_.size()) return;
  const int baud = bauds_[next_++];
  OpenedPort port = open_(path_, baud);
  if (!port.stream) {
    next_ = bauds_.size();  // it has gone, or somebody else has it
    return;
  }
  stream_ = std::move(port.stream);
  stream_->discardInput();
  until_ = now + kDeviceListen;
  if (expected_ == LineDevice::kCreate) return;
  if (expected_ == LineDevice::kArduino || baud == arduino_bridge::kBaud) {
    stream_->write(arduino_bridge::askBaudRate().bytes());
  } else if (expected_ == LineDevice::kRoboclaw || baud == roboclaw::kBaud) {
    stream_->write(roboclaw::askVersion(roboclaw::kFirstAddress).bytes());
  } else if (baud == robolink::kBaud) {
    stream_->write(robolink::question(robolink::Command::kGetSystemInfo));
  } else if (std::find(kOtherBauds.begin(), kOtherBauds.end(), baud) == kOtherBauds.end()) {
    stream_->write(rplidar::encodeRequest(rplidar::Request::kGetInfo));
    stream_->write(std::array<std::uint8_t, 4>{'\n', 'V', 'V', '\n'});  // of SCIP
    if (baud == opencr::kBaud) stream_->write(opencr::ping().bytes());
    if (baud == vesc::kBaud) stream_->write(vesc::askVersion().bytes());
  }
}

bool LineDeviceSearch::tick(Timestamp now) {
  if (!stream_) return false;
  std::array<std::uint8_t, 512> chunk;
  const ReadResult result = stream_->read(chunk, Duration(0));
  if (result.status == ReadResult::kClosed) {
    stream_.reset();
    next_ = bauds_.size();
    return false;
  }
  const std::size_t size = std::min(result.size, kMostBytes - bytes_.size());
  bytes_.insert(bytes_.end(), chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(size));
  if (now < until_ && bytes_.size() < kMostBytes) return true;
  found_ = lineDeviceOf(bytes_);
  found_.baud = bauds_[next_ - 1];
  if (found_.line_device != LineDevice::kUnknown) next_ = bauds_.size();
  listen(now);
  return running();
}

bool WrongDevice::recognises(std::span<const std::uint8_t> bytes) {
  RecognisedDevice found = lineDeviceOf(bytes);
  // A header alone may be chance, or of the device that is expected.
  if (isOwn(found.line_device) || found.line_device == LineDevice::kUnknown ||
      found.line_device == LineDevice::kPackets)
    return false;
  found.baud = baud_;
  asked_ = true;
  describe(found);
  return true;
}

bool WrongDevice::tick(Timestamp now) {
  if (std::exchange(wanted_, false)) {
    search_.begin(path_, baud_, now, own_);
    if (!search_.running()) asked_ = false;  // somebody has the port still: asked anew at the next occasion
  }
  if (!search_.running()) return false;
  if (search_.tick(now)) return true;
  describe(search_.found());
  return false;
}

void WrongDevice::describe(const RecognisedDevice& found) {
  const char* key = kKeys[static_cast<std::size_t>(expected_)];
  const LineDeviceRow& row = rowOf(found.line_device);
  const char* theirs = row.key;
  const char* name = row.name;
  const double baud = found.baud;
  known_ = found.line_device != LineDevice::kUnknown;
  if (isOwn(found.line_device)) {
    known_ = found.baud != baud_;  // else it is the right one, which has answered at last
    problem_ = {problem::kOtherBaud, {baud, static_cast<double>(baud_)}, {name, key}};
  } else if (theirs != nullptr && std::strcmp(theirs, key) != 0) {
    problem_ = {problem::kOtherDevice, {}, {name, key, theirs}};
  } else {
    char header[24] = "";
    if (found.header != std::array<std::uint8_t, 2>{})
      std::snprintf(header, sizeof header, ", header %02X %02X", static_cast<unsigned>(found.header[0]),
                    static_cast<unsigned>(found.header[1]));
    problem_ = {problem::kForeignDevice, {baud}, {name, header}};
    if (row.lidar && expected_ == PortOf::kLidar)
      problem_ = {problem::kForeignLidar, {baud}, {name, header, row.drivers}};
    if (theirs != nullptr && expected_ == PortOf::kBoard)
      problem_ = {problem::kForeignBase, {baud}, {name, header, row.drivers}};
    if (theirs != nullptr && expected_ == PortOf::kImu)
      problem_ = {problem::kForeignImu, {baud}, {name, header, row.drivers}};
  }
}

}  // namespace slam
