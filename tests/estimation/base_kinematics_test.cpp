// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/base_kinematics.hpp"

#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace slam::base_kinematics_test {
namespace {

constexpr BaseKinematics kDifferential{BaseType::kDifferential, 0.0325, 0.10075};
constexpr BaseKinematics kOmni{BaseType::kOmni3, 0.032, 0.1025};
constexpr BaseKinematics kMecanum{BaseType::kMecanum4, 0.0485, 0.199};

std::span<const double> used(const WheelVector& wheels, const BaseKinematics& base) {
  return std::span(wheels).first(static_cast<std::size_t>(wheelCount(base.type)));
}

class AnyBase : public testing::TestWithParam<BaseKinematics> {};

TEST_P(AnyBase, TurnsWheelsBackIntoTheTwistTheyCameFrom) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> speed(-2.0, 2.0);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d twist{speed(random), GetParam().type == BaseType::kDifferential ? 0.0 : speed(random),
                                speed(random)};
    const WheelVector wheels = wheelsOf(GetParam(), twist);
    EXPECT_LT((twistOf(GetParam(), used(wheels, GetParam())) - twist).norm(), 1e-12);
    EXPECT_LT(unexplained(GetParam(), used(wheels, GetParam())), 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Types, AnyBase, testing::Values(kDifferential, kOmni, kMecanum));

/// Linear speeds of the wheels [m/s] by the firmware's own formulas (DEVICES.md 2.5), as its servos count.
TEST(BaseKinematics, HasTheSignsOfTheFirmware) {
  constexpr double x = 0.3, y = -0.2, w = 0.7;
  const auto expectWheels = [&](const BaseKinematics& base, std::vector<double> expected) {
    const WheelVector wheels = wheelsOf(base, {x, y, w});
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_NEAR(wheels[i] * base.wheel_radius, expected[i], 5e-5) << "wheel " << i + 1;
    }
  };
  double R = kOmni.body_radius;
  expectWheels(kOmni, {y + R * w, -0.866 * x - 0.5 * y + R * w, 0.866 * x - 0.5 * y + R * w});
  R = kMecanum.body_radius;
  expectWheels(kMecanum, {-x + y + R * w, x + y + R * w, x - y + R * w, -x - y + R * w});
  R = kDifferential.body_radius;
  expectWheels(kDifferential, {x - R * w, x + R * w, x - R * w, x + R * w});
}

TEST(BaseKinematics, AveragesTheSidesOfTwoAxles) {
  const std::array wheels{1.0, 2.0, 3.0, 6.0};
  const std::array mean{2.0, 4.0};
  EXPECT_EQ(twistOf(kDifferential, wheels), twistOf(kDifferential, mean));
  EXPECT_NEAR(unexplained(kDifferential, wheels), 2.0 * kDifferential.wheel_radius, 1e-15);
}

TEST(BaseKinematics, SeesOneSlippingWheelOfFour) {
  WheelVector wheels = wheelsOf(kMecanum, {0.3, 0.1, 0.5});
  wheels[2] += 0.4;
  // A quarter of it is called motion of each kind, so a quarter is left over at each wheel.
  EXPECT_NEAR(unexplained(kMecanum, wheels), 0.1 * kMecanum.wheel_radius, 1e-12);
}

}  // namespace
}  // namespace slam::base_kinematics_test
