// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/trust.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>

namespace slam {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kSigmas = 3.0, kPosition = 0.03, kHeading = 0.5 * kDegree;  // [1, m, rad] beyond which a pose is wrong
constexpr double kRight = 0.10;                                              // [m] a pose that need not be lost
constexpr std::array kStates{LocalisationState::kInitialising, LocalisationState::kLocalised,
                             LocalisationState::kDegraded, LocalisationState::kLost};
constexpr std::array kNumbers{"t", "x", "y", "theta", "sxx", "sxy", "syy", "sxt", "syt", "stt"};

std::vector<std::string_view> cellsOf(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return cells;
}

struct Columns {
  std::array<std::size_t, kNumbers.size()> numbers{};
  std::size_t state = 0;
};

std::optional<Columns> columnsOf(std::string_view header) {
  const auto names = cellsOf(header);
  const auto find = [&](std::string_view name, std::size_t& place) {
    place = static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    return place < names.size();
  };
  Columns columns;
  bool all = find("state", columns.state);
  for (std::size_t i = 0; i < kNumbers.size(); ++i) all &= find(kNumbers[i], columns.numbers[i]);
  return all ? std::optional(columns) : std::nullopt;
}

std::optional<KnownPose> poseOf(std::string_view line, const Columns& columns) {
  const auto cells = cellsOf(line);
  std::array<double, kNumbers.size()> v{};
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (columns.numbers[i] >= cells.size()) return std::nullopt;
    const std::string_view cell = cells[columns.numbers[i]];
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), v[i]);
    if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  }
  const auto state = std::find_if(kStates.begin(), kStates.end(), [&](LocalisationState s) {
    return columns.state < cells.size() && cells[columns.state] == nameOf(s);
  });
  const auto stamp = stampOf(v[0]);
  if (state == kStates.end() || !stamp) return std::nullopt;
  KnownPose known{.stamp = *stamp, .state = *state, .T_map_base = {v[1], v[2], v[3]}};
  known.covariance << v[4], v[5], v[7], v[5], v[6], v[8], v[7], v[8], v[9];
  return known;
}

/// From the poses of the first localised scans: the mean of their headings' differences, then of their positions'.
Pose2 alignment(const std::vector<KnownPose>& estimates, const Trajectory& truth, double seconds) {
  if (!(seconds > 0.0)) return {};
  std::vector<std::pair<Pose2, Pose2>> pairs;  // truth, estimate
  std::optional<Timestamp> first;
  for (const KnownPose& known : estimates) {
    const auto at = poseAt(truth, known.stamp);
    if (known.state != LocalisationState::kLocalised || !at) continue;
    if (!first) first = known.stamp;
    if (toSeconds(known.stamp - *first) > seconds) break;
    pairs.emplace_back(*at, known.T_map_base);
  }
  double sine = 0.0, cosine = 0.0;
  for (const auto& [at, known] : pairs) {
    sine += std::sin(at.theta - known.theta);
    cosine += std::cos(at.theta - known.theta);
  }
  Pose2 T_truth_map{0.0, 0.0, std::atan2(sine, cosine)};
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  for (const auto& [at, known] : pairs) {
    const Pose2 turned = T_truth_map * known;
    shift += Eigen::Vector2d(at.x - turned.x, at.y - turned.y) / static_cast<double>(pairs.size());
  }
  return {shift.x(), shift.y(), T_truth_map.theta};
}

}  // namespace

std::vector<KnownPose> readEstimates(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file.string() + ": cannot read: " + std::strerror(errno));
  std::string line;
  std::getline(in, line);
  const auto columns = columnsOf(line);
  if (!columns) throw std::runtime_error(file.string() + ":1: not written by slam-replay --estimates");
  std::vector<KnownPose> estimates;
  for (int number = 2; std::getline(in, line); ++number) {
    const auto known = poseOf(line, *columns);
    if (!known) throw std::runtime_error(file.string() + ":" + std::to_string(number) + ": not an estimate");
    estimates.push_back(*known);
  }
  if (estimates.empty()) throw std::runtime_error(file.string() + ": no estimate in it");
  return estimates;
}

TrustErrors trustErrors(const std::vector<KnownPose>& estimates, const Trajectory& truth, const TrustOptions& options) {
  TrustErrors errors;
  const Pose2 T_map_truth = alignment(estimates, truth, options.align_seconds).inverse();
  int judged = 0;
  for (const KnownPose& known : estimates) {
    const auto at = poseAt(truth, known.stamp);
    if (!at) {
      ++errors.left_out;
      continue;
    }
    ++errors.scans;
    const Pose2 right = T_map_truth * *at;
    const Eigen::Vector3d error(known.T_map_base.x - right.x, known.T_map_base.y - right.y,
                                wrapAngle(known.T_map_base.theta - right.theta));
    const double off = error.head<2>().norm();
    const double variance =
        off > 0.0 ? error.head<2>().dot(known.covariance.topLeftCorner<2, 2>() * error.head<2>()) / (off * off) : 0.0;
    // Not a number, in pose or covariance, is wrong, too.
    const bool position = off <= kSigmas * std::sqrt(variance) + kPosition;
    const bool heading = std::abs(error.z()) <= kSigmas * std::sqrt(known.covariance(2, 2)) + kHeading;
    const bool localised = known.state == LocalisationState::kLocalised, wrong = !(position && heading);
    if (localised) {
      ++errors.localised;
      errors.wrong += wrong;
      errors.worst = std::max(errors.worst, off);
      const Eigen::LDLT<Eigen::Matrix3d> inverse(known.covariance);
      if (inverse.info() == Eigen::Success && inverse.isPositive()) {
        errors.nees += error.dot(inverse.solve(error));
        ++judged;
      }
    }
    const double time = toSeconds(known.stamp - estimates.front().stamp);
    if (time > options.settling) {
      ++errors.settled;
      const bool none = known.state == LocalisationState::kLost || known.state == LocalisationState::kInitialising;
      errors.needless += none && off <= kRight;
    }
    if (options.kidnapped && time > *options.kidnapped && !errors.noticed && (!localised || !wrong)) {
      errors.noticed = time - *options.kidnapped;
    }
  }
  if (judged > 0) errors.nees /= judged;
  return errors;
}

}  // namespace slam
