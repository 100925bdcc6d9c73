// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <optional>

#include "core/counter_info.hpp"
#include "core/estimates.hpp"
#include "core/pose2.hpp"
#include "core/pose_covariance.hpp"
#include "core/samples.hpp"
#include "core/timestamp.hpp"
#include "estimation/abrupt_stop.hpp"
#include "estimation/standstill.hpp"

namespace slam {

/// Noise of the robot and its sensors. A random walk of strength q has standard deviation q * sqrt(interval).
struct EkfConfig {
  double acceleration_noise = 2.0;             ///< [m/s per sqrt(s)] how fast the speed changes
  double angular_acceleration_noise = 6.0;     ///< [rad/s per sqrt(s)] how fast the turn rate changes
  double gyro_bias_noise = 2e-5;               ///< [rad/s per sqrt(s)]
  double initial_gyro_bias_sigma = 0.02;       ///< [rad/s]
  double initial_gyro_bias = 0.0;              ///< [rad/s] as known from the last run
  double largest_gyro_bias = 0.5;              ///< [rad/s] what is further off is a fault and no bias
  Pose2 initial_pose;                          ///< of base
  double translation_noise = 0.10;             ///< [m per sqrt(m)] of wheel odometry
  double rotation_noise_per_metre = 0.03;      ///< [rad per sqrt(m)] of wheel odometry, without gyro
  double rotation_noise_wheels = 0.30;         ///< [rad per sqrt(rad)] of wheel odometry, without gyro
  double rotation_noise_gyro = 0.01;           ///< [rad per sqrt(rad)] scale error of the gyro
  double rotation_drift = 0.005;               ///< [rad per sqrt(s)] always
  double translation_drift = 0.005;            ///< [m per sqrt(s)] always
  double wheel_speed_sigma = 0.01;             ///< [m/s] of one wheel sample
  double wheel_turn_rate_sigma = 0.05;         ///< [rad/s] of one wheel sample; used without gyro only
  double wheel_turn_rate_scale = 0.05;         ///< [1] error of wheel turn rate per turn rate
  double gyro_sigma = 0.005;                   ///< [rad/s] of one gyro sample
  double gyro_timeout = 0.2;                   ///< [s] without a gyro sample the wheels give the turn rate
  double hardest_braking = 9.81;               ///< [m/s^2] by tyres: their friction is no more than the weight
  double stop_sigmas = 4.0;                    ///< [1] standard deviations of its place by which a stop is decided
  double standstill_speed_sigma = 0.001;       ///< [m/s] zero-velocity update
  double standstill_turn_rate_sigma = 0.0003;  ///< [rad/s] zero-rate update
  double slip_angle = 0.035;                   ///< [rad] wheels and gyro differing by more within slip_window is slip
  double slip_scale = 0.10;                    ///< [1] and by more than this share of the angle turned in it
  double slip_window = 0.25;                   ///< [s]
  double slip_speed_sigma = 0.15;              ///< [m/s] of one wheel sample while slipping
  double gate_probability = 0.9999;            ///< share of good measurements that the chi-square gates let pass
  double max_speed = 5.0;                      ///< [m/s] no indoor robot drives faster: such a wheel sample is a fault
  double max_turn_rate = 10.0;                 ///< [rad/s] nor turns faster
  int nis_memory = 10;                         ///< matched scans over which the prediction is judged
  double max_coast = 0.5;  ///< [s] the pose is moved on for no longer beyond what the wheels have reported
  SpeedLimits limits;      ///< of a motion that no sensor measures: the pose becomes uncertain by it
  bool holonomic = false;  ///< the base can move sideways (omni, mecanum)
  StandstillConfig standstill;
  int max_rejected_poses = 2;        ///< consecutive matched scans outside the gate: then the filter is wrong, not they
  double same_error = 0.1;           ///< [m, rad] and they put the robot to one place: errors that differ by no more
  double max_contradiction = 100.0;  ///< [1] one scan counts for no more in the doubt
  double short_silence = 0.1;        ///< [s] of wheels beyond two intervals, at least ...
  double long_silence = 1.0;         ///< [s] ... and at most
  double longest_walk = 2.0;         ///< [s] from mean to mean: no robot's speed is further from one, however long
  double silent_intervals = 3.0;     ///< [1] usual intervals of the wheels, beyond which they were silent
  bool smooth = false;               ///< the pose drifts, but never jumps: see Ekf
  bool accepts_sudden_speeds = true;  ///< of the wheels, outside the gate, if the robot can have driven them
  double farthest_pose = 1e3;         ///< [m] from the prediction: no robot is carried further between two scans

  /// Variances of wheel odometry without gyro [m^2], [rad^2], over `distance` [m] and `turn` [rad], both at least zero.
  double wheelTranslationVariance(double distance) const { return translation_noise * translation_noise * distance; }
  double wheelRotationVariance(double distance, double turn) const {
    return rotation_noise_wheels * rotation_noise_wheels * turn +
           rotation_noise_per_metre * rotation_noise_per_metre * distance;
  }

  /// Variance of the heading [rad^2] over `seconds` [s], `distance` [m] and `turn` [rad], by the gyro or by the wheels.
  double headingVariance(double seconds, double distance, double turn, bool by_gyro) const {
    return rotation_drift * rotation_drift * seconds +
           (by_gyro ? rotation_noise_gyro * rotation_noise_gyro * turn : wheelRotationVariance(distance, turn));
  }

  void visitSettings(auto& v) {
    v.expert("acceleration_noise", acceleration_noise, "m/s per sqrt(s)", 0.01, 100.0,
             "The speed changes as a random walk with this standard deviation.");
    v.expert("angular_acceleration_noise", angular_acceleration_noise, "rad/s per sqrt(s)", 0.01, 100.0,
             "The turn rate changes as a random walk with this standard deviation.");
    v.expert("gyro_bias_noise", gyro_bias_noise, "rad/s per sqrt(s)", 0.0, 0.1,
             "The gyro's bias changes as a random walk with this standard deviation.");
    v.expert("initial_gyro_bias_sigma", initial_gyro_bias_sigma, "rad/s", 1e-5, 1.0,
             "The gyro's bias has this standard deviation at the start.");
    v.expert("translation_noise", translation_noise, "m per sqrt(m)", 0.0, 1.0,
             "The distance that the wheels measure has this standard deviation after one metre.");
    v.expert("rotation_noise_per_metre", rotation_noise_per_metre, "rad per sqrt(m)", 0.0, 1.0,
             "The heading that the wheels measure without a gyro has this standard deviation after one metre.");
    v.expert(
        "rotation_noise_wheels", rotation_noise_wheels, "rad per sqrt(rad)", 0.0, 1.0,
        "The heading that the wheels measure without a gyro has this standard deviation after a turn of one radian.");
    v.expert("rotation_noise_gyro", rotation_noise_gyro, "rad per sqrt(rad)", 0.0, 1.0,
             "The heading that the gyro measures has this standard deviation after a turn of one radian.");
    v.expert("rotation_drift", rotation_drift, "rad per sqrt(s)", 1e-6, 0.1,
             "The heading gains this standard deviation in one second, even at rest.");
    v.expert("translation_drift", translation_drift, "m per sqrt(s)", 1e-6, 0.1,
             "The position gains this standard deviation in one second, even at rest.");
    v.expert("wheel_speed_sigma", wheel_speed_sigma, "m/s", 1e-4, 1.0,
             "The speed in one wheel sample has this standard deviation.");
    v.expert("wheel_turn_rate_sigma", wheel_turn_rate_sigma, "rad/s", 1e-4, 5.0,
             "The turn rate in one wheel sample has this standard deviation; it is used without a gyro only.");
    v.expert("wheel_turn_rate_scale", wheel_turn_rate_scale, "1", 0.0, 1.0,
             "The turn rate of the wheels is wrong by this share of itself.");
    v.expert("gyro_sigma", gyro_sigma, "rad/s", 1e-5, 1.0, "One gyro sample has this standard deviation.");
    v.expert("gyro_timeout", gyro_timeout, "s", 0.01, 10.0,
             "The wheels give the turn rate after this time without a gyro sample.");
    v.expert("slip_angle", slip_angle, "rad", 1e-3, 3.0,
             "The wheels slip when they and the gyro differ by more than this angle within ekf.slip_window.");
    v.expert("slip_scale", slip_scale, "1", 0.0, 1.0,
             "Slip also requires that wheels and gyro differ by more than this share of the angle turned in "
             "ekf.slip_window.");
    v.expert("slip_window", slip_window, "s", 0.02, 10.0,
             "Wheels and gyro are compared over this time to detect slip.");
    v.expert("slip_speed_sigma", slip_speed_sigma, "m/s", 1e-3, 10.0,
             "The speed in one wheel sample has this standard deviation while the wheels slip.");
    v.expert("gate_probability", gate_probability, "1", 0.9, 0.999999,
             "The innovation gates accept this share of good measurements.");
    v.expert("max_speed", max_speed, "m/s", 0.1, 100.0,
             "A wheel sample with a higher speed than this is a fault and is not used.");
    v.expert("max_turn_rate", max_turn_rate, "rad/s", 0.1, 100.0,
             "A wheel sample with a higher turn rate than this is a fault and is not used.");
    v.expert("nis_memory", nis_memory, "", 1, 1000, "The filter's prediction is judged by this many matched scans.");
    v.expert("max_coast", max_coast, "s", 0.0, 10.0, "The pose moves on for no longer than this without any sample.");
    standstill.visitSettings(v);
  }
};

enum class UpdateResult : std::uint8_t { kFused, kRejected, kUseless };

/// What the gates let through and what they stopped.
struct EkfCounters {
  std::uint32_t wheels_fused = 0, wheels_rejected = 0;
  std::uint32_t gyro_fused = 0, gyro_rejected = 0;
  std::uint32_t poses_fused = 0, poses_rejected = 0;
  std::uint32_t standstill_updates = 0;

  template <typename Visitor>
  friend void visitCounters(const EkfCounters& c, Visitor&& visit) {
    visit(CounterInfo{"ekf.wheels_fused", "samples", "Wheel samples that the filter fused."}, c.wheels_fused);
    visit(CounterInfo{"ekf.wheels_rejected", "samples", "Wheel samples that a gate stopped."}, c.wheels_rejected);
    visit(CounterInfo{"ekf.gyro_fused", "samples", "Gyro samples that the filter fused."}, c.gyro_fused);
    visit(CounterInfo{"ekf.gyro_rejected", "samples", "Gyro samples that a gate stopped."}, c.gyro_rejected);
    visit(CounterInfo{"ekf.poses_fused", "scans", "Matched poses that the filter fused."}, c.poses_fused);
    visit(CounterInfo{"ekf.poses_rejected", "scans", "Matched poses that a gate stopped."}, c.poses_rejected);
    visit(CounterInfo{"ekf.standstill_updates", "times", "The robot stood still, and its speeds were held at zero."},
          c.standstill_updates);
  }
};

/// Extended Kalman filter of wheels and IMU, eq. (7)-(17) of the paper (section III.A), on the state
///
///     x = (x, y, theta, v, omega, b_g, v_y)        [m, m, rad, m/s, rad/s, rad/s, m/s]
///
/// The motion model f moves the pose along the arc of constant v, v_y and omega; these and the gyro bias b_g are random
/// walks, speeds from one interval of the wheels to the next only: what they tell is the mean over one. v_y, the speed
/// to the left, is not the paper's: a base that cannot move sideways keeps it at zero, exactly. Sensors correct one
/// after another, wheels first, then IMU, then (in the pose filter) a matched scan, each on the result of the one
/// before. Corrections use the Joseph form, which keeps P positive definite for any gain. A filter without
/// scans is smooth: a correction changes its speeds and bias, but not its pose. What a wrong bias has turned since the
/// last rest, or a speed that wheels do not tell for long, would be undone by a jump of metres. What was driven while
/// the wheels were silent is left out.
///
/// A plain value without I/O or allocation: EkfTimeline keeps copies of it. Not safe for concurrent writes.
class Ekf {
 public:
  using Vector = Eigen::Matrix<double, 7, 1>;
  using Matrix = Eigen::Matrix<double, 7, 7>;
  enum Index { kX, kY, kTheta, kSpeed, kTurnRate, kGyroBias, kLateralSpeed };

  explicit Ekf(const EkfConfig& config, Timestamp stamp = {}, const Pose2& pose = {});

  /// Prediction stage, eq. (13)-(14), to `stamp`; an earlier stamp changes nothing.
  void predict(Timestamp stamp);
  /// Where predict() would put the pose, by (13) alone.
  Pose2 poseAt(Timestamp stamp) const;

  /// Wheels: mean body twist over the interval that begins now. @param gyro_mean mean reading of the gyro over the same
  /// interval [rad/s], for the slip test. While a gyro runs the wheels give the speed only: what their radius, track
  /// and slip do to the turn rate would pass for an error of the gyro. They never correct the gyro bias: its gain is
  /// zero (a "considered" state, Schmidt 1966).
  UpdateResult updateWheels(const Twist2& twist, bool turn_rate_known, Duration interval,
                            std::optional<double> gyro_mean);
  /// The wheels' mean body twist over the last few samples, for the time that begins now and that no interval covers
  /// yet: a single one's speed is off by the jitter of its stamps. Replaces the speed; the pose stays as it is.
  void holdTwist(const Twist2& mean, bool turn_rate_known);
  /// Gyro about z [rad/s], h = omega + b_g. Corrects the bias at standstill only, for the same reason. Before anything
  /// is known of the bias, it is what a gyro reads while it and the wheels are quiet, however far off.
  UpdateResult updateGyro(double rate);
  /// It tells nothing from now on: the wheels give the turn rate at once.
  void loseGyro() { gyro_stamp_.reset(); }
  /// The gyro's bias as known from elsewhere. It holds from now on: the pose stays, and what its errors have to do with
  /// those of the bias shrinks or grows with these. @param variance [rad^2/s^2]
  void setGyroBias(double bias, double variance);
  /// A matched scan, along its observable directions only.
  UpdateResult updatePose(const PoseMeasurement& measurement);

  /// Sets the pose, e.g. by command. @param sigma [m, m, rad]
  void setPose(const Pose2& pose, const Eigen::Vector3d& sigma);

  /// The map moved: rewrites pose and covariance in its new frame. @param T_new_old old map coordinates to new ones
  void transform(const Pose2& T_new_old);

  Timestamp stamp() const { return stamp_; }
  Pose2 pose() const { return Pose2::fromVector(x_.head<3>()); }
  Twist2 twist() const { return {x_[kSpeed], x_[kLateralSpeed], x_[kTurnRate]}; }
  double gyroBias() const { return x_[kGyroBias]; }
  GyroBias gyroBiasEstimate() const { return {x_[kGyroBias], P_(kGyroBias, kGyroBias)}; }
  const Vector& state() const { return x_; }
  const Matrix& covariance() const { return P_; }
  /// Of the pose, in map: the errors that P does not hold, since no mean over scans lessens them.
  Sensitivity sensitivity() const { return systematic_.topRows<3>(); }
  bool slip() const { return slip_.now; }
  /// By how much matched scans contradict the prediction: their normalised innovation squared per degree of freedom,
  /// averaged; at least 1. The pose's process noise is taken this many times larger, so that wheels which keep
  /// contradicting the scans are outweighed.
  double nisRatio() const { return std::max(1.0, nis_ratio_); }
  bool standstill() const;
  /// No wheel sample covers this time, though one was due long ago: whether they roll is not known.
  bool wheelsSilent() const { return stamp_ > silent_from_; }
  /// The wheels report that they stand, while scans show that the robot moves.
  bool wheelsDead() const { return stop_.dead(); }
  bool gyroActive() const { return gyroActiveAt(stamp_); }
  const EkfCounters& counters() const { return counters_; }

 private:
  /// Arc of constant twist from stamp() to a later stamp.
  struct Arc {
    double seconds, v, vy, omega;  // [s] in motion, [m/s], [m/s], [rad/s]
    double cos_h, sin_h, chord;    // direction of its chord; [s] length of it per speed
    double dx() const { return chord * (v * cos_h - vy * sin_h); }
    double dy() const { return chord * (v * sin_h + vy * cos_h); }
  };
  Arc arcTo(Timestamp stamp) const;
  Eigen::Vector3d movedAlong(const Arc& arc) const;
  bool gyroActiveAt(Timestamp stamp) const {
    return gyro_stamp_ && toSeconds(stamp - *gyro_stamp_) < config_->gyro_timeout;
  }

  enum Considered { kNone, kBias };  // states whose gain is zero

  /// @param seen  projector onto the pose's directions that the measurement sees, the others stay; null: all of them
  /// @param sensitivity of the measurement
  template <int N>
  UpdateResult correct(
      const Eigen::Matrix<double, N, 1>& innovation, const Eigen::Matrix<double, N, 7>& H,
      const Eigen::Matrix<double, N, N>& R, Considered considered, int gate_degrees,
      double* normalised_innovation_squared = nullptr, const Eigen::Matrix3d* seen = nullptr,
      const Eigen::Matrix<double, N, kSystematic>& sensitivity = Eigen::Matrix<double, N, kSystematic>::Zero());
  UpdateResult correctSpeed(Index state, double speed, bool possible);
  void walkSpeeds(double seconds);
  void walkTurnRate(double seconds);
  void updateStandstill();
  bool isPossible(const Twist2& twist) const;
  bool biasUnknown() const;
  bool mayHaveDied(const Eigen::Vector2d& velocity, double turn_rate, double seconds);
  bool differsAsBefore(const Eigen::Vector3d& error);
  bool detectSlip(double wheel_rate, double gyro_rate, double interval);

  const EkfConfig* config_;  // owned by whoever owns the filter; a copy of the filter shares it
  Timestamp stamp_;
  Vector x_ = Vector::Zero();
  Matrix P_ = Matrix::Zero();
  Eigen::Matrix<double, 7, kSystematic> systematic_ =
      Eigen::Matrix<double, 7, kSystematic>::Zero();  // sensitivity of x
  std::optional<Timestamp> gyro_stamp_;
  Timestamp known_until_{};       // the wheels' mean speed holds up to there
  double interval_ = 0.0;         // [s] that it is the mean of
  Timestamp turn_known_until_{};  // and their mean turn rate, where no gyro tells it
  Timestamp silent_from_{};       // no wheel sample came, though one was due
  Standstill standstill_;
  AbruptStop stop_;
  struct {
    double evidence = 0.0;  // [rad] wheels minus gyro, leaky over slip_window
    double turned = 0.0;    // [rad] angle turned, leaky over slip_window
    bool now = false;
  } slip_;
  double nis_ratio_ = 1.0;
  int rejected_in_a_row_ = 0;  // pose measurements that put the robot to one place
  struct {
    Eigen::Vector3d error = Eigen::Vector3d::Zero();  // [m, m, rad] as far as it was seen
    Eigen::Vector3d at = Eigen::Vector3d::Zero();     // [m, m, rad] where the filter was
  } last_;                                            // pose measurement
  EkfCounters counters_;
};

}  // namespace slam
