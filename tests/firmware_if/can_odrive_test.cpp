// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/can_odrive.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "support/allocations.hpp"

namespace slam::can::odrive::can_odrive_test {
namespace {

constexpr Frame kEstimates{.id = 0x209, .size = 8, .data = {0x00, 0x00, 0xC0, 0x3F, 0x00, 0x00, 0x10, 0xC0}};

TEST(CanOdrive, IdentifiersAreTheRecommendedOnes) {
  EXPECT_EQ(idOf(kLeftNode, Command::kHeartbeat), 0x201U);
  EXPECT_EQ(idOf(kRightNode, Command::kHeartbeat), 0x301U);
  EXPECT_EQ(idOf(kLeftNode, Command::kEncoderEstimates), 0x209U);
  EXPECT_EQ(idOf(kRightNode, Command::kEncoderEstimates), 0x309U);
  EXPECT_EQ(idOf(kLeftNode, Command::kInputVelocity), 0x20DU);
  EXPECT_EQ(idOf(kRightNode, Command::kInputVelocity), 0x30DU);
  EXPECT_EQ(idOf(kLeftNode, Command::kSetAxisState), 0x207U);
  EXPECT_EQ(idOf(kRightNode, Command::kSetAxisState), 0x307U);
}

TEST(CanOdrive, EncoderEstimatesAreTheReferenceFrame) {
  EXPECT_EQ(encodeEncoderEstimates(kLeftNode, {1.5F, -2.25F}), kEstimates);
  EXPECT_EQ(parseEncoderEstimates(kLeftNode, kEstimates), (EncoderEstimates{1.5F, -2.25F}));
}

TEST(CanOdrive, HeartbeatsKeepEachBitInItsPlace) {
  const Frame frame{.id = 0x301, .size = 8, .data = {0x40, 0x08, 0x00, 0x00, 0x08, 0x01, 0x00, 0x81}};
  const Heartbeat value{
      .axis_error = 0x840, .state = 8, .motor_error = true, .controller_error = true, .trajectory_done = true};
  EXPECT_EQ(parseHeartbeat(kRightNode, frame), value);
  EXPECT_EQ(encodeHeartbeat(kRightNode, value), frame);
  const Frame encoder{.id = 0x301, .size = 8, .data = {0, 0, 0, 0, 1, 0, 1, 0}};
  EXPECT_EQ(parseHeartbeat(kRightNode, encoder), (Heartbeat{.state = 1, .encoder_error = true}));
}

TEST(CanOdrive, DistinguishesTheDialectsOfItsHeartbeatsApart) {
  const auto heartbeat = [](std::array<std::uint8_t, 8> data) { return Frame{.id = 0x201, .size = 8, .data = data}; };
  // As an S1 sends it in closed loop: byte 5 is a procedure result, byte 6 says that the trajectory is done.
  const Frame busy = heartbeat({0x00, 0x00, 0x00, 0x00, 0x08, 0x01, 0x01, 0x00});
  EXPECT_EQ(dialectOf(busy), Dialect::kUnknown) << "0.5 sends it too, with a failed motor and encoder";
  EXPECT_EQ(parseHeartbeat(kLeftNode, busy, Dialect::k06),
            (Heartbeat{.state = 8, .trajectory_done = true, .procedure_result = 1}));
  EXPECT_EQ(encodeHeartbeat(kLeftNode, {.state = 8, .trajectory_done = true, .procedure_result = 1}, Dialect::k06),
            busy);
  EXPECT_EQ(dialectOf(heartbeat({0, 0, 0, 0, 8, 0, 0, 0x80})), Dialect::k05);
  EXPECT_EQ(dialectOf(heartbeat({0x40, 0, 0, 0, 1, 1, 0, 0x81})), Dialect::k05);
  EXPECT_EQ(dialectOf(heartbeat({0, 0, 0, 0, 1, 3, 0, 0})), Dialect::k06);
  EXPECT_EQ(dialectOf(heartbeat({0, 0, 0, 1, 1, 0, 0, 0})), Dialect::k06);
  EXPECT_EQ(dialectOf(heartbeat({0, 0, 0, 0, 8, 0xFF, 0, 0x80})), Dialect::kUnknown) << "damage";
}

TEST(CanOdrive, ParametersAreAskedForByTheirNumber) {
  EXPECT_EQ(requestParameter(kLeftNode, 0x0102), (Frame{.id = 0x204, .size = 4, .data = {0x00, 0x02, 0x01, 0x00}}));
  const Frame frame{.id = 0x205, .size = 8, .data = {0x00, 0x02, 0x01, 0x00, 0x78, 0x56, 0x34, 0x12}};
  EXPECT_EQ(parseParameter(kLeftNode, frame), (Parameter{0x0102, 0x12345678}));
  EXPECT_EQ(encodeParameter(kLeftNode, {0x0102, 0x12345678}), frame);
  Frame boolean = frame;
  boolean.size = 5;
  EXPECT_EQ(parseParameter(kLeftNode, boolean), (Parameter{0x0102, 0x78})) << "what is behind was not sent";
  boolean.size = 4;
  EXPECT_FALSE(parseParameter(kLeftNode, boolean));
  EXPECT_FALSE(parseParameter(kRightNode, frame));
}

TEST(CanOdrive, VersionsAreAskedForWithARemoteFrame) {
  EXPECT_EQ(requestVersion(1), (Frame{.id = 0x020, .size = 8, .remote = true}));
  const Frame frame{.id = 0x200, .size = 8, .data = {2, 5, 2, 0, 0, 6, 9, 1}};
  const Version version{.hardware = {5, 2, 0}, .firmware = {0, 6, 9}, .unreleased = true};
  EXPECT_EQ(parseVersion(kLeftNode, frame), version);
  EXPECT_EQ(encodeVersion(kLeftNode, version), frame);
  EXPECT_EQ(version.dialect(), Dialect::k06);
  EXPECT_EQ((Version{.firmware = {0, 5, 6}}).dialect(), Dialect::k05);
  EXPECT_EQ((Version{.firmware = {1, 0, 0}}).dialect(), Dialect::k06);
  EXPECT_FALSE(parseVersion(kLeftNode, requestVersion(kLeftNode)));
}

TEST(CanOdrive, CommandsAreTheBytesOfTheProtocol) {
  const Frame velocity{.id = 0x20D, .size = 8, .data = {0, 0, 0xC0, 0x3F, 0, 0, 0, 0}};
  EXPECT_EQ(encodeInputVelocity(kLeftNode, {1.5F, 0.0F}), velocity);
  EXPECT_EQ(parseInputVelocity(kLeftNode, velocity), (InputVelocity{1.5F, 0.0F}));
  const Frame state{.id = 0x307, .size = 4, .data = {8, 0, 0, 0}};
  EXPECT_EQ(encodeAxisState(kRightNode, AxisState::kClosedLoop), state);
  EXPECT_EQ(parseAxisState(kRightNode, state), 8U);
  EXPECT_EQ(encodeClearErrors(kLeftNode), (Frame{.id = 0x218, .size = 0}));
}

TEST(CanOdrive, RefusesWhatIsNotItsFrame) {
  for (std::uint8_t size = 0; size < 8; ++size) {
    Frame frame = kEstimates;
    frame.size = size;
    EXPECT_FALSE(parseEncoderEstimates(kLeftNode, frame)) << int(size);
    frame.id = idOf(kLeftNode, Command::kHeartbeat);
    EXPECT_FALSE(parseHeartbeat(kLeftNode, frame)) << int(size);
  }
  EXPECT_FALSE(parseEncoderEstimates(kRightNode, kEstimates));
  for (bool Frame::*kind : {&Frame::extended, &Frame::remote, &Frame::error}) {
    Frame frame = kEstimates;
    frame.*kind = true;
    EXPECT_FALSE(parseEncoderEstimates(kLeftNode, frame));
  }
}

TEST(CanOdrive, RefusesValuesThatAreNotFinite) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    EXPECT_FALSE(parseEncoderEstimates(kLeftNode, encodeEncoderEstimates(kLeftNode, {bad, 0.0F})));
    EXPECT_FALSE(parseEncoderEstimates(kLeftNode, encodeEncoderEstimates(kLeftNode, {0.0F, bad})));
    EXPECT_FALSE(parseInputVelocity(kLeftNode, encodeInputVelocity(kLeftNode, {bad, 0.0F})));
  }
}

TEST(CanOdrive, SurvivesAnyPayloadWithoutAllocating) {
  std::mt19937 random(7);
  int parsed = 0;
  const auto allocations = test::allocationsDuring([&] {
    for (int i = 0; i < 20000; ++i) {
      Frame frame{.id = static_cast<std::uint32_t>(0x200 + random() % 32),
                  .size = static_cast<std::uint8_t>(random() % 9)};
      for (auto& byte : frame.data) byte = static_cast<std::uint8_t>(random());
      parsed += parseHeartbeat(kLeftNode, frame).has_value() + parseEncoderEstimates(kLeftNode, frame).has_value() +
                parseAxisState(kLeftNode, frame).has_value();
    }
  });
  EXPECT_EQ(allocations, 0U);
  EXPECT_GT(parsed, 100);
}

}  // namespace
}  // namespace slam::can::odrive::can_odrive_test
