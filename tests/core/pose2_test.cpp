// SPDX-License-Identifier: BSD-3-Clause
#include "core/pose2.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace slam::pose2_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kStep = 1e-4;  // [m, rad] of the numeric derivatives

void expectSame(const Pose2& actual, const Pose2& expected, double tolerance = 1e-12) {
  EXPECT_NEAR(actual.x, expected.x, tolerance);
  EXPECT_NEAR(actual.y, expected.y, tolerance);
  EXPECT_NEAR(wrapAngle(actual.theta - expected.theta), 0.0, tolerance);
  EXPECT_LE(std::abs(actual.theta), kPi);
}

/// Headings that formulas trip over: none, too small for sin(t)/t, at the switch to a series, a half turn.
std::vector<double> awkwardHeadings() {
  std::vector<double> headings{0.0, 1.5, -1.5, 3.0, -3.0, 3.1, -3.1, 3.14, -3.14};
  for (double theta = 1e-14; theta < 1.0; theta *= 4.0) {
    headings.push_back(theta);
    headings.push_back(-theta);
  }
  return headings;
}

std::vector<Pose2> manyPoses(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> metres(-20.0, 20.0), radians(-3.1, 3.1);
  std::vector<Pose2> poses;
  for (const double heading : awkwardHeadings()) poses.push_back({metres(random), metres(random), heading});
  for (int i = 0; i < 100; ++i) poses.push_back({metres(random), metres(random), radians(random)});
  return poses;
}

/// Central difference of f at v; f gives a pose, whose heading may wrap.
template <typename Function>
Eigen::Matrix3d numericJacobian(const Eigen::Vector3d& v, Function&& f) {
  Eigen::Matrix3d J;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(i);
    const Eigen::Vector3d plus = f(v + d), minus = f(v - d);
    J.col(i) = plus - minus;
    J(2, i) = wrapAngle(J(2, i));
  }
  return J / (2.0 * kStep);
}

void expectClose(const Eigen::Matrix3d& actual, const Eigen::Matrix3d& expected) {
  EXPECT_LT((actual - expected).cwiseAbs().maxCoeff(), 5e-7) << "actual:\n" << actual << "\nexpected:\n" << expected;
}

TEST(WrapAngle, KeepsTheDirectionAndStaysWithinAHalfTurn) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> radians(-1e3, 1e3);
  for (int i = 0; i < 1000; ++i) {
    const double angle = radians(random), wrapped = wrapAngle(angle);
    EXPECT_LE(std::abs(wrapped), kPi);
    EXPECT_NEAR(std::cos(wrapped), std::cos(angle), 1e-12);
    EXPECT_NEAR(std::sin(wrapped), std::sin(angle), 1e-12);
  }
  for (const double edge : {kPi, -kPi, 3 * kPi, -3 * kPi}) EXPECT_LE(std::abs(wrapAngle(edge)), kPi);
}

TEST(Pose2, PosesFormAGroup) {
  const auto a = manyPoses(2), b = manyPoses(3), c = manyPoses(4);
  for (std::size_t i = 0; i < a.size(); ++i) {
    expectSame((a[i] * b[i]) * c[i], a[i] * (b[i] * c[i]), 1e-11);
    expectSame(a[i] * a[i].inverse(), {}, 1e-12);
    expectSame(a[i].inverse() * a[i], {}, 1e-12);
    expectSame(a[i] * between(a[i], b[i]), b[i], 1e-11);
  }
}

TEST(Pose2, ComposingActsOnPointsLikeOneAfterTheOther) {
  EXPECT_TRUE((Pose2{1, 2, kPi / 2} * Eigen::Vector2d{3, 0}).isApprox(Eigen::Vector2d{1, 5}));  // counter-clockwise
  const auto a = manyPoses(5), b = manyPoses(6);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Eigen::Vector2d p{0.7, -1.3};
    EXPECT_LT(((a[i] * b[i]) * p - a[i] * (b[i] * p)).norm(), 1e-12);
  }
}

TEST(PointTransform, TakesPointsWhereComposingTakesThemAndTurnsWhatLiesBetweenThem) {
  for (const Pose2& T_a_b : manyPoses(7)) {
    const Eigen::Vector2d p{0.7, -1.3}, q{-12.0, 4.0};
    const PointTransform transform(T_a_b);
    EXPECT_LT((transform * p - (T_a_b * Pose2{p.x(), p.y(), 0.3}).translation()).norm(), 1e-12);
    EXPECT_LT((transform.turned(q - p) - (transform * q - transform * p)).norm(), 1e-12);
  }
}

TEST(Pose2, IsFiniteOnlyWhenAllCoordinatesAre) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(isFinite({1, 2, 3}));
  for (const double bad : {kNan, kInf, -kInf}) {
    EXPECT_FALSE(isFinite({bad, 0, 0}));
    EXPECT_FALSE(isFinite({0, bad, 0}));
    EXPECT_FALSE(isFinite({0, 0, bad}));
  }
}

TEST(Pose2, FromVectorWrapsTheHeading) {
  expectSame(Pose2::fromVector({1, 2, 7.0}), {1, 2, 7.0 - 2 * kPi});
  EXPECT_EQ((Pose2{1, 2, 3}.vector()), (Eigen::Vector3d{1, 2, 3}));
}

TEST(Pose2, ComposeJacobiansEqualNumericOnes) {
  const auto a = manyPoses(7), b = manyPoses(8);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto J = composeJacobians(a[i], b[i]);
    expectClose(J.first, numericJacobian(a[i].vector(), [&](const Eigen::Vector3d& v) {
                  return (Pose2{v.x(), v.y(), v.z()} * b[i]).vector();
                }));
    expectClose(J.second, numericJacobian(b[i].vector(), [&](const Eigen::Vector3d& v) {
                  return (a[i] * Pose2{v.x(), v.y(), v.z()}).vector();
                }));
  }
}

TEST(Pose2, BetweenJacobiansEqualNumericOnes) {
  const auto a = manyPoses(9), b = manyPoses(10);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto J = betweenJacobians(a[i], b[i]);
    expectClose(J.first, numericJacobian(a[i].vector(), [&](const Eigen::Vector3d& v) {
                  return between({v.x(), v.y(), v.z()}, b[i]).vector();
                }));
    expectClose(J.second, numericJacobian(b[i].vector(), [&](const Eigen::Vector3d& v) {
                  return between(a[i], {v.x(), v.y(), v.z()}).vector();
                }));
  }
}

TEST(Pose2, InverseJacobianEqualsTheNumericOne) {
  for (const Pose2& T : manyPoses(11))
    expectClose(inverseJacobian(T), numericJacobian(T.vector(), [](const Eigen::Vector3d& v) {
                  return Pose2{v.x(), v.y(), v.z()}.inverse().vector();
                }));
}

TEST(Pose2, ExpIsTheLimitOfManySmallSteps) {
  for (const double turn : {0.0, 1e-9, 1e-3, -0.4, 2.0, -5.0}) {
    const Eigen::Vector3d twist{0.8, -0.3, turn};
    constexpr int kSteps = 100'000;
    Pose2 stepped;
    for (int i = 0; i < kSteps; ++i) {  // midpoint rule: the error of n steps is of order n^-2
      const Pose2 half{0, 0, twist.z() / kSteps / 2};
      stepped = stepped * half * Pose2{twist.x() / kSteps, twist.y() / kSteps, 0} * half;
    }
    expectSame(exp(twist), stepped, 1e-9);
  }
}

TEST(Pose2, LogUndoesExpAndBackDownToTheSmallestTurns) {
  for (const Pose2& pose : manyPoses(12)) {
    expectSame(exp(log(pose)), pose, 1e-11);
    const Eigen::Vector3d xi = pose.vector();  // any three numbers are a twist
    EXPECT_LT((log(exp(xi)) - xi).cwiseAbs().maxCoeff(), 1e-10) << xi.transpose();
  }
  EXPECT_EQ(log(Pose2{}), Eigen::Vector3d::Zero());
}

TEST(Pose2, LogOfAHalfTurnIsFinite) {
  for (const double theta : {kPi, -kPi}) {
    const Pose2 pose{1, 2, theta};
    ASSERT_TRUE(log(pose).allFinite());
    expectSame(exp(log(pose)), pose, 1e-11);
  }
}

TEST(Pose2, ExpRightJacobianEqualsTheNumericOne) {
  for (const Pose2& pose : manyPoses(13)) {
    const Eigen::Vector3d xi = pose.vector();
    const Pose2 back = exp(xi).inverse();
    expectClose(expRightJacobian(xi),
                numericJacobian(xi, [&](const Eigen::Vector3d& v) { return log(back * exp(v)); }));
  }
}

TEST(Pose2, LogRightJacobianEqualsTheNumericOneAndInvertsTheOther) {
  for (const Pose2& pose : manyPoses(14)) {
    expectClose(logRightJacobian(pose),
                numericJacobian(Eigen::Vector3d::Zero(), [&](const Eigen::Vector3d& d) { return log(pose * exp(d)); }));
    expectClose(logRightJacobian(pose) * expRightJacobian(log(pose)), Eigen::Matrix3d::Identity());
  }
}

}  // namespace
}  // namespace slam::pose2_test
