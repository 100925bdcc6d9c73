// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/situation/company.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace slam::sim::company_test {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr Pose2 kLidar{0.06, 0.0, 0.0};
constexpr double kStep = 0.005;  // [s]

Situation with(std::initializer_list<const char*> kinds) {
  Situation situation;
  for (const char* kind : kinds) addTo(situation, kind);
  return situation;
}

/// Drives along a circle of 3 m radius. @param visit is called with pose and company after each step
template <typename Visit>
void drive(Company& company, double seconds, Visit&& visit) {
  Pose2 pose{2.0, 1.0, 0.3};
  for (double time = 0.0; time < seconds; time += kStep) {
    pose = pose * exp({0.5 * kStep, 0.0, 0.5 / 3.0 * kStep});
    company.step(pose, kStep);
    visit(pose);
  }
}

TEST(Company, OfNobodyIsNeverSeen) {
  Company company({});
  drive(company, 1.0, [](const Pose2&) {});
  for (double bearing = -kPi; bearing < kPi; bearing += 0.01) EXPECT_TRUE(std::isinf(company.range(kLidar, bearing)));
}

TEST(Company, ABodyIsSeenAtItsBearingsAlone) {
  const Company company(with({"casing=170,200,0.25"}));
  for (const double degrees : {171.0, 180.0, -179.0, -161.0}) {
    EXPECT_EQ(company.range(kLidar, degrees * kPi / 180.0), 0.25) << degrees;
  }
  for (const double degrees : {169.0, -159.0, 0.0, 90.0}) {
    EXPECT_TRUE(std::isinf(company.range(kLidar, degrees * kPi / 180.0))) << degrees;
  }
}

TEST(Company, TheFloorLineLiesAcrossTheWay) {
  const Company company(with({"floor-line=1.5"}));
  for (double bearing = -1.4; bearing < 1.4; bearing += 0.1) {
    EXPECT_NEAR(company.range(kLidar, bearing) * std::cos(bearing), 1.5, 1e-9);
  }
  EXPECT_TRUE(std::isinf(company.range(kLidar, 1.6)));
  EXPECT_TRUE(std::isinf(company.range(kLidar, kPi)));
}

TEST(Company, ARigidFollowerKeepsBehindAndASwayingOneSwings) {
  for (const bool swaying : {true, false}) {
    Company company(with({swaying ? "follower=swaying" : "follower=rigid"}));
    double nearest = 10.0, farthest = 0.0;
    drive(company, 5.0, [&](const Pose2&) {
      ASSERT_EQ(company.solids().cylinders.size(), 2U);
      const Cylinder &right = company.solids().cylinders[0], &left = company.solids().cylinders[1];
      EXPECT_NEAR((right.x + left.x) / 2, -0.55, 1e-9);
      EXPECT_NEAR(left.y - right.y, Person::kFeetApart, 1e-9);
      nearest = std::min(nearest, std::abs(left.x));
      farthest = std::max(farthest, std::abs(left.x));
    });
    EXPECT_NEAR(farthest - nearest, swaying ? 2 * Person::kSwing : 0.0, 0.02);
  }
}

TEST(Company, WalkersComeAlongAndNeverFasterThanPeopleDo) {
  Company company(with({"walkers=4"}));
  std::vector<Eigen::Vector2d> before;
  drive(company, 20.0, [&](const Pose2& pose) {
    ASSERT_EQ(company.solids().cylinders.size(), 8U);
    std::vector<Eigen::Vector2d> now;
    for (std::size_t i = 0; i < 8; i += 2) {
      const Cylinder &right = company.solids().cylinders[i], &left = company.solids().cylinders[i + 1];
      const Eigen::Vector2d middle((right.x + left.x) / 2, (right.y + left.y) / 2);
      EXPECT_GT(middle.norm(), 0.4);
      EXPECT_LT(middle.norm(), 2.2);
      now.push_back(pose * middle);
      if (!before.empty()) {
        EXPECT_LT((now.back() - before[i / 2]).norm(), 1.41 * kStep);
      }
    }
    before = now;
  });
}

TEST(Company, TheCartComesAfterOnItsPole) {
  Company company(with({"cart=towed"}));
  Eigen::Vector2d before(0.0, 0.0);
  drive(company, 20.0, [&](const Pose2& pose) {
    ASSERT_EQ(company.solids().boxes.size(), 1U);
    const Box& cart = company.solids().boxes[0];
    EXPECT_NEAR(std::hypot(cart.x + 0.30, cart.y), 0.60, 1e-9);
    const Eigen::Vector2d axle = pose * Eigen::Vector2d(cart.x, cart.y), moved = axle - before;
    if (before.norm() > 0.0) {  // its wheels do not slip sideways
      const double heading = pose.theta + cart.yaw;
      EXPECT_LT(std::abs(-std::sin(heading) * moved.x() + std::cos(heading) * moved.y()), 1e-4);
    }
    before = axle;
  });
  EXPECT_LT(std::abs(company.solids().boxes[0].y), 0.3);
  EXPECT_GT(std::abs(company.solids().boxes[0].y), 0.05);  // cuts the corner
  EXPECT_NEAR(company.range(kLidar, kPi), 0.66, 0.05);     // from lidar to the cart's front
}

}  // namespace
}  // namespace slam::sim::company_test
