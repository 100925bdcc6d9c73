// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/ekf.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <utility>

namespace slam {
namespace {

/// Chi-square quantile by Wilson and Hilferty's cube approximation (1931), within 2 % at p = 0.9; at
/// p = 0.9999 it lies 7, 5 and 3 % above for one, two and three degrees.
/// @param z standard normal quantile of the same probability
double chiSquareQuantile(int degrees, double z) {
  const double a = 2.0 / (9.0 * degrees);
  const double root = 1.0 - a + z * std::sqrt(a);
  return degrees * root * root * root;
}

/// Standard normal quantile for p in (0.5, 1), Abramowitz and Stegun 26.2.23 (error below 4.5e-4).
double normalQuantile(double p) {
  const double t = std::sqrt(-2.0 * std::log(1.0 - p));
  return t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
}

}  // namespace

Ekf::Ekf(const EkfConfig& config, Timestamp stamp, const Pose2& pose) : config_(&config), stamp_(stamp) {
  x_.head<3>() = pose.vector();
  x_[kGyroBias] = config.initial_gyro_bias;
  P_.diagonal() << 1e-8, 1e-8, 1e-8, square(0.5), square(0.5), square(config.initial_gyro_bias_sigma),
      config.holonomic ? square(0.5) : 0.0;
}

/// (13): the arc of constant twist, written as its chord.
Ekf::Arc Ekf::arcTo(Timestamp stamp) const {
  const EkfConfig& c = *config_;
  const double dt = toSeconds(stamp - stamp_);
  const double moved_time = std::min(dt, std::max(c.max_coast, toSeconds(known_until_ - stamp_)));
  // Wheels that have reported no speed for long: the robot may have stopped, and no scan shows where it is.
  const Timestamp reported_until = std::max(silent_from_, known_until_ + fromSeconds(c.max_coast));
  const double reported_share = c.smooth ? std::clamp(toSeconds(reported_until - stamp_) / moved_time, 0.0, 1.0) : 1.0;
  const double v = reported_share * x_[kSpeed], vy = reported_share * x_[kLateralSpeed];
  const double omega = (gyroActiveAt(stamp) ? 1.0 : reported_share) * x_[kTurnRate];
  const double half_turn = 0.5 * omega * moved_time;
  const double sinc = std::abs(half_turn) < 1e-6 ? 1.0 : std::sin(half_turn) / half_turn;
  const double heading = x_[kTheta] + half_turn;
  return {moved_time, v, vy, omega, std::cos(heading), std::sin(heading), moved_time * sinc};
}

/// @return the pose (x, y, theta) [m, m, rad] at the arc's end
Eigen::Vector3d Ekf::movedAlong(const Arc& arc) const {
  return {x_[kX] + arc.dx(), x_[kY] + arc.dy(), wrapAngle(x_[kTheta] + arc.omega * arc.seconds)};
}

Pose2 Ekf::poseAt(Timestamp stamp) const {
  return stamp <= stamp_ ? pose() : Pose2::fromVector(movedAlong(arcTo(stamp)));
}

void Ekf::predict(Timestamp stamp) {
  if (stamp <= stamp_) return;
  const EkfConfig& c = *config_;
  const Arc arc = arcTo(stamp);
  const Timestamp from = std::exchange(stamp_, stamp);
  const double dt = toSeconds(stamp - from);
  const auto secondsBeyond = [&](Timestamp until) { return std::max(0.0, toSeconds(stamp - std::max(from, until))); };
  const double speed_walks = secondsBeyond(known_until_);
  const double turn_rate_walks = gyroActive() ? dt : secondsBeyond(turn_known_until_);
  // At the end of its interval a speed is not the mean any more.
  const double walked = std::min(interval_, config_->longest_walk);
  if (speed_walks > 0.0 && from <= known_until_) walkSpeeds(walked);
  if (turn_rate_walks > 0.0 && from <= turn_known_until_) walkTurnRate(walked);

  x_.head<3>() = movedAlong(arc);

  Matrix A = Matrix::Identity();
  A(kX, kTheta) = -arc.dy();
  A(kY, kTheta) = arc.dx();
  A(kX, kSpeed) = arc.chord * arc.cos_h;
  A(kY, kSpeed) = arc.chord * arc.sin_h;
  A(kX, kTurnRate) = -0.5 * arc.seconds * arc.dy();
  A(kY, kTurnRate) = 0.5 * arc.seconds * arc.dx();
  A(kX, kLateralSpeed) = -arc.chord * arc.sin_h;
  A(kY, kLateralSpeed) = arc.chord * arc.cos_h;
  A(kTheta, kTurnRate) = arc.seconds;

  const double distance = std::hypot(arc.v, arc.vy) * arc.seconds, turned = std::abs(arc.omega) * arc.seconds;
  const double translation = c.wheelTranslationVariance(distance) + square(c.translation_drift) * dt;
  const double rotation = c.headingVariance(dt, distance, turned, gyroActive());
  P_ = A * P_ * A.transpose();  // (14)
  systematic_ = (A * systematic_).eval();
  P_.diagonal().head<3>() += nisRatio() * Eigen::Vector3d(translation, translation, rotation);
  // No sensor was heard for so long that nothing is known of the motion but what a robot can do.
  if (const double unknown = dt - arc.seconds; dt > c.longest_walk) {
    const double reach = c.limits.max_speed * unknown;
    P_.diagonal().head<3>() += Eigen::Vector3d(reach, reach, c.limits.max_turn_rate * unknown).cwiseAbs2();
  }
  P_(kGyroBias, kGyroBias) += square(c.gyro_bias_noise) * dt;
  walkSpeeds(speed_walks);
  walkTurnRate(turn_rate_walks);
}

void Ekf::walkSpeeds(double seconds) {
  const double walked = square(config_->acceleration_noise) * seconds;
  P_(kSpeed, kSpeed) += walked;
  if (config_->holonomic) P_(kLateralSpeed, kLateralSpeed) += walked;
}

void Ekf::walkTurnRate(double seconds) {
  P_(kTurnRate, kTurnRate) += square(config_->angular_acceleration_noise) * seconds;
}

template <int N>
UpdateResult Ekf::correct(const Eigen::Matrix<double, N, 1>& innovation, const Eigen::Matrix<double, N, 7>& H,
                          const Eigen::Matrix<double, N, N>& R, Considered considered, int gate_degrees,
                          double* normalised_innovation_squared, const Eigen::Matrix3d* seen,
                          const Eigen::Matrix<double, N, kSystematic>& sensitivity) {
  if (!innovation.allFinite() || !H.allFinite() || !R.allFinite()) return UpdateResult::kUseless;
  const Eigen::Matrix<double, 7, N> PHt = P_ * H.transpose();
  const Eigen::Matrix<double, N, N> S = H * PHt + R;
  const Eigen::LLT<Eigen::Matrix<double, N, N>> S_llt(S);
  if (S_llt.info() != Eigen::Success) return UpdateResult::kUseless;
  if (gate_degrees > 0) {
    const double limit = chiSquareQuantile(gate_degrees, normalQuantile(config_->gate_probability));
    const double distance = innovation.dot(S_llt.solve(innovation));
    if (normalised_innovation_squared) *normalised_innovation_squared = distance;
    if (!(distance <= limit)) return UpdateResult::kRejected;  // also for NaN
  }
  Eigen::Matrix<double, 7, N> K = S_llt.solve(PHt.transpose()).transpose();  // (15)
  if (considered == kBias) K.row(kGyroBias).setZero();
  if (config_->smooth) K.template topRows<3>().setZero();
  if (seen != nullptr) K.template topRows<3>() = (*seen * K.template topRows<3>()).eval();
  x_ += K * innovation;  // (16)
  x_[kTheta] = wrapAngle(x_[kTheta]);
  const Matrix I_KH = Matrix::Identity() - K * H;
  P_ = I_KH * P_ * I_KH.transpose() + K * R * K.transpose();  // (17) in Joseph form
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  systematic_ = (I_KH * systematic_ + K * sensitivity).eval();
  return UpdateResult::kFused;
}

bool Ekf::isPossible(const Twist2& twist) const {
  return std::hypot(twist.vx, twist.vy) < config_->max_speed && std::abs(twist.omega) < config_->max_turn_rate;
}

bool Ekf::detectSlip(double wheel_rate, double gyro_rate, double interval) {
  const double leak = std::exp(-interval / config_->slip_window);
  slip_.evidence = leak * slip_.evidence + (wheel_rate - gyro_rate) * interval;
  slip_.turned = leak * slip_.turned + std::abs(gyro_rate) * interval;
  return std::abs(slip_.evidence) > config_->slip_angle + config_->slip_scale * slip_.turned;
}

/// The wheels' speed along one axis of the base. @param possible the robot can have driven it, however sudden
UpdateResult Ekf::correctSpeed(Index state, double speed, bool possible) {
  Eigen::Matrix<double, 1, 7> H = Eigen::Matrix<double, 1, 7>::Zero();
  H(0, state) = 1.0;
  const double sigma = slip_.now ? config_->slip_speed_sigma : config_->wheel_speed_sigma;
  const Eigen::Matrix<double, 1, 1> innovation(speed - x_[state]), R(square(sigma));
  const UpdateResult result = correct<1>(innovation, H, R, kBias, 1);
  if (result == UpdateResult::kRejected && possible) {
    P_(state, state) += square(innovation.x());
    correct<1>(innovation, H, R, kBias, 0);
  }
  return result;
}

/// Whether wheels that stand are not to be followed. From an abrupt stop on the speed is zero give or take what it was,
/// until scans show where the robot is.
bool Ekf::mayHaveDied(const Eigen::Vector2d& velocity, double turn_rate, double seconds) {
  if (!config_->standstill.isQuiet(velocity.norm(), turn_rate)) {
    stop_.move(velocity);
    return false;
  }
  if (!stop_.stand(config_->hardest_braking, seconds, stamp_, pose())) return stop_.doubtful();
  silent_from_ = known_until_ = stamp_;
  const auto stop = [this](Index state) {
    x_[state] = 0.0;
    P_.row(state).setZero();
    P_.col(state).setZero();
    P_(state, state) = square(stop_.speed());
    systematic_.row(state).setZero();
  };
  stop(kSpeed);
  if (config_->holonomic) stop(kLateralSpeed);
  return true;
}

UpdateResult Ekf::updateWheels(const Twist2& twist, bool turn_rate_known, Duration interval,
                               std::optional<double> gyro_mean) {
  const EkfConfig& c = *config_;
  const double seconds = toSeconds(interval);
  const double vy = c.holonomic ? twist.vy : 0.0;
  const bool finite = std::isfinite(twist.vx) && std::isfinite(vy) && std::isfinite(twist.omega);
  if (!(seconds > 0.0) || !finite) return UpdateResult::kUseless;

  const Eigen::Vector2d velocity(twist.vx, vy);
  const double known_turn_rate = turn_rate_known ? twist.omega : 0.0;
  if (!c.smooth && mayHaveDied(velocity, known_turn_rate, seconds)) return UpdateResult::kUseless;
  const bool was_silent = interval_ > 0.0 && seconds > std::max(c.longest_walk, c.silent_intervals * interval_);
  interval_ = seconds;
  if (c.smooth && was_silent) return UpdateResult::kUseless;
  known_until_ = stamp_ + interval;
  silent_from_ = known_until_ + fromSeconds(std::clamp(2.0 * seconds, config_->short_silence, config_->long_silence));
  standstill_.addWheels(stamp_, velocity.norm(), known_turn_rate, c.standstill);
  slip_.now = turn_rate_known && gyro_mean && detectSlip(twist.omega, *gyro_mean - x_[kGyroBias], seconds);

  // The wheels' mean over an interval is the only word on what was driven in it: coasting through it at the old speed
  // would be worse than any sample that the robot can have driven. One outside the gate is a sudden change of speed.
  const bool possible = c.accepts_sudden_speeds && isPossible({twist.vx, vy, twist.omega});
  // From one mean to the next the speed walks at once, not within an interval: that would let the next one's mean
  // correct the way that was driven in it.
  const double walked = std::min(seconds, config_->longest_walk);
  walkSpeeds(walked);
  const auto sudden = [&](double innovation, Index state) { P_(state, state) += square(innovation); };

  UpdateResult result;
  if (turn_rate_known && !gyroActive() && !slip_.now) {
    turn_known_until_ = known_until_;
    walkTurnRate(walked);
    Eigen::Matrix<double, 2, 7> H = Eigen::Matrix<double, 2, 7>::Zero();
    H(0, kSpeed) = H(1, kTurnRate) = 1.0;
    const Eigen::Matrix2d R =
        Eigen::Vector2d(square(c.wheel_speed_sigma),
                        square(c.wheel_turn_rate_sigma) + square(c.wheel_turn_rate_scale * twist.omega))
            .asDiagonal();
    const Eigen::Vector2d innovation(twist.vx - x_[kSpeed], twist.omega - x_[kTurnRate]);
    result = correct<2>(innovation, H, R, kBias, 2);
    if (result == UpdateResult::kRejected && possible) {
      sudden(innovation.x(), kSpeed);
      sudden(innovation.y(), kTurnRate);
      correct<2>(innovation, H, R, kBias, 0);
    }
  } else {
    result = correctSpeed(kSpeed, twist.vx, possible);
  }
  if (c.holonomic) correctSpeed(kLateralSpeed, vy, possible);
  ++(result == UpdateResult::kFused ? counters_.wheels_fused : counters_.wheels_rejected);
  updateStandstill();
  return result;
}

void Ekf::holdTwist(const Twist2& mean, bool turn_rate_known) {
  if (slip_.now || !isPossible(mean)) return;
  const auto hold = [this](Index state, double value, double sigma) {
    x_[state] = value;
    P_.row(state).setZero();
    P_.col(state).setZero();
    P_(state, state) = square(sigma);
    systematic_.row(state).setZero();
  };
  hold(kSpeed, mean.vx, config_->wheel_speed_sigma);
  if (config_->holonomic) hold(kLateralSpeed, mean.vy, config_->wheel_speed_sigma);
  if (turn_rate_known && !gyroActive()) hold(kTurnRate, mean.omega, config_->wheel_turn_rate_sigma);
}

UpdateResult Ekf::updateGyro(double rate) {
  if (!std::isfinite(rate)) return UpdateResult::kUseless;
  const EkfConfig& c = *config_;
  const bool bias_unknown = biasUnknown();
  standstill_.addGyro(stamp_, rate - x_[kGyroBias], bias_unknown ? c.largest_gyro_bias : c.standstill.max_gyro_rate,
                      c.standstill);
  updateStandstill();  // here too: between two wheel samples the turn rate has become uncertain again
  Eigen::Matrix<double, 1, 7> H = Eigen::Matrix<double, 1, 7>::Zero();
  H(0, kTurnRate) = H(0, kGyroBias) = 1.0;
  // While driving, the predicted turn rate comes from the wheels: learning the bias from the difference would let their
  // systematic errors in again. The bias is learned at standstill and from matched scans.
  const Eigen::Matrix<double, 1, 1> innovation(rate - x_[kTurnRate] - x_[kGyroBias]), R(square(c.gyro_sigma));
  UpdateResult result = correct<1>(innovation, H, R, standstill() ? kNone : kBias, 1);
  if (result == UpdateResult::kRejected && bias_unknown && !wheelsSilent() &&
      standstill_.active(stamp_, c.standstill.min_time)) {
    P_(kGyroBias, kGyroBias) += square(innovation.x());
    result = correct<1>(innovation, H, R, kNone, 0);
  }
  ++(result == UpdateResult::kFused ? counters_.gyro_fused : counters_.gyro_rejected);
  gyro_stamp_ = stamp_;
  return result;
}

void Ekf::setGyroBias(double bias, double variance) {
  if (!std::isfinite(bias) || !(variance > 0.0)) return;
  const double scale = std::sqrt(variance / P_(kGyroBias, kGyroBias));
  x_[kGyroBias] = bias;
  P_.row(kGyroBias) *= scale;
  P_.col(kGyroBias) *= scale;
}

bool Ekf::biasUnknown() const { return P_(kGyroBias, kGyroBias) > square(0.5 * config_->initial_gyro_bias_sigma); }

bool Ekf::standstill() const {
  // At start the gyro's bias is unknown and would turn the pose for as long as standstill takes to be believed. Wheels
  // that do not move are then the better word from their first sample on.
  if (wheelsSilent()) return false;
  const StandstillConfig& times = config_->standstill;
  return standstill_.active(stamp_, gyroActive() && biasUnknown() ? times.min_time_unbiased : times.min_time);
}

void Ekf::updateStandstill() {
  if (!standstill()) return;
  Eigen::Matrix<double, 2, 7> H = Eigen::Matrix<double, 2, 7>::Zero();
  H(0, kSpeed) = H(1, kTurnRate) = 1.0;
  const Eigen::Matrix2d R =
      Eigen::Vector2d(square(config_->standstill_speed_sigma), square(config_->standstill_turn_rate_sigma))
          .asDiagonal();
  correct<2>(Eigen::Vector2d(-x_[kSpeed], -x_[kTurnRate]), H, R, kNone, 0);
  if (config_->holonomic) {
    Eigen::Matrix<double, 1, 7> across = Eigen::Matrix<double, 1, 7>::Zero();
    across(0, kLateralSpeed) = 1.0;
    correct<1>(Eigen::Matrix<double, 1, 1>(-x_[kLateralSpeed]), across, R.topLeftCorner<1, 1>(), kNone, 0);
  }
  ++counters_.standstill_updates;
}

/// Remembers by how much a scan is off the prediction. @return whether the last one was off alike, give or take what
/// slipping wheels have made up since
bool Ekf::differsAsBefore(const Eigen::Vector3d& error) {
  const Eigen::Vector3d change = error - std::exchange(last_.error, error);
  const Eigen::Vector3d pose = x_.head<3>(), moved = pose - std::exchange(last_.at, pose);
  return change.head<2>().norm() <= config_->same_error + moved.head<2>().norm() &&
         std::abs(wrapAngle(change.z())) <= config_->same_error + std::abs(wrapAngle(moved.z()));
}

UpdateResult Ekf::updatePose(const PoseMeasurement& measurement) {
  const int n = measurement.observable;
  if (n <= 0) return UpdateResult::kUseless;
  Eigen::Vector3d error = measurement.T_map_base.vector() - x_.head<3>();
  error.z() = wrapAngle(error.z());

  // Blind directions take no part: they get a zero row in H, a zero innovation and a unit variance of their own.
  Eigen::Matrix<double, 3, 7> H = Eigen::Matrix<double, 3, 7>::Zero();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d innovation = Eigen::Vector3d::Zero();
  Sensitivity sensitivity = Sensitivity::Zero();
  const auto U = measurement.directions.leftCols(n);
  sensitivity.topRows(n) = U.transpose() * measurement.sensitivity;
  H.topLeftCorner(n, 3) = U.transpose();
  innovation.head(n) = U.transpose() * error;
  R.topLeftCorner(n, n) = U.transpose() * measurement.covariance * U;

  // Which way is blind is known to a fraction of a degree. Where the prediction is off by metres along it, centimetres
  // of them would pass for what the scan saw across: the gain along it is zero [Schmidt 1966].
  const Eigen::Matrix3d seen = U * U.transpose();

  double distance = n;
  UpdateResult result = correct<3>(innovation, H, R, kNone, n, &distance, &seen, sensitivity);
  nis_ratio_ += (std::min(distance / n, config_->max_contradiction) - nis_ratio_) / config_->nis_memory;
  // A wrong filter is refuted by the same error each time, a wrong match by another one from scan to scan.
  const Eigen::Vector3d seen_error = U * innovation.head(n);
  if (!differsAsBefore(seen_error)) rejected_in_a_row_ = 0;
  const bool override_gate = result == UpdateResult::kRejected &&
                             (measurement.bypass_gate || ++rejected_in_a_row_ > config_->max_rejected_poses) &&
                             error.norm() < config_->farthest_pose;
  if (override_gate) {  // the robot was moved or the wheels slipped, as far as the scan sees it
    P_.topLeftCorner<3, 3>() += (2.0 * seen_error * seen_error.transpose()).eval();
    result = correct<3>(innovation, H, R, kNone, 0, nullptr, &seen, sensitivity);
  }
  if (result == UpdateResult::kFused) rejected_in_a_row_ = 0;
  stop_.decide(stamp_, pose(), config_->stop_sigmas * std::sqrt(P_.topLeftCorner<2, 2>().trace()));
  ++(result == UpdateResult::kFused ? counters_.poses_fused : counters_.poses_rejected);
  return result;
}

void Ekf::setPose(const Pose2& pose, const Eigen::Vector3d& sigma) {
  x_.head<3>() = pose.vector();
  P_.topRows<3>().setZero();
  P_.leftCols<3>().setZero();
  P_.diagonal().head<3>() = sigma.cwiseAbs2();
  systematic_.topRows<3>().setZero();
  rejected_in_a_row_ = 0;
  nis_ratio_ = 1.0;
  stop_.beginAt(stamp_, pose);
}

void Ekf::transform(const Pose2& T_new_old) {
  x_.head<3>() = (T_new_old * pose()).vector();
  Matrix rotation = Matrix::Identity();
  rotation.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(T_new_old.theta).toRotationMatrix();
  P_ = (rotation * P_ * rotation.transpose()).eval();
  systematic_ = (rotation * systematic_).eval();
  stop_.transform(T_new_old);
}

}  // namespace slam
