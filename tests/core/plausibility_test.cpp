// SPDX-License-Identifier: BSD-3-Clause
#include "core/plausibility.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/absurd.hpp"

namespace slam::plausibility_test {
namespace {

using test::absurdNumbers;
using test::plausibleNumbers;
using testing::HasSubstr;
using testing::StartsWith;

constexpr double Pose2::*kCoordinates[] = {&Pose2::x, &Pose2::y, &Pose2::theta};

TEST(Plausibility, TakesPosesUpToItsLimitsAndNoneBeyond) {
  int refused = 0;
  for (const auto coordinate : kCoordinates) {
    const double limit = coordinate == &Pose2::theta ? kPlausible.turn : kPlausible.farthest;
    for (const double value : plausibleNumbers(limit)) {
      Pose2 pose{1.0, -2.0, 0.5};
      pose.*coordinate = value;
      EXPECT_TRUE(isPlausible(pose)) << value;
      EXPECT_EQ(implausibilityOf(pose), "");
    }
    for (const double value : absurdNumbers(limit)) {
      Pose2 pose{1.0, -2.0, 0.5};
      pose.*coordinate = value;
      EXPECT_FALSE(isPlausible(pose)) << value;
      EXPECT_NE(implausibilityOf(pose), "") << value;
      ++refused;
    }
  }
  EXPECT_GT(refused, 200);
}

TEST(Plausibility, NamesTheNumberOfAPoseThatCannotBe) {
  EXPECT_EQ(implausibilityOf({1e6, 0.0, 0.0}), "x = 1e+06 m is more than 10 km from the map's origin");
  EXPECT_EQ(implausibilityOf({0.0, -15000.0, 0.0}), "y = -15000 m is more than 10 km from the map's origin");
  EXPECT_EQ(implausibilityOf({0.0, -15000.0, 0.0}, kPlausible.stored_farthest), "");
  EXPECT_EQ(implausibilityOf({0.0, 0.0, 90.0}), "theta = 90 rad is more than a full turn");
  EXPECT_EQ(implausibilityOf({std::nan(""), 0.0, 0.0}), "x is no finite number");
  EXPECT_EQ(implausibilityOf({0.0, 0.0, HUGE_VAL}), "theta is no finite number");
}

TEST(Plausibility, TakesSamplesUpToItsLimitsAndNoneBeyond) {
  for (const auto coordinate : kCoordinates) {
    WheelSample sample;
    for (const double value : plausibleNumbers(kPlausible.dead_reckoned)) {
      sample.T_wheels_base.*coordinate = value;
      EXPECT_TRUE(isPlausible(sample)) << value;
    }
    for (const double value : absurdNumbers(kPlausible.dead_reckoned)) {
      sample.T_wheels_base.*coordinate = value;
      EXPECT_FALSE(isPlausible(sample)) << value;
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto holds = [axis](Eigen::Vector3d ImuSample::*vector, double value) {
      ImuSample sample;
      (sample.*vector)[axis] = value;
      return isPlausible(sample);
    };
    for (const double value : plausibleNumbers(kPlausible.turn_rate)) EXPECT_TRUE(holds(&ImuSample::gyro, value));
    for (const double value : absurdNumbers(kPlausible.turn_rate)) EXPECT_FALSE(holds(&ImuSample::gyro, value));
    for (const double value : plausibleNumbers(kPlausible.acceleration)) EXPECT_TRUE(holds(&ImuSample::accel, value));
    for (const double value : absurdNumbers(kPlausible.acceleration)) EXPECT_FALSE(holds(&ImuSample::accel, value));
  }
}

TEST(Plausibility, ABeamThatCannotBeIsNoReturn) {
  const Beam beam{.range = 2.0F, .bearing = 0.5F, .time_offset = 0.01F, .intensity = 7.0F};
  EXPECT_EQ(plausible(beam).range, 2.0F);
  EXPECT_EQ(plausible(beam).intensity, 7.0F);
  for (const double value : absurdNumbers(kPlausible.range)) {
    Beam bad = beam;
    bad.range = static_cast<float>(value);
    EXPECT_EQ(plausible(bad).range, 0.0F) << value;
    EXPECT_EQ(plausible(bad).bearing, 0.5F) << "it still looks there";
    for (float Beam::*member : {&Beam::bearing, &Beam::time_offset}) {
      bad = beam;
      bad.*member = static_cast<float>(value);
      EXPECT_EQ(plausible(bad).range, 0.0F) << value;
      EXPECT_EQ(plausible(bad).*member, 0.0F) << value;
    }
  }
}

TEST(Plausibility, APictureLiesNearItsMapsOriginAndHasRoomInMemory) {
  EXPECT_EQ(implausibilityOfPicture(0.05, -12.35, 3.7, 4000, 4000), "");
  EXPECT_EQ(implausibilityOfPicture(1.0, -9000.0, 0.0, 10000, 10000), "");
  EXPECT_THAT(implausibilityOfPicture(1.0, -9000.0, 0.0, 20000, 20), HasSubstr("right edge x = 11000 m"));
  EXPECT_THAT(implausibilityOfPicture(0.05, 4.5e5, 0.0, 10, 10), StartsWith("its left edge x = 450000 m"));
  EXPECT_THAT(implausibilityOfPicture(0.05, 0.0, 5.4e6, 10, 10), StartsWith("its lower edge y = 5.4e+06 m"));
  EXPECT_THAT(implausibilityOfPicture(0.005, 0.0, 0.0, 200'000, 200'000), HasSubstr("200000 x 200000 cells"));
  for (const double resolution : absurdNumbers(kPlausible.coarsest))
    EXPECT_THAT(implausibilityOfPicture(resolution, 0.0, 0.0, 10, 10), HasSubstr("resolution"));
  for (const double resolution : {0.0, 1e-310, 0.0009})
    EXPECT_NE(implausibilityOfResolution(resolution), "") << resolution;
  for (const double resolution : {0.001, 0.05, 1.0}) EXPECT_EQ(implausibilityOfResolution(resolution), "");
  EXPECT_EQ(implausibilityOfSize(kPlausible.picture_cells, 1), "");
  EXPECT_EQ(implausibilityOfSize(1, kPlausible.picture_cells), "");
  EXPECT_NE(implausibilityOfSize(kPlausible.picture_cells / 2 + 1, 2), "");
  EXPECT_NE(implausibilityOfSize(std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::max()),
            "");
  EXPECT_NE(implausibilityOfSize(0, 5), "");
  EXPECT_NE(implausibilityOfSize(5, -1), "");
}

}  // namespace
}  // namespace slam::plausibility_test
