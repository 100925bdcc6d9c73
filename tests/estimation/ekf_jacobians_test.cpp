// SPDX-License-Identifier: BSD-3-Clause
// The filter's covariances against numeric derivatives of its own motion and against textbook updates.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <initializer_list>
#include <sstream>

#include "estimation/ekf.hpp"
#include "support/property.hpp"

namespace slam::ekf_jacobians_test {
namespace {

using std::chrono::milliseconds;
using test::draw;
using Vector = Ekf::Vector;
using Matrix = Ekf::Matrix;

constexpr Timestamp kBegin{std::chrono::seconds(1000)};
constexpr Duration kLong = std::chrono::seconds(1);  // interval of the wheels, longer than any prediction here

/// [1] of the standard deviations. A leaves out by how much a turning robot's chord is shorter than its arc: that
/// changes with the turn rate, by up to a third of half the angle turned.
constexpr double kChord = 1e-3;

/// Each noise differs from all others, so that none can stand for another.
EkfConfig uneven(bool holonomic) {
  EkfConfig config;
  config.translation_noise = 0.11;
  config.rotation_noise_per_metre = 0.07;
  config.rotation_noise_wheels = 0.23;
  config.rotation_noise_gyro = 0.05;
  config.rotation_drift = 0.013;
  config.translation_drift = 0.017;
  config.gyro_bias_noise = 0.002;
  config.wheel_turn_rate_scale = 0.3;
  config.holonomic = holonomic;
  return config;
}

void expectNear(const Matrix& actual, const Matrix& expected, double tolerance) {
  const Vector sigma = expected.diagonal().cwiseSqrt().cwiseMax(1e-9);
  const Matrix error = sigma.cwiseInverse().asDiagonal() * (actual - expected) * sigma.cwiseInverse().asDiagonal();
  if (error.cwiseAbs().maxCoeff() < tolerance) return;
  std::ostringstream text;
  text << "actual:\n" << actual << "\nexpected:\n" << expected;
  RC_FAIL(text.str());
}

/// The state after the filter's own motion from x. Another filter than the one tested, which no gyro and no end of an
/// interval disturbs: what moves the mean must not depend on them.
Vector moved(const EkfConfig& config, const Vector& x, Duration dt) {
  Ekf ekf(config, kBegin);
  ekf.setPose(Pose2{x[0], x[1], x[2]}, {1, 1, 1});
  ekf.updateWheels({}, true, kLong, std::nullopt);
  ekf.holdTwist({x[Ekf::kSpeed], x[Ekf::kLateralSpeed], x[Ekf::kTurnRate]}, true);
  ekf.predict(kBegin + dt);
  return ekf.state();
}

/// Central differences of moved(). The bias and, on a base that cannot move sideways, v_y stay as they are.
Matrix numericA(const EkfConfig& config, const Vector& x, Duration dt) {
  constexpr double kStep = 1e-5;
  Matrix A = Matrix::Identity();
  for (const auto i : {Ekf::kX, Ekf::kY, Ekf::kTheta, Ekf::kSpeed, Ekf::kTurnRate, Ekf::kLateralSpeed}) {
    if (i == Ekf::kLateralSpeed && !config.holonomic) continue;
    const Vector d = kStep * Vector::Unit(i);
    Vector column = moved(config, x + d, dt) - moved(config, x - d, dt);
    column[Ekf::kTheta] = wrapAngle(column[Ekf::kTheta]);
    A.col(i) = column / (2.0 * kStep);
    A(Ekf::kGyroBias, i) = 0.0;
  }
  return A;
}

Eigen::Matrix3d drawCovariance() {
  Eigen::Matrix3d root;
  for (int i = 0; i < 9; ++i) root(i) = draw(-0.02, 0.02);
  return root * root.transpose() + 1e-5 * Eigen::Matrix3d::Identity();
}

/// A filter in motion, all of whose states depend on each other.
Ekf drawFilter(const EkfConfig& config, bool gyro) {
  Ekf ekf(config, kBegin - milliseconds(200));
  ekf.setPose(test::drawPose(5.0), {draw(0.01, 0.1), draw(0.01, 0.1), draw(0.01, 0.1)});
  const double omega = draw(-1.0, 1.0);
  const Twist2 twist{draw(0.1, 1.0), config.holonomic ? draw(-0.8, 0.8) : 0.0, omega};
  ekf.updateWheels(twist, true, milliseconds(100), std::nullopt);
  ekf.predict(kBegin - milliseconds(100));
  if (gyro) ekf.updateGyro(ekf.twist().omega + draw(-0.01, 0.01));
  PoseMeasurement match{.stamp = ekf.stamp(),
                        .T_map_base = ekf.pose() * Pose2{draw(-0.01, 0.01), draw(-0.01, 0.01), 0}};
  match.covariance = drawCovariance();
  ekf.updatePose(match);
  ekf.predict(kBegin);
  return ekf;
}

RC_GTEST_PROP(EkfPrediction, ItsCovarianceIsThatOfTheNumericJacobian, ()) {
  const EkfConfig config = uneven(draw(0, 1) < 0.5);
  const bool gyro = draw(0, 1) < 0.5;
  Ekf ekf = drawFilter(config, gyro);
  const Twist2 twist = ekf.twist();
  ekf.updateWheels(twist, false, kLong, std::nullopt);  // from here on it knows its speed for a second
  if (!gyro) ekf.updateWheels(twist, true, kLong, std::nullopt);
  const Vector x = ekf.state();
  const Matrix before = ekf.covariance();
  RC_ASSERT(ekf.gyroActive() == gyro);
  const Duration dt = fromSeconds(draw(0.005, 0.03));
  ekf.predict(kBegin + dt);

  const Matrix A = numericA(config, x, dt);
  const double s = toSeconds(dt), distance = s * std::hypot(x[Ekf::kSpeed], x[Ekf::kLateralSpeed]);
  const double turned = s * std::abs(x[Ekf::kTurnRate]);
  Matrix expected = A * before * A.transpose();
  const double way = square(0.11) * distance + square(0.017) * s;
  const double turn =
      square(0.013) * s + (gyro ? square(0.05) * turned : square(0.23) * turned + square(0.07) * distance);
  expected.diagonal().head<3>() += ekf.nisRatio() * Eigen::Vector3d(way, way, turn);
  expected(Ekf::kGyroBias, Ekf::kGyroBias) += square(0.002) * s;
  if (gyro) expected(Ekf::kTurnRate, Ekf::kTurnRate) += square(config.angular_acceleration_noise) * s;
  expectNear(ekf.covariance(), expected, kChord);
  RC_ASSERT((ekf.state() - moved(config, x, dt)).norm() < 1e-9 + std::abs(x[Ekf::kGyroBias]));
}

RC_GTEST_PROP(EkfPrediction, SpeedsWalkBeyondWhatTheWheelsHaveTold, ()) {
  const EkfConfig config = uneven(draw(0, 1) < 0.5);
  Ekf ekf = drawFilter(config, false);
  const double interval = draw(0.005, 0.02), beyond = draw(0.005, 0.02);
  ekf.updateWheels(ekf.twist(), true, fromSeconds(interval), std::nullopt);
  const Vector x = ekf.state();
  Matrix expected = ekf.covariance();
  const double doubt = ekf.nisRatio();
  const Duration dt = fromSeconds(interval) + fromSeconds(beyond);
  ekf.predict(kBegin + dt);
  const auto walk = [&](double seconds) {
    expected(Ekf::kSpeed, Ekf::kSpeed) += square(2.0) * seconds;
    if (config.holonomic) expected(Ekf::kLateralSpeed, Ekf::kLateralSpeed) += square(2.0) * seconds;
    expected(Ekf::kTurnRate, Ekf::kTurnRate) += square(6.0) * seconds;
  };
  walk(interval);  // at its end a speed is not the mean any more
  const Matrix A = numericA(config, x, dt);
  expected = (A * expected * A.transpose()).eval();
  const double s = toSeconds(dt), distance = s * std::hypot(x[Ekf::kSpeed], x[Ekf::kLateralSpeed]);
  const double way = square(0.11) * distance + square(0.017) * s;
  const double turn = square(0.013) * s + square(0.23) * s * std::abs(x[Ekf::kTurnRate]) + square(0.07) * distance;
  expected.diagonal().head<3>() += doubt * Eigen::Vector3d(way, way, turn);
  expected(Ekf::kGyroBias, Ekf::kGyroBias) += square(0.002) * s;
  walk(beyond);
  expectNear(ekf.covariance(), expected, kChord);
}

struct Gaussian {
  Vector mean;
  Matrix covariance;
};

/// Kalman's update by the textbook. @param considered states whose gain is zero @param seen  projector onto what the
/// pose may be moved by
template <int N>
Gaussian updated(Gaussian prior, const Eigen::Matrix<double, N, 1>& innovation, const Eigen::Matrix<double, N, 7>& H,
                 const Eigen::Matrix<double, N, N>& R, std::initializer_list<Ekf::Index> considered,
                 const Eigen::Matrix3d& seen = Eigen::Matrix3d::Identity()) {
  const Eigen::Matrix<double, N, N> S = H * prior.covariance * H.transpose() + R;
  Eigen::Matrix<double, 7, N> K = prior.covariance * H.transpose() * S.inverse();
  for (const Ekf::Index i : considered) K.row(i).setZero();
  K.template topRows<3>() = (seen * K.template topRows<3>()).eval();
  // For any gain: P - K H P - (K H P)^T + K S K^T.
  const Matrix KHP = K * H * prior.covariance;
  return {prior.mean + K * innovation, prior.covariance - KHP - KHP.transpose() + K * S * K.transpose()};
}

void expectSame(const Ekf& ekf, const Gaussian& expected) {
  Vector error = ekf.state() - expected.mean;
  error[Ekf::kTheta] = wrapAngle(error[Ekf::kTheta]);
  RC_ASSERT(error.norm() < 1e-9);
  expectNear(ekf.covariance(), expected.covariance, 1e-7);
}

RC_GTEST_PROP(EkfUpdate, WheelsCorrectSpeedAndWithoutGyroTheTurnRate, ()) {
  const EkfConfig config = uneven(draw(0, 1) < 0.5);
  const bool gyro = draw(0, 1) < 0.5;
  Ekf ekf = drawFilter(config, gyro);
  Gaussian expected{ekf.state(), ekf.covariance()};
  const double interval = 0.02;
  const Twist2 twist{ekf.twist().vx + draw(-0.05, 0.05), ekf.twist().vy + draw(-0.05, 0.05),
                     ekf.twist().omega + draw(-0.05, 0.05)};
  expected.covariance(Ekf::kSpeed, Ekf::kSpeed) += square(2.0) * interval;
  if (config.holonomic) expected.covariance(Ekf::kLateralSpeed, Ekf::kLateralSpeed) += square(2.0) * interval;
  const double speed_variance = square(config.wheel_speed_sigma);
  if (gyro) {
    Eigen::Matrix<double, 1, 7> H = Eigen::Matrix<double, 1, 7>::Zero();
    H[Ekf::kSpeed] = 1.0;
    expected = updated<1>(expected, Eigen::Matrix<double, 1, 1>(twist.vx - expected.mean[Ekf::kSpeed]), H,
                          Eigen::Matrix<double, 1, 1>(speed_variance), {Ekf::kGyroBias});
  } else {
    expected.covariance(Ekf::kTurnRate, Ekf::kTurnRate) += square(6.0) * interval;
    Eigen::Matrix<double, 2, 7> H = Eigen::Matrix<double, 2, 7>::Zero();
    H(0, Ekf::kSpeed) = H(1, Ekf::kTurnRate) = 1.0;
    const double turn_variance = square(config.wheel_turn_rate_sigma) + square(0.3 * twist.omega);
    const Eigen::Vector2d innovation(twist.vx - expected.mean[Ekf::kSpeed],
                                     twist.omega - expected.mean[Ekf::kTurnRate]);
    expected = updated<2>(expected, innovation, H, Eigen::Vector2d(speed_variance, turn_variance).asDiagonal(),
                          {Ekf::kGyroBias});
  }
  if (config.holonomic) {
    Eigen::Matrix<double, 1, 7> H = Eigen::Matrix<double, 1, 7>::Zero();
    H[Ekf::kLateralSpeed] = 1.0;
    expected = updated<1>(expected, Eigen::Matrix<double, 1, 1>(twist.vy - expected.mean[Ekf::kLateralSpeed]), H,
                          Eigen::Matrix<double, 1, 1>(speed_variance), {Ekf::kGyroBias});
  }
  ekf.updateWheels(twist, true, fromSeconds(interval), std::nullopt);
  expectSame(ekf, expected);
}

RC_GTEST_PROP(EkfUpdate, TheGyroCorrectsTheTurnRateAndItsBiasAtRestOnly, ()) {
  const EkfConfig config = uneven(draw(0, 1) < 0.5);
  Ekf ekf = drawFilter(config, true);
  const double rate = ekf.twist().omega + ekf.gyroBias() + draw(-0.02, 0.02);
  Eigen::Matrix<double, 1, 7> H = Eigen::Matrix<double, 1, 7>::Zero();
  H[Ekf::kTurnRate] = H[Ekf::kGyroBias] = 1.0;
  const Gaussian expected = updated<1>({ekf.state(), ekf.covariance()},
                                       Eigen::Matrix<double, 1, 1>(rate - ekf.twist().omega - ekf.gyroBias()), H,
                                       Eigen::Matrix<double, 1, 1>(square(config.gyro_sigma)), {Ekf::kGyroBias});
  RC_ASSERT(ekf.updateGyro(rate) == UpdateResult::kFused);
  expectSame(ekf, expected);

  Ekf resting(config, kBegin);
  resting.setPose(test::drawPose(5.0), {0.01, 0.01, 0.01});
  resting.updateWheels({}, true, milliseconds(20), std::nullopt);
  for (int i = 1; i <= 60; ++i) {
    resting.predict(kBegin + milliseconds(10) * i);
    if (i % 2 == 0) resting.updateWheels({}, true, milliseconds(20), std::nullopt);
  }
  RC_ASSERT(resting.standstill());
  Gaussian rest{resting.state(), resting.covariance()};
  Eigen::Matrix<double, 2, 7> still = Eigen::Matrix<double, 2, 7>::Zero();
  still(0, Ekf::kSpeed) = still(1, Ekf::kTurnRate) = 1.0;
  const Eigen::Matrix2d R =
      Eigen::Vector2d(square(config.standstill_speed_sigma), square(config.standstill_turn_rate_sigma)).asDiagonal();
  rest = updated<2>(rest, -still * rest.mean, still, R, {});
  if (config.holonomic) {
    Eigen::Matrix<double, 1, 7> across = Eigen::Matrix<double, 1, 7>::Zero();
    across[Ekf::kLateralSpeed] = 1.0;
    rest = updated<1>(rest, -across * rest.mean, across, R.topLeftCorner<1, 1>(), {});
  }
  const double reading = draw(-0.02, 0.02);
  rest = updated<1>(rest, Eigen::Matrix<double, 1, 1>(reading - rest.mean[Ekf::kTurnRate] - rest.mean[Ekf::kGyroBias]),
                    H, Eigen::Matrix<double, 1, 1>(square(config.gyro_sigma)), {});
  RC_ASSERT(resting.updateGyro(reading) == UpdateResult::kFused);
  expectSame(resting, rest);
}

RC_GTEST_PROP(EkfUpdate, AMatchCorrectsAllStatesButThePoseAlongWhatItDidNotSee, ()) {
  const EkfConfig config = uneven(draw(0, 1) < 0.5);
  Ekf ekf = drawFilter(config, false);
  ekf.updateWheels(ekf.twist(), true, kLong, std::nullopt);  // the wheels tell the way: speeds are corrected, too
  PoseMeasurement match{.stamp = ekf.stamp(), .T_map_base = {}};
  match.covariance = drawCovariance();
  match.T_map_base = Pose2::fromVector(ekf.state().head<3>() +
                                       Eigen::Vector3d(draw(-0.02, 0.02), draw(-0.02, 0.02), draw(-0.01, 0.01)));
  const Eigen::Vector3d blind = Eigen::Vector3d(draw(-1, 1), draw(-1, 1), draw(-0.2, 0.2)).normalized();
  const Eigen::Vector3d seen = blind.unitOrthogonal();
  match.directions << seen, blind.cross(seen), blind;
  match.observable = *rc::gen::inRange(2, 4);
  Gaussian expected{ekf.state(), ekf.covariance()};
  Eigen::Vector3d error = match.T_map_base.vector() - expected.mean.head<3>();
  error.z() = wrapAngle(error.z());
  const Eigen::Matrix3d D = match.directions;
  if (match.observable == 3) {
    Eigen::Matrix<double, 3, 7> H = Eigen::Matrix<double, 3, 7>::Zero();
    H.leftCols<3>() = D.transpose();
    expected = updated<3>(expected, D.transpose() * error, H, D.transpose() * match.covariance * D, {});
  } else {
    Eigen::Matrix<double, 2, 7> H = Eigen::Matrix<double, 2, 7>::Zero();
    H.leftCols<3>() = D.leftCols<2>().transpose();
    expected = updated<2>(expected, D.leftCols<2>().transpose() * error, H,
                          D.leftCols<2>().transpose() * match.covariance * D.leftCols<2>(), {},
                          Eigen::Matrix3d::Identity() - blind * blind.transpose());
  }
  RC_PRE(ekf.updatePose(match) == UpdateResult::kFused);
  expectSame(ekf, expected);
}

/// What an error that all matched scans have does to the filter, as much as it believes them.
RC_GTEST_PROP(EkfSensitivity, IsWhatTheMeasuredPosesErrorsDoToThePose, ()) {
  const EkfConfig config = uneven(false);
  const Ekf begin = drawFilter(config, true);
  std::vector<PoseMeasurement> matches(3);
  for (PoseMeasurement& match : matches) {
    match.T_map_base = begin.pose();
    match.covariance = Eigen::Vector3d(draw(0.01, 0.1), draw(0.01, 0.1), draw(0.01, 0.1)).asDiagonal();
    match.observable = draw(0, 1) < 0.5 ? 3 : 2;
    match.bypass_gate = true;
    for (int i = 0; i < 3; ++i) match.sensitivity.row(i) << draw(-1.0, 1.0), draw(-1.0, 1.0);
  }
  const auto poseWith = [&](int error, double size) {
    Ekf ekf = begin;
    for (PoseMeasurement match : matches) {
      ekf.predict(ekf.stamp() + milliseconds(100));
      match.T_map_base = Pose2::fromVector(ekf.pose().vector() + size * match.sensitivity.col(error));
      if (size == 0.0) match.T_map_base = ekf.pose();
      ekf.updatePose(match);
    }
    return ekf;
  };
  // The measured poses move with the filter's own, so that its errors add up: beside the one to come, those before.
  Ekf ekf = begin;
  Eigen::Matrix<double, 3, kSystematic> expected = ekf.sensitivity();
  for (int error = 0; error < kSystematic; ++error) {
    constexpr double kSize = 1e-5;
    const Ekf there = poseWith(error, kSize), back = poseWith(error, -kSize);
    Eigen::Vector3d moved = there.pose().vector() - back.pose().vector();
    moved.z() = wrapAngle(moved.z());
    expected.col(error) = moved / (2.0 * kSize);
  }
  for (PoseMeasurement match : matches) {
    ekf.predict(ekf.stamp() + milliseconds(100));
    match.T_map_base = ekf.pose();
    match.sensitivity += ekf.sensitivity();
    ekf.updatePose(match);
  }
  const double difference = (ekf.sensitivity() - expected).cwiseAbs().maxCoeff();
  if (difference > 0.02 * std::max(1.0, expected.cwiseAbs().maxCoeff())) {
    std::ostringstream text;
    text << "filter:\n" << ekf.sensitivity() << "\nmeasured:\n" << expected;
    RC_FAIL(text.str());
  }
}

RC_GTEST_PROP(EkfTransform, TurnsTheWholeCovarianceWithTheMap, ()) {
  const EkfConfig config = uneven(draw(0, 1) < 0.5);
  Ekf ekf = drawFilter(config, draw(0, 1) < 0.5);
  const Ekf before = ekf;
  const Pose2 T_new_old = test::drawPose(10.0);
  ekf.transform(T_new_old);
  const auto inNew = [&](const Vector& x) {
    Vector y = x;
    y.head<3>() = (T_new_old * Pose2{x[0], x[1], x[2]}).vector();
    return y;
  };
  Matrix J = Matrix::Identity();
  for (int i = 0; i < 7; ++i) {
    const Vector d = 1e-5 * Vector::Unit(i);
    Vector column = inNew(before.state() + d) - inNew(before.state() - d);
    column[Ekf::kTheta] = wrapAngle(column[Ekf::kTheta]);
    J.col(i) = column / 2e-5;
  }
  expectSame(ekf, {inNew(before.state()), J * before.covariance() * J.transpose()});
}

}  // namespace
}  // namespace slam::ekf_jacobians_test
