// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/robolink.hpp"

#include <algorithm>
#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

#include "firmware_if/bytes.hpp"
#include "support/allocations.hpp"

namespace slam::robolink::robolink_test {
namespace {

using test::Bytes;
using test::operator+;
using testing::ElementsAre;

Bytes frameOf(std::uint8_t sender, std::uint8_t receiver, Command command, const Bytes& payload = {}) {
  Bytes out(kMaxFrame);
  out.resize(encodeFrame(sender, receiver, command, payload, out));
  return out;
}
Bytes answer(Command command, const Bytes& payload = {}) { return frameOf(kSlave, kMaster, command, payload); }

struct Received {
  std::uint8_t sender, receiver, command;
  Bytes payload;
  bool operator==(const Received&) const = default;
};

/// Everything the decoder makes of the bytes, in order.
std::vector<Received> decodeAll(Decoder& decoder, const Bytes& bytes) {
  std::vector<Received> all;
  const auto keep = [&](const Frame& frame) {
    all.push_back({frame.sender, frame.receiver, frame.command, {frame.payload.begin(), frame.payload.end()}});
  };
  for (const std::uint8_t byte : bytes) {
    if (const auto frame = decoder.push(byte)) keep(*frame);
  }
  while (const auto frame = decoder.flush()) keep(*frame);
  return all;
}

const Bytes kAcknowledgement{0xFF, 0xFF, 0x11, 0x01, 0x00, 0x01, 0x0C, 0x1F};
const Received kAcknowledged{kSlave, kMaster, 12, {}};

// ---- Frames of DEVICES.md 2.6

struct Vector {
  std::uint8_t sender, receiver, command;
  Bytes payload, frame;
};

class RoboLinkVector : public testing::TestWithParam<Vector> {};

TEST_P(RoboLinkVector, IsEncodedByteForByte) {
  const auto& [sender, receiver, command, payload, frame] = GetParam();
  EXPECT_EQ(frameOf(sender, receiver, static_cast<Command>(command), payload), frame);
}

TEST_P(RoboLinkVector, IsDecodedByTheSideItIsFor) {
  const auto& [sender, receiver, command, payload, frame] = GetParam();
  Decoder decoder(receiver, sender);
  EXPECT_THAT(decodeAll(decoder, frame), ElementsAre(Received{sender, receiver, command, payload}));
  EXPECT_EQ(decoder.counters().frames, 1U);
  EXPECT_EQ(decoder.counters().skipped_bytes, 0U);
}

const Bytes kSpeed{0xCD, 0xCC, 0x4C, 0x3E, 0, 0, 0, 0, 0, 0, 0, 0x3F};
const Bytes kMotors{0, 0, 0x60, 0xC0, 0, 0, 0x88, 0x40, 0, 0, 0, 0, 0, 0, 0, 0};

INSTANTIATE_TEST_SUITE_P(
    Of, RoboLinkVector,
    testing::Values(
        Vector{kMaster, kSlave, 15, {}, {0xFF, 0xFF, 0x01, 0x11, 0x00, 0x01, 0x0F, 0x22}},
        Vector{kMaster, kSlave, 16, {}, {0xFF, 0xFF, 0x01, 0x11, 0x00, 0x01, 0x10, 0x23}},
        Vector{kMaster, kSlave, 17, {}, {0xFF, 0xFF, 0x01, 0x11, 0x00, 0x01, 0x11, 0x24}},
        Vector{kMaster, kSlave, 24, {}, {0xFF, 0xFF, 0x01, 0x11, 0x00, 0x01, 0x18, 0x2B}},
        Vector{kSlave, kMaster, 0, {}, {0xFF, 0xFF, 0x11, 0x01, 0x00, 0x01, 0x00, 0x13}},
        Vector{kMaster, kSlave, 0, Bytes(12), Bytes{0xFF, 0xFF, 0x01, 0x11, 0, 0x0D, 0} + Bytes(12) + Bytes{0x1F}},
        Vector{kMaster, kSlave, 12, kSpeed, Bytes{0xFF, 0xFF, 0x01, 0x11, 0, 0x0D, 0x0C} + kSpeed + Bytes{0x8F}},
        Vector{kSlave, kMaster, 12, {}, kAcknowledgement},
        Vector{kSlave, kMaster, 15, kMotors, Bytes{0xFF, 0xFF, 0x11, 0x01, 0, 0x11, 0x0F} + kMotors + Bytes{0x1C}}));

// ---- Encoding

TEST(RoboLinkChecksum, IsTheSumModulo255) {
  EXPECT_EQ(checksum({}), 0);
  EXPECT_EQ(checksum(Bytes{0xFE}), 0xFE);
  EXPECT_EQ(checksum(Bytes{0xFF}), 0);
  EXPECT_EQ(checksum(Bytes{0xFE, 0x03}), 2);
  EXPECT_EQ(checksum(Bytes(1022, 0xFE)), 1022 * 0xFE % 255);
}

TEST(RoboLinkEncoder, RefusesWhatDoesNotFit) {
  Bytes out(kMaxFrame + 100);
  EXPECT_EQ(encodeFrame(kMaster, kSlave, Command::kGetImu, Bytes(kMaxPayload + 1), out), 0U);
  EXPECT_EQ(encodeFrame(kMaster, kSlave, Command::kGetImu, Bytes(kMaxPayload), out), kMaxFrame);
  EXPECT_EQ(encodeFrame(kMaster, kSlave, Command::kGetImu, Bytes(4), std::span(out).first(11)), 0U);
  EXPECT_EQ(encodeFrame(kMaster, kSlave, Command::kGetImu, Bytes(4), std::span(out).first(12)), 12U);
}

TEST(RoboLinkDecoder, TakesTheLongestFrame) {
  Decoder decoder;
  const Bytes payload(kMaxPayload, 0x5A);
  EXPECT_THAT(decodeAll(decoder, answer(Command::kGetImu, payload)),
              ElementsAre(Received{kSlave, kMaster, 24, payload}));
}

// ---- Damage

class StrayBytes : public testing::TestWithParam<int> {};

TEST_P(StrayBytes, OfTheHeaderBeforeAFrameDoNoHarm) {
  Decoder decoder;
  EXPECT_THAT(decodeAll(decoder, Bytes(static_cast<std::size_t>(GetParam()), 0xFF) + kAcknowledgement),
              ElementsAre(kAcknowledged));
  EXPECT_EQ(decoder.counters().skipped_bytes, static_cast<std::uint32_t>(GetParam()));
  EXPECT_EQ(decoder.counters().bad_checksums, 0U);
}

INSTANTIATE_TEST_SUITE_P(Count, StrayBytes, testing::Values(1, 2, 3, 50));

TEST(RoboLinkDecoder, LosesNothingBehindABadChecksum) {
  Bytes bad = answer(Command::kGetMotorMileage, Bytes(16, 7));
  ++bad.back();
  Decoder decoder;
  EXPECT_THAT(decodeAll(decoder, bad + kAcknowledgement), ElementsAre(kAcknowledged));
  EXPECT_EQ(decoder.counters().bad_checksums, 1U);
  EXPECT_EQ(decoder.counters().frames, 1U);
}

TEST(RoboLinkDecoder, LosesNothingBehindAFrameCutShort) {
  const Bytes whole = answer(Command::kGetMotorMileage, Bytes(16, 7));
  const Bytes quiet(kMaxFrame);  // ends whatever a length field made of two frames announces
  for (std::size_t size = 1; size < whole.size(); ++size) {
    Decoder decoder;
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_THAT(decodeAll(decoder, cut + kAcknowledgement + whole + kAcknowledgement + quiet),
                ElementsAre(kAcknowledged, Received{kSlave, kMaster, 16, Bytes(16, 7)}, kAcknowledged))
        << "cut after " << size;
  }
}

TEST(RoboLinkDecoder, GivesTheFramesHeldBackByAFalseLength) {
  const Bytes false_header{0xFF, 0xFF, 0x11, 0x01, 0x00, 60, 0x10};
  Bytes stream = false_header;
  for (int i = 0; i < 20; ++i) stream = stream + kAcknowledgement;
  Decoder decoder;
  EXPECT_EQ(decodeAll(decoder, stream), std::vector<Received>(20, kAcknowledged));
}

class BadLength : public testing::TestWithParam<std::pair<std::uint8_t, std::uint8_t>> {};

TEST_P(BadLength, IsCountedAndTheNextFrameIsUsed) {
  const auto [high, low] = GetParam();
  Decoder decoder;
  EXPECT_THAT(decodeAll(decoder, Bytes{0xFF, 0xFF, 0x11, 0x01, high, low} + kAcknowledgement),
              ElementsAre(kAcknowledged));
  EXPECT_EQ(decoder.counters().bad_lengths, 1U);
}

INSTANTIATE_TEST_SUITE_P(HighLow, BadLength,
                         testing::Values(std::pair{0x00, 0x00}, std::pair{0x04, 0x00}, std::pair{0x80, 0x01},
                                         std::pair{0xFE, 0xFE}));

TEST(RoboLinkDecoder, CountsAndDropsFramesOfAndForOthers) {
  Decoder decoder;
  const Bytes stream = frameOf(kSlave, 0x02, Command::kGetImu) + frameOf(0x12, kMaster, Command::kGetImu) +
                       frameOf(kMaster, kSlave, Command::kGetImu) + kAcknowledgement;
  EXPECT_THAT(decodeAll(decoder, stream), ElementsAre(kAcknowledged));
  EXPECT_EQ(decoder.counters().foreign_frames, 3U);
  EXPECT_EQ(decoder.counters().frames, 1U);
}

TEST(RoboLinkDecoder, HandsOnACommandItHasNoNameFor) {
  Decoder decoder;
  EXPECT_THAT(decodeAll(decoder, answer(static_cast<Command>(200), {1, 2})),
              ElementsAre(Received{kSlave, kMaster, 200, {1, 2}}));
}

TEST(RoboLinkDecoder, ForgetsAHalfFrameOnReset) {
  Decoder decoder;
  for (int i = 0; i < 6; ++i) decoder.push(kAcknowledgement[static_cast<std::size_t>(i)]);
  decoder.reset();
  EXPECT_THAT(decodeAll(decoder, {0x0C, 0x1F}), testing::IsEmpty());
  EXPECT_THAT(decodeAll(decoder, kAcknowledgement), ElementsAre(kAcknowledged));
}

/// Bytes with many headers and plausible frame heads among them.
Bytes noise(std::mt19937& random, std::size_t size) {
  constexpr std::uint8_t kLikely[] = {0xFF, 0xFF, 0xFF, 0x11, 0x01, 0x00, 0x03, 0x04};
  Bytes bytes(size);
  for (auto& byte : bytes) {
    const auto r = random();
    byte = r % 2 == 0 ? kLikely[r / 2 % std::size(kLikely)] : static_cast<std::uint8_t>(r >> 8);
  }
  return bytes;
}

TEST(RoboLinkDecoder, SurvivesNoiseAndGivesTheFramesAfterIt) {
  std::mt19937 random(1);
  const Bytes sentinel{0xDE, 0xAD, 0xBE, 0x0F};
  int recovered = 0;
  constexpr int kRounds = 300, kFrames = 150;  // 150 frames of 12 bytes: longer than any frame held by a false header
  for (int round = 0; round < kRounds; ++round) {
    Decoder decoder;
    Bytes stream = noise(random, 1 + random() % 3000);
    for (int i = 0; i < kFrames; ++i) stream = stream + answer(Command::kGetMotorSpeed, sentinel);
    const auto frames = decodeAll(decoder, stream);
    ASSERT_FALSE(frames.empty());
    EXPECT_EQ(frames.back(), (Received{kSlave, kMaster, 15, sentinel})) << "round " << round;
    recovered += static_cast<int>(std::count(frames.begin(), frames.end(), frames.back()));
  }
  // Only a false frame whose checksum fits by chance (1/255) may swallow good ones.
  EXPECT_GT(recovered, kRounds * kFrames * 98 / 100);
}

TEST(RoboLinkDecoder, DoesNotAllocate) {
  std::mt19937 random(2);
  Bytes stream;
  for (int i = 0; i < 50; ++i) stream = stream + noise(random, 100) + answer(Command::kGetImu, Bytes(kImuSize));
  Decoder decoder;
  EXPECT_EQ(test::allocationsDuring([&] {
              for (const std::uint8_t byte : stream) decoder.push(byte);
              while (decoder.flush()) {
              }
            }),
            0U);
  EXPECT_GT(decoder.counters().frames, 0U);
}

// ---- Payloads

void putFloat(std::span<std::uint8_t> bytes, std::size_t offset, float value) {
  static_assert(std::numeric_limits<float>::is_iec559);
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

TEST(RoboLinkPayload, CoordinateIsThreeFloats) {
  const auto bytes = encodeCoordinate({0.2F, 0.0F, 0.5F});
  EXPECT_EQ(Bytes(bytes.begin(), bytes.end()), kSpeed);
  const auto value = parseCoordinate(bytes);
  ASSERT_TRUE(value);
  EXPECT_EQ(value->x, 0.2F);
  EXPECT_EQ(value->y, 0.0F);
  EXPECT_EQ(value->z, 0.5F);
}

TEST(RoboLinkPayload, MotorVectorIsFourFloats) {
  const MotorVector motors{-3.5F, 4.25F, 0.0F, 0.0F};
  const auto bytes = encodeMotorVector(motors);
  EXPECT_EQ(Bytes(bytes.begin(), bytes.end()), kMotors);
  EXPECT_EQ(parseMotorVector(bytes), motors);
}

TEST(RoboLinkPayload, ImuHasItsFieldsAtTheDocumentedOffsets) {
  Bytes bytes(kImuSize);
  bytes[0] = 0x05;
  bytes[3] = 0x32;  // second rate, little-endian
  bytes[4] = 0x01;
  for (std::size_t i = 0; i < 3; ++i) {
    putFloat(bytes, 7 + 4 * i, 0.5F + static_cast<float>(i));
    putFloat(bytes, 19 + 4 * i, -9.0F + static_cast<float>(i));
  }
  const auto imu = parseImu(bytes);
  ASSERT_TRUE(imu);
  EXPECT_EQ(imu->online, 0x05);
  EXPECT_THAT(imu->update_rates, ElementsAre(0, 0x0132, 0));
  EXPECT_THAT(imu->gyro, ElementsAre(0.5F, 1.5F, 2.5F));
  EXPECT_THAT(imu->accel, ElementsAre(-9.0F, -8.0F, -7.0F));
  const auto encoded = encodeImu(*imu);
  EXPECT_EQ(Bytes(encoded.begin(), encoded.end()), bytes);
}

TEST(RoboLinkPayload, SystemInfoHasItsFieldsAtTheDocumentedOffsets) {
  Bytes bytes(kSystemInfoSize);
  for (std::size_t i = 0; i < 5; ++i) putFloat(bytes, 4 * i, 10.0F + static_cast<float>(i));
  const Bytes time{0x01, 0xEA, 0x07, 11, 21, 6, 14, 49, 59};  // Saturday 2026-11-21 14:49:59
  std::copy(time.begin(), time.end(), bytes.begin() + 20);
  const auto info = parseSystemInfo(bytes);
  ASSERT_TRUE(info);
  EXPECT_EQ(info->system_time, 10.0F);
  EXPECT_EQ(info->cpu_temperature, 11.0F);
  EXPECT_EQ(info->cpu_usage, 12.0F);
  EXPECT_EQ(info->battery, 13.0F);
  EXPECT_EQ(info->power_remain, 14.0F);
  EXPECT_EQ(info->local_time, (LocalTime{true, 2026, 11, 21, 6, 14, 49, 59}));
  const auto encoded = encodeSystemInfo(*info);
  EXPECT_EQ(Bytes(encoded.begin(), encoded.end()), bytes);
}

TEST(RoboLinkPayload, ChassisParametersHaveTheirFieldsAtTheDocumentedOffsets) {
  Bytes bytes(kChassisSize);
  bytes[0] = 4;
  for (std::size_t i = 0; i < 3; ++i) {
    putFloat(bytes, 1 + 4 * i, 0.25F + static_cast<float>(i));
    putFloat(bytes, 15 + 4 * i, 3.0F + static_cast<float>(i));
    putFloat(bytes, 27 + 4 * i, 6.0F + static_cast<float>(i));
  }
  bytes[13] = 1;
  bytes[14] = 2;
  const auto chassis = parseChassis(bytes);
  ASSERT_TRUE(chassis);
  EXPECT_EQ(chassis->type, ChassisType::kMecanum4);
  EXPECT_EQ(chassis->wheel_radius, 0.25F);
  EXPECT_EQ(chassis->body_radius, 1.25F);
  EXPECT_EQ(chassis->speed_low_filter, 2.25F);
  EXPECT_EQ(chassis->imu_fusion, 1);
  EXPECT_EQ(chassis->control_enable, 2);
  EXPECT_THAT(chassis->max_speed, ElementsAre(3.0F, 4.0F, 5.0F));
  EXPECT_THAT(chassis->max_acceleration, ElementsAre(6.0F, 7.0F, 8.0F));
  const auto encoded = encodeChassis(*chassis);
  EXPECT_EQ(Bytes(encoded.begin(), encoded.end()), bytes);
}

TEST(RoboLinkPayload, LocalTimeIsTheCalendarsOfItsSecond) {
  EXPECT_EQ(localTimeAt(0), (LocalTime{true, 1970, 1, 1, 4, 0, 0, 0}));
  EXPECT_EQ(localTimeAt(951'782'400 + 86'399), (LocalTime{true, 2000, 2, 29, 2, 23, 59, 59}));
  EXPECT_EQ(localTimeAt(1'795'272'599), (LocalTime{true, 2026, 11, 21, 6, 14, 49, 59}));
}

template <typename Parse>
void expectRefused(Parse parse, std::size_t size, const std::vector<std::size_t>& floats) {
  EXPECT_TRUE(parse(Bytes(size)));
  for (const std::size_t wrong : {std::size_t{0}, std::size_t{1}, size - 1, size + 1, 2 * size}) {
    EXPECT_FALSE(parse(Bytes(wrong))) << wrong << " bytes";
  }
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const std::size_t offset : floats) {
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), kInfinity, -kInfinity}) {
      Bytes bytes(size);
      putFloat(bytes, offset, bad);
      EXPECT_FALSE(parse(bytes)) << bad << " at " << offset;
    }
  }
}

TEST(RoboLinkPayload, OfAWrongSizeOrNotFiniteIsRefused) {
  expectRefused([](const Bytes& b) { return parseCoordinate(b).has_value(); }, kCoordinateSize, {0, 4, 8});
  expectRefused([](const Bytes& b) { return parseMotorVector(b).has_value(); }, kMotorVectorSize, {0, 4, 8, 12});
  expectRefused([](const Bytes& b) { return parseImu(b).has_value(); }, kImuSize, {7, 11, 15, 19, 23, 27});
  expectRefused([](const Bytes& b) { return parseSystemInfo(b).has_value(); }, kSystemInfoSize, {0, 4, 8, 12, 16});
  expectRefused([](const Bytes& b) { return parseChassis(b).has_value(); }, kChassisSize,
                {1, 5, 9, 15, 19, 23, 27, 31, 35});
}

TEST(RoboLinkTime, CountsWeekdaysFromMondayToSunday) {
  constexpr std::int64_t kDay = 86'400;  // [s]; the first of 1970 was a Thursday
  const int weekdays[] = {4, 5, 6, 7, 1, 2, 3, 4};
  for (int day = 0; day < 8; ++day) EXPECT_EQ(localTimeAt(day * kDay + kDay / 2).weekday, weekdays[day]) << day;
}

}  // namespace
}  // namespace slam::robolink::robolink_test
