// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/survey.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace slam {
namespace {

constexpr double kFarthest = 200.0;                // [m] further is no return anyway
constexpr std::uint32_t kFewest = 10;              // beams that share a code
constexpr double kFewestShare = 5e-4;              // [1] of all beams
constexpr double kMostShare = 0.95;                // [1]: where all are one value there is no rim
constexpr int kFewestDirections = 4;               // of 64
constexpr double kOverNeighbours = 10.0;           // [1] times the beams that share a value below
constexpr double kRimShare = 0.1, kRimEnd = 0.01;  // [1] of a code's beams, of all: so few lie above

constexpr std::size_t kFewestScans = 5, kMostScans = 100000;  // that beam times are judged by
constexpr std::int64_t kLongestTurn = 2000000;                // [us]
constexpr std::int64_t kCopied = 20;                          // so many times shorter than a turn is no measurement

}  // namespace

void RangeCensus::add(std::size_t beam, std::size_t beams, double range) {
  if (!(range > 0.0) || range >= kFarthest || beams == 0) return;
  const auto at = static_cast<std::size_t>(std::lround(range / kStep));
  if (at >= bins_.size()) bins_.resize(at + 1);
  Bin& bin = bins_[at];
  if (bin.count < std::numeric_limits<std::uint32_t>::max()) ++bin.count;
  bin.directions |= std::uint64_t{1} << (64 * std::min(beam, beams - 1) / beams);
  ++total_;
}

double RangeCensus::largest() const {
  for (std::size_t i = bins_.size(); i-- > 0;) {
    if (bins_[i].count > 0) return kStep * static_cast<double>(i);
  }
  return 0.0;
}

double RangeCensus::limit() const {
  constexpr double kAbove = 0.01, kLeast = 1.0;  // [m]
  double limit = largest() + kAbove;
  for (const double code : codes()) limit = std::min(limit, code - kStep);
  return std::max(kLeast, limit);
}

std::vector<double> RangeCensus::codes() const {
  std::vector<double> codes;
  std::vector<double> beams{0.0}, values{0.0};  // in the bins below
  for (const Bin& bin : bins_) {
    beams.push_back(beams.back() + bin.count);
    values.push_back(values.back() + (bin.count > 0 ? 1.0 : 0.0));
  }
  const auto all = static_cast<double>(total_);
  double above = 0.0;  // real ranges
  for (std::size_t i = bins_.size(); i-- > 0 && above <= kRimEnd * all;) {
    const Bin& bin = bins_[i];
    if (bin.count == 0) continue;
    const double near = beams[i] - beams[i / 2], near_values = values[i] - values[i / 2];
    const double count = bin.count;
    const bool many = bin.count >= kFewest && count >= kFewestShare * all && count <= kMostShare * all &&
                      std::popcount(bin.directions) >= kFewestDirections;
    if (many && count * near_values >= kOverNeighbours * near && above <= kRimShare * count) {
      codes.push_back(kStep * static_cast<double>(i));
    } else {
      above += count;
    }
  }
  std::reverse(codes.begin(), codes.end());
  return codes;
}

bool isCode(double range, double code) { return std::abs(range - code) <= 0.5 * RangeCensus::kStep + 1e-9; }

void BeamTimes::add(std::int64_t first, std::int64_t last) {
  if (spans_.size() >= kMostScans) return;
  spans_.push_back(last - first);
  const std::int64_t period = first - last_.value_or(first);
  if (period > 0 && period < kLongestTurn) periods_.push_back(period);
  last_ = first;
}

std::optional<std::int64_t> BeamTimes::copiedTurn() const {
  if (spans_.size() < kFewestScans || 2 * periods_.size() < spans_.size()) return std::nullopt;
  const std::int64_t turn = median(periods_);
  return kCopied * median(spans_) < turn ? std::optional(turn) : std::nullopt;
}

}  // namespace slam
