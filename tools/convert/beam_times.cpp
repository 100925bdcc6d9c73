// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/beam_times.hpp"

#include <algorithm>
#include <cstdio>

namespace slam {
namespace {

constexpr std::size_t kFewest = 5;              // scans
constexpr std::size_t kMost = 100000;           // that are kept
constexpr std::int64_t kLongestTurn = 2000000;  // [us]
constexpr std::int64_t kCopied = 20;            // so many times shorter than a turn is no measurement

std::int64_t median(std::vector<std::int64_t> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void BeamTimes::add(std::int64_t first, std::int64_t last) {
  if (spans_.size() >= kMost) return;
  spans_.push_back(last - first);
  const std::int64_t period = first - last_.value_or(first);
  if (period > 0 && period < kLongestTurn) periods_.push_back(period);
  last_ = first;
}

std::optional<std::int64_t> BeamTimes::copiedTurn() const {
  if (spans_.size() < kFewest || 2 * periods_.size() < spans_.size()) return std::nullopt;
  const std::int64_t turn = median(periods_);
  return kCopied * median(spans_) < turn ? std::optional(turn) : std::nullopt;
}

std::string noteOfCopiedTurns(std::int64_t turn) {
  char text[200];
  std::snprintf(text, sizeof(text),
                "the beams of a scan have one time, that of a turn which was complete: it was measured over the %.3f s "
                "before, and is used so",
                1e-6 * static_cast<double>(turn));
  return text;
}

}  // namespace slam
