// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/gyro_scale.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace slam {
namespace {

constexpr double kSpan = 1.0;           // [s] of one turn that is compared
constexpr double kMostSpan = 2.0;       // [s] longer ones have a gap
constexpr double kMaxGap = 0.1;         // [s] between two readings of the gyro
constexpr double kMinTurn = 0.5;        // [rad] root of the sum of squared turns, below which nothing is said
constexpr double kOutlier = 3.0;        // [1] of the robust sigma
constexpr double kMadToSigma = 1.4826;  // [1] of a normal distribution
constexpr std::size_t kFewest = 10;     // spans

struct Span {
  double gyro, scans, time;  // [rad], [rad], [s]
};

/// Trapezes between the readings. @return std::nullopt: some are missing
std::optional<double> gyroTurn(const std::vector<TurnRate>& rates, Timestamp begin, Timestamp end) {
  auto at = std::lower_bound(rates.begin(), rates.end(), begin,
                             [](const TurnRate& reading, Timestamp stamp) { return reading.stamp < stamp; });
  if (at == rates.begin()) return std::nullopt;
  double turn = 0.0;
  for (Timestamp from = begin; from < end; ++at) {
    if (at == rates.end()) return std::nullopt;
    const TurnRate& before = *std::prev(at);
    const double interval = toSeconds(at->stamp - before.stamp);
    if (interval > kMaxGap) return std::nullopt;
    const auto rateAt = [&](Timestamp stamp) {
      return before.rate + (at->rate - before.rate) * toSeconds(stamp - before.stamp) / interval;
    };
    const Timestamp to = std::min(at->stamp, end);
    turn += 0.5 * (rateAt(from) + rateAt(to)) * toSeconds(to - from);
    from = to;
  }
  return turn;
}

std::vector<Span> spansOf(const SensorLog& log) {
  std::vector<Span> spans;
  const MatchedScan* begin = nullptr;
  double turned = 0.0;
  const MatchedScan* previous = nullptr;
  for (const MatchedScan& scan : log.scans) {
    if (previous != nullptr) turned += wrapAngle(scan.T_map_base.theta - previous->T_map_base.theta);
    previous = &scan;
    const double time = begin == nullptr ? 0.0 : toSeconds(scan.stamp - begin->stamp);
    if (begin != nullptr && time < kSpan) continue;
    const auto gyro =
        begin != nullptr && time < kMostSpan ? gyroTurn(log.turn_rates, begin->stamp, scan.stamp) : std::nullopt;
    if (gyro) spans.push_back({*gyro, turned, time});
    begin = &scan;
    turned = 0.0;
  }
  return spans;
}

std::optional<GyroScale> fit(const std::vector<Span>& spans) {
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const Span& span : spans) {
    const Eigen::Vector2d row(span.scans, span.time);
    information += row * row.transpose();
    right += row * span.gyro;
  }
  if (spans.size() < kFewest || std::sqrt(information(0, 0)) < kMinTurn) return std::nullopt;
  const Eigen::Vector2d found = information.ldlt().solve(right);
  double squares = 0.0;
  for (const Span& span : spans) squares += std::pow(span.gyro - found[0] * span.scans - found[1] * span.time, 2);
  const double variance = squares / static_cast<double>(spans.size() - 2);
  return GyroScale{found[0], std::sqrt(variance * information.inverse()(0, 0)), found[1]};
}

}  // namespace

std::optional<GyroScale> gyroScale(const SensorLog& log) {
  std::vector<Span> spans = spansOf(log);
  const auto first = fit(spans);
  if (!first) return std::nullopt;
  const auto misfit = [&](const Span& span) {
    return std::abs(span.gyro - first->value * span.scans - first->bias * span.time);
  };
  std::vector<double> misfits;
  std::transform(spans.begin(), spans.end(), std::back_inserter(misfits), misfit);
  const auto middle = misfits.begin() + static_cast<std::ptrdiff_t>(misfits.size() / 2);
  std::nth_element(misfits.begin(), middle, misfits.end());
  const double limit = kOutlier * kMadToSigma * *middle;
  std::erase_if(spans, [&](const Span& span) { return misfit(span) > limit; });
  return fit(spans);
}

}  // namespace slam
