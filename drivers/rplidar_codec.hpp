// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

/// RPLidar A-series serial protocol: bytes to measurement nodes and back (Slamtec, "Interface Protocol and Application
/// Notes"). Pure: no I/O, no clock.
namespace slam::rplidar {

enum class Request : std::uint8_t {
  kStop = 0x25,
  kReset = 0x40,
  kScan = 0x20,
  kGetInfo = 0x50,
  kGetHealth = 0x52,
  kGetSampleRate = 0x59,
  kExpressScan = 0x82,
  kSetMotorPwm = 0xF0,
  kGetAccessoryBoardFlag = 0xFF,
};

/// `A5 cmd` and, when bit 7 of cmd is set, `size payload... checksum`; the checksum is the XOR of all bytes before it.
std::vector<std::uint8_t> encodeRequest(Request request, std::span<const std::uint8_t> payload = {});
std::vector<std::uint8_t> encodeExpressScan(std::uint8_t mode = 0);
std::vector<std::uint8_t> encodeMotorPwm(std::uint16_t pwm);

enum class AnswerType : std::uint8_t {
  kInfo = 0x04,
  kHealth = 0x06,
  kSampleRate = 0x15,
  kStandardNodes = 0x81,
  kExpressCapsules = 0x82,
  kAccessoryBoardFlag = 0xFF,
};

/// Announces an answer: `A5 5A`, u32 LE (30 bits length, 2 bits send mode), type.
struct Descriptor {
  std::uint32_t length = 0;  ///< [bytes] of one answer
  bool stream = false;       ///< answers of that length follow without end
  std::uint8_t type = 0;     ///< AnswerType, or a value that it does not name
};
inline constexpr std::size_t kDescriptorSize = 7;
std::array<std::uint8_t, kDescriptorSize> encodeDescriptor(const Descriptor& descriptor);
/// @param bytes exactly kDescriptorSize; std::nullopt unless they begin with A5 5A
std::optional<Descriptor> parseDescriptor(std::span<const std::uint8_t> bytes);

struct DeviceInfo {
  std::uint8_t model = 0;      ///< major id in the high nibble
  std::uint16_t firmware = 0;  ///< high byte major, low byte minor
  std::uint8_t hardware = 0;
  std::array<std::uint8_t, 16> serial{};
};
enum class HealthStatus : std::uint8_t { kOk = 0, kWarning = 1, kError = 2 };
struct Health {
  HealthStatus status = HealthStatus::kOk;  ///< kError: Protection Stop, only a reset leaves it
  std::uint16_t error_code = 0;
};
struct SampleRate {
  std::uint16_t standard_us = 0, express_us = 0;  ///< [us] per sample
};
/// Each returns std::nullopt for a wrong size or a value outside the protocol.
std::optional<DeviceInfo> parseInfo(std::span<const std::uint8_t> data);
std::optional<Health> parseHealth(std::span<const std::uint8_t> data);
std::optional<SampleRate> parseSampleRate(std::span<const std::uint8_t> data);

/// One sample in device units, in acquisition order.
struct Node {
  std::uint16_t angle_q6 = 0;     ///< [deg * 64] clockwise seen from above, 0..23039
  std::uint32_t distance_q2 = 0;  ///< [mm * 4]; 0: no echo
  std::uint8_t quality = 0;
  bool start = false;  ///< first node of a new turn
};

/// Standard node `81`, 5 bytes: no sync word and weak check bits.
inline constexpr std::size_t kStandardNodeSize = 5;
std::array<std::uint8_t, kStandardNodeSize> encodeStandardNode(const Node& node);
std::optional<Node> parseStandardNode(std::span<const std::uint8_t> bytes);

/// Express capsule `82`, 84 bytes: 32 samples that can be placed only when the next capsule's start angle is known.
inline constexpr std::size_t kExpressCapsuleSize = 84;
inline constexpr int kExpressSamples = 32;
struct ExpressCapsule {
  std::uint16_t start_angle_q6 = 0;
  bool start = false;  ///< S bit: the scan began, or the encoder was reset
  struct Sample {
    std::uint16_t distance_mm = 0;  ///< 14 bits; 0: no echo
    std::uint8_t offset_q3 = 0;     ///< [deg / 8] 0..63, to be taken off the raw angle
  };
  std::array<Sample, kExpressSamples> samples{};
};
std::array<std::uint8_t, kExpressCapsuleSize> encodeExpressCapsule(const ExpressCapsule& capsule);
/// @return std::nullopt for wrong sync nibbles or checksum
std::optional<ExpressCapsule> parseExpressCapsule(std::span<const std::uint8_t> bytes);
/// Samples of `capsule` as nodes, their angles interpolated to the start angle of the capsule after it.
std::array<Node, kExpressSamples> decodeExpress(const ExpressCapsule& capsule, std::uint16_t next_start_angle_q6);

struct DecoderCounters {
  std::uint64_t nodes = 0;
  std::uint32_t bad_check_bits = 0;  ///< standard nodes whose S or C bits are wrong
  std::uint32_t bad_checksums = 0;   ///< capsules
  std::uint32_t encoder_resets = 0;  ///< capsules with a late S bit
  std::uint32_t skipped_bytes = 0;   ///< bytes that belonged to no node or capsule
};

/// A decoded node and how much younger the newest byte pushed so far is than the node's sampling.
struct TimedNode {
  Node node;
  double age = 0.0;  ///< [s] from sampling to the arrival of the last byte of its packet
};

/// Nodes out of a scan's stream of bytes, whatever damage it has. After damage it realigns: for standard nodes it asks
/// for kAlignNodes good ones in a row, because random bytes pass the check bits with probability 1/4.
class StreamDecoder {
 public:
  static constexpr int kAlignNodes = 5;

  /// @param type         kStandardNodes or kExpressCapsules
  /// @param sample_time  [s] per sample
  /// @param byte_time    [s] on the line
  StreamDecoder(AnswerType type, double sample_time, double byte_time);

  /// Takes one byte; appends the nodes it completes (up to 32) to `nodes`.
  void push(std::uint8_t byte, std::vector<TimedNode>& nodes);
  void reset();
  const DecoderCounters& counters() const { return counters_; }

 private:
  void pushStandard(std::vector<TimedNode>& nodes);
  void pushExpress(std::vector<TimedNode>& nodes);
  void drop(std::size_t bytes);

  AnswerType type_;
  double sample_time_, byte_time_;
  std::vector<std::uint8_t> buffer_;
  bool aligned_ = false;
  std::optional<ExpressCapsule> held_;  // waits for the start angle of the next one
  bool first_capsule_ = true;
  DecoderCounters counters_;
};

}  // namespace slam::rplidar
