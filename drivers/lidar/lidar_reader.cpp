// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/lidar_reader.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kSilence = 500ms;  // while it streams
constexpr Duration kHoldUp = 100ms;   // between two reads, beyond the unit's own pauses
// Between two reads, so that not every two bytes wake the thread. On a busy line it costs the stamps nothing: the last
// of the bytes that wait has just come, and those before it came one behind the other.
constexpr Duration kRest = 3ms;
constexpr Duration kSlowestTurn = 2s;  // ten times what these units need
constexpr std::size_t kChunk = 1024;   // [bytes] of a read

}  // namespace

LidarReader::LidarReader(Clock now, LidarScanStart start)
    : now_(now),
      scans_(std::move(start.scans)),
      read_ahead_(std::move(start.read_ahead)),
      rests_(start.busy_line),
      hold_up_(kHoldUp + start.pause),
      last_node_(now() + start.spin_up - kSilence),
      last_turn_(last_node_),
      last_arrival_(last_node_) {}

LidarReader::Ending LidarReader::read(ByteStream& stream, Duration timeout, const LidarScanStream::Sink& sink) {
  std::array<std::uint8_t, kChunk> chunk;
  std::size_t size = std::min(read_ahead_.size(), chunk.size());
  if (size > 0) {
    std::copy_n(read_ahead_.begin(), size, chunk.begin());
    read_ahead_.erase(read_ahead_.begin(), read_ahead_.begin() + static_cast<std::ptrdiff_t>(size));
  } else {
    if (rests_ && timeout > kRest) stream.rest(kRest);
    const Duration patience = std::max<Duration>(last_node_ + kSilence - now_(), 0ns);
    const ReadResult result = stream.read(chunk, std::min(timeout, patience));
    if (result.status == ReadResult::kClosed) return Ending::kClosed;
    size = result.size;
  }
  const Timestamp arrival = now_();  // of the chunk's last byte
  if (size > 0) take({chunk.data(), size}, arrival, sink);
  if (scans_->sawBootText()) return Ending::kRestarted;
  if (nodes_ > 0 && arrival - last_turn_ > kSlowestTurn) return Ending::kHeadStands;
  return arrival - last_node_ < kSilence ? Ending::kNone : Ending::kSilent;
}

void LidarReader::take(std::span<const std::uint8_t> bytes, Timestamp arrival, const LidarScanStream::Sink& sink) {
  const bool held_up = bytes_ > 0 && arrival - last_arrival_ > hold_up_;
  last_arrival_ = arrival;
  bytes_ += static_cast<std::int64_t>(bytes.size());
  int nodes = 0;
  if (held_up) {
    scans_->restart();
    catching_up_ = true;
  }
  if (catching_up_) {
    scans_->skip(bytes);
    last_node_ = last_turn_ = arrival;  // late is not silent
    catching_up_ = bytes.size() == kChunk;
  } else {
    nodes = scans_->push(bytes, arrival, sink);
  }
  if (nodes > 0) last_node_ = arrival;
  nodes_ += nodes;
  if (scans_->turns() != turns_) last_turn_ = arrival;
  turns_ = scans_->turns();
}

}  // namespace slam
