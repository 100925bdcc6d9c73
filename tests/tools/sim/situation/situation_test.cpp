// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/situation/situation.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <sstream>

namespace slam::sim::situation_test {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

Situation with(std::initializer_list<const char*> kinds) {
  Situation situation;
  for (const char* kind : kinds) addTo(situation, kind);
  return situation;
}

std::string refusal(const char* kind) {
  Situation situation;
  try {
    addTo(situation, kind);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "taken";
}

TEST(Situation, CasingsAndPostsAddUp) {
  const Situation s = with({"casing=170,200,0.25", "posts=4,18,0.3", "casing=-40,-20,0.5"});
  ASSERT_EQ(s.bodies.size(), 6U);
  EXPECT_NEAR(wrapAngle(s.bodies[0].middle - 185.0 * kDegree), 0.0, 1e-9);
  EXPECT_NEAR(s.bodies[0].half_width, 15.0 * kDegree, 1e-9);
  EXPECT_EQ(s.bodies[0].range, 0.25);
  EXPECT_NEAR(s.bodies[1].middle, 45.0 * kDegree, 1e-9);
  EXPECT_NEAR(s.bodies[4].half_width, 9.0 * kDegree, 1e-9);
  EXPECT_NEAR(s.bodies[5].middle, -30.0 * kDegree, 1e-9);
}

TEST(Situation, ReadsNumbersInTheirUnits) {
  const Situation s = with({"field-of-view=58",     "range-max=4",       "beams=1080",
                            "turn-rate=5",          "range-noise=0.3",   "range-noise-per-metre=0.02",
                            "claimed-range-max=80", "second-lidar=5",    "gyro-step=1",
                            "gyro-clip=1",          "gyro-offset=-0.1",  "wheels-away=20,32",
                            "wheels-dead=20,32",    "floor-line=1.5",    "walkers=4",
                            "range-bias=-0.03",     "range-scale=0.01",  "bearing-scale=0.02",
                            "lidar-turned=4",       "lidar-ahead=-0.06", "lift=3"});
  EXPECT_NEAR(s.field_of_view, 58 * kDegree, 1e-12);
  EXPECT_EQ(s.lidar.range_max, 4.0);
  EXPECT_EQ(s.beams, 1080);
  EXPECT_EQ(s.turn_rate, 5.0);
  EXPECT_EQ(s.lidar.range_noise, 0.3);
  EXPECT_EQ(s.lidar.range_noise_per_metre, 0.02);
  EXPECT_EQ(s.claimed_range_max, 80.0);
  EXPECT_NEAR(*s.second_lidar, 5 * kDegree, 1e-12);
  EXPECT_NEAR(s.imu.step, kDegree, 1e-12);
  EXPECT_EQ(s.imu.clip, 1.0);
  EXPECT_EQ(s.imu.offset, -0.1);
  EXPECT_FALSE(s.wheels_away->contains(19.9));
  EXPECT_TRUE(s.wheels_away->contains(20.0));
  EXPECT_FALSE(s.wheels_away->contains(32.0));
  EXPECT_EQ(s.floor_line, 1.5);
  EXPECT_EQ(s.walkers, 4);
  EXPECT_EQ(s.range_bias, -0.03);
  EXPECT_EQ(s.range_scale, 0.01);
  EXPECT_EQ(s.bearing_scale, 0.02);
  EXPECT_NEAR(s.mount_error.theta, 4 * kDegree, 1e-12);
  EXPECT_EQ(s.mount_error.x, -0.06);
  EXPECT_EQ(s.scene.lift, 3);
}

TEST(Situation, ReadsWords) {
  const Situation s = with({"cart=towed", "follower=swaying", "beam-times=none", "gyro-unit=deg", "gyro-axis=down",
                            "start=moving", "kidnapped=60,covered"});
  EXPECT_TRUE(s.cart);
  EXPECT_EQ(s.follower, Situation::Follower::kSwaying);
  EXPECT_FALSE(s.beam_times);
  EXPECT_TRUE(s.imu.degrees);
  EXPECT_TRUE(s.imu.down);
  EXPECT_TRUE(s.starts_moving);
  EXPECT_EQ(s.kidnapping->time, 60.0);
  EXPECT_TRUE(s.kidnapping->covered);
  EXPECT_FALSE(with({"kidnapped=60"}).kidnapping->covered);
}

TEST(Situation, HasTheCodesOfNoReturn) {
  EXPECT_TRUE(std::isinf(with({"no-return=inf"}).no_return.ranges.at(0)));
  EXPECT_TRUE(std::isnan(with({"no-return=nan"}).no_return.ranges.at(0)));
  EXPECT_EQ(with({"no-return=8.183,8.187,8.191"}).no_return.ranges, (std::vector<float>{8.183F, 8.187F, 8.191F}));
  EXPECT_EQ(with({"no-return=-1"}).no_return.ranges, std::vector<float>{-1.0F});
  EXPECT_TRUE(with({"no-return=max"}).no_return.beyond_reach);
  EXPECT_EQ(with({"no-return=over"}).no_return.ranges, std::vector<float>{1.0F});
}

TEST(Situation, AnUnknownKindIsRefused) {
  EXPECT_EQ(refusal("fog=1"), "'fog' is not known; see slam-sim --help");
  EXPECT_NE(refusal("=1").find("is not known"), std::string::npos);
  EXPECT_NE(refusal("").find("is not known"), std::string::npos);
}

TEST(Situation, ABadValueIsRefusedWithItsForm) {
  EXPECT_EQ(refusal("beams=many"), "beams=many is not beams=N: of a scan");
  for (const char* bad : {"beams",
                          "beams=",
                          "beams=1.5",
                          "beams=1",
                          "beams=360,2",
                          "beams=5000",
                          "field-of-view=361",
                          "range-max=nan",
                          "range-max=inf",
                          "range-noise=-1",
                          "range-bias=2",
                          "bearing-scale=x",
                          "turn-rate=0",
                          "casing=10,20",
                          "casing=20,10,0.3",
                          "casing=10,20,0",
                          "posts=2,200,0.3",
                          "posts=1.5,10,0.3",
                          "cart=pushed",
                          "follower=1",
                          "no-return=",
                          "no-return=x",
                          "no-return=1,,2",
                          "no-return=1,inf",
                          "wheels-away=5",
                          "wheels-away=9,5",
                          "kidnapped=0",
                          "kidnapped=5,open",
                          "kidnapped=,covered",
                          "beam-times=all",
                          "blocks=0",
                          "laps=0",
                          "gyro-unit=rad"}) {
    EXPECT_NE(refusal(bad).find("is not"), std::string::npos) << bad;
  }
}

TEST(Situation, EveryKindHasItsLine) {
  std::istringstream lines(situationKinds());
  int kinds = 0;
  for (std::string line; std::getline(lines, line); ++kinds) {
    EXPECT_NE(line.find('='), std::string::npos) << line;
    EXPECT_NE(line.find(": "), std::string::npos) << line;
  }
  EXPECT_GE(kinds, 33);
}

}  // namespace
}  // namespace slam::sim::situation_test
