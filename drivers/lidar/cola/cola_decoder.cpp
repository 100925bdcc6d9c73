// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/cola/cola_decoder.hpp"

#include <cmath>
#include <utility>

#include "drivers/lidar/text/turn_gap.hpp"

namespace slam {
namespace {

constexpr double kNoEcho = 10.0, kFurthest = 262143.0;  // [mm] small values are codes

}  // namespace

ColaDecoder::ColaDecoder(const cola::Scan& scan, double byte_time) : scan_(scan), byte_time_(byte_time) {
  scan_.values = {};  // of a telegram that does not stay
  text_.reserve(cola::kLongest);
  distances_q2_.reserve(mostNodes());
}

void ColaDecoder::reset() {
  inside_ = false;
  last_began_.reset();
  lost_ = 0;
}

void ColaDecoder::push(std::uint8_t byte, std::vector<TimedNode>& nodes) {
  lost_ = 0;
  ends_turn_ = false;
  const char c = static_cast<char>(byte);
  if (c == cola::kBegin) {
    rejects_ += inside_;  // the end of the one before is missing
    inside_ = true;
    text_.clear();
  } else if (inside_ && c == cola::kEnd) {
    inside_ = false;
    ends_turn_ = takeScan(nodes);
    rejects_ += !ends_turn_;
  } else if (inside_ && text_.size() < cola::kLongest) {
    text_.push_back(c);
  } else if (inside_) {
    inside_ = false;
    ++rejects_;
  }
}

bool ColaDecoder::takeScan(std::vector<TimedNode>& nodes) {
  const auto scan = cola::parseScan(text_);
  if (!scan || !scan->isLike(scan_)) return false;
  distances_q2_.clear();
  std::string_view values = scan->values;
  for (int i = 0; i < scan->beams; ++i) {
    const auto value = cola::takeNumber(values);
    if (!value || *value > 0xFFFF) return false;
    const double mm = scan->scale * *value;
    distances_q2_.push_back(mm < kNoEcho || mm > kFurthest ? 0U : static_cast<std::uint32_t>(std::lround(4.0 * mm)));
  }
  if (const auto last = std::exchange(last_began_, scan->began_us))
    lost_ = samplesBetween(1e-6 * (scan->began_us - *last), scan_.turn_time, scan_.per_turn, scan_.beams);
  const double behind = byte_time_ * static_cast<double>(text_.size() + 2);  // [s] from its first byte to the newest
  for (int i = 0; i < scan->beams; ++i) {
    nodes.push_back(
        {{.angle_q6 = scan_.angleQ6(i), .distance_q2 = distances_q2_[static_cast<std::size_t>(i)], .start = i == 0},
         scan_.stepTime() * (scan->beams - 1 - i) + behind});
  }
  return true;
}

}  // namespace slam
