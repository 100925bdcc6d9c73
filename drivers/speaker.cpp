// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/speaker.hpp"

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

namespace slam {
namespace {

using namespace std::chrono_literals;
using Bytes = std::span<const std::uint8_t>;

constexpr int kBoardBaud = 921600;
constexpr std::array kLidarBauds = {115200, 256000, 460800, 1000000};
constexpr std::array kOtherBauds = {230400, 128000};
constexpr Duration kListen = 200ms;
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

/// What is known of a speaker besides its bytes.
struct SpeakerRow {
  Speaker speaker;
  const char* name;
  const char* key;      ///< the device that belongs to a port of the configuration; nullptr: to none
  const char* drivers;  ///< words of lidar.driver, base.driver or imu.driver for it
  bool lidar = false;
};
constexpr const char* kBase = "base";
constexpr const char* kImu = "imu";
constexpr std::array kRows = {
    SpeakerRow{Speaker::kRplidar, "an RPLidar", "lidar", "rplidar", true},
    SpeakerRow{Speaker::kBoard, "the HandsFree board", kBase, "handsfree"},
    SpeakerRow{Speaker::kArduino, "an Arduino with ros_arduino_bridge", kBase, "text"},
    SpeakerRow{Speaker::kCreate, "an iRobot Create 2 or Roomba", kBase, "create"},
    SpeakerRow{Speaker::kKobuki, "a Kobuki", kBase, "kobuki"},
    SpeakerRow{Speaker::kFrameBase, "a base with the reference firmware", kBase, "frame"},
    SpeakerRow{Speaker::kRoboclaw, "a RoboClaw", kBase, "roboclaw"},
    SpeakerRow{Speaker::kOpencr, "a TurtleBot3 with OpenCR", kBase, "opencr"},
    SpeakerRow{Speaker::kImu, "a HandsFree IMU", kImu, "hfi"},
    SpeakerRow{Speaker::kBno08x, "a BNO08x in UART-RVC mode", kImu, "bno08x"},
    SpeakerRow{Speaker::kWitmotion, "a WitMotion IMU", kImu, "witmotion"},
    SpeakerRow{Speaker::kXsens, "an Xsens MTi", kImu, "xsens"},
    SpeakerRow{Speaker::kLdrobot, "a lidar of LDROBOT (LD06, LD19, STL)", nullptr,
               "ld06, ld19, stl19p, stl27l, ms200 or lds02", true},
    SpeakerRow{Speaker::kYdlidar, "a lidar as of YDLIDAR", nullptr,
               "ydlidar-x2, -x4, -x4-pro, -g2, -g4, -t-mini or coin-d4", true},
    SpeakerRow{Speaker::kNeato, "a lidar as of Neato (XV-11, LDS-01)", nullptr, "xv11, roborock or lds01", true},
    SpeakerRow{Speaker::kCamsense, "a lidar of Camsense", nullptr, "camsense-x1", true},
    SpeakerRow{Speaker::kHokuyo, "a lidar of Hokuyo", nullptr, "hokuyo", true},
    SpeakerRow{Speaker::kGps, "a GPS receiver", nullptr, nullptr},
};

const SpeakerRow& rowOf(Speaker speaker) {
  static constexpr SpeakerRow kNobody{Speaker::kUnknown, "a device of unknown make", nullptr, nullptr};
  const auto row = std::find_if(kRows.begin(), kRows.end(), [&](const auto& one) { return one.speaker == speaker; });
  return row == kRows.end() ? kNobody : *row;
}

}  // namespace

const char* nameOf(Speaker speaker) { return rowOf(speaker).name; }

bool isOtherDevice(Speaker speaker) {
  return !rowOf(speaker).lidar && speaker != Speaker::kUnknown && speaker != Speaker::kPackets;
}

Heard speakerOf(Bytes bytes) {
  if (isBoard(bytes)) return {Speaker::kBoard};
  if (hasFrames<hfi::A9Decoder>(bytes)) return {Speaker::kImu};  // an A9
  if (hasFrames<witmotion::Decoder>(bytes)) return {Speaker::kWitmotion};
  if (hasFrames<bno08x::Decoder>(bytes)) return {Speaker::kBno08x};
  if (hasFrames<xsens::Decoder>(bytes)) return {Speaker::kXsens};
  if (isRplidar(bytes)) return {Speaker::kRplidar};
  if (isFrameBase(bytes)) return {Speaker::kFrameBase};
  if (isOpencr(bytes)) return {Speaker::kOpencr};
  if (isRoboclaw(bytes)) return {Speaker::kRoboclaw};
  if (isKobuki(bytes)) return {Speaker::kKobuki};
  if (isCreate(bytes)) return {Speaker::kCreate};
  if (isArduino(bytes)) return {Speaker::kArduino};
  if (const auto header = packetsIn(bytes, ldrobotLength)) return {Speaker::kLdrobot, *header};
  if (const auto header = packetsIn(bytes, ydlidarLength<2>)) return {Speaker::kYdlidar, *header};
  if (const auto header = packetsIn(bytes, ydlidarLength<3>)) return {Speaker::kYdlidar, *header};
  if (const auto header = packetsIn(bytes, neatoLength<22>)) return {Speaker::kNeato, *header};
  if (const auto header = packetsIn(bytes, neatoLength<42>)) return {Speaker::kNeato, *header};
  if (const auto header = packetsIn(bytes, camsenseLength)) return {Speaker::kCamsense, *header};
  if (isHokuyo(bytes)) return {Speaker::kHokuyo};
  if (isGps(bytes)) return {Speaker::kGps};
  if (const auto header = repeatedHeader(bytes)) return {Speaker::kPackets, *header};
  return {};
}

void SpeakerSearch::begin(const std::string& path, int baud, Timestamp now, Speaker expected) {
  path_ = path;
  expected_ = expected;
  found_ = {};
  bauds_ = {baud, kBoardBaud};
  std::copy(kLidarBauds.begin(), kLidarBauds.end(), bauds_.begin() + 2);
  std::copy(kOtherBauds.begin(), kOtherBauds.end(), bauds_.begin() + 6);
  bauds_[8] = arduino_bridge::kBaud;
  bauds_.back() = roboclaw::kBaud;
  next_ = 0;
  listen(now);
}

void SpeakerSearch::listen(Timestamp now) {
  stream_.reset();
  heard_bytes_.clear();
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
  until_ = now + kListen;
  if (expected_ == Speaker::kCreate) return;
  if (expected_ == Speaker::kArduino || baud == arduino_bridge::kBaud) {
    stream_->write(arduino_bridge::askBaudRate().bytes());
  } else if (expected_ == Speaker::kRoboclaw || baud == roboclaw::kBaud) {
    stream_->write(roboclaw::askVersion(roboclaw::kFirstAddress).bytes());
  } else if (baud == kBoardBaud) {
    std::array<std::uint8_t, robolink::kMaxFrame> frame;
    const std::size_t size =
        robolink::encodeFrame(robolink::kMaster, robolink::kSlave, robolink::Command::kGetSystemInfo, {}, frame);
    stream_->write({frame.data(), size});
  } else if (std::find(kOtherBauds.begin(), kOtherBauds.end(), baud) == kOtherBauds.end()) {
    stream_->write(rplidar::encodeRequest(rplidar::Request::kGetInfo));
    stream_->write(std::array<std::uint8_t, 4>{'\n', 'V', 'V', '\n'});  // of SCIP
    if (baud == opencr::kBaud) stream_->write(opencr::ping().bytes());
  }
}

bool SpeakerSearch::tick(Timestamp now) {
  if (!stream_) return false;
  std::array<std::uint8_t, 512> chunk;
  const ReadResult result = stream_->read(chunk, Duration(0));
  if (result.status == ReadResult::kClosed) {
    stream_.reset();
    next_ = bauds_.size();
    return false;
  }
  const std::size_t size = std::min(result.size, kMostBytes - heard_bytes_.size());
  heard_bytes_.insert(heard_bytes_.end(), chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(size));
  if (now < until_ && heard_bytes_.size() < kMostBytes) return true;
  found_ = speakerOf(heard_bytes_);
  found_.baud = bauds_[next_ - 1];
  if (found_.speaker != Speaker::kUnknown) next_ = bauds_.size();
  listen(now);
  return running();
}

bool WrongSpeaker::hears(std::span<const std::uint8_t> bytes) {
  Heard heard = speakerOf(bytes);
  // A header alone may be chance, or of the device that is expected.
  if (isOwn(heard.speaker) || heard.speaker == Speaker::kUnknown || heard.speaker == Speaker::kPackets) return false;
  heard.baud = baud_;
  asked_ = true;
  describe(heard);
  return true;
}

bool WrongSpeaker::tick(Timestamp now) {
  if (std::exchange(wanted_, false)) {
    search_.begin(path_, baud_, now, own_);
    if (!search_.running()) asked_ = false;  // somebody has the port still: asked anew at the next occasion
  }
  if (!search_.running()) return false;
  if (search_.tick(now)) return true;
  describe(search_.found());
  return false;
}

void WrongSpeaker::describe(const Heard& heard) {
  const char* key = kKeys[static_cast<std::size_t>(expected_)];
  const SpeakerRow& row = rowOf(heard.speaker);
  const char* theirs = row.key;
  const char* name = row.name;
  const double baud = heard.baud;
  known_ = heard.speaker != Speaker::kUnknown;
  if (isOwn(heard.speaker)) {
    known_ = heard.baud != baud_;  // else it is the right one, which has answered at last
    problem_ = {problem::kOtherBaud, {baud, static_cast<double>(baud_)}, {name, key}};
  } else if (theirs != nullptr && std::strcmp(theirs, key) != 0) {
    problem_ = {problem::kOtherDevice, {}, {name, key, theirs}};
  } else {
    char header[24] = "";
    if (heard.header != std::array<std::uint8_t, 2>{})
      std::snprintf(header, sizeof header, ", header %02X %02X", static_cast<unsigned>(heard.header[0]),
                    static_cast<unsigned>(heard.header[1]));
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
