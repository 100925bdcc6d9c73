// SPDX-License-Identifier: BSD-3-Clause
#include "diagnostics/mount_estimate.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <span>

namespace slam {
namespace {

/// Scale times cosine and sine of minus the yaw; offset [m].
using Unknowns = Eigen::Vector4d;
enum Free { kScale = 1, kYaw = 2, kOffset = 4 };  // which of them a fit may choose

/// One motion: the way that scans tell, as the unknowns make it of the wheels' [m].
struct Equation {
  Eigen::Matrix<double, 2, 4> by;
  Eigen::Vector2d scans;
  double turn, travel;  // [rad], [m]
  double speed;
  double weight = 1.0;  // 0: an outlier

  double residual(const Unknowns& unknowns) const { return (scans - by * unknowns).squaredNorm(); }
};

struct Fit {
  Unknowns value = Unknowns::Zero();
  Eigen::Matrix4d covariance;  // for residuals of 1 m
};

Fit fit(std::span<const Equation> equations, int free) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (const Equation& equation : equations) {
    normal += equation.weight * equation.by.transpose() * equation.by;
    right += equation.weight * equation.by.transpose() * equation.scans;
  }
  const std::array is_free{(free & kScale) != 0, (free & kYaw) != 0, (free & kOffset) != 0, (free & kOffset) != 0};
  for (int i = 0; i < 4; ++i) {
    if (is_free[static_cast<std::size_t>(i)]) continue;
    normal.row(i).setZero();
    normal.col(i).setZero();
    normal(i, i) = 1.0;
    right(i) = 0.0;
  }
  normal.diagonal().array() += 1e-9;  // [m^2]: nothing was seen of it
  Fit fit;
  fit.covariance = normal.inverse();
  fit.value = fit.covariance * right;
  return fit;
}

double medianOf(std::array<double, 144>& values, std::size_t count) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(values.begin(), middle, values.begin() + static_cast<std::ptrdiff_t>(count));
  return *middle;
}

/// Leaves out what fits to nothing, again and again. @return variance of the rest [m^2]
double dropOutliers(std::span<Equation> equations, double outlier) {
  double sum = 0.0;
  int used = 0;
  for (int round = 0; round < 4; ++round) {
    const Unknowns now = fit(equations, kScale | kYaw | kOffset).value;
    std::array<double, 144> residuals{};
    for (std::size_t i = 0; i < equations.size(); ++i) residuals[i] = equations[i].residual(now);
    const double most = outlier * outlier * medianOf(residuals, equations.size());
    sum = 0.0;
    used = 0;
    for (Equation& equation : equations) {
      equation.weight = equation.residual(now) <= most ? 1.0 : 0.0;
      sum += equation.weight * equation.residual(now);
      used += equation.weight > 0.0;
    }
  }
  return sum / std::max(1, 2 * used - 4);
}

/// How much better some of the pairs fit, outliers cut.
struct Gain {
  double deviations, left_over;
};

template <typename Filter>
Gain gainOf(std::span<const Equation> equations, const Unknowns& without, const Unknowns& with, double most,
            Filter filter) {
  double sum = 0.0, squares = 0.0, before = 0.0, after = 0.0;
  int count = 0;
  for (const Equation& equation : equations) {
    if (!filter(equation)) continue;
    const double old = std::min(equation.residual(without), most), now = std::min(equation.residual(with), most);
    sum += old - now;
    squares += (old - now) * (old - now);
    before += old;
    after += now;
    ++count;
  }
  if (count < 2 || before <= 0.0) return {0.0, 1.0};
  const double mean = sum / count, variance = std::max(squares / count - mean * mean, 1e-30);
  return {mean * std::sqrt(count / variance), after / before};
}

}  // namespace

void MountEstimate::add(const Pose2& scans, const Pose2& wheels, double gyro_turn, double seconds) {
  const double turn = std::abs(scans.theta), most = config_.same_turn * std::max(turn, config_.least_turn);
  const double travel = wheels.translation().norm();
  if (std::abs(wheels.theta - scans.theta) > most || std::abs(gyro_turn - scans.theta) > most || seconds <= 0.0) return;
  const bool turns = turn >= config_.least_turn;
  if (!turns && travel < config_.least_travel) return;
  Pairs& pairs = !turns ? straight_ : scans.theta > 0.0 ? left_ : right_;
  pairs.last[pairs.count++ % pairs.last.size()] = {scans, wheels, (turns ? turn : travel) / seconds};
}

bool MountEstimate::wantsTurns() const { return std::min(left_.count, right_.count) < config_.wanted; }

MountCorrection MountEstimate::correction() const {
  std::array<Equation, 144> storage;
  std::size_t size = 0;
  for (const Pairs* pairs : {&left_, &right_, &straight_}) {
    for (std::size_t i = 0; i < std::min(pairs->count, pairs->last.size()); ++i) {
      const Pair& pair = pairs->last[i];
      const double x = pair.wheels.x, y = pair.wheels.y, c = std::cos(pair.scans.theta) - 1.0,
                   s = std::sin(pair.scans.theta);
      Equation& equation = storage[size++];
      equation.by << x, -y, c, -s, y, x, s, c;
      equation.scans = pair.scans.translation();
      equation.turn = pairs == &straight_ ? 0.0 : pair.scans.theta;
      equation.travel = pair.wheels.translation().norm();
      equation.speed = pair.speed;
    }
  }
  if (size < 4 * config_.least_pairs) return {};
  const std::span<Equation> equations(storage.data(), size);
  const double variance = dropOutliers(equations, config_.outlier);
  const double most = config_.sure * config_.sure * variance;
  const Fit whole = fit(equations, kScale | kYaw | kOffset);
  const double scale = whole.value.head<2>().norm(), yaw = -std::atan2(whole.value(1), whole.value(0));
  const Eigen::Vector2d offset = whole.value.tail<2>();
  const auto sigma = [&](int i) { return std::sqrt(variance * whole.covariance(i, i)); };
  const auto isBetter = [&](int without, auto filter) {
    const Gain gain = gainOf(equations, fit(equations, without).value, whole.value, most, filter);
    return gain.deviations > config_.gain && gain.left_over < config_.left_over;
  };
  // Slow and fast ones of some pairs, each for itself. @param tells what its sums say: (value, whether they say so)
  const auto agree = [&](auto filter, auto tells) {
    std::array<const Equation*, 144> group;
    std::size_t count = 0;
    for (const Equation& equation : equations) {
      if (equation.weight > 0.0 && filter(equation)) group[count++] = &equation;
    }
    if (count < 2 * config_.least_pairs) return false;
    const std::span all(group.data(), count);
    std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count / 2), all.end(),
                     [](const Equation* a, const Equation* b) { return a->speed < b->speed; });
    return tells(all.first(count / 2)) && tells(all.subspan(count / 2));
  };

  MountCorrection correction;
  const auto turns = [](const Equation& equation) { return equation.turn != 0.0; };
  const auto tellsOffset = [&](std::span<const Equation* const> group) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double weight = 0.0;
    for (const Equation* equation : group) {
      const Eigen::Matrix2d lever = equation->by.rightCols<2>();
      sum += lever.transpose() * (equation->scans - equation->by.leftCols<2>() * whole.value.head<2>());
      weight += lever.col(0).squaredNorm();
    }
    return (sum / weight - offset).norm() < config_.alike * offset.norm();
  };
  if (offset.norm() > std::max(config_.least_offset, config_.sure * std::max(sigma(2), sigma(3))) &&
      isBetter(kScale | kYaw, turns) &&
      agree([](const Equation& equation) { return equation.turn > 0.0; }, tellsOffset) &&
      agree([](const Equation& equation) { return equation.turn < 0.0; }, tellsOffset)) {
    correction.offset = offset;
  }
  const auto travels = [&](const Equation& equation) { return equation.travel >= config_.least_travel; };
  const auto tellsYaw = [&](std::span<const Equation* const> group) {
    double along = 0.0, across = 0.0;
    for (const Equation* equation : group) {
      const Eigen::Vector2d seen = equation->scans - equation->by.rightCols<2>() * offset;
      along += equation->by.col(0).dot(seen);
      across += equation->by.col(1).dot(seen);
    }
    return std::abs(-std::atan2(across, along) - yaw) < config_.alike * std::abs(yaw);
  };
  if (std::abs(yaw) > std::max(config_.least_yaw, config_.sure * sigma(1) / scale) &&
      isBetter(kScale | kOffset, travels) && agree(travels, tellsYaw)) {
    correction.yaw = yaw;
  }
  return correction;
}

}  // namespace slam
