// SPDX-License-Identifier: BSD-3-Clause
#include "matching/normal_equations.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <gtest/gtest.h>

#include "support/property.hpp"

namespace slam::normal_equations_test {
namespace {

using test::draw;

constexpr double kLeast = 0.01;  // [1] min_information

Eigen::Vector3d drawVector(double size) {
  const double x = draw(-size, size), y = draw(-size, size);
  return {x, y, draw(-size, size)};
}

/// Sums over pairs with these Jacobians, and errors that a step has made.
NormalEquations sumsOf(const Eigen::Matrix<double, Eigen::Dynamic, 3>& J, const Eigen::VectorXd& errors) {
  NormalEquations equations;
  equations.H = J.transpose() * J;
  equations.g = J.transpose() * errors;
  equations.weight = static_cast<double>(J.rows());
  return equations;
}

RC_GTEST_PROP(SolveObservable, TakesTheStepThatUndoesTheErrors, ()) {
  const double lever = draw(0.5, 8.0);
  Eigen::Matrix<double, Eigen::Dynamic, 3> J(12, 3);
  for (int i = 0; i < J.rows(); ++i) {
    const double direction = draw(-3.1, 3.1);
    J.row(i) << std::cos(direction), std::sin(direction), lever * draw(-1.0, 1.0);
  }
  const Eigen::Vector3d off = drawVector(0.1);
  const NormalEquations equations = sumsOf(J, J * off);
  const ObservableStep solved = solveObservable(equations, lever, 1e-9);
  RC_ASSERT(solved.observable == 3);
  RC_ASSERT((solved.step + off).norm() < 1e-6);
  RC_ASSERT((solved.inverse * equations.H - Eigen::Matrix3d::Identity()).norm() < 1e-5);
  RC_ASSERT(solved.directions == Eigen::Matrix3d::Identity());
}

RC_GTEST_PROP(SolveObservable, StaysWhereItIsBlindAndNamesTheDirection, ()) {
  const double lever = draw(0.5, 8.0);
  const Eigen::Vector3d blind =
      (Eigen::Vector3d(1, 1, 1.0 / lever).asDiagonal() * (drawVector(1.0) + Eigen::Vector3d(0.1, 0, 0))).normalized();
  Eigen::Matrix<double, Eigen::Dynamic, 3> J(12, 3);
  const Eigen::Vector3d one = blind.unitOrthogonal(), other = blind.cross(one);  // J sees nothing along blind
  for (int i = 0; i < J.rows(); ++i) {
    const double angle = 0.5 * i;
    J.row(i) = std::cos(angle) * one + std::sin(angle) * other;
  }
  const NormalEquations equations = sumsOf(J, J * drawVector(0.1));
  const ObservableStep solved = solveObservable(equations, lever, 1e-6);
  RC_ASSERT(solved.observable == 2);
  RC_ASSERT(std::abs(std::abs(solved.directions.col(2).dot(blind)) - 1.0) < 1e-9);
  RC_ASSERT((solved.directions.transpose() * solved.directions - Eigen::Matrix3d::Identity()).norm() < 1e-9);
  RC_ASSERT((equations.H * solved.step + equations.g).norm() < 1e-6);
  // A metre at the lever counts as a metre: there the step is square to the degenerate direction.
  const Eigen::Vector3d metres(1.0, 1.0, lever);
  RC_ASSERT(std::abs(solved.step.cwiseProduct(metres).dot(blind.cwiseProduct(metres))) < 1e-6);
  RC_ASSERT((solved.inverse * equations.H * solved.inverse - solved.inverse).norm() < 1e-6 * solved.inverse.norm());
}

NormalEquations diagonal(double x, double y, double theta) {
  NormalEquations equations;
  equations.H.diagonal() << x, y, theta;
  equations.g << 1.0, 2.0, 3.0;
  equations.weight = 100.0;  // the threshold is 1
  return equations;
}

TEST(SolveObservable, ADirectionIsSeenFromItsShareOfTheInformationOn) {
  EXPECT_EQ(solveObservable(diagonal(1.02, 50, 50), 1.0, kLeast).observable, 3);
  const ObservableStep blind = solveObservable(diagonal(0.98, 50, 50), 1.0, kLeast);
  EXPECT_EQ(blind.observable, 2);
  EXPECT_NEAR(std::abs(blind.directions(0, 2)), 1.0, 1e-12);
  EXPECT_EQ(blind.step.x(), 0.0);
  EXPECT_NEAR(blind.step.y(), -2.0 / 50, 1e-12);
  EXPECT_NEAR(blind.step.z(), -3.0 / 50, 1e-12);
  EXPECT_EQ(solveObservable(diagonal(0.98, 0.5, 50), 1.0, kLeast).observable, 1);
  const ObservableStep none = solveObservable(diagonal(0.98, 0.5, 0.9), 1.0, kLeast);
  EXPECT_EQ(none.observable, 0);
  EXPECT_EQ(none.step, Eigen::Vector3d::Zero());
}

TEST(SolveObservable, ATurnIsMeasuredAtTheLever) {
  for (const double lever : {0.5, 4.0}) {
    EXPECT_EQ(solveObservable(diagonal(50, 50, 1.02 * lever * lever), lever, kLeast).observable, 3) << lever;
    const ObservableStep blind = solveObservable(diagonal(50, 50, 0.98 * lever * lever), lever, kLeast);
    EXPECT_EQ(blind.observable, 2) << lever;
    EXPECT_NEAR(std::abs(blind.directions(2, 2)), 1.0, 1e-12);
    EXPECT_EQ(blind.step.z(), 0.0);
  }
}

TEST(SolveObservable, WhatNoiseFeignsIsTakenOffAndMustBeOutweighed) {
  for (const auto& [information, seen] : {std::pair(1.0 + 2 * 0.7 - 0.02, 2), std::pair(1.0 + 2 * 0.7 + 0.02, 3)}) {
    NormalEquations equations = diagonal(50, information, 50);
    equations.spurious(1, 1) = 0.7;
    EXPECT_EQ(solveObservable(equations, 1.0, kLeast).observable, seen) << information;
  }
}

TEST(SolveObservable, LeavesOutTheWeakestFirst) {
  const double lever = 2.0;
  const NormalEquations equations = diagonal(20, 40, 30 * lever * lever);
  EXPECT_LT((solveObservable(equations, lever, kLeast).weakest.cwiseAbs() - Eigen::Vector3d(1, 0, 0)).norm(), 1e-12);
  const ObservableStep two = solveObservable(equations, lever, kLeast, 2);
  ASSERT_EQ(two.observable, 2);
  EXPECT_NEAR(std::abs(two.directions(0, 2)), 1.0, 1e-12);
  EXPECT_LT((two.weakest.cwiseAbs() - Eigen::Vector3d(0, 0, 1 / lever)).norm(), 1e-12) << "a metre at the lever";
  const ObservableStep one = solveObservable(equations, lever, kLeast, 1);
  ASSERT_EQ(one.observable, 1);
  EXPECT_NEAR(std::abs(one.directions(1, 0)), 1.0, 1e-12);
  EXPECT_LT((one.directions.transpose() * one.directions - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LT((one.step - Eigen::Vector3d(0, -2.0 / 40, 0)).norm(), 1e-12);
  EXPECT_EQ(solveObservable(equations, lever, kLeast, 0).observable, 0);
}

}  // namespace
}  // namespace slam::normal_equations_test
