// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/scip/scip_decoder.hpp"

#include <utility>

#include "drivers/lidar/text/turn_gap.hpp"

namespace slam {

ScipDecoder::ScipDecoder(const scip::Parameters& unit, std::string command, double byte_time)
    : unit_(unit), command_(std::move(command)), byte_time_(byte_time) {
  line_.reserve(kLongestLine);
  data_.reserve(mostNodes() * scip::kRangeSize);
}

void ScipDecoder::reset() {
  expects_ = Expects::kNextScan;
  line_.clear();
  last_stamp_.reset();
  lost_ = 0;
}

/// Behind what is left of a damaged line, perhaps. Its two last digits count the scans that are still to come.
bool ScipDecoder::isEcho() const {
  const std::size_t size = command_.size();
  return line_.size() >= size && line_.compare(line_.size() - size, size - 2, command_, 0, size - 2) == 0;
}

void ScipDecoder::beginScan() {
  expects_ = Expects::kStatus;
  data_.clear();
  bytes_ = line_.size() + 1;
}

void ScipDecoder::reject() {
  ++rejects_;
  expects_ = Expects::kNextScan;
}

void ScipDecoder::push(std::uint8_t byte, std::vector<TimedNode>& nodes) {
  lost_ = 0;
  ends_turn_ = false;
  ++bytes_;
  if (byte == '\n') {
    takeLine(nodes);
    line_.clear();
  } else if (line_.size() < kLongestLine) {
    line_.push_back(static_cast<char>(byte));
  } else {
    line_.clear();
    if (expects_ != Expects::kNextScan) reject();
  }
}

void ScipDecoder::takeLine(std::vector<TimedNode>& nodes) {
  const bool is_end = line_.empty();
  switch (expects_) {
    case Expects::kNextScan:  // behind damage: a scan begins with its echo, whatever its beginning has lost
      if (is_end) expects_ = Expects::kEcho;
      if (isEcho()) beginScan();
      return;
    case Expects::kEcho:
      if (isEcho()) return beginScan();
      return is_end ? void() : reject();
    case Expects::kStatus:
      if (line_ == scip::kStartStatus) expects_ = Expects::kNextScan;  // the command is taken, it is no scan
      if (line_ == scip::kStartStatus) return;
      expects_ = Expects::kStamp;
      return line_ == scip::kScanStatus ? void() : reject();
    case Expects::kStamp:
      stamp_ = scip::decode(std::string_view(line_).substr(0, scip::kStampSize));
      expects_ = Expects::kData;
      return line_.size() == scip::kStampSize + 1 && scip::sumFits(line_) ? void() : reject();
    case Expects::kData:
      if (is_end) return takeScan(nodes);
      if (scip::sumFits(line_) && data_.size() + line_.size() - 1 <= mostNodes() * scip::kRangeSize) {
        data_.append(line_, 0, line_.size() - 1);
        return;
      }
      reject();
      if (isEcho()) beginScan();
  }
}

void ScipDecoder::takeScan(std::vector<TimedNode>& nodes) {
  expects_ = Expects::kEcho;
  if (data_.size() != mostNodes() * scip::kRangeSize) {
    ++rejects_;
    return;
  }
  if (last_stamp_) {
    const double passed = 1e-3 * ((stamp_ - *last_stamp_) % scip::kStampWrap);  // [s]
    lost_ = samplesBetween(passed, unit_.turnTime(), unit_.steps_per_turn, unit_.steps());
  }
  last_stamp_ = stamp_;
  const double behind = byte_time_ * static_cast<double>(bytes_);  // [s] from its first byte to the newest
  for (int i = 0; i < unit_.steps(); ++i) {
    const auto mm = static_cast<int>(
        scip::decode(std::string_view(data_).substr(static_cast<std::size_t>(i) * scip::kRangeSize, scip::kRangeSize)));
    const bool echo = mm >= unit_.least_mm && mm <= unit_.most_mm;
    nodes.push_back({{.angle_q6 = unit_.angleQ6(unit_.first + i),
                      .distance_q2 = echo ? 4U * static_cast<std::uint32_t>(mm) : 0U,
                      .start = i == 0},
                     unit_.stepTime() * (unit_.steps() - 1 - i) + behind});
  }
  ends_turn_ = true;
}

}  // namespace slam
