// SPDX-License-Identifier: BSD-3-Clause
// The input is a byte that chooses the channel, then the datagram; without its fingerprint unless bit 7 is set.
#include <algorithm>
#include <cmath>

#include "bus/checked_decode.hpp"
#include "bus/encoding.hpp"
#include "bus/messages.hpp"
#include "fuzz/fuzzing.hpp"

namespace slam {
namespace {

using fuzz::Bytes;

constexpr std::uint8_t kWithFingerprint = 0x80;

void checkSample(const LaserScan& scan) {
  FUZZ_CHECK(scan.size >= 0 && scan.size <= LaserScan::kCapacity);
  for (const Beam& beam : scan.beams()) {
    FUZZ_CHECK(std::isfinite(beam.range) && beam.range >= 0.0F && std::isfinite(beam.bearing));
    FUZZ_CHECK(std::abs(beam.time_offset) < 10.0F);
  }
}

void checkSample(const WheelSample& sample) { FUZZ_CHECK(isFinite(sample.T_wheels_base)); }

void checkSample(const ImuSample& sample) { FUZZ_CHECK(sample.gyro.allFinite() && sample.accel.allFinite()); }

void checkSample(const PseudoLaser& laser) {
  FUZZ_CHECK(laser.size >= 0 && laser.size <= PseudoLaser::kCapacity);
  FUZZ_CHECK(laser.surface_count >= 0 && laser.surface_count <= PseudoLaser::kSurfaceCapacity);
  for (const PseudoBeam& beam : laser.beams()) FUZZ_CHECK(beam.free_from >= 0.0F && beam.free_from <= beam.range);
  for (const PseudoLaser::Surface& surface : laser.surfaces()) {
    FUZZ_CHECK(surface.beam < laser.size && surface.from > 0.0F && surface.from <= surface.to);
  }
}

/// What is taken from a message goes out and comes in again unchanged.
template <typename Message>
void checkContent(const Message& message) {
  const auto sample = fromMessage(message);
  if (!sample) return;
  FUZZ_CHECK(sample->stamp == fromMicroseconds(message.utime));
  checkSample(*sample);
  const auto bytes = test::encoded(toMessage(*sample, message.utime));
  const auto decoded = decodeChecked<Message>(bytes);
  FUZZ_CHECK(decoded.has_value());
  const auto again = fromMessage(*decoded);
  FUZZ_CHECK(again.has_value());
  FUZZ_CHECK(test::encoded(toMessage(*again, message.utime)) == bytes);
}

void checkContent(const drive_t& drive) {
  const auto twist = fromMessage(drive);
  FUZZ_CHECK(!twist || (std::isfinite(twist->vx) && std::isfinite(twist->vy) && std::isfinite(twist->omega)));
}

void checkContent(const ack_t& ack) {
  FUZZ_CHECK(ack.message.size() <= static_cast<std::size_t>(ack.getEncodedSize()));
}

void checkContent(const health_t& health) {
  const auto size = static_cast<std::size_t>(health.getEncodedSize());
  FUZZ_CHECK(health.devices.size() + health.stages.size() + health.counters.size() <= size);
}

void checkContent(const problems_t& problems) {
  const auto size = static_cast<std::size_t>(problems.getEncodedSize());
  FUZZ_CHECK(problems.problems.size() <= size);
  for (const problem_t& problem : problems.problems)
    FUZZ_CHECK(problem.numbers.size() + problem.texts.size() + problem.cause.size() + problem.fix.size() <= size);
}

void checkContent(const pose_estimate_t&) {}
void checkContent(const map_edit_t& edit) {
  FUZZ_CHECK(edit.x.size() == edit.y.size() && edit.x.size() == static_cast<std::size_t>(edit.npoints));
}
void checkContent(const odometry_t&) {}
void checkContent(const map_meta_t&) {}
void checkContent(const map_tile_t& tile) {
  FUZZ_CHECK(tile.cells.size() == static_cast<std::size_t>(tile.side) * static_cast<std::size_t>(tile.side));
}

void checkContent(const command_t& command) {
  FUZZ_CHECK(command.verb.size() + command.argument.size() <= static_cast<std::size_t>(command.getEncodedSize()));
}

void checkContent(const config_t& config) {
  FUZZ_CHECK(config.configuration.size() <= static_cast<std::size_t>(config.getEncodedSize()));
}

template <typename Message>
void checkMessage(Bytes bytes, bool with_fingerprint) {
  std::vector<std::uint8_t> datagram;
  if (!with_fingerprint) {
    const auto fingerprint = static_cast<std::uint64_t>(Message::getHash());
    for (int shift = 56; shift >= 0; shift -= 8) datagram.push_back(static_cast<std::uint8_t>(fingerprint >> shift));
  }
  datagram.insert(datagram.end(), bytes.begin(), bytes.end());
  const auto message = decodeChecked<Message>(datagram);
  if (!message) return;
  FUZZ_CHECK(test::encoded(*message) == datagram);  // nothing was left out, nothing made up
  checkContent(*message);
}

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam;
  if (size == 0) return -1;
  const bool with_fingerprint = (data[0] & kWithFingerprint) != 0;
  const Bytes datagram{data + 1, size - 1};
  switch (data[0] % 16) {
    case 0:
      checkMessage<scan_t>(datagram, with_fingerprint);
      break;
    case 1:
      checkMessage<wheels_t>(datagram, with_fingerprint);
      break;
    case 2:
      checkMessage<imu_t>(datagram, with_fingerprint);
      break;
    case 3:
      checkMessage<depth_t>(datagram, with_fingerprint);
      break;
    case 4:
      checkMessage<drive_t>(datagram, with_fingerprint);
      break;
    case 5:
      checkMessage<command_t>(datagram, with_fingerprint);
      break;
    case 6:
      checkMessage<ack_t>(datagram, with_fingerprint);
      break;
    case 8:
      checkMessage<pose_estimate_t>(datagram, with_fingerprint);
      break;
    case 9:
      checkMessage<map_meta_t>(datagram, with_fingerprint);
      break;
    case 10:
      checkMessage<map_tile_t>(datagram, with_fingerprint);
      break;
    case 7:
      checkMessage<health_t>(datagram, with_fingerprint);
      break;
    case 11:
      checkMessage<map_edit_t>(datagram, with_fingerprint);
      break;
    case 13:
      checkMessage<odometry_t>(datagram, with_fingerprint);
      break;
    case 12:
      checkMessage<problems_t>(datagram, with_fingerprint);
      break;
    default:
      checkMessage<config_t>(datagram, with_fingerprint);
  }
  return 0;
}
